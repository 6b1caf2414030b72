"""The equations of motion as the adaptive method takes them: cusps rounded, errors weighted."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials
from stickslip.model import film, friction, noise
from stickslip.model.rhs import Equations, equations
from stickslip.model.solids import Thresholds, thresholds
from stickslip.model.state import State, components_of
from stickslip.options import ADIABATIC, Physics
from stickslip.parameters import Parameters

# An error of the velocity counts also by the error of the force that it makes, against this many
# times the force that locks the block: a locked block moves with the drive to parts in 1e5, and its
# slip must be right, not just its speed.
_FORCE_WEIGHT = 20.0
_LARGEST_AT_CUSP = 100.0

# A cusp of the law is rounded below this many tolerances of X_m omega: a step may then cross the
# cusp without falling into it. A wider rounding changes the slip of a locked block, and the stress
# with it; a tenth of this one takes a tenth more steps, and a hundredth ten times as many.
_ROUNDING = 1e-2

# Where the noise holds ln(phi) up, it forgets an error at the rate 2 D_eff/phi^2. The error counts
# less there, by this many times that rate over the film's own, but at least a thousandth.
_FORGETTING_WEIGHT, _LARGEST_RELIEF = 10.0, 1000.0
_SLOWEST_FILM = 100.0  # rates omega


class Problem(NamedTuple):
    """What the adaptive method integrates."""

    p: Parameters
    u_s: float
    """Relative speed [m/s] below which a cusp of the law is rounded."""
    phases: Thresholds
    """Order parameters by which the phases of the film are told apart."""


@inline
def rounding_speed(p: Parameters, rtol: float) -> float:
    """Relative speed [m/s] below which a cusp of the law is rounded at a tolerance."""
    return _ROUNDING * rtol * (abs(p.drive_amplitude) * p.angular_frequency)


@inline
def problem_of(p: Parameters, rtol: float) -> Problem:
    """The problem of the parameters `p` at a tolerance."""
    return Problem(p, rounding_speed(p, rtol), thresholds(p))


class ProblemFunctions(NamedTuple):
    """What a drive needs to integrate a Problem; inline functions."""

    equations: Equations

    width: int
    """Number of state variables."""

    rhs: Callable[..., State]
    """(problem, t, y): the rates of the state."""

    jacobian: Callable[..., tuple[State, ...]]
    """(problem, t, y): the rows of the Jacobian, and d(rhs)/dt."""

    error_weight: Callable[..., State]
    """(problem, y, J): weights [1/m, s/m, 1, 1] with which the errors of y count."""


@cache
def problem_functions(physics: Physics) -> ProblemFunctions:
    """What a drive needs to integrate these physics."""
    bound = equations(physics)
    model_rhs, model_jacobian, has_cusp = bound.rhs, bound.jacobian, bound.law.has_cusp

    @inline
    def rhs(problem: Problem, t: float, y: State) -> State:
        return model_rhs(problem.p, t, y, problem.u_s)

    @inline
    def jacobian(problem: Problem, t: float, y: State) -> tuple[State, ...]:
        return model_jacobian(problem.p, t, y, problem.u_s)

    @inline
    def error_weight(problem: Problem, y: State, J: tuple[State, ...]) -> State:
        p = problem.p
        X_m = abs(p.drive_amplitude)
        V_m = X_m * p.angular_frequency
        force = V_m * (-J[1][1] * p.block_mass) / (_FORCE_WEIGHT * _locking_force(p))
        if has_cusp(p):  # the slope of the rounded cusp grows with the tolerance
            force = _LARGEST_AT_CUSP if force > _LARGEST_AT_CUSP else force
        return 1.0 / X_m, (1.0 + force) / V_m, _film_weight(p, y[2])

    @inline
    def relaxing_weight(problem: Problem, y: State, J: tuple[State, ...]) -> State:
        p = problem.p
        x_weight, u_weight, psi_weight = error_weight(problem, y, J)
        # An error of the strain counts like that of the velocity that it belongs to in the end,
        # by itself and by its force.
        V_m = abs(p.drive_amplitude) * p.angular_frequency
        strain = V_m * friction.strain_slope(p)
        force = strain * (-J[1][3] * p.block_mass) / (_FORCE_WEIGHT * _locking_force(p))
        return x_weight, u_weight, psi_weight, (1.0 + force) / strain

    weight = error_weight if physics.strain == ADIABATIC else relaxing_weight
    width = len(components_of(physics.strain))
    return ProblemFunctions(bound, width, rhs, jacobian, weight)


@inline
def _locking_force(p: Parameters) -> float:
    """The sum of the forces that springs and inertia of a locked block need [N]."""
    X_m = abs(p.drive_amplitude)
    V_m = X_m * p.angular_frequency
    return 2.0 * p.spring_stiffness * X_m + p.block_mass * p.angular_frequency * V_m


@inline
def _film_weight(p: Parameters, psi: float) -> float:
    """The weight of an error of ln(phi)."""
    _, inverse_phi = exponentials(psi)
    forgetting = _FORGETTING_WEIGHT * (2.0 * noise.typical_path(p, inverse_phi))
    own = _SLOWEST_FILM * p.angular_frequency + p.kinetic_coefficient * abs(film.heating(p))
    most = _LARGEST_RELIEF * own
    forgetting = most if forgetting > most else forgetting
    return own / ((1.0 + abs(psi)) * (own + forgetting))
