"""The kernels of the adaptive method, which integrate many motions in lanes.

A point is integrated half a drive period at a time, over phases 0 to pi in its own units
(model/scaling.py), and then mirrored, which maps orbits onto orbits. A lane takes the next point
as soon as its point has ended. A kernel returns some points that have ended while others are still
on their way. Its arrays then hold everything that it needs to continue.
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
"""Attempts of all lanes together in a kernel call, which take about a second, so that Ctrl-C is
noticed."""

_reduced_of = make_lane_reader(Reduced, SLOTS.parameters, get)

TRAVEL, SEARCH, MEASURE, VARY = range(4)
"""Kinds of passes. TRAVEL has no record. SEARCH has none either, but stores the state after each of
the half periods that a search wants. MEASURE has a record. VARY also shows how small displacements
of the first state change the motion and its extrema."""


class Pass(NamedTuple):
    """The kind of a pass, its number of half periods, and the budget of steps of a point.

    With 0 half periods each point goes through its cycle, or through those that its search wants.
    """

    mode: int
    halves: int
    max_steps: int


WAITING, BUSY, ENDED, LANE_COUNTS = range(4)


class Lanes(NamedTuple):
    """The complete state of the lanes between two calls of a kernel.

    `values` (slots*LANES,); `rows` (LANES,) the point in each lane, -1 if idle; `halves` (LANES,)
    half periods of this pass; `queue` (n,) the points that wait for a lane; `ended` (2*LANES,) the
    points that ended in the last call; `counts` (LANE_COUNTS,) of points WAITING, lanes BUSY and
    points ENDED.
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
        # Compiling this function would take half a second for a single call.
        values=aligned.py_func((columns_begin(width) + room_of(width)) * LANES),
        rows=np.full(LANES, -1, np.int64),
        halves=np.zeros(LANES, np.int64),
        queue=np.empty(most, np.int64),
        ended=np.empty(2 * LANES, np.int64),
        counts=np.zeros(LANE_COUNTS, np.int64),
    )


@jit
def _enough(lanes: Lanes) -> bool:
    """Return whether the points that have ended should be judged before the others go on.

    Either they are enough to fill all lanes, or half of the lanes wait for them.
    """
    counts = lanes.counts
    idle = counts[WAITING] == 0 and 2 * counts[BUSY] <= LANES
    return counts[ENDED] >= LANES or (counts[ENDED] > 0 and idle)


@jit
def _next_row(lanes: Lanes, motions: Motions) -> int:
    """Take the point with the longest search out of the queue, since all wait for the longest."""
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
    """Park an idle lane, which with an infinite end and limit raises no event."""
    put(lanes.values, SLOTS.end, lane, np.inf)
    put(lanes.values, SLOTS.limit, lane, np.inf)


@jit
def _store_ahead(lanes: Lanes, motions: Motions, lane: int) -> None:
    """Store the state after a half period as a row of `ahead`, with the attempts so far."""
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
    """Store the outcome of the point in a lane, and free the lane."""
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
    """Return the function (lanes, lane) that reads the Problem of a lane of one family."""
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
    """Return the function (values, lane, y) that puts a lane into a state at phase 0."""
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

    `streams` is the first slot of its stream of random numbers, or 0 without noise.
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
        # Half a period is pi in the units of a point. Nothing of the previous point may stay in the
        # lane, since no bit of a result may depend on the other points of a sweep.
        put(values, SLOTS.end, lane, math.pi)
        put(values, SLOTS.step, lane, motions.states[row, motions.states.shape[1] - 1])
        put(values, SLOTS.grows, lane, motions.control[row, GROWS])
        put(values, SLOTS.remembered, lane, motions.control[row, REMEMBERED])
        put(values, SLOTS.rtol, lane, motions.rtols[row])
        put(values, SLOTS.longest, lane, motions.longest[row])
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
    """Return the function that handles an event in a lane and returns a status, or -1 to go on."""
    mirror_record = recording.record.mirror
    mirrored, get_state = state.mirrored, lane_vectors(LANES, width).get
    begin_half = _make_begin_half(width)
    mirror_columns, store_columns = variations.mirror, variations.store

    @jit
    def after_half(lanes: Lanes, motions: Motions, task: Pass, lane: int) -> int:
        values, row = lanes.values, lanes.rows[lane]
        begin_half(values, lane, mirrored(get_state(values, SLOTS.state, lane)))
        if task.mode >= MEASURE:
            # The record is mirrored with the frame; a maximum is the minimum of the mirror image.
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
        # The inside of the step comes before its end, which would begin a new half period.
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
    """Return the function that evaluates the last step of all lanes for a kind of pass."""

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
    """Return the function that adds random noise after a step, and the slot of its stream or 0."""
    if not chance:
        return _no_kick, 0
    from stickslip.kernels.adaptive.kicks import make_kick  # only stochastic films need it

    return make_kick(problems, width), stream_begin(width)


def make_pass(problems: Any, physics: Physics, *, two_solids: bool = False) -> Any:
    """Return the function of a pass over problems that `problems(lanes, lane)` reads.

    With `two_solids` the pass also counts changes between a soft and a hard solid.

    It maps (motions, more, lanes, task, attempts) to the number of motions that have not ended,
    among those in lanes and queue and in the rows `more` (m,). It works for this number of attempts
    of all lanes together, or until some motions have ended, and must be called until the number is
    0.
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
        goes_on = counts[BUSY] > 0  # reading the arrays before each attempt takes a fifth more time
        while goes_on and attempts > 0:
            # Vector code handles all lanes; then the few lanes with an event follow one by one.
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
    """Return the kernel of the pass of `make_pass` for a family of fluids."""
    work = make_pass(make_problems(family), family.physics, two_solids=family.higher)
    return named_kernel(f"adaptive_pass[{family}]", work)


class InLanes:
    """Motions of one family on their way through a pass."""

    def __init__(self, motions: Motions, family: Family, task: Pass) -> None:
        self._motions, self._kernel, self._task = motions, pass_kernel(family), task
        self._lanes = new_lanes(motions.width, len(motions.points))

    def go_on(self, more: np.ndarray) -> np.ndarray:
        """Go on with the motions and `more` rows; return the rows of some that have ended.

        An empty array means that all have ended. The array is valid until the next call.
        """
        ended, counts = self._lanes.ended, self._lanes.counts
        left = self._kernel(self._motions, more, self._lanes, self._task, WORK)
        check_interruption()
        while left and not counts[ENDED]:
            left = self._kernel(self._motions, more[:0], self._lanes, self._task, WORK)
            check_interruption()
        return ended[: counts[ENDED]]

    def finish(self, more: np.ndarray) -> None:
        """Go on to the end of all motions."""
        while len(self.go_on(more)):
            more = more[:0]


def work_through(
    motions: Motions, mode: int, rtol: float, max_steps: int, physics: Physics, halves: int = 0
) -> None:
    """Take the motions that are still ok through a pass at a tolerance.

    Each goes through the half periods of its cycle, or all go through `halves`, in at most
    `max_steps`.
    """
    alive, task = np.flatnonzero(motions.counts[:, OUTCOME] == OK), Pass(mode, halves, max_steps)
    motions.rtols[alive], motions.control[alive] = rtol, fresh_control(len(alive))
    for family, members in families(physics, motions.points[:, KINDS][alive]):
        InLanes(motions, family, task).finish(alive[members])
