"""From parameters to stationary orbits and their observables: the friendly side of the doors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip import kernels, stability
from stickslip.options import DEFAULTS, NoiseError, Options
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

_NOISE = Parameters._fields.index("noise_intensity")
_PHI_0 = Parameters._fields.index("initial_order_parameter")


class Orbit(NamedTuple):
    """The observables of one stationary orbit, in SI units; `variables.RESULTS` has the meanings.

    Unless `status` is ok the amplitudes are NaN and the counts -1. `state` is (x, v, ln phi) at
    the start of a drive period on the orbit, or where the search ended.
    """

    elastic_stress_amplitude: float
    friction_force_amplitude: float
    elastic_stress_max: float
    elastic_stress_min: float
    friction_force_max: float
    friction_force_min: float
    amplitude_error: float
    power_balance_error: float
    orbit_periods: int
    melting_count: int
    asymmetry: float
    periods_integrated: int
    status: Status
    state: tuple[float, float, float]


def prepared_points(points: np.ndarray, noise: str) -> np.ndarray:
    """The rows of parameters (n, 20) as the doors take them under a noise treatment.

    Raises NoiseError where a film starts at phi = 0 and nothing could make it solid.
    """
    points = np.array(np.atleast_2d(points), dtype=float)
    if noise == "none":
        points[:, _NOISE] = 0.0
    if np.any((points[:, _NOISE] == 0.0) & (points[:, _PHI_0] == 0.0)):
        raise NoiseError
    return points


def prepare_kernels(options: Options, gammas: np.ndarray) -> None:
    """Compile or load what `compute_orbits` needs for fluids with these rheological indices."""
    if options.method == "adaptive":
        kernels.compile_lanes(gammas, options.settings())
    else:
        compute_orbits(np.empty((0, len(Parameters._fields))), options)


def compute_orbits(points: np.ndarray, options: Options) -> tuple[np.ndarray, np.ndarray]:
    """Stationary orbits of many points.

    Parameters
    ----------
    points
        (n, 20) parameters in SI units, in the order of `Parameters._fields`.
    options
        Method, tolerances, noise.

    Returns
    -------
    results
        (n, 13) in the order of `RESULT_COLUMNS`; the last column is the Status.
    finals
        (n, 4) in the order of `kernels.FINAL_COLUMNS`.

    Raises
    ------
    NoiseError
        phi_0 = 0 without noise.
    """
    points = prepared_points(points, options.noise)
    results = np.full((len(points), len(RESULT_COLUMNS)), np.nan)
    finals = np.full((len(points), len(kernels.FINAL_COLUMNS)), np.nan)
    if options.method == "adaptive":
        kernels.lane_orbits(points, options.settings(), results, finals)
        return results, finals
    stable = options.dt <= stability.largest_stable_step(points)
    results[~stable] = refused_row()
    if stable.any():
        parts = results[stable], finals[stable]
        kernels.fixed_lane_orbits(points[stable], options.settings(), *parts)
        results[stable], finals[stable] = parts
    return results, finals


def refused_row() -> np.ndarray:
    """The result row of a point whose fixed step is unstable."""
    return _empty_row(Status.REFUSED)


def failed_row() -> np.ndarray:
    """The result row of a point whose computation raised an exception."""
    return _empty_row(Status.FAILED)


def _empty_row(status: Status) -> np.ndarray:
    row = dict.fromkeys(RESULT_COLUMNS, np.nan)
    row |= {"orbit_periods": -1, "melting_count": -1, "periods_integrated": -1, "status": status}
    return np.array(list(row.values()), dtype=float)


def stationary_orbit(
    parameters: Parameters | None = None,
    *,
    method: str = DEFAULTS.method,
    rtol: float = DEFAULTS.rtol,
    dt: float = DEFAULTS.dt,
    noise: str = DEFAULTS.noise,
    max_periods: int = DEFAULTS.max_periods,
    max_steps: int | None = DEFAULTS.max_steps,
    accelerate: bool = DEFAULTS.accelerate,
) -> Orbit:
    """The stationary orbit that the start of `parameters` leads to, and its amplitudes.

    Parameters
    ----------
    parameters
        The model's parameters; the paper's Fig. 3 by default.
    method
        'adaptive' (stiff, order 4) or 'euler-cromer' (the paper's explicit scheme, order 1).
    rtol
        Tolerance of the adaptive method and of stationarity.
    dt
        Step of euler-cromer [s].
    noise
        'typical-path', or 'none' for the deterministic equation.
    max_periods, max_steps
        Budgets of drive periods and of steps.
    accelerate
        Extrapolate a plainly contracting sequence instead of iterating it to the end.

    Returns
    -------
    Orbit
        Its `status` says how the search ended; no exception is raised for a failure to converge.

    Raises
    ------
    NoiseError
        phi_0 = 0 without noise.
    OptionError
        An unknown method or treatment, a tolerance, step or budget out of range.
    """
    options = Options(
        method=method,
        rtol=rtol,
        dt=dt,
        max_steps=max_steps,
        stationary_rtol=rtol,
        max_periods=max_periods,
        accelerate=accelerate,
        noise=noise,
    )
    results, finals = compute_orbits(np.array(parameters or Parameters()), options)
    return orbit_of_row(results[0], finals[0])


def orbit_of_row(row: np.ndarray, final: np.ndarray) -> Orbit:
    """The Orbit of a result row and its final state."""
    fields = dict(zip(RESULT_COLUMNS, row.tolist(), strict=True))
    for count in ("orbit_periods", "melting_count", "periods_integrated"):
        fields[count] = int(fields[count])
    fields["status"] = Status(int(fields["status"]))
    return Orbit(**fields, state=(float(final[0]), float(final[1]), float(final[2])))
