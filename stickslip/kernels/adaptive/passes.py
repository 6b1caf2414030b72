"""The adaptive method in lanes: kernels that take many motions along.

A point is integrated half a drive period at a time, over phases 0 to pi in its own units
(model/scaling.py), and then mirrored, which maps its orbit onto itself. A lane takes the next point
as soon as its own has ended. A kernel returns some points that have ended while others are under
way, and leaves everything it needs to go on in the arrays that it was given.
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
from stickslip.kernels.adaptive.variations import (
    Variations,
    columns_begin,
    make_variations,
    room_of,
)
from stickslip.kernels.families import Family, families
from stickslip.kernels.interruption import check_interruption
from stickslip.kernels.orbits.motions import (
    AHEAD,
    ATTEMPTED,
    CONTROL,
    CYCLE,
    DONE,
    FILM_COLUMNS,
    GROWS,
    HALVES,
    HIGHEST,
    KINDS,
    LOWEST,
    OUTCOME,
    REMEMBERED,
    Motions,
    fresh_control,
)
from stickslip.kernels.orbits.states import StateFunctions, state_functions
from stickslip.kernels.problem import Problem, problem_functions, problem_of, rounding_speed
from stickslip.kernels.streams import STREAM
from stickslip.measure.accumulate import RECORD
from stickslip.model.models import model_of
from stickslip.model.scaling import Reduced
from stickslip.model.solids import Thresholds
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT
from stickslip.numerics.adaptive_lanes import make_attempt
from stickslip.numerics.lane_array import aligned, lane_vectors
from stickslip.numerics.linear import algebra
from stickslip.numerics.rosenbrock import make_step
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.options import Physics

WORK = 2_000_000
"""Attempts of all lanes together in a kernel call: about a second, so that Ctrl-C is noticed."""

_reduced_of = make_lane_reader(Reduced, SLOTS.parameters, get)

TRAVEL, SEARCH, MEASURE, VARY = range(4)
"""Kinds of passes: without a record; the same, for a search, which wants some half periods and what
each has led to; with a record; the same, and how small displacements of the first state move the
motion and its extrema."""


class Pass(NamedTuple):
    """The kind of a pass, how many half periods it takes, and the budget of steps of a point.

    With 0 half periods each point goes through its own cycle, or what its search wants.
    """

    mode: int
    halves: int
    max_steps: int


WAITING, BUSY, ENDED, LANE_COUNTS = range(4)


class Lanes(NamedTuple):
    """The complete state of the lanes between two calls of a kernel.

    `values` (slots*LANES,); `rows` (LANES,) the point in each lane, -1 if idle; `halves` (LANES,)
    half periods of this pass; `queue` (n,) the points that wait for a lane; `ended` (2*LANES,)
    those that ended in the last call. `counts` (LANE_COUNTS,): points WAITING, lanes BUSY, points
    ENDED.
    """

    values: np.ndarray
    rows: np.ndarray
    halves: np.ndarray
    queue: np.ndarray
    ended: np.ndarray
    counts: np.ndarray


def new_lanes(width: int, most: int) -> Lanes:
    """Return idle lanes, for states of this many components, and a queue for `most` points."""
    return Lanes(
        # Not compiled: that would take half a second for a single call.
        values=aligned.py_func((columns_begin(width) + room_of(width)) * LANES),
        rows=np.full(LANES, -1, np.int64),
        halves=np.zeros(LANES, np.int64),
        queue=np.empty(most, np.int64),
        ended=np.empty(2 * LANES, np.int64),
        counts=np.zeros(LANE_COUNTS, np.int64),
    )


@jit
def _enough(lanes: Lanes) -> bool:
    """Tell whether points that have ended should be judged before the others go on.

    They are enough to fill all lanes, or half of the lanes wait for them.
    """
    counts = lanes.counts
    idle = counts[WAITING] == 0 and 2 * counts[BUSY] <= LANES
    return counts[ENDED] >= LANES or (counts[ENDED] > 0 and idle)


@jit
def _next_row(lanes: Lanes, motions: Motions) -> int:
    """Take out of the queue the point that has gone farthest: all wait for the longest search."""
    queue, counts, farthest = lanes.queue, motions.counts, 0
    for i in range(1, lanes.counts[WAITING]):
        if counts[queue[i], HALVES] > counts[queue[farthest], HALVES]:
            farthest = i
    row = queue[farthest]
    lanes.counts[WAITING] -= 1
    queue[farthest] = queue[lanes.counts[WAITING]]
    return int(row)


@jit
def _park(lanes: Lanes, lane: int) -> None:
    """Park an idle lane: with an infinite end and limit it raises no event."""
    put(lanes.values, SLOTS.end, lane, np.inf)
    put(lanes.values, SLOTS.limit, lane, np.inf)


@jit
def _store_ahead(lanes: Lanes, motions: Motions, lane: int) -> None:
    """Store what a half period has led to, as `ahead_of` says, with all attempts of the pass."""
    values, ahead, row, half = lanes.values, motions.ahead, lanes.rows[lane], lanes.halves[lane]
    width = motions.states.shape[1] - 1
    control, film = width + 1, width + 1 + CONTROL
    for component in range(width):
        ahead[row, half, component] = get(values, SLOTS.state + component, lane)
    ahead[row, half, width] = get(values, SLOTS.step, lane)
    ahead[row, half, control + GROWS] = get(values, SLOTS.grows, lane)
    ahead[row, half, control + REMEMBERED] = get(values, SLOTS.remembered, lane)
    ahead[row, half, film + LOWEST] = get(values, recording.LOWEST, lane)
    ahead[row, half, film + HIGHEST] = get(values, recording.HIGHEST, lane)
    ahead[row, half, film + FILM_COLUMNS] = get(values, SLOTS.attempts, lane)


@jit
def _close(lanes: Lanes, motions: Motions, lane: int, status: int, mode: int) -> None:
    """Store the outcome of the point in a lane, which is idle then."""
    row, values, width = lanes.rows[lane], lanes.values, motions.states.shape[1] - 1
    if mode == SEARCH and status != OK:
        _store_ahead(lanes, motions, lane)
    lanes.rows[lane] = -1
    lanes.ended[lanes.counts[ENDED]] = row
    lanes.counts[ENDED] += 1
    lanes.counts[BUSY] -= 1
    motions.counts[row, OUTCOME] = status
    motions.counts[row, DONE] = lanes.halves[lane]
    if mode == SEARCH:
        return
    for component in range(width):
        motions.states[row, component] = get(values, SLOTS.state + component, lane)
    motions.states[row, width] = get(values, SLOTS.step, lane)
    motions.counts[row, ATTEMPTED] += int(get(values, SLOTS.attempts, lane))
    if mode == TRAVEL:
        return
    for slot in range(RECORD):
        motions.measured[row, slot] = get(values, recording.RECORD_BEGIN + slot, lane)


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


def _make_begin_half(width: int) -> Any:
    """Return the function (values, lane, y) that puts a lane at phase 0 in a state."""
    put_state = lane_vectors(LANES, width).put

    @jit
    def begin_half(values: np.ndarray, lane: int, y: Any) -> None:
        put_state(values, SLOTS.state, lane, y)
        put(values, SLOTS.time, lane, 0.0)

    return begin_half


def _make_load(
    state: StateFunctions, width: int, begin_record: Any, begin_columns: Any, streams: int
) -> Any:
    """Return the function that puts the next point of the queue into an idle lane, or parks it.

    `streams` is the first slot of its stream of random numbers, 0 if there is none.
    """
    row_state, begin_half = state.of_row, _make_begin_half(width)
    reduced = len(Reduced._fields)

    @jit
    def load(lanes: Lanes, motions: Motions, task: Pass, lane: int) -> None:
        values = lanes.values
        if lanes.counts[WAITING] == 0:
            _park(lanes, lane)
            return
        row = _next_row(lanes, motions)
        lanes.counts[BUSY] += 1
        for slot in range(reduced):
            put(values, SLOTS.parameters + slot, lane, motions.points[row, slot])
        if streams > 0:
            for slot in range(STREAM):
                put(values, streams + slot, lane, motions.points[row, reduced + slot])
        begin_half(values, lane, row_state(motions.states[row]))
        # Half a period is pi in the units of a point. Nothing of the previous point stays in the
        # lane: a result must not depend, to its last bit, on the other points of a sweep.
        put(values, SLOTS.end, lane, math.pi)
        put(values, SLOTS.step, lane, motions.states[row, motions.states.shape[1] - 1])
        put(values, SLOTS.grows, lane, motions.control[row, GROWS])
        put(values, SLOTS.remembered, lane, motions.control[row, REMEMBERED])
        put(values, SLOTS.rtol, lane, motions.rtols[row])
        put(values, SLOTS.attempts, lane, 0.0)
        # All passes of a point share one budget of steps.
        put(values, SLOTS.limit, lane, float(task.max_steps - motions.counts[row, ATTEMPTED]))
        lanes.rows[lane], lanes.halves[lane] = row, 0
        recording.begin_following(values, lane)
        if task.mode >= MEASURE:
            begin_record(values, lane, True)
        if task.mode == VARY:
            begin_columns(values, lane)

    return load


def _make_handle_event(
    state: StateFunctions, width: int, begin_record: Any, refine: Any, variations: Variations
) -> Any:
    """Return the function that handles an event in a lane: it gives a status, or -1 to go on."""
    mirror_record = recording.record.mirror
    mirrored, get_state = state.mirrored, lane_vectors(LANES, width).get
    begin_half = _make_begin_half(width)
    mirror_columns, store_columns = variations.mirror, variations.store

    @jit
    def after_half(lanes: Lanes, motions: Motions, task: Pass, lane: int) -> int:
        values, row = lanes.values, lanes.rows[lane]
        begin_half(values, lane, mirrored(get_state(values, SLOTS.state, lane)))
        if task.mode >= MEASURE:
            # The record turns with the frame: a maximum is the minimum of the mirror image.
            mirror_record(values, lane)
            begin_record(values, lane, False)
        if task.mode == VARY:
            mirror_columns(values, lane)
            store_columns(values, lane, motions.varied[row])
        if task.mode == SEARCH:
            _store_ahead(lanes, motions, lane)
        lanes.halves[lane] += 1
        wanted = motions.counts[row, AHEAD if task.mode == SEARCH else CYCLE]
        if lanes.halves[lane] >= (task.halves if task.halves > 0 else wanted):
            return OK
        recording.begin_following(values, lane)
        return -1

    @jit
    def handle_event(lanes: Lanes, motions: Motions, task: Pass, lane: int) -> int:
        values = lanes.values
        # First the inside of the step, then its end, which would begin a new half period.
        if task.mode >= MEASURE and get(values, recording.PROMISING, lane) > 0.0:
            refine(values, lane, task.mode == VARY)
        if get(values, SLOTS.time, lane) >= get(values, SLOTS.end, lane):
            return after_half(lanes, motions, task, lane)
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
        if mode == SEARCH:
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

    It maps (motions, more, lanes, task, attempts) to the number of motions that have not ended,
    those in lanes and queue and `more` rows (m,): it works for that many attempts of all lanes
    together, or until some have ended, and is to be called again until the number is 0.
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
    load = _make_load(state, functions.width, begin_record, variations.begin, streams)
    handle_event = _make_handle_event(state, functions.width, begin_record, refine, variations)

    def work(motions: Motions, more: np.ndarray, lanes: Lanes, task: Pass, attempts: int) -> int:
        counts = lanes.counts
        for row in more:
            lanes.queue[counts[WAITING]] = row
            counts[WAITING] += 1
        for lane in range(LANES):
            if lanes.rows[lane] < 0:
                load(lanes, motions, task, lane)
        counts[ENDED] = 0
        goes_on = counts[BUSY] > 0  # asking the arrays before each attempt takes a fifth more time
        while goes_on and attempts > 0:
            # First vector code for all lanes; then, one by one, the few lanes that raised an event.
            attempts -= 1
            attempt(lanes.values)
            see(lanes.values, task.mode)
            kick(lanes.values)
            for lane in range(LANES):
                if get(lanes.values, SLOTS.event, lane) > 0.0 and lanes.rows[lane] >= 0:
                    status = handle_event(lanes, motions, task, lane)
                    if status >= 0:
                        _close(lanes, motions, lane, status, task.mode)
                        load(lanes, motions, task, lane)
                        goes_on = counts[BUSY] > 0 and not _enough(lanes)
        return counts[WAITING] + counts[BUSY]

    return work


@kernel_factory
def pass_kernel(family: Family) -> Any:
    """Return the kernel of a family of fluids, as `make_pass` describes it."""
    work = make_pass(make_problems(family), family.physics, two_solids=family.higher)
    return named_kernel(f"adaptive_pass[{family}]", work)


class InLanes:
    """Motions of one family on their way through a pass."""

    def __init__(self, motions: Motions, family: Family, task: Pass) -> None:
        self._motions, self._kernel, self._task = motions, pass_kernel(family), task
        self._lanes = new_lanes(motions.width, len(motions.points))

    def go_on(self, more: np.ndarray) -> np.ndarray:
        """Take motions along, and `more` rows; return those of some that have ended.

        None if all have. They are valid until the next call.
        """
        ended, counts = self._lanes.ended, self._lanes.counts
        left = self._kernel(self._motions, more, self._lanes, self._task, WORK)
        check_interruption()
        while left and not counts[ENDED]:
            left = self._kernel(self._motions, more[:0], self._lanes, self._task, WORK)
            check_interruption()
        return ended[: counts[ENDED]]

    def finish(self, more: np.ndarray) -> None:
        """Take all to the end."""
        while len(self.go_on(more)):
            more = more[:0]


def work_through(
    motions: Motions, mode: int, rtol: float, max_steps: int, physics: Physics, halves: int = 0
) -> None:
    """Take the motions that are still ok through a pass at a tolerance.

    As many half periods as its cycle has for each, or `halves` for all, in at most `max_steps`.
    """
    alive, task = np.flatnonzero(motions.counts[:, OUTCOME] == OK), Pass(mode, halves, max_steps)
    motions.rtols[alive], motions.control[alive] = rtol, fresh_control(len(alive))
    for family, members in families(physics, motions.points[:, KINDS][alive]):
        InLanes(motions, family, task).finish(alive[members])
