"""The scalar adaptive method with one part replaced, over three drive periods from the start.

The scalar method takes the steps that a lane takes. The amplitudes are measured as in lanes:
extrema are located on the continuous extension, and a shorter step of the method goes there.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from inside import PHYSICS, WIDTH, amplitudes_of
from inside.other_tableaus import RODAS4, RODAS4P
from stickslip.compiled.decorators import inline, jit
from stickslip.kernels.adaptive.recording import NODES, Step, make_node, vertex
from stickslip.kernels.parameter_rows import FIRST_STEP, parameters_of
from stickslip.kernels.problem import Problem, problem_functions, problem_of
from stickslip.measure.accumulate import FORCE_MAX, RECORD, STRESS_MAX, accumulator
from stickslip.model import drive
from stickslip.model.models import model_of
from stickslip.model.rhs import relative_state, starting_state
from stickslip.numerics import adaptive, step_control
from stickslip.numerics.linear import algebra, larger
from stickslip.numerics.rosenbrock import make_step
from stickslip.numerics.tableaus import RODAS4P2, RosenbrockTableau
from stickslip.parameters import Parameters

PERIODS = 3
_SAMPLES, _MOST_STEPS = 400, 10**7
_functions = problem_functions(PHYSICS)
_rhs, _jacobian, _own_weight = _functions.rhs, _functions.jacobian, _functions.error_weight
_observables = model_of(PHYSICS).equations.observables
_node, _record = make_node(_functions), accumulator(1, 0)


@inline
def _weight_without_relief(problem: Any, y: Any, y1: Any, J: Any) -> Any:
    """The error weights, but an error of ln(phi) counts in full where the noise sustains phi."""
    x, u, _ = _own_weight(problem, y, y1, J)
    return x, u, 1.0 / (1.0 + abs(y[2]))


@inline
def _after_success(error: float, remembered: float) -> tuple[float, float]:
    """The elementary controller: the next step depends on the last error alone."""
    return step_control.after_rejection(larger(error, 1e-10)), remembered


@inline
def _no_defect(f1: Any, LU: Any, y0: Any, y1: Any, d1: Any, d2: Any, h: float) -> Any:
    return 0.0, 0.0, 0.0


class Variant(NamedTuple):
    """A tableau, error weights, the rounding of the cusp (1: as usual), and what is replaced."""

    tableau: RosenbrockTableau = RODAS4P2
    weight: Callable[..., Any] = _own_weight
    rounding: float = 1.0
    replaced: tuple[tuple[Any, str, Any], ...] = ()


OWN, OTHER = "RODAS4P2", "RODAS4"
# Step control and defect are no arguments of the method, so these are replaced in their modules.
VARIANTS = {
    OWN: Variant(),
    "RODAS4P (RODASP)": Variant(RODAS4P),
    OTHER: Variant(RODAS4),
    "without the rounded cusp": Variant(rounding=0.0),
    "without relief for ln φ": Variant(weight=_weight_without_relief),
    "without the PI controller": Variant(
        replaced=((step_control, "after_success", _after_success),)
    ),
    "without the defect estimate": Variant(
        replaced=((adaptive, "make_defect_error", lambda _algebra: _no_defect),)
    ),
}


class Course(NamedTuple):
    """What a run took, and its last period.

    `steps` are the attempted steps a period. Of the last period: `attempted` and `accepted` steps,
    `samples` (400, 3) of x [m], u [m/s] and the force [N] in the middle of equal intervals, and
    `amplitudes` (2,) of stress [Pa] and force [N].
    """

    steps: float
    attempted: int
    accepted: int
    samples: np.ndarray
    amplitudes: np.ndarray


def course_with(variant: Variant) -> Callable[[np.ndarray, float], Course]:
    """Return a function of a row of parameters and a tolerance that runs a variant, compiled."""
    with ExitStack() as stack:
        for module, name, value in variant.replaced:
            stack.enter_context(patch.object(module, name, value))
        run = _compiled(variant._replace(rounding=1.0))

    def course(row: np.ndarray, rtol: float) -> Course:
        samples, counts, extrema = _room()
        total, attempted, status = run(row, rtol, variant.rounding, samples, counts, extrema)
        assert status == adaptive.OK
        assert counts[0] == _SAMPLES
        amplitudes = amplitudes_of(extrema[None])[0]
        return Course(total / PERIODS, attempted, int(counts[1]), samples, amplitudes)

    return course


def _room() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return arrays for samples, for counts of samples and accepted steps, and for the record."""
    return np.empty((_SAMPLES, 3)), np.zeros(2, np.int64), np.empty(RECORD)


@cache
def _compiled(variant: Variant) -> Any:
    """Compile the run of a variant, while what it replaces is in place; with any rounding."""
    advance = adaptive.make_adaptive(
        _rhs, _jacobian, variant.weight, _make_observe(variant.tableau), variant.tableau,
        algebra(WIDTH), limits=_functions.step_limits,
    )  # fmt: skip

    @jit
    def run(
        row: Any, rtol: float, rounding: float, samples: Any, counts: Any, extrema: Any
    ) -> tuple[int, int, int]:
        p = parameters_of(row)
        usual, period = problem_of(p, rtol), drive.period(p)
        problem = Problem(p, rtol, rounding * usual.u_s, usual.phases)
        y, h = relative_state(p, 0.0, starting_state(p)), FIRST_STEP * period
        total, attempted, status = 0, 0, 0
        for _ in range(PERIODS):
            counts[0] = counts[1] = 0
            _record.clear(extrema, 0)
            y, h, attempted, status = advance(
                problem, rtol, 0.0, period, y, h, _MOST_STEPS, (samples, counts, extrema)
            )
            total += attempted
            if status != 0:
                break
        return total, attempted, status

    run(np.array(Parameters()), 1e-3, 1.0, *_room())
    return run


def _make_observe(tableau: RosenbrockTableau) -> Any:
    """Return the `observe` of `make_adaptive` that samples a step and sees the extrema in it."""
    shorter_step = make_step(_rhs, tableau, algebra(WIDTH))

    @jit
    def see(problem: Any, y: Any, extrema: Any) -> None:
        sigma, F = _observables(problem.p, y, np.exp(y[2]), problem.u_s)
        finite = np.isfinite(sigma) and np.isfinite(F)
        _record.see_extremum(extrema, 0, STRESS_MAX, sigma, finite)
        _record.see_extremum(extrema, 0, FORCE_MAX, F, finite)

    @jit
    def see_inside(problem: Any, step: Any, values: Any, slot: int, extrema: Any) -> None:
        # As in lanes only where the curve may exceed the record, if it overshoots no farther.
        reach = abs(values[1] - values[0]) + abs(values[2] - values[1]) + abs(values[3] - values[2])
        if max(values) + reach < extrema[slot] and min(values) - reach > extrema[slot + 1]:
            return
        for i in range(2):
            x0, x1, x2 = NODES[i], NODES[i + 1], NODES[i + 2]
            place = vertex(x0, x1, x2, values[i], values[i + 1], values[i + 2])
            if x0 < place < x2:
                f, J = _rhs(problem, step.t, step.y0), _jacobian(problem, step.t, step.y0)
                part = place * step.used
                see(problem, shorter_step(problem, step.t, step.y0, part, f, J)[0], extrema)

    @jit
    def observe(
        problem: Any, t: float, h: float, y0: Any, y1: Any, d1: Any, d2: Any, record: Any
    ) -> None:
        samples, counts, extrema = record
        step, spacing = Step(t, h, y0, y1, d1, d2), drive.period(problem.p) / _SAMPLES
        while counts[0] < _SAMPLES and (counts[0] + 0.5) * spacing <= t + h:
            part = ((counts[0] + 0.5) * spacing - t) / h
            y, _, _, force = _node(problem, step, part)
            samples[counts[0], 0], samples[counts[0], 1] = y[0], y[1]
            samples[counts[0], 2] = force
            counts[0] += 1
        counts[1] += 1
        see(problem, y1, extrema)
        _, _, sigma0, F0 = _node(problem, step, NODES[0])
        _, _, sigmaa, Fa = _node(problem, step, NODES[1])
        _, _, sigmab, Fb = _node(problem, step, NODES[2])
        _, _, sigma1, F1 = _node(problem, step, NODES[3])
        see_inside(problem, step, (sigma0, sigmaa, sigmab, sigma1), STRESS_MAX, extrema)
        see_inside(problem, step, (F0, Fa, Fb, F1), FORCE_MAX, extrema)

    return observe
