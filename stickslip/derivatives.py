"""Derivatives of amplitudes with respect to parameters, and the propagation of errors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.model.drive import full_forces
from stickslip.options import options_for_orbits
from stickslip.parameters import Parameters
from stickslip.points import orbit_rows, places_of, results_at, rows_of
from stickslip.status import Status
from stickslip.variables import (
    ENERGY_COEFFICIENTS,
    PARAMETERS,
    RESULT_COLUMNS,
    RESULTS,
    full_name,
    full_names,
    unbounded,
)

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.points import Points

AMPLITUDES = ("elastic_stress_amplitude", "friction_force_amplitude")

PARAMETER = "parameter"
"""The dimension of the parameters with respect to which amplitudes are differentiated."""

LOGARITHMIC, PLAIN = "logarithmic", "plain"

_TOLERANCE = 1e-8  # default of rtol
_STEP = 1e-3  # the larger of two steps, relative to the parameter or in its natural unit
_PARTS = (-1.0, -0.5, 0.5, 1.0)

# As measured, amplitudes that are not small are smooth to this part of the tolerance.
_ROUGHNESS = 0.01

# If one of these changes within the step, so does the kind of motion.
_KIND = [RESULT_COLUMNS.index(name) for name in ("regime", "melting_count", "orbit_periods")]
_STATUS = RESULT_COLUMNS.index("status")
_SMALL_PART = 0.01
_AREA = Parameters._fields.index("contact_area")
_ENERGY = [Parameters._fields.index(name) for name in ENERGY_COEFFICIENTS]


def sensitivities(
    points: Points,
    by: str | Iterable[str],
    of: str | Iterable[str] = AMPLITUDES,
    *,
    rtol: float = _TOLERANCE,
    **options: Any,
) -> xr.Dataset:
    """Return the orbits of points, with derivatives of their amplitudes with respect to parameters.

    The logarithm of an amplitude is differentiated with respect to the logarithm of a parameter, or
    to the parameter itself where that may be 0 or negative (rheological index, start, coefficients
    beyond the paper). A derivative is NaN where the amplitude is 0 or the orbit does not close. It
    is NaN as well where the regime, the number of meltings or the number of periods changes within
    the step: amplitudes jump there.

    >>> ds = sensitivities({"T": [200, 250]}, by=["k", "T"])
    >>> ds.friction_force_amplitude_sensitivity.sel(parameter="temperature").round(2).values
    array([-2.31, -5.08])

    Parameters
    ----------
    points
        As for `stationary_orbits`.
    by
        Names or symbols of parameters, which `points` need not have. One that is repeated counts
        once.
    of
        `elastic_stress_amplitude`, `friction_force_amplitude` or both.
    rtol, **options
        As for `stationary_orbit`.

    Returns
    -------
    xarray.Dataset
        The orbits, as `stationary_orbits` returns them, and for each amplitude
        `<amplitude>_sensitivity` and its estimated error, `<amplitude>_sensitivity_error`, over the
        dimensions of the points and `parameter`. The attribute `form` says for each parameter
        whether its derivative is `logarithmic` or `plain`, in 1/(unit of the parameter).

    Raises
    ------
    ValueError
        `of` is not an amplitude, `by` is empty, the noise is stochastic, or a dimension of the
        points is called `parameter`.
    TypeError
        A parameter or option is unknown. Other errors are as in `stationary_orbits`.
    """
    parameters, amplitudes = [*dict.fromkeys(map(full_name, _listed(by)))], _listed(of)
    if not parameters:
        raise ValueError("by is empty; name at least one parameter")
    if unknown := set(amplitudes) - set(AMPLITUDES):
        known = ", ".join(AMPLITUDES)
        raise ValueError(f"of: there is no amplitude {', '.join(unknown)}; there are {known}")
    places, chosen = places_of(points), options_for_orbits(rtol=rtol, **options)
    if chosen.physics.chance:
        raise ValueError("noise: a mean of random paths has no derivative; leave out 'stochastic'")
    if PARAMETER in places.dims:
        raise ValueError(
            f"the points have a dimension {PARAMETER}, as the derivatives will; "
            "rename that of the points"
        )
    rows = rows_of(places)
    steps = [_Step.of(rows, name, part) for name in parameters for part in _PARTS]
    results = orbit_rows(np.concatenate([rows, *(step.rows for step in steps)]), chosen)
    results = results.reshape(1 + len(steps), len(rows), len(RESULT_COLUMNS))
    found = results_at(places, results[0])
    moved = np.array([step.by for step in steps]).reshape(len(parameters), len(_PARTS), len(rows))
    around = results[1:].reshape(*moved.shape, len(RESULT_COLUMNS))
    same = _same_motion(results[0], around)
    for name in amplitudes:
        with np.errstate(all="ignore"):  # where there is no derivative
            column = RESULT_COLUMNS.index(name)
            values, errors = _derivatives(around[..., column], moved)
            roughness = _ROUGHNESS * rtol * _largeness(rows, results[0], name)
            errors += roughness / np.abs(moved).max(axis=1)
            errors += _jumps(results[0, :, column], around[..., column], moved, roughness)
            errors[np.isnan(values)] = np.nan
        for suffix, array in (("sensitivity", values), ("sensitivity_error", errors)):
            array[~same] = np.nan
            found[f"{name}_{suffix}"] = _variable(name, suffix, array, parameters, places)
    return found.assign_coords({PARAMETER: (PARAMETER, parameters)})


def propagated(ds: xr.Dataset, errors: Mapping[str, ArrayLike]) -> xr.Dataset:
    """Return the standard errors of amplitudes, from independent errors of the parameters.

    >>> ds = propagated(sensitivities({"T": 250}, by="T"), {"T": 0.5})
    >>> round(float(ds.friction_force_amplitude_standard_error), 7)
    1.34e-05

    Parameters
    ----------
    ds
        The result of `sensitivities`, by all parameters in `errors`.
    errors
        The standard errors of parameters, by name or symbol, in SI units: numbers, arrays, or
        DataArrays over dimensions of the points.

    Returns
    -------
    xarray.Dataset
        For each amplitude `<amplitude>_standard_error`, in its unit.

    Raises
    ------
    TypeError
        A parameter is unknown, or given twice.
    ValueError
        `ds` lacks the derivative with respect to a parameter.
    """
    by_name = full_names(errors)
    if PARAMETER not in ds.coords or (missing := by_name.keys() - set(ds[PARAMETER].values)):
        lacking = (
            f"with respect to {', '.join(sorted(missing))}" if PARAMETER in ds.coords else "at all"
        )
        raise ValueError(f"there are no derivatives {lacking}: call sensitivities(..., by=...)")
    found = ds.drop_vars([PARAMETER, *ds.data_vars])
    for name in (name for name in AMPLITUDES if f"{name}_sensitivity" in ds):
        squares: Any = 0.0
        for parameter, error in by_name.items():
            derivative = ds[f"{name}_sensitivity"].sel({PARAMETER: parameter}, drop=True)
            scale = abs(ds[parameter]) if _form(parameter) == LOGARITHMIC else 1.0
            squares = squares + (derivative * error / scale) ** 2
        variable = RESULTS[name]
        standard_error = ds[name] * squares**0.5
        standard_error.attrs = {
            "long_name": f"standard error of the {variable.meaning}",
            "units": variable.units,
        }
        found[f"{name}_standard_error"] = standard_error
    return found


class _Step(NamedTuple):
    """Points (n, parameters) with one parameter changed, and the change (n,) of it or of its log.

    A point stays where it is if the new value would be invalid.
    """

    rows: NDArray[np.float64]
    by: NDArray[np.float64]

    @classmethod
    def of(cls, rows: NDArray[np.float64], name: str, part: float) -> _Step:
        """Change a parameter by a part of the step."""
        variable, column = PARAMETERS[name], Parameters._fields.index(name)
        by = np.full(len(rows), part * _STEP)
        if variable.measured_in is None:
            moved = rows[:, column] * math.exp(part * _STEP)
        else:
            units = [rows[:, Parameters._fields.index(unit)] for unit in variable.measured_in]
            by *= np.abs(np.prod(units, axis=0))
            moved = rows[:, column] + by
        changed = rows.copy()
        changed[:, column] = moved
        valid = np.array([variable.complaint(value) is None for value in moved], dtype=bool)
        valid &= moved != rows[:, column]
        if column in _ENERGY:
            valid &= np.array([unbounded(*row) is None for row in changed[:, _ENERGY]], dtype=bool)
        return cls(np.where(valid[:, None], changed, rows), np.where(valid, by, 0.0))


def _same_motion(results: NDArray[np.float64], around: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether all motions around a point are of its kind, for each parameter and point.

    `results` (n, columns) of the points; `around` (k, steps, n, columns) of the points next to
    them.
    """
    close = (around[..., _STATUS] == Status.OK) & (results[:, _STATUS] == Status.OK)
    alike = (around[..., _KIND] == results[:, _KIND]).all(axis=-1)
    return (close & alike).all(axis=1)


def _derivatives(
    values: NDArray[np.float64], moved: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the derivatives of ln(values) and their errors, (k, n), from values (k, 4, n).

    The differences over the whole step and half of it are extrapolated to a step of length 0. They
    are of order 2, or of order 1 where a point could be moved to one side only.
    """
    logs = np.log(values)
    whole = (logs[:, 3] - logs[:, 0]) / (moved[:, 3] - moved[:, 0])
    half = (logs[:, 2] - logs[:, 1]) / (moved[:, 2] - moved[:, 1])
    both = (moved[:, 0] != 0.0) & (moved[:, 3] != 0.0)
    correction = (half - whole) / np.where(both, 3.0, 1.0)
    found = half + correction
    # A logarithm of 0 has no derivative.
    found[~np.isfinite(logs).all(axis=1)] = np.nan
    return found, np.abs(correction)


def _jumps(
    middle: NDArray[np.float64],
    values: NDArray[np.float64],
    moved: NDArray[np.float64],
    roughness: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the errors (k, n) of derivatives of ln(values) by jumps, from values (k, 4, n).

    A motion may jump without a change of its kind. Four times the second difference over half the
    step, less that over the whole step, is then three times the jump, and of order 4 if there is
    none. A jump changes the derivative by 7/6 of itself over the step. Without both sides there is
    no second difference, and the error is 0.
    """
    logs = np.log(values) - np.log(middle)
    tripled = np.abs(4.0 * (logs[:, 1] + logs[:, 2]) - (logs[:, 0] + logs[:, 3]))
    both = (moved[:, 0] != 0.0) & (moved[:, 3] != 0.0)
    # Roughness alone may make this much, by the weights 4, 4, 1, 1 and, of the middle, 6.
    excess = np.where(both, np.maximum(tripled - 16.0 * roughness, 0.0), 0.0)
    return np.nan_to_num(excess) / np.abs(moved).max(axis=1)


def _largeness(
    rows: NDArray[np.float64], results: NDArray[np.float64], name: str
) -> NDArray[np.float64]:
    """Return the scale of the tolerance relative to an amplitude, (n,): 1 unless that is small.

    As for `amplitude_error`, the scale is at least 1 % of max(2K, M omega^2)|X_m|, over A for the
    stress.
    """
    least = _SMALL_PART * full_forces(rows)
    if name == "elastic_stress_amplitude":
        least /= rows[:, _AREA]
    return np.maximum(least / results[:, RESULT_COLUMNS.index(name)], 1.0)


def _variable(
    name: str, suffix: str, array: NDArray[np.float64], parameters: list[str], places: xr.Dataset
) -> tuple[tuple[str, ...], NDArray[np.float64], dict[str, str]]:
    """Return an array (k, n) as a variable over the dimensions of the points and `parameter`."""
    what = "derivative" if suffix == "sensitivity" else "estimated error of the derivative"
    attributes = {
        "long_name": f"{what} of the logarithm of the {RESULTS[name].meaning} "
        "with respect to the parameters",
        "form": " ".join(_form(parameter) for parameter in parameters),
    }
    shape = (*places.sizes.values(), len(parameters))
    return (*map(str, places.sizes), PARAMETER), array.T.reshape(shape), attributes


def _form(parameter: str) -> str:
    return LOGARITHMIC if PARAMETERS[parameter].measured_in is None else PLAIN


def _listed(names: str | Iterable[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)
