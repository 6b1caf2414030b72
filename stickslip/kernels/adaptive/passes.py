"""The adaptive method in lanes: doors that take a queue of points through it.

A point is integrated half a drive period at a time, over phases 0 to pi of its own units
(model/units.py), and then mirrored, which maps its orbit onto itself. Lanes take the next point
of the queue as soon as theirs is finished. A door works for a given number of attempts and leaves
everything it needs to go on in the arrays that it was given.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import door, inline, jit
from stickslip.compiled.simd import LANES
from stickslip.kernels.adaptive import recording as records
from stickslip.kernels.problem import (
    Scene,
    error_weight,
    scene_jacobian,
    scene_of,
    scene_rhs,
)
from stickslip.model.scaling import Reduced, with_gamma
from stickslip.numerics import step_control
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT
from stickslip.numerics.adaptive_lanes import (
    ATTEMPTS,
    END,
    EVENT,
    GROWS,
    LIMIT,
    PARAMETERS,
    REMEMBERED,
    RTOL,
    STEP,
    STUCK,
    TIME,
    aligned,
    arrived,
    at,
    make_attempt,
    put,
    put_state,
    state_of,
)
from stickslip.numerics.linear import Vector
from stickslip.numerics.periodic import search
from stickslip.numerics.rosenbrock import make_step
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.status import Status

NOT_STATIONARY = int(Status.NOT_STATIONARY)

TRAVEL, SETTLE, MEASURE = 0, 1, 2
"""What a pass through a queue does: so many half periods; as many as it takes to the stationary
orbit; so many with a record."""

# ln(phi) repeats to this many tolerances: it is slaved to the motion, and swings by hundreds.
FILM_WEIGHT = 1e-3

REFINEMENT = 0.1
"""The finer tolerance of the search, and of the measurement, as a part of the coarser one."""

# Columns of `states`: the state in the point's own units, and the step to go on with.
STATE_COLUMNS = 4
# Columns of `counts`, integers. HALVES: half periods done; CYCLE: half periods after which the
# orbit closes (or, for TRAVEL, how many to do); ATTEMPTS: steps attempted, all passes together.
HALVES, CYCLE, ATTEMPTED, OUTCOME = range(4)
COUNT_COLUMNS = 4


class Pass(NamedTuple):
    """What a pass does, and with which tolerances and budgets; half periods, not periods."""

    mode: int
    rtol: float
    stationary_rtol: float
    max_halves: int
    max_steps: int
    accelerate: bool


class Queue(NamedTuple):
    """The points of a pass; rows are points.

    `points` (n, 9) reduced parameters; `states` (n, 4) and `counts` (n, 4) in and out; `measured`
    (n, RECORD) and `ratios` (n,), the contraction of the orbit, out.
    """

    points: np.ndarray
    states: np.ndarray
    counts: np.ndarray
    measured: np.ndarray
    ratios: np.ndarray


class Lanes(NamedTuple):
    """The state of the lanes between two calls of a door: all of it.

    `values` (SLOTS*LANES,); `rows` (LANES,) the point in each lane, -1 where idle; `halves`
    (LANES,) done in this pass; `memories` (LANES, search.MEMORY); `cursor` (2,) the next point
    of the queue and the number of lanes at work, -1 before the first call.
    """

    values: np.ndarray
    rows: np.ndarray
    halves: np.ndarray
    memories: np.ndarray
    cursor: np.ndarray


def new_lanes() -> Lanes:
    """Lanes that have not begun."""
    return Lanes(
        values=aligned(records.SLOTS * LANES),
        rows=np.full(LANES, -1, np.int64),
        halves=np.zeros(LANES, np.int64),
        memories=np.zeros((LANES, search.MEMORY)),
        cursor=np.array([0, -1]),
    )


@inline
def _mirrored(y: Vector) -> Vector:
    return -y[0], -y[1], y[2]


@inline
def _scaled(y: Vector) -> Vector:
    """The state as its repetition is judged: the film loosely."""
    return y[0], y[1], FILM_WEIGHT * y[2]


@jit
def _idle(lanes: Lanes, lane: int) -> None:
    """Let a lane run on for ever: nobody looks."""
    lanes.rows[lane] = -1
    put(lanes.values, END, lane, np.inf)
    put(lanes.values, LIMIT, lane, np.inf)


@jit
def _close(lanes: Lanes, queue: Queue, lane: int, status: int) -> None:
    """Write down what became of the point in a lane."""
    row, values = lanes.rows[lane], lanes.values
    y, counts = state_of(values, lane), queue.counts[row]
    queue.states[row, 0], queue.states[row, 1], queue.states[row, 2] = y
    queue.states[row, 3] = at(values, STEP, lane)
    counts[ATTEMPTED] += int(at(values, ATTEMPTS, lane))
    counts[OUTCOME] = status
    for slot in range(records.RECORD):
        queue.measured[row, slot] = at(values, records.STRESS_MAX + slot, lane)


@jit
def _again(values: np.ndarray, lane: int, y: Vector) -> None:
    """Put a lane at phase 0."""
    put_state(values, lane, y)
    put(values, TIME, lane, 0.0)


@jit
def _obey(lanes: Lanes, task: Pass, lane: int, y: Vector) -> int:
    """Settle: ask what to do after a half period, and do it; -1 while the search goes on."""
    values, memory = lanes.values, lanes.memories[lane]
    rtol = at(values, RTOL, lane)
    verdict, dx, dv = search.judge(memory, _scaled(y), task.stationary_rtol, rtol, task.max_halves)
    _again(values, lane, (y[0] + dx, y[1] + dv, y[2]))
    if verdict == search.SETTLED:
        dx, dv = search.last_correction(memory)
        put_state(values, lane, (y[0] + dx, y[1] + dv, y[2]))
        return OK
    if verdict == search.EXHAUSTED:
        return NOT_STATIONARY
    if verdict == search.FINER:
        put(values, RTOL, lane, REFINEMENT * rtol)
    elif verdict == search.RESTORE:
        x, v, film = search.stored(memory)
        put_state(values, lane, (x, v, film / FILM_WEIGHT))
        put(values, RTOL, lane, task.rtol)
    return -1


@inline
def _reduced_of(values: np.ndarray, lane: int) -> Reduced:
    return Reduced(
        at(values, PARAMETERS, lane),
        at(values, PARAMETERS + 1, lane),
        at(values, PARAMETERS + 2, lane),
        at(values, PARAMETERS + 3, lane),
        at(values, PARAMETERS + 4, lane),
        at(values, PARAMETERS + 5, lane),
        at(values, PARAMETERS + 6, lane),
        at(values, PARAMETERS + 7, lane),
        at(values, PARAMETERS + 8, lane),
        at(values, PARAMETERS + 9, lane),
    )


def _make_scenes(gamma: float | None) -> Any:
    """The scene of a lane for fluids with the index `gamma`, a literal, or with any for None."""
    if gamma is None:

        @inline
        def any_scene(values: np.ndarray, lane: int) -> Scene:
            q = _reduced_of(values, lane)
            return scene_of(with_gamma(q, q.gamma), at(values, RTOL, lane))

        return any_scene

    @inline
    def scene(values: np.ndarray, lane: int) -> Scene:
        return scene_of(with_gamma(_reduced_of(values, lane), gamma), at(values, RTOL, lane))

    return scene


def _make_load(start_record: Any) -> Any:
    """What puts the next point of the queue into a lane, or lets the lane idle."""

    @jit
    def load(lanes: Lanes, queue: Queue, task: Pass, lane: int) -> None:
        values, row = lanes.values, lanes.cursor[0]
        if row >= queue.points.shape[0]:
            _idle(lanes, lane)
            lanes.cursor[1] -= 1
            return
        lanes.cursor[0] += 1
        for slot in range(queue.points.shape[1]):
            put(values, PARAMETERS + slot, lane, queue.points[row, slot])
        state = queue.states[row]
        y = state[0], state[1], state[2]
        _again(values, lane, y)
        put(values, END, lane, math.pi)
        put(values, STEP, lane, state[3])
        put(values, GROWS, lane, 1.0)
        put(values, REMEMBERED, lane, step_control.START)
        put(values, RTOL, lane, task.rtol)
        put(values, ATTEMPTS, lane, 0.0)
        put(values, LIMIT, lane, float(task.max_steps - queue.counts[row, ATTEMPTED]))
        lanes.rows[lane], lanes.halves[lane] = row, 0
        if task.mode == SETTLE:
            search.start(lanes.memories[lane], _scaled(y), task.accelerate, True)
        elif task.mode == MEASURE:
            start_record(values, lane, True)

    return load


def _make_look(start_record: Any, refine: Any) -> Any:
    """What an event in a lane means for its point: a status, or -1 to go on."""

    @jit
    def after_half(lanes: Lanes, queue: Queue, task: Pass, lane: int) -> int:
        y, row = _mirrored(state_of(lanes.values, lane)), lanes.rows[lane]
        lanes.halves[lane] += 1
        if task.mode == SETTLE:
            status = _obey(lanes, task, lane, y)
            queue.counts[row, HALVES] = lanes.halves[lane]
            if status == OK:
                queue.counts[row, CYCLE], queue.ratios[row] = search.found(lanes.memories[lane])
            return status
        _again(lanes.values, lane, y)
        if task.mode == MEASURE:
            records.turn(lanes.values, lane)
            start_record(lanes.values, lane, False)
        return OK if lanes.halves[lane] >= queue.counts[row, CYCLE] else -1

    @jit
    def look(lanes: Lanes, queue: Queue, task: Pass, lane: int) -> int:
        values = lanes.values
        if task.mode == MEASURE and at(values, records.PROMISING, lane) > 0.0:
            refine(values, lane)
        if arrived(values, lane):
            return after_half(lanes, queue, task, lane)
        if at(values, STUCK, lane) > 0.0:
            return DIVERGED
        return STEP_LIMIT if at(values, ATTEMPTS, lane) >= at(values, LIMIT, lane) else -1

    return look


def _make_pass(gamma: float | None) -> Any:
    """A pass for fluids with the rheological index `gamma`, or with any for None.

    It maps (queue, lanes, task, attempts) to the number of points still to be finished: 0 when
    the pass is done.
    """
    scenes = _make_scenes(gamma)
    attempt = make_attempt(scene_rhs, scene_jacobian, error_weight, scenes, RODAS4P2)
    see, start_record = records.make_see(scenes), records.make_start(scenes)
    refine = records.make_refine(scenes, make_step(scene_rhs, RODAS4P2))
    load, look = _make_load(start_record), _make_look(start_record, refine)

    @jit
    def work(queue: Queue, lanes: Lanes, task: Pass, attempts: int) -> int:
        if lanes.cursor[1] < 0:
            lanes.cursor[1] = LANES
            for lane in range(LANES):
                load(lanes, queue, task, lane)
        while lanes.cursor[1] > 0 and attempts > 0:
            attempts -= 1
            attempt(lanes.values)
            if task.mode == MEASURE:
                see(lanes.values)
            for lane in range(LANES):
                if at(lanes.values, EVENT, lane) > 0.0 and lanes.rows[lane] >= 0:
                    status = look(lanes, queue, task, lane)
                    if status >= 0:
                        _close(lanes, queue, lane, status)
                        load(lanes, queue, task, lane)
        return queue.points.shape[0] - lanes.cursor[0] + lanes.cursor[1]

    return work


_pseudoplastic, _newtonian = _make_pass(-2.0 / 3.0), _make_pass(0.0)
_dilatant, _general = _make_pass(2.0 / 3.0), _make_pass(None)


@door
def pseudoplastic_pass(queue: Queue, lanes: Lanes, task: Pass, attempts: int) -> int:
    """A pass of points with gamma = -2/3.

    Works for so many attempts of all lanes together, and returns how many points are still to be
    finished; call it again until that is 0.
    """
    return _pseudoplastic(queue, lanes, task, attempts)


@door
def newtonian_pass(queue: Queue, lanes: Lanes, task: Pass, attempts: int) -> int:
    """A pass of points with gamma = 0; as `pseudoplastic_pass`."""
    return _newtonian(queue, lanes, task, attempts)


@door
def dilatant_pass(queue: Queue, lanes: Lanes, task: Pass, attempts: int) -> int:
    """A pass of points with gamma = 2/3; as `pseudoplastic_pass`."""
    return _dilatant(queue, lanes, task, attempts)


@door
def general_pass(queue: Queue, lanes: Lanes, task: Pass, attempts: int) -> int:
    """A pass of points with any gamma, by a general power; as `pseudoplastic_pass`."""
    return _general(queue, lanes, task, attempts)


SPECIAL_PASSES = {-2.0 / 3.0: pseudoplastic_pass, 0.0: newtonian_pass, 2.0 / 3.0: dilatant_pass}
"""Fluids with kernels of their own, by their rheological index; `general_pass` does the others."""
