"""The adaptive method in lanes: kernels that work through a queue of points.

A point is integrated half a drive period at a time, over phases 0 to pi in its own units
(model/scaling.py), and then mirrored, which maps its orbit onto itself. A lane takes the next point
of the queue as soon as its own is finished. A kernel works for a given number of attempts and
leaves everything it needs to go on in the arrays that it was given.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit, kernel_factory, named_kernel
from stickslip.compiled.fields import make_lane_reader
from stickslip.compiled.simd import LANES
from stickslip.kernels.adaptive import recording
from stickslip.kernels.adaptive.recording import ROOM, SLOTS, get, put, stream_begin
from stickslip.kernels.adaptive.states import StateFunctions, state_functions
from stickslip.kernels.adaptive.variations import (
    Variations,
    columns_begin,
    make_variations,
    room_of,
    stored_of,
)
from stickslip.kernels.families import Family
from stickslip.kernels.problem import Problem, problem_functions, problem_of, rounding_speed
from stickslip.kernels.streams import STREAM
from stickslip.measure.accumulate import RECORD
from stickslip.model import drive, solids
from stickslip.model.models import model_of
from stickslip.model.noise import clearance, freezes_late, in_between
from stickslip.model.rhs import Equations
from stickslip.model.scaling import Reduced
from stickslip.model.solids import Thresholds
from stickslip.model.state import FILM, STATE
from stickslip.numerics import step_control
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT
from stickslip.numerics.adaptive_lanes import make_attempt
from stickslip.numerics.lane_array import aligned
from stickslip.numerics.linear import algebra
from stickslip.numerics.periodic import search
from stickslip.numerics.rosenbrock import make_step
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.options import Physics
from stickslip.parameters import Parameters
from stickslip.status import Status

NOT_STATIONARY, APERIODIC = int(Status.NOT_STATIONARY), int(Status.APERIODIC)

TRAVEL, SETTLE, MEASURE, VARY = range(4)
"""Kinds of passes through a queue: a given number of half periods; as many as it takes to reach the
stationary orbit; a given number with a record; the same, and how small displacements of the first
state move the motion and its extrema."""

REFINEMENT = 0.1
"""The finer tolerance of the search, and of the measurement, as a fraction of the coarser one."""

TIGHTEST = 1e-13
"""The smallest tolerance: below it rounding dominates."""

# The largest tolerance on the way to an orbit: beyond it a film may miss the moment at which it
# freezes, and end on another orbit.
_SEARCH = 1e-5

# The longest jump, in units of the scaled position, of a film that may freeze late: short enough
# not to skip the periods in which it does.
_LATE_JUMP = 0.1

# Columns of `counts`, integers. HALVES: half periods of the search, over all its passes; CYCLE:
# half periods after which the orbit closes (or how many to do); ATTEMPTED: steps attempted, over
# all passes; OUTCOME: a Status, APERIODIC if a search wanders.
HALVES, CYCLE, ATTEMPTED, OUTCOME, COUNT_COLUMNS = range(5)

_reduced_of = make_lane_reader(Reduced, SLOTS.parameters, get)


class Pass(NamedTuple):
    """The kind of a pass, its tolerances, and its budgets of half periods and steps."""

    mode: int
    rtol: float
    stationary_rtol: float
    max_halves: int
    max_steps: int
    accelerate: bool
    late: bool = False
    """True for a search that continues one which found no cycle."""


class Queue(NamedTuple):
    """The points of a pass; rows are points.

    `points` (n, reduced parameters), as `Reduced`, followed by a stream of random numbers if the
    noise is stochastic. In and out: `states` (n, width + 1), the state in the point's own units and
    the next step, and `counts` (n, COUNT_COLUMNS). Out: `measured` (n, RECORD); `ratios` (n,), the
    contraction of the orbit; `varied` (n, `variations.stored_of(width)`).
    """

    points: np.ndarray
    states: np.ndarray
    counts: np.ndarray
    measured: np.ndarray
    ratios: np.ndarray
    varied: np.ndarray


class Lanes(NamedTuple):
    """The complete state of the lanes between two calls of a kernel.

    `values` (slots*LANES,); `rows` (LANES,) the point in each lane, -1 if idle; `halves` (LANES,)
    half periods of this pass, or of the whole search; `memories` (LANES,) of the searches; `cursor`
    (2,) the next point of the queue and the number of busy lanes, -1 before the first call.
    """

    values: np.ndarray
    rows: np.ndarray
    halves: np.ndarray
    memories: np.ndarray
    cursor: np.ndarray


def new_lanes(width: int) -> Lanes:
    """Return lanes that have not begun, for states of this many components."""
    return Lanes(
        # Not compiled: that would take half a second for a single call.
        values=aligned.py_func((columns_begin(width) + room_of(width)) * LANES),
        rows=np.full(LANES, -1, np.int64),
        halves=np.zeros(LANES, np.int64),
        memories=np.zeros(LANES, search.memory_of(width)),
        cursor=np.array([0, -1]),
    )


def new_queue(points: np.ndarray, states: np.ndarray) -> Queue:
    """Return a queue of points (n, reduced parameters) in these states (n, width + 1)."""
    n = len(points)
    return Queue(
        points,
        states,
        counts=np.zeros((n, COUNT_COLUMNS), np.int64),
        measured=np.zeros((n, RECORD)),
        ratios=np.zeros(n),
        varied=np.zeros((n, stored_of(states.shape[1] - 1))),
    )


@jit
def _park(lanes: Lanes, lane: int) -> None:
    """Park an idle lane: with an infinite end and limit it raises no event."""
    lanes.rows[lane] = -1
    put(lanes.values, SLOTS.end, lane, np.inf)
    put(lanes.values, SLOTS.limit, lane, np.inf)


@jit
def _close(lanes: Lanes, queue: Queue, lane: int, status: int) -> None:
    """Store the outcome of the point in a lane."""
    row, values = lanes.rows[lane], lanes.values
    width, counts = queue.states.shape[1] - 1, queue.counts[row]
    for component in range(width):
        queue.states[row, component] = get(values, SLOTS.state + component, lane)
    queue.states[row, width] = get(values, SLOTS.step, lane)
    counts[ATTEMPTED] += int(get(values, SLOTS.attempts, lane))
    counts[OUTCOME] = status
    for slot in range(RECORD):
        queue.measured[row, slot] = get(values, recording.RECORD_BEGIN + slot, lane)


@inline
def _coarser(task: Pass) -> float:
    """The tolerance at which a search begins."""
    return min(task.rtol, _SEARCH)


@inline
def _finer(task: Pass, cuts: int) -> float:
    """The tolerance of a search after so many cuts; the first puts the noise below the aim."""
    first = min(task.rtol * REFINEMENT, _SEARCH, max(task.stationary_rtol, TIGHTEST))
    return first * REFINEMENT ** (cuts - 1)


@inline
def _longest_jump(p: Parameters, phi: float, waits: bool) -> float:
    """Longest jump allowed: a jump must not skip the periods in which a film freezes late.

    A film that `waits` may freeze, but was liquid throughout the last half period.
    """
    if not (freezes_late(p) or waits):
        return np.inf
    return 0.0 if in_between(p, phi) else _LATE_JUMP


def _make_apply_verdict(state: StateFunctions) -> Any:
    """Return the function that carries out the search's verdict on a half period; -1 to go on."""
    judged, unjudged, moved = state.judged, state.unjudged, state.moved
    begin_half, put_state = state.begin_half, state.put

    @jit
    def apply_verdict(lanes: Lanes, task: Pass, lane: int, y: Any) -> int:
        values, memory = lanes.values, lanes.memories[lane]
        rtol = get(values, SLOTS.rtol, lane)
        # The search counts the halves of this pass; those of earlier ones have used the budget too.
        before = lanes.halves[lane] - 1 - memory.applications
        budget = task.max_halves - before
        verdict, dx, dv = search.judge(memory, judged(y), task.stationary_rtol, rtol, budget)
        begin_half(values, lane, moved(y, dx, dv))
        if verdict == search.SETTLED:
            # The remaining way to the limit is known: the measurement begins nearer to it.
            dx, dv = search.last_correction(memory)
            put_state(values, SLOTS.state, lane, moved(y, dx, dv))
            return OK
        if verdict == search.EXHAUSTED:
            return NOT_STATIONARY
        if verdict == search.WANDERING:
            return APERIODIC
        if verdict == search.FINER:
            put(values, SLOTS.rtol, lane, _finer(task, memory.fineness))
        elif verdict == search.RESTORE:
            # A jump has led astray: return to the state before it, as at the start of a search.
            put_state(values, SLOTS.state, lane, unjudged(memory.stored))
            put(values, SLOTS.rtol, lane, _finer(task, 1) if task.late else _coarser(task))
        return -1

    return apply_verdict


def make_problems(family: Family) -> Any:
    """Return the function (lanes, lane) that reads the Problem of a lane, for one family."""
    values_of: Any = model_of(family.physics).values(family.gamma, higher=family.higher)

    @inline
    def problem(values: np.ndarray, lane: int) -> Problem:
        return problem_of(values_of(_reduced_of(values, lane)), get(values, SLOTS.rtol, lane))

    @inline
    def higher_problem(values: np.ndarray, lane: int) -> Problem:
        q, rtol = _reduced_of(values, lane), get(values, SLOTS.rtol, lane)
        p, phases = values_of(q), Thresholds(q.solid, q.soft, q.hard, q.weakest, q.strongest)
        return Problem(p, rtol, rounding_speed(p, rtol), phases)

    return higher_problem if family.higher else problem


def _make_load(state: StateFunctions, begin_record: Any, begin_columns: Any, streams: int) -> Any:
    """Return the function that puts the next point of the queue into a lane, or parks the lane.

    `streams` is the first slot of its stream of random numbers, 0 if there is none.
    """
    row_state, judged, begin_half = state.of_row, state.judged, state.begin_half
    reduced = len(Reduced._fields)

    @jit
    def load(lanes: Lanes, queue: Queue, task: Pass, lane: int) -> None:
        values, row = lanes.values, lanes.cursor[0]
        if row >= queue.points.shape[0]:
            _park(lanes, lane)
            lanes.cursor[1] -= 1
            return
        lanes.cursor[0] += 1
        for slot in range(reduced):
            put(values, SLOTS.parameters + slot, lane, queue.points[row, slot])
        if streams > 0:
            for slot in range(STREAM):
                put(values, streams + slot, lane, queue.points[row, reduced + slot])
        y = row_state(queue.states[row])
        begin_half(values, lane, y)
        # Half a period is pi in the units of a point. Nothing of the previous point stays in the
        # lane: a result must not depend, to its last bit, on the other points of a sweep.
        put(values, SLOTS.end, lane, math.pi)
        put(values, SLOTS.step, lane, queue.states[row, queue.states.shape[1] - 1])
        put(values, SLOTS.grows, lane, 1.0)
        put(values, SLOTS.remembered, lane, step_control.START)
        put(values, SLOTS.rtol, lane, task.rtol)
        put(values, SLOTS.attempts, lane, 0.0)
        # All passes of a point share one budget of steps.
        put(values, SLOTS.limit, lane, float(task.max_steps - queue.counts[row, ATTEMPTED]))
        lanes.rows[lane], lanes.halves[lane] = row, 0
        if task.mode == SETTLE:
            put(values, SLOTS.rtol, lane, _finer(task, 1) if task.late else _coarser(task))
            lanes.halves[lane] = queue.counts[row, HALVES]
            recording.begin_following(values, lane)
            search.start(lanes.memories[lane], judged(y), 2, task.accelerate, True, task.late)
        elif task.mode >= MEASURE:
            begin_record(values, lane, True)
            if task.mode == VARY:
                begin_columns(values, lane)

    return load


def _make_limit_search(equations: Equations) -> Any:
    """Return the function that limits the jumps of a search after a half period.

    It takes (memory, problem, phi, lowest, highest): the order parameter at its end, and the
    extremes of ln(phi) during it. Where a film may still freeze, a jump must not skip the moment
    (docs/decisions/late-freezing.md).
    """
    strain_amplitude, rounded = equations.strain_amplitude, equations.law.rounded
    upper_displacement = equations.upper.displacement

    @jit
    def out_of_reach(problem: Problem, phi: float) -> tuple[float, float]:
        """Where a liquid film cannot freeze: gain and least distance of `search.keep_clear`."""
        p, strain = problem.p, strain_amplitude(problem.p, 1.0)
        if drive.highest_harmonic(p) > 1.0 or not strain > 0.0:  # the bound is that of a sine
            return np.inf, np.inf
        critical = solids.solidification_strain(p) / strain
        gain, least = clearance(p, critical)
        # Friction makes a passage through rest longer, with a cusp there most of all.
        stress, slope, _ = rounded(p, critical, phi, problem.u_s)
        return gain + slope * p.contact_area, least + stress * p.contact_area

    @jit
    def limit_search(
        memory: Any, problem: Problem, phi: float, lowest: float, highest: float
    ) -> None:
        p, least_phi, most_phi = problem.p, math.exp(lowest), math.exp(highest)
        solid = solids.solid_threshold(p)
        contracting = solids.parts_never(p, least_phi, most_phi)
        # In a liquid that cannot freeze the peaks do not matter.
        may_freeze = p.temperature < solids.solidification_temperature(p, 0.0)
        peak = STATE[FILM].weight * max(highest, STATE[FILM].floor) if may_freeze else 0.0
        longest = _longest_jump(p, phi, may_freeze and most_phi < solid)
        search.limit_jumps(memory, longest, contracting, peak)
        if not may_freeze:
            return
        search.limit_spirals(memory)
        if least_phi < solid:
            gain, least = np.inf, np.inf
            if most_phi < solid:
                gain, least = out_of_reach(problem, most_phi)
            centre, stiffness = upper_displacement(p, 0.0), 2.0 * p.spring_stiffness
            search.keep_clear(memory, centre, stiffness, gain, least)

    return limit_search


def _make_handle_event(
    problems: Any,
    equations: Equations,
    state: StateFunctions,
    begin_record: Any,
    refine: Any,
    variations: Variations,
) -> Any:
    """Return the function that handles an event in a lane: it gives a status, or -1 to go on."""
    mirror_record, apply_verdict = recording.record.mirror, _make_apply_verdict(state)
    mirrored, get_state, begin_half = state.mirrored, state.get, state.begin_half
    limit_search = _make_limit_search(equations)
    mirror_columns, store_columns = variations.mirror, variations.store

    @jit
    def after_half(lanes: Lanes, queue: Queue, task: Pass, lane: int) -> int:
        values, row = lanes.values, lanes.rows[lane]
        y = mirrored(get_state(values, SLOTS.state, lane))
        lanes.halves[lane] += 1
        if task.mode == SETTLE:
            lowest, highest = (
                get(values, recording.LOWEST, lane),
                get(values, recording.HIGHEST, lane),
            )
            memory, problem = lanes.memories[lane], problems(values, lane)
            limit_search(memory, problem, math.exp(y[FILM]), lowest, highest)
            recording.begin_following(values, lane)
            status = apply_verdict(lanes, task, lane, y)
            queue.counts[row, HALVES] = lanes.halves[lane]
            if status == OK:
                queue.counts[row, CYCLE], queue.ratios[row] = search.found(lanes.memories[lane])
            return status
        begin_half(values, lane, y)
        if task.mode >= MEASURE:
            # The record turns with the frame: a maximum is the minimum of the mirror image.
            mirror_record(values, lane)
            begin_record(values, lane, False)
        if task.mode == VARY:
            mirror_columns(values, lane)
            store_columns(values, lane, queue.varied[row])
        return OK if lanes.halves[lane] >= queue.counts[row, CYCLE] else -1

    @jit
    def handle_event(lanes: Lanes, queue: Queue, task: Pass, lane: int) -> int:
        values = lanes.values
        # First the inside of the step, then its end, which would begin a new half period.
        if task.mode >= MEASURE and get(values, recording.PROMISING, lane) > 0.0:
            refine(values, lane, task.mode == VARY)
        if get(values, SLOTS.time, lane) >= get(values, SLOTS.end, lane):
            return after_half(lanes, queue, task, lane)
        if get(values, SLOTS.stuck, lane) > 0.0:
            return DIVERGED
        exhausted = get(values, SLOTS.attempts, lane) >= get(values, SLOTS.limit, lane)
        return STEP_LIMIT if exhausted else -1

    return handle_event


def _make_see(record: Any, carry: Any) -> Any:
    """Return the function that looks at the last step of all lanes, as the kind of pass needs."""

    @jit
    def see(values: np.ndarray, mode: int) -> None:
        if mode >= MEASURE:
            record(values)
        if mode == VARY:
            carry(values)
        if mode == SETTLE:
            recording.follow_film(values)

    return see


@inline
def _no_kick(lanes: np.ndarray) -> None:
    pass


def _make_noise(problems: Any, width: int, *, chance: bool) -> tuple[Any, int]:
    """Return the function that adds random noise after a step, and its stream's slot (or 0)."""
    if not chance:
        return _no_kick, 0
    from stickslip.kernels.adaptive.kicks import make_kick  # only stochastic films need it

    return make_kick(problems, width), stream_begin(width)


def make_pass(problems: Any, physics: Physics, *, two_solids: bool = False) -> Any:
    """Return a pass, not yet a kernel, over problems that `problems(lanes, lane)` reads.

    With `two_solids` changes between a soft and a hard solid are counted.

    It maps (queue, lanes, task, attempts) to the number of unfinished points: it works for that
    many attempts of all lanes together, and is to be called again until the number is 0.
    """
    functions = problem_functions(physics)
    state = state_functions(model_of(physics).components)
    operations = algebra(functions.width)
    rhs, jacobian, weight = functions.rhs, functions.jacobian, functions.error_weight
    attempt = make_attempt(
        rhs, jacobian, weight, problems, RODAS4P2, operations, ROOM, functions.step_limits
    )
    step = make_step(rhs, RODAS4P2, operations)
    record = recording.make_see(problems, functions, two_solids=two_solids)
    begin_record = recording.make_begin(problems, functions)
    variations = make_variations(problems, functions, model_of(physics).components)
    see = _make_see(record, variations.carry)
    refine = recording.make_refine(problems, functions, step, variations.note)
    kick, streams = _make_noise(problems, functions.width, chance=physics.chance)
    load = _make_load(state, begin_record, variations.begin, streams)
    handle_event = _make_handle_event(
        problems, functions.equations, state, begin_record, refine, variations
    )

    def work(queue: Queue, lanes: Lanes, task: Pass, attempts: int) -> int:
        if lanes.cursor[1] < 0:  # the first call
            lanes.cursor[1] = LANES
            for lane in range(LANES):
                load(lanes, queue, task, lane)
        while lanes.cursor[1] > 0 and attempts > 0:
            # First vector code for all lanes; then, one by one, the few lanes that raised an event.
            attempts -= 1
            attempt(lanes.values)
            see(lanes.values, task.mode)
            kick(lanes.values)
            for lane in range(LANES):
                if get(lanes.values, SLOTS.event, lane) > 0.0 and lanes.rows[lane] >= 0:
                    status = handle_event(lanes, queue, task, lane)
                    if status >= 0:
                        _close(lanes, queue, lane, status)
                        load(lanes, queue, task, lane)
        # Points that wait, and those in busy lanes.
        return queue.points.shape[0] - lanes.cursor[0] + lanes.cursor[1]

    return work


@kernel_factory
def pass_kernel(family: Family) -> Any:
    """Return the kernel of a family of fluids, as `make_pass` describes it."""
    work = make_pass(make_problems(family), family.physics, two_solids=family.higher)
    return named_kernel(f"adaptive_pass[{family}]", work)
