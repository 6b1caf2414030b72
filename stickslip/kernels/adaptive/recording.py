"""The record of an orbit in lanes: extrema, integrals and phases, half period by half period.

A lane integrates half a drive period and is then mirrored, (x, u) -> (-x, -u), so that its phase is
always between 0 and pi. Records are kept in the present frame, which may be the mirrored one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.elementary import exponentials
from stickslip.compiled.simd import LANES, for_lanes
from stickslip.kernels.problem import Problem, ProblemFunctions
from stickslip.measure.accumulate import (
    BLOCK_WORK,
    FORCE_MAX,
    RECORD,
    STRESS_MAX,
    Moment,
    accumulator,
    make_see_integrals,
)
from stickslip.model import block, film, solids
from stickslip.model.rhs import Equations
from stickslip.model.scaling import Reduced
from stickslip.model.state import FILM, State
from stickslip.numerics.adaptive_lanes import slots_for
from stickslip.numerics.lane_array import lane_array, lane_vectors
from stickslip.numerics.linear import algebra, larger

# The record of a lane follows its parameters. Then come stress, force and their rates at the end of
# the last accepted step, a flag for a possible extremum inside the last attempted step, and the
# lowest and highest ln(phi) at the ends of steps since the half period began.
ROOM = len(Reduced._fields) + RECORD + 7
"""The number of slots of a lane in addition to the slots of its integration."""

SLOTS = slots_for(0, ROOM)
"""Slots of the numbers of a lane; the slots of vectors depend on their width."""

RECORD_BEGIN = SLOTS.parameters + len(Reduced._fields)


def stream_begin(width: int) -> int:
    """Return the first slot of the stream of random numbers of a lane, after all others."""
    return slots_for(width, ROOM).total


STRESS = RECORD_BEGIN + RECORD
FORCE, _STRESS_RATE, _FORCE_RATE, PROMISING, LOWEST, HIGHEST = range(STRESS + 1, STRESS + 7)

# Nodes at which a step is evaluated, and weights of the Lobatto quadrature of order 6.
_INNER = 0.5 * math.sqrt(0.2)
NODES = (0.0, 0.5 - _INNER, 0.5 + _INNER, 1.0)
_PARTS = (NODES[1] - NODES[0], NODES[2] - NODES[1], NODES[3] - NODES[2])
# An outer interval as a fraction of the two intervals that a parabola covers.
_OUTER = _PARTS[0] / (_PARTS[0] + _PARTS[1])
WEIGHTS = (1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0)

Values = tuple[float, float, float, float]

_array = lane_array(LANES)
get, put = _array.get, _array.put
record = accumulator(LANES, RECORD_BEGIN)
_see_extremum, _see_phase = record.see_extremum, record.see_phase
_see_solid, _add = record.see_solid, record.add


class Step(NamedTuple):
    """The last attempted step of a lane: its start, its length, and its continuous extension."""

    t: float
    used: float
    y0: State
    y1: State
    d1: State
    d2: State


@cache
def step_reader(width: int) -> Any:
    """Return the function (lanes, lane) that reads the last attempted Step of a lane."""
    slots, get_state = slots_for(width, ROOM), lane_vectors(LANES, width).get

    @inline
    def step_of(lanes: np.ndarray, lane: int) -> Step:
        return Step(
            get(lanes, slots.begin, lane),
            get(lanes, slots.used, lane),
            get_state(lanes, slots.old, lane),
            get_state(lanes, slots.state, lane),
            get_state(lanes, slots.d1, lane),
            get_state(lanes, slots.d2, lane),
        )

    return step_of


@inline
def _promising(
    lanes: np.ndarray, lane: int, slot: int, values: Values, rates: tuple[float, float]
) -> bool:
    """Return whether the observable turns between the nodes and could exceed the record there.

    `values` are at the nodes, `rates` at the ends. The rate of the force on a very light block is a
    small difference, lost in the error of the velocity. The slopes of the parabolas that cover the
    step see such a turn.
    """
    begin, first, second, end = values
    high = get(lanes, RECORD_BEGIN + slot, lane)
    low = get(lanes, RECORD_BEGIN + slot + 1, lane)
    # We assume that between the nodes a curve overshoots no farther than it rose and fell at them.
    top, bottom = larger(larger(first, second), end), -larger(larger(-first, -second), -end)
    rise0, rise1, rise2 = first - begin, second - first, end - second
    left, middle, right = rise0 / _PARTS[0], rise1 / _PARTS[1], rise2 / _PARTS[2]
    slope0 = left - _OUTER * (middle - left)
    slope1 = right + _OUTER * (right - middle)
    # `|` and `&` evaluate both sides; `or` and `and` would branch.
    turns = (rates[0] * rates[1] < 0.0) | (rise0 * rise1 < 0.0) | (rise1 * rise2 < 0.0)
    turns = turns | (slope0 * left < 0.0) | (slope1 * right < 0.0)
    reach = abs(rise0) + abs(rise1) + abs(rise2)
    return turns & ((top + reach >= high) | (bottom - reach <= low))


Node = tuple[State, float, float, float]
"""The state, phi, stress and force at a node of a step."""


def make_moment(equations: Equations) -> Any:
    """Return the inline function (problem, t, node) that makes the Moment of a node at time t."""
    power, loss, relative_state = equations.power, equations.loss, equations.relative_state
    upper_velocity = equations.upper.velocity

    @inline
    def moment(problem: Problem, t: float, node: Node) -> Moment:
        y, phi, sigma_el, F = node
        p, V, phase = problem.p, upper_velocity(problem.p, t), problem.p.angular_frequency * t
        gained, lost = power(p, V, y, F), loss(p, V, y, F)
        motion = block.harmonic_force(p, y[0], relative_state(p, t, y)[1])
        return Moment(y[0], V, y[1], phi, sigma_el, F, gained, lost, motion, phase)

    return moment


def _make_see_work(equations: Equations) -> Any:
    """Return the function that adds a step to the integrals of a record.

    Its arguments are (lanes, lane, problem, step, nodes, accepted).
    """
    stored_energy, moment = equations.stored_energy, make_moment(equations)
    see_integrals = make_see_integrals(record, WEIGHTS)

    @inline
    def see_work(
        lanes: np.ndarray, lane: int, problem: Problem, step: Step, nodes: Any, accepted: bool
    ) -> None:
        moments = (
            moment(problem, step.t + NODES[0] * step.used, nodes[0]),
            moment(problem, step.t + NODES[1] * step.used, nodes[1]),
            moment(problem, step.t + NODES[2] * step.used, nodes[2]),
            moment(problem, step.t + NODES[3] * step.used, nodes[3]),
        )
        see_integrals(lanes, lane, moments, step.used, accepted)

    @inline
    def see_work_and_energy(
        lanes: np.ndarray, lane: int, problem: Problem, step: Step, nodes: Any, accepted: bool
    ) -> None:
        see_work(lanes, lane, problem, step, nodes, accepted)
        gained = stored_energy(problem.p, step.y1) - stored_energy(problem.p, step.y0)  # type: ignore[misc]
        _add(lanes, lane, BLOCK_WORK, -gained, accepted)

    return see_work if stored_energy is None else see_work_and_energy


@inline
def _see_one_solid(
    lanes: np.ndarray, lane: int, problem: Problem, eps: float, phi: float, accepted: bool
) -> None:
    pass


@inline
def _see_either_solid(
    lanes: np.ndarray, lane: int, problem: Problem, eps: float, phi: float, accepted: bool
) -> None:
    B, phases = film.melting_function(problem.p, eps), problem.phases
    is_liquid, is_hard = phi <= solids.MELTED_PART * phases.solid, phi >= phases.hard
    _see_solid(lanes, lane, is_liquid, solids.is_soft(phases, phi, B), is_hard, accepted)


@inline
def _lane_follow(lane: int, lanes: np.ndarray) -> None:
    psi = get(lanes, SLOTS.state + FILM, lane)
    low, high = get(lanes, LOWEST, lane), get(lanes, HIGHEST, lane)
    put(lanes, LOWEST, lane, psi if psi < low else low)
    put(lanes, HIGHEST, lane, psi if psi > high else high)


@jit
def follow_film(lanes: np.ndarray) -> None:
    """Update the lowest and highest ln(phi) of every lane after a step."""
    for_lanes(LANES, _lane_follow, (lanes,))


@inline
def begin_following(lanes: np.ndarray, lane: int) -> None:
    """Prepare a lane for `follow_film` over half a period."""
    put(lanes, LOWEST, lane, np.inf)
    put(lanes, HIGHEST, lane, -np.inf)


@inline
def vertex(x0: float, x1: float, x2: float, y0: float, y1: float, y2: float) -> float:
    """Abscissa of the vertex of a parabola through three points; NaN or inf on a straight line."""
    left, right = (y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1)
    return 0.5 * (x0 + x1) - 0.5 * left * (x2 - x0) / (right - left)


def make_node(functions: ProblemFunctions) -> Any:
    """Return the function (problem, step, theta) that makes a Node of a step."""
    observables, interpolate = functions.equations.observables, algebra(functions.width).interpolate

    @inline
    def node(problem: Problem, step: Step, theta: float) -> Node:
        y = interpolate(theta, step.y0, step.y1, step.d1, step.d2)
        phi, _ = exponentials(y[2])
        sigma, F = observables(problem.p, y, phi, problem.u_s)
        return y, phi, sigma, F

    return node


def make_see(
    problems: Callable[..., Problem],
    functions: ProblemFunctions,
    *,
    two_solids: bool,
) -> Any:
    """Return the function (lanes) that records the last step of every lane if it was accepted.

    `problems(lanes, lane)` is the problem of a lane.
    """
    see_solid = _see_either_solid if two_solids else _see_one_solid
    node, observables_and_rates = make_node(functions), functions.equations.observables_and_rates
    step_of, strain = step_reader(functions.width), functions.equations.strain
    see_work = _make_see_work(functions.equations)

    @inline
    def lane_see(lane: int, lanes: np.ndarray) -> None:
        # To avoid branches a rejected step is evaluated like any other, and its values are dropped.
        problem, step = problems(lanes, lane), step_of(lanes, lane)
        accepted = get(lanes, SLOTS.accepted, lane) > 0.0
        ya, phia, sigmaa, Fa = node(problem, step, NODES[1])
        yb, phib, sigmab, Fb = node(problem, step, NODES[2])
        sigma1, F1, sigma_rate1, F_rate1 = observables_and_rates(
            problem.p, step.t + step.used, step.y1, problem.u_s
        )
        sigma0, F0 = get(lanes, STRESS, lane), get(lanes, FORCE, lane)
        sigma_rate0, F_rate0 = get(lanes, _STRESS_RATE, lane), get(lanes, _FORCE_RATE, lane)
        stresses, forces = (sigma0, sigmaa, sigmab, sigma1), (F0, Fa, Fb, F1)
        inside = _promising(lanes, lane, STRESS_MAX, stresses, (sigma_rate0, sigma_rate1))
        inside = inside | _promising(lanes, lane, FORCE_MAX, forces, (F_rate0, F_rate1))
        inside = inside & accepted
        _see_extremum(lanes, lane, STRESS_MAX, sigma1, accepted)
        _see_extremum(lanes, lane, FORCE_MAX, F1, accepted)
        # A look inside takes more steps, and few lanes need it, so it is an event for scalar code.
        put(lanes, PROMISING, lane, 1.0 if inside else 0.0)
        put(lanes, SLOTS.event, lane, 1.0 if inside else get(lanes, SLOTS.event, lane))
        solid = problem.phases.solid
        melted = solids.MELTED_PART * solid
        phi1 = exponentials(step.y1[2])[0]
        # An interval between nodes belongs to the phase at its end, so that none counts twice.
        dta, dtb, dt1 = (_PARTS[0] * step.used, _PARTS[1] * step.used, _PARTS[2] * step.used)
        _see_phase(lanes, lane, phia, solid, melted, dta, accepted)
        _see_phase(lanes, lane, phib, solid, melted, dtb, accepted)
        _see_phase(lanes, lane, phi1, solid, melted, dt1, accepted)
        see_solid(lanes, lane, problem, strain(problem.p, ya), phia, accepted)
        see_solid(lanes, lane, problem, strain(problem.p, yb), phib, accepted)
        see_solid(lanes, lane, problem, strain(problem.p, step.y1), phi1, accepted)
        begin = (step.y0, exponentials(step.y0[2])[0], sigma0, F0)
        nodes = (begin, (ya, phia, sigmaa, Fa), (yb, phib, sigmab, Fb), (step.y1, phi1, sigma1, F1))
        see_work(lanes, lane, problem, step, nodes, accepted)
        # The end of this step is the start of the next, so the law is evaluated once for both.
        put(lanes, STRESS, lane, sigma1 if accepted else sigma0)
        put(lanes, FORCE, lane, F1 if accepted else F0)
        put(lanes, _STRESS_RATE, lane, sigma_rate1 if accepted else sigma_rate0)
        put(lanes, _FORCE_RATE, lane, F_rate1 if accepted else F_rate0)

    @jit
    def see(lanes: np.ndarray) -> None:
        for_lanes(LANES, lane_see, (lanes,))

    return see


def make_begin(problems: Callable[..., Problem], functions: ProblemFunctions) -> Any:
    """Return the function (lanes, lane, fresh) that prepares a lane to measure half a period.

    With `fresh` it begins a new record.
    """
    observables_and_rates, clear = functions.equations.observables_and_rates, record.clear
    get_state = lane_vectors(LANES, functions.width).get

    @jit
    def begin(lanes: np.ndarray, lane: int, fresh: bool) -> None:
        problem, y = problems(lanes, lane), get_state(lanes, SLOTS.state, lane)
        # Every half period begins at phase 0 of the mirrored frame.
        values = observables_and_rates(problem.p, 0.0, y, problem.u_s)
        for i in range(4):
            put(lanes, STRESS + i, lane, values[i])
        if fresh:
            clear(lanes, lane)

    return begin


def make_refine(
    problems: Callable[..., Problem], functions: ProblemFunctions, shorter_step: Any, note: Any
) -> Any:
    """Return the function (lanes, lane, sloped) that searches for extrema in a promising step.

    It locates them on the continuous extension and then goes there with `shorter_step`, the step of
    the method, because the extension is of lower order and a force can be steep. With `sloped`,
    `note(lanes, lane, y, values)` gets the state and the values found there.
    """
    node, observables = make_node(functions), functions.equations.observables
    rhs, jacobian, step_of = functions.rhs, functions.jacobian, step_reader(functions.width)

    @jit
    def see_inside(lanes: np.ndarray, lane: int, theta: float, sloped: bool) -> None:
        problem, step = problems(lanes, lane), step_of(lanes, lane)
        f, J = rhs(problem, step.t, step.y0), jacobian(problem, step.t, step.y0)
        y = shorter_step(problem, step.t, step.y0, theta * step.used, f, J)[0]
        phi, _ = exponentials(y[2])
        sigma, F = observables(problem.p, y, phi, problem.u_s)
        # No error control has chosen this length, and a step that overflows is ignored.
        finite = math.isfinite(sigma) and math.isfinite(F)
        _see_extremum(lanes, lane, STRESS_MAX, sigma, finite)
        _see_extremum(lanes, lane, FORCE_MAX, F, finite)
        if sloped and finite:
            note(lanes, lane, y, (sigma, F))

    @jit
    def see_vertices(lanes: np.ndarray, lane: int, values: Values, sloped: bool) -> None:
        # Two parabolas, each through three neighbouring nodes, cover the step.
        for i in range(2):
            x0, x1, x2 = NODES[i], NODES[i + 1], NODES[i + 2]
            place = vertex(x0, x1, x2, values[i], values[i + 1], values[i + 2])
            if x0 < place < x2:
                see_inside(lanes, lane, place, sloped)

    @jit
    def refine(lanes: np.ndarray, lane: int, sloped: bool) -> None:
        problem, step = problems(lanes, lane), step_of(lanes, lane)
        _, _, sigma0, F0 = node(problem, step, NODES[0])
        _, _, sigmaa, Fa = node(problem, step, NODES[1])
        _, _, sigmab, Fb = node(problem, step, NODES[2])
        _, _, sigma1, F1 = node(problem, step, NODES[3])
        see_vertices(lanes, lane, (sigma0, sigmaa, sigmab, sigma1), sloped)
        see_vertices(lanes, lane, (F0, Fa, Fb, F1), sloped)

    return refine
