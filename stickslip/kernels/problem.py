"""The equations of motion with rounded cusps, for the adaptive method."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.model import drive
from stickslip.model.models import model_of
from stickslip.model.rhs import Equations
from stickslip.model.solids import Thresholds, thresholds
from stickslip.model.state import State
from stickslip.numerics.adaptive import make_adaptive
from stickslip.numerics.linear import algebra
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.options import Physics
from stickslip.parameters import Parameters

# A cusp of the law is rounded below this many tolerances of X_m omega, so that a step can cross the
# cusp without getting stuck in it. A wider rounding changes the slip of a locked block, and with it
# the stress. A tenth of this width takes a tenth more steps, and a hundredth ten times as many.
_ROUNDING = 1e-2


class Problem(NamedTuple):
    """The problem that the adaptive method integrates, at a tolerance `rtol`.

    `u_s` is the relative speed [m/s] below which a cusp of the law is rounded; `phases` are the
    limits between the phases of the film.
    """

    p: Parameters
    rtol: float
    u_s: float
    phases: Thresholds


@inline
def rounding_speed(p: Parameters, rtol: float) -> float:
    """Relative speed [m/s] below which a cusp of the law is rounded at this tolerance."""
    return _ROUNDING * rtol * drive.largest_speed(p)


@inline
def problem_of(p: Parameters, rtol: float) -> Problem:
    """Problem for parameters `p` at a tolerance."""
    return Problem(p, rtol, rounding_speed(p, rtol), thresholds(p))


class ProblemFunctions(NamedTuple):
    """The inline functions that an integration of a Problem needs."""

    equations: Equations

    width: int
    """Number of state variables."""

    rhs: Callable[..., State]
    """(problem, t, y) -> the rates of the state."""

    jacobian: Callable[..., tuple[State, ...]]
    """(problem, t, y) -> the rows of the Jacobian, and d(rhs)/dt."""

    error_weight: Callable[..., State]
    """(problem, y, y1, J) -> the weights [1/m, s/m, 1, 1] of the errors of y."""

    step_limits: Callable[..., tuple[float, float]]
    """(problem, y0, f0, y1, f1, h) -> the largest part of a step that may be taken, and the longest
    step after it, as in `Equations.step_limits`."""


@cache
def problem_functions(physics: Physics) -> ProblemFunctions:
    """Return the functions with which an integrator solves these physics."""
    model = model_of(physics)
    bound, weight = model.equations, model.equations.error_weight
    model_rhs, model_jacobian, limits = bound.rhs, bound.jacobian, bound.step_limits

    @inline
    def rhs(problem: Problem, t: float, y: State) -> State:
        return model_rhs(problem.p, t, y, problem.u_s)

    @inline
    def jacobian(problem: Problem, t: float, y: State) -> tuple[State, ...]:
        return model_jacobian(problem.p, t, y, problem.u_s)

    @inline
    def error_weight(problem: Problem, y: State, y1: State, J: tuple[State, ...]) -> State:
        return weight(problem.p, problem.rtol, y, y1, J)

    @inline
    def step_limits(
        problem: Problem, y0: State, f0: State, y1: State, f1: State, h: float
    ) -> tuple[float, float]:
        return limits(problem.p, problem.phases.solid, y0, f0, y1, f1, h)

    width = len(model.components)
    return ProblemFunctions(bound, width, rhs, jacobian, error_weight, step_limits)


def make_travel(functions: ProblemFunctions, observe: Callable[..., None], **disturb: Any) -> Any:
    """Return the scalar integrator of the adaptive method; arguments as in `make_adaptive`."""
    return make_adaptive(
        functions.rhs,
        functions.jacobian,
        functions.error_weight,
        observe,
        RODAS4P2,
        algebra(functions.width),
        limits=functions.step_limits,
        **disturb,
    )
