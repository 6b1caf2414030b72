"""The solvers of other packages, each with the best settings of those that were tried."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Callable
from functools import cache, partial
from importlib import metadata
from typing import Any, NamedTuple

import numpy as np

from peers.scaled import FLAGS, fill_rates, rates, rates_jacobian
from stickslip.model import noise
from stickslip.parameters import Parameters, ParameterValues

State = tuple[float, float, float]
"""(x, v, ln phi) in SI units."""

LADDER = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)

# Steps between two outputs from which a run of numbalsoda counts as stuck: a period takes up to 1e4
# of them, and at tight tolerances LSODA may go on for ever with steps of no length.
MOST_STEPS = 2_000_000
_PLENTY = 100_000_000
_ATOL_OF_CVODES = 1e-3  # in rtol
_SMALLEST_STRAIN_RATE = 1e-90  # as in the model: stands for 0 where a derivative is infinite

# Long enough for a solver to take its first steps and to have its own parts compiled.
_WARM_UP_PHASE = 1e-3

_PARAMETERS = len(Parameters._fields)
_INDEX = Parameters._fields.index("rheological_index")


class PeerFailed(RuntimeError):  # noqa: N818 - an outcome of the benchmark, not an error of it
    """A solver gave up, or ended with something that is not a state."""


class Peer(NamedTuple):
    """A solver of another package on the scaled equations of `peers.scaled`.

    `solve` returns the scaled state at a phase from the one at 0, of a row of parameters, at a
    tolerance, or raises PeerFailed. `package` is the distribution that it comes from, `ladder` the
    tolerances it is measured at, `slow` whether quick runs leave it out.
    """

    package: str
    solve: Callable[[np.ndarray, np.ndarray, float, float], np.ndarray]
    ladder: tuple[float, ...] = LADDER
    slow: bool = False

    def version(self) -> str | None:
        """Return version of the installed package; None where it is not installed."""
        try:
            return metadata.version(self.package)
        except metadata.PackageNotFoundError:
            return None

    def prepare(self, p: Parameters, start: State, rtol: float) -> None:
        """Do what need not be timed: imports and compilation for this fluid and tolerance."""
        row, begin, _ = _scaled(p, start)
        rates(row, 0.0, begin)
        rates_jacobian(row, 0.0, begin)  # a solver may ask for its first Jacobian late
        self.solve(row, begin, _WARM_UP_PHASE, rtol)

    def end_state(self, p: Parameters, start: State, periods: int, rtol: float) -> State:
        """Return the state (x, v, ln phi) after so many drive periods from `start` at phase 0.

        Raises PeerFailed where the solver does not get there.
        """
        row, begin, scales = _scaled(p, start)
        end = self.solve(row, begin, 2.0 * math.pi * periods, rtol) * scales
        if not np.isfinite(end).all():
            raise PeerFailed("ends with NaN")
        x, v, psi = end.tolist()
        return x, v, psi


def _scaled(p: Parameters, start: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the row of parameters, the scaled state, and its scales: at phase 0, u = -v."""
    X_m = abs(p.drive_amplitude)
    scales = np.array([X_m, -X_m * p.angular_frequency, 1.0])
    return np.array(p, dtype=float), np.array(start) / scales, scales


# --- numbalsoda -----------------------------------------------------------------------------------


def _numbalsoda(row: np.ndarray, begin: np.ndarray, phase: float, rtol: float) -> np.ndarray:
    """Solve by `numbalsoda.lsoda`, in C++; it takes one absolute tolerance and no Jacobian.

    In scaled variables atol = rtol came out best of 0.001 to 10 rtol and of four scales of ln phi:
    the others are not faster at equal error, and fail on more points at loose tolerances. It fails
    on more and more points of the paper's fluid below rtol 1e-8, hence 5e-9 in its ladder, and
    needs 1e-10 for an error of 1e-8 with the others.
    """
    from numbalsoda import lsoda

    states, success = lsoda(
        right_hand_side().address, begin, np.array([0.0, phase]), row, rtol, rtol, MOST_STEPS
    )
    if not success:
        raise PeerFailed("LSODA reports no success")
    return np.asarray(states[-1])


_LADDER_OF_NUMBALSODA = tuple(sorted({*LADDER, 5e-9, 1e-10}, reverse=True))


@cache
def right_hand_side() -> Any:
    """Return the compiled right-hand side for numbalsoda."""
    from numba import carray, cfunc
    from numbalsoda import lsoda_sig

    @cfunc(lsoda_sig, **FLAGS)
    def callback(s, y, out, row):
        fill_rates(carray(row, (_PARAMETERS,)), s, carray(y, (3,)), carray(out, (3,)))

    return callback


# --- CyRK and SciPy -------------------------------------------------------------------------------


def _cyrk(method: str, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float) -> np.ndarray:
    """Solve by an implicit method of `CyRK.nbsolve2_ivp`, in C++; it takes no Jacobian."""
    from CyRK import nbsolve2_ivp

    result = nbsolve2_ivp(
        int(_cyrk_right_hand_side().address), (0.0, phase), begin,
        method=method, args=row, rtol=rtol, atol=rtol, max_num_steps=_PLENTY,
        t_eval=np.array([phase]),  # otherwise every step is kept
    )  # fmt: skip
    try:
        if not result.success:
            raise PeerFailed(str(result.message))
        return np.array(result.y[:, -1])
    finally:
        result.free()


@cache
def _cyrk_right_hand_side() -> Any:
    from CyRK import cyjit
    from numba import carray

    @cyjit
    def callback(out, s, y, row):
        fill_rates(carray(row, (_PARAMETERS,)), s, carray(y, (3,)), carray(out, (3,)))

    return callback


def _scipy_ivp(
    method: str, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
) -> np.ndarray:
    """Solve by `scipy.integrate.solve_ivp` with compiled right-hand side and Jacobian."""
    from scipy.integrate import solve_ivp

    try:
        with warnings.catch_warnings(action="ignore"):
            solution = solve_ivp(
                lambda s, y: rates(row, s, y), (0.0, phase), begin, method=method, t_eval=[phase],
                rtol=rtol, atol=rtol, jac=lambda s, y: rates_jacobian(row, s, y),
            )  # fmt: skip
    except ValueError as error:  # NaN in a linear system
        raise PeerFailed(str(error)) from error
    if not solution.success or not solution.y.size:
        raise PeerFailed(str(solution.message))
    return np.asarray(solution.y[:, -1])


# --- casadi ---------------------------------------------------------------------------------------


def _casadi_cvodes(row: np.ndarray, begin: np.ndarray, phase: float, rtol: float) -> np.ndarray:
    """Solve by casadi's CVODES (BDF), with derivatives by automatic differentiation.

    One integrator a fluid, tolerance and phase. At absolute tolerances from 0.01 rtol on, CVODES
    fails at rtol 1e-5 and 1e-6 on the paper's fluid; C code from the expressions (`jit`) is not
    faster than casadi's own evaluation.
    """
    integrator = _cvodes(float(row[_INDEX]), phase, rtol)
    try:
        return np.asarray(integrator(x0=begin, p=row)["xf"]).ravel()
    except RuntimeError as error:
        message = str(error)
        name = re.search(r"CV_\w+", message)
        known = f"CVODES returns {name[0]}" if name else message.strip().splitlines()[-1][:120]
        raise PeerFailed(known) from error


@cache
def _cvodes(gamma: float, phase: float, rtol: float) -> Any:
    import casadi

    s, y = casadi.SX.sym("s"), casadi.SX.sym("y", 3)
    row = casadi.SX.sym("row", _PARAMETERS)
    values = [row[i] for i in range(_PARAMETERS)]
    values[_INDEX] = gamma
    growth = casadi.vertcat(*_expressions(casadi, ParameterValues(*values), s, y))
    options = {"abstol": _ATOL_OF_CVODES * rtol, "reltol": rtol, "max_num_steps": _PLENTY}
    equations = {"t": s, "x": y, "p": row, "ode": growth}
    return casadi.integrator("model", "cvodes", equations, 0.0, phase, options)


def _expressions(ops: Any, p: ParameterValues, s: Any, y: Any) -> list[Any]:
    """Return dy/ds of `peers.scaled` as expressions.

    `ops` is casadi; the fields of `p` may be symbols, except for the rheological index, which
    decides the form of the expression.
    """
    omega, X_m = p.angular_frequency, ops.fabs(p.drive_amplitude)
    V_m = X_m * omega
    phi = ops.exp(y[2])
    u, sign = y[1] * V_m, ops.sign(p.drive_amplitude)
    strain = u * p.strain_relaxation_time / p.film_thickness
    viscous = p.viscosity_coefficient * _rate_power(ops, u / p.film_thickness, p.rheological_index)
    force = (p.elastic_coefficient * phi**2 * strain + viscous) * p.contact_area
    growth = 2 * p.thermal_coefficient * (p.temperature - p.critical_temperature)
    growth = growth + p.elastic_coefficient * strain**2
    growth = growth - p.cubic_coefficient * phi + p.quartic_coefficient * phi**2
    noise_rate = noise.TYPICAL_FRACTION * p.noise_intensity / ops.fmax(phi**2, 1e-300)
    acceleration = (force - 2 * p.spring_stiffness * y[0] * X_m) / p.block_mass
    psi_rate = noise_rate - p.kinetic_coefficient * growth
    x_rate, V_rate = -sign * ops.sin(s) - y[1], -sign * ops.sin(s + 0.5 * np.pi)
    return [x_rate, V_rate - acceleration / (V_m * omega), psi_rate / omega]


def _rate_power(ops: Any, strain_rate: Any, gamma: float) -> Any:
    """Return sgn(r) |r|^(gamma + 1) with finite derivatives."""
    if gamma == 0.0:
        return strain_rate
    size = ops.fmax(ops.fabs(strain_rate), _SMALLEST_STRAIN_RATE)
    return ops.sign(strain_rate) * size ** (gamma + 1.0)


# --- all of them ----------------------------------------------------------------------------------

NUMBALSODA = "numbalsoda LSODA"

PEERS = {
    NUMBALSODA: Peer("numbalsoda", _numbalsoda, _LADDER_OF_NUMBALSODA),
    "CyRK LSODA": Peer("CyRK", partial(_cyrk, "LSODA")),
    "CyRK BDF": Peer("CyRK", partial(_cyrk, "BDF"), slow=True),
    "CyRK Radau": Peer("CyRK", partial(_cyrk, "RADAU"), slow=True),
    "casadi CVODES": Peer("casadi", _casadi_cvodes),
    "SciPy LSODA": Peer("scipy", partial(_scipy_ivp, "LSODA")),
    "SciPy BDF": Peer("scipy", partial(_scipy_ivp, "BDF"), slow=True),
    "SciPy Radau": Peer("scipy", partial(_scipy_ivp, "Radau"), slow=True),
}
