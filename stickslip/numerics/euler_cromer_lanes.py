"""The fixed-step drive in lanes: Euler-Cromer for many trajectories side by side.

The unit of time is a lane's own step, so that no step length appears. All lanes advance by one step
at a time; an idle lane computes a useless step, which costs nothing beside its neighbours. The
numbers of a lane depend neither on the contents of other lanes nor on which lane it is.

The drive of the system is a sum of sines, each of which advances by second differences:
V(n+1) - 2 V(n) + V(n-1) = -turn V(n), which is exact for turn = 4 sin^2(angle/2) and costs two
operations. Every STEPS_BETWEEN_CHECKS steps it is reset from the sine itself, before rounding
errors add up.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit_making_arrays
from stickslip.compiled.fields import make_function
from stickslip.compiled.simd import LANES, for_lanes
from stickslip.numerics.adaptive import DIVERGED, OK
from stickslip.numerics.lane_array import aligned, lane_array
from stickslip.numerics.linear import algebra
from stickslip.status import Status

PENDING = int(Status.PENDING)

_finite = algebra(3).finite

WIDTH = 4 * LANES
"""Lanes side by side. A single lane would wait for its own results ten times as long as a step
takes to compute; 64 lanes keep the processor busy meanwhile and still fit its nearest cache."""

# Checking every step for NaN, or resetting the sine, would cost as much as the step.
STEPS_BETWEEN_CHECKS = 4096

# Slots of a lane: the state (x, v, w); then for each sine of the drive its value, its change in the
# last step and the factor of its second difference; then the constants of the lane.
X, V, W, DRIVE, CHANGE, TURN = range(6)
SINE = 3
"""Number of slots of a sine."""


def first_free(sines: int) -> int:
    """Return the slot after those of the state and of this many sines."""
    return DRIVE + SINE * sines


class Tasks(NamedTuple):
    """Trajectories to be marched, one per row.

    `rows` (n, slots) holds the contents of lanes; `done` and `total` (n,) steps; `status` (n,)
    is PENDING while there are steps to do, then OK or DIVERGED.
    """

    rows: np.ndarray
    done: np.ndarray
    total: np.ndarray
    status: np.ndarray


class Chance(NamedTuple):
    """Random numbers for lanes, a group of steps at a time; inline functions."""

    group: int
    """Steps per group; 0 without random numbers."""

    refresh: Callable[..., None]
    """(lane, lanes): prepare a lane for the next group of steps."""

    draw: Callable[..., float]
    """(lanes, lane): the random number of the next step."""


@inline
def _no_refresh(lane: int, lanes: np.ndarray) -> None:
    pass


@inline
def _no_draw(lanes: np.ndarray, lane: int) -> float:
    return 0.0


NO_RANDOM_NUMBERS = Chance(0, _no_refresh, _no_draw)

_array = lane_array(WIDTH)
get, put = _array.get, _array.put


def make_euler_cromer_lanes(
    parameters: Callable[..., Any],
    increments: Callable[..., tuple[float, float]],
    observe: Callable[..., None],
    sines: Sequence[Callable[..., tuple[float, float]]],
    slots: int,
    chance: Chance = NO_RANDOM_NUMBERS,
) -> Any:
    """Return the Euler-Cromer drive of many systems of one kind.

    `parameters(lanes, lane)` reads the slots of a lane from `first_free` to `slots`;
    `increments(p, V, y, xi)` gives the increments of v and w in a step from the state y = (x, v, w)
    under the drive V with the random number xi; x then gains the *new* v, and w is reflected at 0.
    `observe(p, V, y, lanes, lane)` is called at the start of every step. All three must be free of
    branches, calls and divisions. Each of `sines`, a function of (p, n), gives its part of the
    drive at step n and its change since step n - 1. With `chance` the tasks and the budget are
    whole numbers of its groups of steps.

    The drive maps (tasks, queue, budget) to the unused steps of the budget: it marches the PENDING
    ones among the rows of `queue`, for at most `budget` steps of all lanes together, and leaves in
    `tasks` what it needs to go on. Results do not depend on where the budget ends. A state that is
    not finite is noticed within 4096 steps. Order 1; stable only for steps below 2/(fastest rate),
    which is not checked here.
    """
    march = _make_march(parameters, increments, observe, len(sines), chance)
    check = _make_check(parameters, sines)
    fill, look = _make_fill(check), _make_look(check)

    @jit_making_arrays
    def work(tasks: Tasks, queue: np.ndarray, budget: int) -> int:
        lanes, row_of = aligned(slots * WIDTH), np.empty(WIDTH, np.int64)
        active, following = fill(tasks, queue, lanes, row_of, 0, 0)
        while active > 0 and budget > 0:
            steps = min(budget, _steps_to_next_check(tasks, row_of, active))
            # Whole vectors: the idle lanes among them compute in vain.
            march(lanes, (active + LANES - 1) // LANES * LANES, steps)
            budget -= steps
            active = look(tasks, lanes, row_of, active, steps)
            active, following = fill(tasks, queue, lanes, row_of, active, following)
        for lane in range(active):
            _store(tasks.rows[row_of[lane]], lanes, lane)
        return budget

    return work


def _make_march(
    parameters: Callable[..., Any],
    increments: Callable[..., tuple[float, float]],
    observe: Callable[..., None],
    sines: int,
    chance: Chance,
) -> Any:
    """Return the inner loop, `steps` steps of `count` lanes; its loops over sines are unrolled."""
    draw, refresh = chance.draw, chance.refresh

    @inline
    def step(lane: int, lanes: np.ndarray) -> None:
        p = parameters(lanes, lane)
        drive = get(lanes, DRIVE, lane)
        for i in range(1, sines):
            drive += get(lanes, DRIVE + SINE * i, lane)
        x, v, w = get(lanes, X, lane), get(lanes, V, lane), get(lanes, W, lane)
        # The record takes a step at its start, so that the same values serve both.
        observe(p, drive, (x, v, w), lanes, lane)
        dv, dw = increments(p, drive, (x, v, w), draw(lanes, lane))
        v += dv
        put(lanes, X, lane, x + v)
        put(lanes, V, lane, v)
        put(lanes, W, lane, abs(w + dw))
        # A sine by its own difference equation, V'' = -omega^2 V: a call of sin() would prevent
        # vectorisation. Its rounding error grows with the steps, so it is reset every so often.
        for i in range(sines):
            own, turn = get(lanes, DRIVE + SINE * i, lane), get(lanes, TURN + SINE * i, lane)
            change = get(lanes, CHANGE + SINE * i, lane) - turn * own
            put(lanes, DRIVE + SINE * i, lane, own + change)
            put(lanes, CHANGE + SINE * i, lane, change)

    # None of these makes arrays, but as `jit` LLVM would not vectorise their loops.
    @jit_making_arrays
    def march(lanes: np.ndarray, count: int, steps: int) -> None:
        for _ in range(steps):
            for_lanes(count, step, (lanes,))

    group = chance.group

    @jit_making_arrays
    def march_groups(lanes: np.ndarray, count: int, steps: int) -> None:
        for done in range(steps):
            if done % group == 0:
                for_lanes(count, refresh, (lanes,))
            for_lanes(count, step, (lanes,))

    return march_groups if group else march


def _make_set_right(sines: Sequence[Callable[..., tuple[float, float]]]) -> Any:
    """Return the function (p, n, lanes, lane) that resets the drive of a lane at step n."""
    lines = []
    for i in range(len(sines)):
        lines.append(f"value, change = sine{i}(p, n)")
        lines.append(f"put(lanes, {DRIVE + SINE * i}, lane, value)")
        lines.append(f"put(lanes, {CHANGE + SINE * i}, lane, change)")
    names = {"put": put} | {f"sine{i}": sine for i, sine in enumerate(sines)}
    return make_function(f"set_right[{len(sines)}]", "p, n, lanes, lane", lines, names)


def _make_check(
    parameters: Callable[..., Any], sines: Sequence[Callable[..., tuple[float, float]]]
) -> Any:
    """Return the regular check of a lane: whether it goes on, and resetting its drive."""
    set_right = _make_set_right(sines)

    @jit_making_arrays
    def check(tasks: Tasks, row: int, lanes: np.ndarray, lane: int) -> None:
        done = tasks.done[row]
        if not _finite((get(lanes, X, lane), get(lanes, V, lane), get(lanes, W, lane))):
            tasks.status[row] = DIVERGED
        elif done >= tasks.total[row]:
            tasks.status[row] = OK
        elif done % STEPS_BETWEEN_CHECKS == 0:
            set_right(parameters(lanes, lane), done, lanes, lane)

    return check


def _make_fill(check: Callable[..., None]) -> Any:
    """Return the function that gives idle lanes the next rows of the queue."""

    @jit_making_arrays
    def fill(
        tasks: Tasks,
        queue: np.ndarray,
        lanes: np.ndarray,
        row_of: np.ndarray,
        active: int,
        following: int,
    ) -> tuple[int, int]:
        while active < WIDTH and following < queue.shape[0]:
            row = queue[following]
            following += 1
            if tasks.status[row] == PENDING:
                _load(tasks.rows[row], lanes, active)
                row_of[active] = row
                # Between checks a resumed row goes on with the drive that it was stored with.
                if tasks.done[row] % STEPS_BETWEEN_CHECKS == 0 or _arrived(tasks, row):
                    check(tasks, row, lanes, active)
                active += 1 if tasks.status[row] == PENDING else 0
        return active, following

    return fill


def _make_look(check: Callable[..., None]) -> Any:
    """Return the function that checks the lanes that are due and releases those that are done."""

    @jit_making_arrays
    def look(tasks: Tasks, lanes: np.ndarray, row_of: np.ndarray, active: int, steps: int) -> int:
        # Backwards, because the last lane fills the gap of one that is done.
        for lane in range(active - 1, -1, -1):
            row = row_of[lane]
            tasks.done[row] += steps
            if tasks.done[row] % STEPS_BETWEEN_CHECKS == 0 or _arrived(tasks, row):
                check(tasks, row, lanes, lane)
            if tasks.status[row] != PENDING:
                _store(tasks.rows[row], lanes, lane)
                active -= 1
                row_of[lane] = row_of[active]
                _move(lanes, active, lane)
        return active

    return look


@inline
def _load(row: np.ndarray, lanes: np.ndarray, lane: int) -> None:
    for slot in range(row.shape[0]):
        put(lanes, slot, lane, row[slot])


@inline
def _store(row: np.ndarray, lanes: np.ndarray, lane: int) -> None:
    for slot in range(row.shape[0]):
        row[slot] = get(lanes, slot, lane)


@inline
def _move(lanes: np.ndarray, source: int, target: int) -> None:
    """Let the last lane fill a gap: a step is faster the fewer lanes are busy."""
    for slot in range(lanes.shape[0] // WIDTH):
        put(lanes, slot, target, get(lanes, slot, source))


@inline
def _arrived(tasks: Tasks, row: int) -> bool:
    return tasks.done[row] >= tasks.total[row]


@inline
def _steps_to_next_check(tasks: Tasks, row_of: np.ndarray, active: int) -> int:
    """Number of steps that all lanes can do before one of them needs a check."""
    steps = STEPS_BETWEEN_CHECKS
    for lane in range(active):
        done = tasks.done[row_of[lane]]
        left = tasks.total[row_of[lane]] - done
        steps = min(steps, left, STEPS_BETWEEN_CHECKS - done % STEPS_BETWEEN_CHECKS)
    return steps
