"""The promises of every law of the viscous stress: odd, rising, with correct slopes and units.

Tests check all laws of stickslip; a law from outside is checked when it is loaded. A kernel, cached
like all others, samples the law at speeds from far below the slip of a locked block to 1 m/s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba.core.errors import NumbaError
from numpy.typing import ArrayLike, NDArray

from stickslip.compiled.decorators import kernel_factory, named_kernel
from stickslip.compiled.fields import make_row_reader
from stickslip.laws import LawError
from stickslip.model import scaling
from stickslip.model.laws import FrictionLaw
from stickslip.parameters import ParameterError, Parameters, ParameterValues
from stickslip.variables import PARAMETERS

Array = NDArray[np.float64]

FLUIDS = (
    *({"gamma": gamma} for gamma in (-0.9, -2 / 3, -0.5, -1 / 3, 0.0, 1 / 3, 2 / 3, 2.0, 5.0)),
    {"k": 1.0, "h": 1e-8},
)
"""The fluids in which a law is checked if it declares none."""

_SPEEDS = np.geomspace(1e-15, 1.0, 61)
_BOTH_WAYS = np.concatenate([-_SPEEDS[::-1], _SPEEDS])
_AT_REST = np.array([0.0, -0.0, 5e-324, -5e-324, 1e-300])
_U_S = 8e-12  # the drive's largest speed times a tolerance of 1e-6
_DRIVE = 8e-6  # the drive's largest speed
_PHI = 0.37
_STENCIL, _WEIGHTS = np.array([-2, -1, 1, 2]), np.array([1, -8, 8, -1]) / 12  # of fourth order


class _Values(NamedTuple):
    """The values of the functions of a law at some speeds (n,)."""

    stress: Array
    rounded: Array
    slope: Array
    over_psi: Array
    stable_slope: Array
    in_own_units: Array
    """The stress, computed in the units of the point."""


@dataclass(frozen=True)
class Fluid:
    """A law with the parameters of one fluid."""

    law: FrictionLaw
    p: Parameters
    sample: Any

    @property
    def has_cusp(self) -> bool:
        """Whether the slope is infinite at rest."""
        return bool(self._sampled(0.0, _PHI, 0.0)[0, -1])

    def at(self, u: ArrayLike, phi: ArrayLike = _PHI, u_s: ArrayLike = 0.0) -> _Values:
        """Return the values at speeds `u` [m/s], order parameters and widths `u_s` [m/s] (n,)."""
        return _Values(*self._sampled(u, phi, u_s).T[:-1])

    def _sampled(self, *places: ArrayLike) -> Array:
        where = np.column_stack([each.ravel() for each in np.broadcast_arrays(*places)])
        out = np.empty((len(where), len(_Values._fields) + 1))
        own = np.empty(len(scaling.Reduced._fields))
        self.sample(np.array(self.p), where.astype(float), own, out)
        return out


def fluids_of(law: FrictionLaw, name: str) -> list[Fluid]:
    """Return the fluids in which a law is checked; `name` must be unique to the law.

    Raises LawError if it cannot be compiled, or names unknown or unsuitable parameters.
    """
    beyond_paper = [name for name, variable in PARAMETERS.items() if not variable.in_paper]
    for each in {*law.parameters, *law.scaled} - PARAMETERS.keys():
        raise LawError(f"there is no parameter {each!r}; a law uses k and gamma")
    for each in law.scaled.keys() - {"viscosity_coefficient", "rheological_index", *beyond_paper}:
        raise LawError(f"`scaled` has {each}, on which more than the law depends")
    try:
        points = [Parameters(**fluid) for fluid in law.fluids or FLUIDS]
        fluids = [Fluid(law, p, _sample_kernel(name, law)) for p in points]
        fluids[0].at(1e-6)
    except (ParameterError, TypeError) as error:
        raise LawError(f"`fluids`: {error}") from error
    except NumbaError as error:
        lines = dict.fromkeys(line.strip() for line in str(error).splitlines() if line.strip())
        raise LawError(f"it cannot be compiled: {' '.join(lines)}") from error
    return fluids


def require_promises(law: FrictionLaw, name: str) -> None:
    """Raise LawError, with the fluid, the speed and the values, if the law breaks a promise."""
    for fluid in fluids_of(law, name):
        for promise in PROMISES:
            promise(fluid)
    # In the first fluid alone, because a parameter may have no effect in another.
    fluid = fluids_of(law, name)[0]
    for each in law.parameters:
        changed = fluid.p._replace(**{each: 0.9 * getattr(fluid.p, each)})
        if Fluid(law, changed, fluid.sample).at(3e-6).stress == fluid.at(3e-6).stress:
            raise LawError(f"`parameters` has {each}, on which the stress does not depend")


# --- the exact law -------------------------------------------------------------------------------


def odd(fluid: Fluid) -> None:
    """The stress is odd, bit for bit, and has the sign of the slip; NaN gives NaN."""
    stress, opposite = fluid.at(_SPEEDS).stress, fluid.at(-_SPEEDS).stress
    _require(fluid, "stress > 0 for u > 0", stress > 0, _SPEEDS, stress)
    _require(fluid, "stress(-u) = -stress(u)", opposite == -stress, _SPEEDS, opposite, -stress)
    nothing = fluid.at(np.nan, u_s=_U_S)
    _require(fluid, "stress of NaN is NaN", np.isnan(nothing.stress), [np.nan], nothing.stress)
    _require(fluid, "rounded of NaN is NaN", np.isnan(nothing.rounded), [np.nan], nothing.rounded)


def rising_with_the_slip(fluid: Fluid) -> None:
    """The stress does not fall with the slip, so that friction always dissipates."""
    speeds = np.concatenate([-_SPEEDS[::-1], [0.0], _SPEEDS])
    values = fluid.at(speeds)
    before = np.concatenate([[-np.inf], values.stress[:-1]])
    _require(fluid, "stress does not fall with u", values.stress >= before, speeds, values.stress)
    _require(fluid, "slope >= 0", values.slope >= 0, speeds, values.slope)


def rising_with_the_order(fluid: Fluid) -> None:
    """The size of the stress does not fall with the order parameter."""
    below = np.zeros(len(_SPEEDS))
    for phi in (0.0, 1e-9, 0.1, _PHI, 1.1):
        stress = fluid.at(_SPEEDS, phi).stress
        _require(
            fluid, f"stress does not fall with phi, up to {phi}", stress >= below, _SPEEDS, stress
        )
        below = stress


def derivative_over_the_log_of_the_order(fluid: Fluid) -> None:
    """The third value of `rounded` is the derivative with respect to ln(phi)."""
    u, step = _SPEEDS[::10, None], 1e-3
    near = fluid.at(u, _PHI * np.exp(step * _STENCIL)).stress.reshape(-1, 4)
    expected, values = near @ _WEIGHTS / step, fluid.at(u)
    close = _is_close(values.over_psi, expected, 1e-9, 1e-11 * np.abs(values.stress))
    what = "third value of rounded = d stress/d ln(phi)"
    _require(fluid, what, close, u[:, 0], values.over_psi, expected)


def slope(fluid: Fluid) -> None:
    """The second value of `rounded` is the derivative with respect to u."""
    step, values = 1e-3 * _BOTH_WAYS, fluid.at(_BOTH_WAYS)
    expected = _difference(fluid, _BOTH_WAYS, step, 0.0)
    # Where the stress is nearly constant, differences lose digits; and a law may be wrong by the
    # rounding of its stress at the speed of the drive.
    size = np.abs(_BOTH_WAYS)
    noise = (1e-11 * np.abs(values.stress) + 1e-13 * fluid.at(_DRIVE).stress) / size
    close = _is_close(values.slope, expected, 1e-9, noise)
    _require(fluid, "slope = d stress/du", close, _BOTH_WAYS, values.slope, expected)


def finite_at_rest(fluid: Fluid) -> None:
    """Where the blocks move together, all values are finite and the stress is 0."""
    for u_s in (0.0, _U_S):
        values = fluid.at(_AT_REST, u_s=u_s)
        finite = np.isfinite(values.slope) & (values.slope >= 0)
        _require(fluid, "slope is finite and >= 0", finite, _AT_REST, values.slope)
        for stress in (values.stress, values.rounded):
            _require(fluid, "stress is finite", np.isfinite(stress), _AT_REST, stress)
            _require(fluid, "stress(0) = 0", stress[:2] == 0.0, _AT_REST[:2], stress)


# --- the rounded law -----------------------------------------------------------------------------


def exact_away_from_the_cusp(fluid: Fluid) -> None:
    """The rounded law equals the exact one away from a cusp, and everywhere if there is none."""
    exact = fluid.at(_BOTH_WAYS)
    parts = {part: 20 * part**2 + 1e-13 for part in (1e-3, 1e-5, 1e-7)}  # error falls as the square
    for part, error in parts.items() if fluid.has_cusp else ((10.0, 1e-13), *parts.items()):
        values, what = fluid.at(_BOTH_WAYS, u_s=part * np.abs(_BOTH_WAYS)), f"at u_s = {part:g} |u|"
        for name, of, as_of in (
            ("stress", values.rounded, exact.stress),
            ("slope", values.slope, exact.slope),
        ):
            close = _is_close(of, as_of, error)
            _require(fluid, f"rounded {name} {what} = exact one", close, _BOTH_WAYS, of, as_of)


def rounded_odd(fluid: Fluid) -> None:
    """The rounded stress is odd and its slope even, bit for bit."""
    there, back = fluid.at(_SPEEDS, u_s=_U_S), fluid.at(-_SPEEDS, u_s=_U_S)
    for what, of, as_of in (
        ("rounded(-u) = -rounded(u)", back.rounded, -there.rounded),
        ("slope(-u) = slope(u), rounded", back.slope, there.slope),
    ):
        _require(fluid, what, of == as_of, _SPEEDS, of, as_of)


def rounded_slope(fluid: Fluid) -> None:
    """The rounded slope is the derivative of the rounded stress."""
    u = np.outer([1.0, -1.0], np.geomspace(0.1, 30.0, 30) * _U_S).ravel()
    step = 1e-3 * np.abs(u)
    largest = np.abs([fluid.at(u + way * step, u_s=_U_S).rounded for way in (-2, 2)]).max(axis=0)
    noise = 4e-13 * largest / step + 1e-13 * fluid.at(_DRIVE).stress / np.abs(u)
    of, expected = fluid.at(u, u_s=_U_S).slope, _difference(fluid, u, step, _U_S)
    close = _is_close(of, expected, 1e-9, noise)
    _require(fluid, f"slope = d stress/du, rounded at u_s = {_U_S:g} m/s", close, u, of, expected)


# --- declarations of a law -----------------------------------------------------------------------


def cusp(fluid: Fluid) -> None:
    """The slope is unbounded at a cusp, and only there."""
    speeds = np.array([0.0, 1e-15, 1e-6])
    at_rest, near, far = slopes = fluid.at(speeds).slope
    if fluid.has_cusp:
        steep = [at_rest > 10 * near > 100 * far]
        _require(fluid, "slope is unbounded at a cusp", steep, [0.0], slopes)
        rounded = fluid.at(0.0, u_s=_U_S).slope
        _require(fluid, "rounded slope at a cusp is smaller", rounded < at_rest, [0.0], rounded)
    else:
        bounded = [at_rest <= near * (1 + 1e-6)]
        _require(fluid, "slope is bounded without a cusp", bounded, [0.0], slopes)


def stable_slope(fluid: Fluid) -> None:
    """The stable slope bounds the slopes up to a speed, except at a cusp."""
    stable = fluid.at(_SPEEDS).stable_slope
    bounded = np.isfinite(stable) & (stable >= 0)
    _require(fluid, "stable_slope is finite and >= 0", bounded, _SPEEDS, stable)
    for part in () if fluid.has_cusp else (0.0, 0.1, 0.5, 1.0):
        steep = fluid.at(part * _SPEEDS).slope
        enough = stable >= steep * (1 - 1e-12)
        _require(fluid, f"stable_slope >= slope at {part:g} u", enough, _SPEEDS, stable, steep)


def scaled(fluid: Fluid) -> None:
    """The stress is the same in the units of kernels, so that no number with a unit is hidden."""
    speeds = np.array([-2.0, 1e-3, 1.0, 30.0]) * _DRIVE
    values = fluid.at(speeds)
    same = _is_close(values.in_own_units, values.stress, 1e-12)
    what = (
        "stress is the same in the units of kernels (does the law contain a number with a unit, "
        "or a parameter not `scaled` as the law uses it?)"
    )
    _require(fluid, what, same, speeds, values.in_own_units, values.stress)


PROMISES: tuple[Callable[[Fluid], None], ...] = (
    odd,
    rising_with_the_slip,
    rising_with_the_order,
    derivative_over_the_log_of_the_order,
    slope,
    finite_at_rest,
    exact_away_from_the_cusp,
    rounded_odd,
    rounded_slope,
    cusp,
    stable_slope,
    scaled,
)
"""The promises, as functions that raise LawError if a law breaks them in a fluid."""


def _require(
    fluid: Fluid, what: str, holds: Any, u: Any, found: Array, expected: Array | None = None
) -> None:
    """Raise LawError if a promise does not hold at one of the speeds `u` (n,)."""
    if np.all(holds):
        return
    first = int(np.argmin(holds))
    own = ("viscosity_coefficient", "rheological_index")
    p = ", ".join(f"{PARAMETERS[name].symbol} = {getattr(fluid.p, name):g}" for name in own)
    right = "" if expected is None else f" instead of {expected[first]!s}"
    raise LawError(f"violated: {what}, at u = {u[first]:g} m/s, {p}: {found[first]!s}{right}")


def _difference(fluid: Fluid, u: Array, step: Array, u_s: float) -> Array:
    """Return the derivative of the rounded stress, or of the exact one for u_s = 0, numerically."""
    near = fluid.at(u[:, None] + step[:, None] * _STENCIL, u_s=u_s)
    return (near.rounded if u_s else near.stress).reshape(-1, 4) @ _WEIGHTS / step


def _is_close(of: Array, as_of: Array, relative: float, absolute: Any = 0.0) -> Any:
    """Return where numbers (n,) are close to others; numbers that are not finite never are."""
    return np.abs(of - as_of) <= np.maximum(relative * np.abs(as_of), absolute)


# --- the kernel that samples a law ---------------------------------------------------------------


@kernel_factory
def _sample_kernel(name: str, law: FrictionLaw) -> Any:
    """Return the kernel (point, where, own, out) that samples a law at `where` (n, 3): u, phi, u_s.

    `point` (parameters,) is in SI units. The kernel writes the reduced parameters into `own`, and
    `_Values` and whether the law has a cusp into `out` (n, 7).
    """
    stress, rounded, has_cusp, stable = law.stress, law.rounded, law.has_cusp, law.stable_slope
    parameters_of, reduced_of = make_row_reader(ParameterValues), make_row_reader(scaling.Reduced)
    write = scaling.reduction(law, scaling.FOLLOWING)
    values_of, units_of = scaling.model_values(None), scaling.units_of

    def sample(point: np.ndarray, where: np.ndarray, own: np.ndarray, out: np.ndarray) -> None:
        p = parameters_of(point)
        write(p, own)
        q, unit = values_of(reduced_of(own)), units_of(p)
        for i in range(where.shape[0]):
            u, phi, u_s = where[i, 0], where[i, 1], where[i, 2]
            out[i, 0] = stress(p, u, phi)
            out[i, 1], out[i, 2], out[i, 3] = rounded(p, u, phi, u_s)
            out[i, 4] = stable(p, u, phi)
            out[i, 5] = stress(q, u / unit.speed, phi) * unit.stress
            out[i, 6] = has_cusp(p)

    return named_kernel(f"law[{name}]", sample)
