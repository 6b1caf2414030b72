"""The fixed-step integrator in lanes: Euler-Cromer for many trajectories side by side.

The unit of time is the step of the lane, so that no step length appears. All lanes advance
together, one step at a time; an idle lane computes a useless step at no extra cost. The numbers of
a lane depend neither on the other lanes nor on its place among them.

The system is driven by a sum of sines, each of which advances by second differences:
V(n+1) - 2 V(n) + V(n-1) = -turn V(n), which is exact for turn = 4 sin^2(angle/2) and costs two
operations. Every STEPS_BETWEEN_CHECKS steps the sine itself resets it, before rounding errors add
up.
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
"""The number of lanes. A single lane would wait for its own results ten times as long as a step
takes; 64 lanes keep the processor busy meanwhile, and still fit into its nearest cache."""

# A check for NaN, or a reset of the sine, at every step would cost as much as the step.
STEPS_BETWEEN_CHECKS = 4096

# The slots of a lane: the state (x, v, w); for each sine of the drive its value, its change in the
# last step and the factor of its second difference; then the constants of the lane.
X, V, W, DRIVE, CHANGE, TURN = range(6)
SINE = 3
"""The number of slots of a sine."""


def first_free(sines: int) -> int:
    """Return the first slot after the state and this many sines."""
    return DRIVE + SINE * sines


class Tasks(NamedTuple):
    """The trajectories to integrate, one in each row.

    `rows` (n, slots) has the contents of their lanes, `done` and `total` (n,) count steps. `status`
    (n,) is PENDING until all steps are done, then OK or DIVERGED.
    """

    rows: np.ndarray
    done: np.ndarray
    total: np.ndarray
    status: np.ndarray


class Chance(NamedTuple):
    """Random numbers for lanes, drawn for a group of steps at a time; inline functions."""

    group: int
    """The number of steps in a group; 0 without random numbers."""

    refresh: Callable[..., None]
    """(lane, lanes): prepare a lane for the next group of steps."""

    draw: Callable[..., float]
    """(lanes, lane): return the random number of the next step."""


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
    """Return the Euler-Cromer integrator of many systems of one kind.

    `parameters(lanes, lane)` reads the slots of a lane from `first_free` to `slots`.
    `increments(p, V, y, xi)` returns the increments of v and w in a step from the state y =
    (x, v, w), for the drive V and the random number xi; x then gains the *new* v, and w is
    reflected at 0. `observe(p, V, y, lanes, lane)` is called at the start of every step. These
    three must have no branches, calls or divisions. Each of the `sines`, a function (p, n), returns
    its part of the drive at step n and its change since step n - 1. With `chance` the tasks and the
    budget are multiples of its group.

    The integrator maps (tasks, queue, budget) to the unused steps of the budget. It integrates the
    PENDING rows in `queue`, for no more than `budget` steps of all lanes together, and stores in
    `tasks` what it needs to continue. Results do not depend on where a budget ends. A state that is
    not finite is detected within 4096 steps. The method is of order 1, and stable only for steps
    below 2/(fastest rate), which is not checked here.
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
            # Whole vectors; the idle lanes in them compute useless steps.
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
    """Return the inner loop over steps and lanes; its loops over sines are unrolled."""
    draw, refresh = chance.draw, chance.refresh

    @inline
    def step(lane: int, lanes: np.ndarray) -> None:
        p = parameters(lanes, lane)
        drive = get(lanes, DRIVE, lane)
        for i in range(1, sines):
            drive += get(lanes, DRIVE + SINE * i, lane)
        x, v, w = get(lanes, X, lane), get(lanes, V, lane), get(lanes, W, lane)
        # The record sees a step at its start, so that both use the same values.
        observe(p, drive, (x, v, w), lanes, lane)
        dv, dw = increments(p, drive, (x, v, w), draw(lanes, lane))
        v += dv
        put(lanes, X, lane, x + v)
        put(lanes, V, lane, v)
        put(lanes, W, lane, abs(w + dw))
        # A sine by its difference equation, V'' = -omega^2 V, because a call of sin() would prevent
        # vectorisation. Its rounding error grows with the steps, so that it needs resets.
        for i in range(sines):
            own, turn = get(lanes, DRIVE + SINE * i, lane), get(lanes, TURN + SINE * i, lane)
            change = get(lanes, CHANGE + SINE * i, lane) - turn * own
            put(lanes, DRIVE + SINE * i, lane, own + change)
            put(lanes, CHANGE + SINE * i, lane, change)

    # Neither makes arrays, but with `jit` LLVM would not vectorise their loops.
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
    """Return the regular check of a lane, which updates its status or resets its drive."""
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
                # Between checks a resumed row continues with its stored drive.
                if _is_due(tasks, row):
                    check(tasks, row, lanes, active)
                active += 1 if tasks.status[row] == PENDING else 0
        return active, following

    return fill


def _make_look(check: Callable[..., None]) -> Any:
    """Return the function that checks the lanes that are due, and releases finished ones."""

    @jit_making_arrays
    def look(tasks: Tasks, lanes: np.ndarray, row_of: np.ndarray, active: int, steps: int) -> int:
        # Backwards, because the last lane takes the place of a finished one.
        for lane in range(active - 1, -1, -1):
            row = row_of[lane]
            tasks.done[row] += steps
            if _is_due(tasks, row):
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
    """Move the last lane into a gap, because fewer lanes make a faster step."""
    for slot in range(lanes.shape[0] // WIDTH):
        put(lanes, slot, target, get(lanes, slot, source))


@inline
def _is_due(tasks: Tasks, row: int) -> bool:
    """Return whether a row needs a check."""
    return tasks.done[row] % STEPS_BETWEEN_CHECKS == 0 or tasks.done[row] >= tasks.total[row]


@inline
def _steps_to_next_check(tasks: Tasks, row_of: np.ndarray, active: int) -> int:
    """Number of steps until the first lane needs a check."""
    steps = STEPS_BETWEEN_CHECKS
    for lane in range(active):
        done = tasks.done[row_of[lane]]
        left = tasks.total[row_of[lane]] - done
        steps = min(steps, left, STEPS_BETWEEN_CHECKS - done % STEPS_BETWEEN_CHECKS)
    return steps
