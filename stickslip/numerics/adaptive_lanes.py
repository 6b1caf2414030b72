"""The adaptive drive in lanes: many trajectories side by side, each with its own time and step.

The lanes live in one flat array, slot after slot of LANES numbers. `attempt` lets every lane try
one step; what is accepted advances, the others keep their state and take a shorter step next. The
arithmetic is that of the scalar drive (adaptive.py), with choices instead of branches.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.simd import LANES, for_lanes
from stickslip.numerics import step_control
from stickslip.numerics.linear import Vector, largest
from stickslip.numerics.rosenbrock import defect_error, make_step
from stickslip.numerics.tableaus import RosenbrockTableau

# Slots of a lane: where it is and goes; the step tried last, for its continuous extension; the
# number of attempts and their limit; whether the step has shrunk to rounding; whether any of this
# needs attention. Parameters come behind.
(
    TIME, END, Y0, Y1, Y2, STEP, GROWS, REMEMBERED, RTOL,
    FROM, USED, OLD0, OLD1, OLD2, D10, D11, D12, D20, D21, D22, ACCEPTED,
    ATTEMPTS, LIMIT, STUCK, EVENT,
    PARAMETERS,
) = range(26)  # fmt: skip


@jit
def aligned(size: int) -> np.ndarray:
    """Zeros from the beginning of a cache line: with vectors across two, a step takes 1.3 times."""
    line = 8
    room = np.zeros(size + line)
    first = -(room.ctypes.data // 8) % line
    return room[first : first + size]


@inline
def at(lanes: np.ndarray, slot: int, lane: int) -> float:
    """The number in a slot of a lane."""
    return lanes[slot * LANES + lane]


@inline
def put(lanes: np.ndarray, slot: int, lane: int, value: float) -> None:
    """Write a slot of a lane."""
    lanes[slot * LANES + lane] = value


@inline
def state_of(lanes: np.ndarray, lane: int) -> Vector:
    """The state of a lane."""
    return at(lanes, Y0, lane), at(lanes, Y1, lane), at(lanes, Y2, lane)


@inline
def put_state(lanes: np.ndarray, lane: int, y: Vector) -> None:
    """Write the state of a lane."""
    put(lanes, Y0, lane, y[0])
    put(lanes, Y1, lane, y[1])
    put(lanes, Y2, lane, y[2])


@inline
def arrived(lanes: np.ndarray, lane: int) -> bool:
    """Whether a lane has reached its end."""
    return at(lanes, TIME, lane) >= at(lanes, END, lane)


def make_attempt(
    rhs: Callable[..., Vector],
    jacobian: Callable[..., tuple[Vector, Vector, Vector, Vector]],
    error_weight: Callable[..., Vector],
    parameters: Callable[..., Any],
    tableau: RosenbrockTableau,
) -> Any:
    """One attempted step in every lane, of y' = rhs(p, t, y) with p = parameters(lanes, lane).

    The other arguments are those of `make_adaptive`. What comes back maps the array of lanes to
    nothing: lanes that have arrived at END stay there.
    """
    step = make_step(rhs, tableau)

    @inline
    def lane_attempt(lane: int, lanes: np.ndarray) -> None:
        p, y = parameters(lanes, lane), state_of(lanes, lane)
        t, end, h = at(lanes, TIME, lane), at(lanes, END, lane), at(lanes, STEP, lane)
        rtol, grows = at(lanes, RTOL, lane), at(lanes, GROWS, lane) > 0.0
        left = end - t
        last = 1.0001 * h >= left
        half = 0.5 * left
        used = left if last else (h if h < half else half)  # no sliver is left for the end
        f, J = rhs(p, t, y), jacobian(p, t, y)
        y1, error, d1, d2, LU = step(p, t, y, used, f, J)
        weight = error_weight(p, y, J)
        f1 = rhs(p, t + used, y1)
        embedded = largest(error, weight)
        seen = largest(defect_error(f1, LU, y, y1, d1, d2, used), weight)
        ratio = (embedded if seen <= embedded else seen) / rtol  # NaN counts
        accepted = ratio <= 1.0
        remembered = at(lanes, REMEMBERED, lane)
        factor, remembers = step_control.after_success(ratio, remembered)
        longer = used * factor
        longer = longer if grows or longer < used else used
        longer = longer if longer < h or not last else h
        put(lanes, STEP, lane, longer if accepted else used * step_control.after_rejection(ratio))
        put(lanes, REMEMBERED, lane, remembers if accepted else remembered)
        put(lanes, FROM, lane, t)
        put(lanes, USED, lane, used)
        put(lanes, OLD0, lane, y[0])
        put(lanes, OLD1, lane, y[1])
        put(lanes, OLD2, lane, y[2])
        put(lanes, D10, lane, d1[0])
        put(lanes, D11, lane, d1[1])
        put(lanes, D12, lane, d1[2])
        put(lanes, D20, lane, d2[0])
        put(lanes, D21, lane, d2[1])
        put(lanes, D22, lane, d2[2])
        put(lanes, TIME, lane, (end if last else t + used) if accepted else t)
        put(lanes, Y0, lane, y1[0] if accepted else y[0])
        put(lanes, Y1, lane, y1[1] if accepted else y[1])
        put(lanes, Y2, lane, y1[2] if accepted else y[2])
        put(lanes, GROWS, lane, 1.0 if accepted else 0.0)
        put(lanes, ACCEPTED, lane, 1.0 if accepted else 0.0)
        attempts = at(lanes, ATTEMPTS, lane) + 1.0
        stuck = (not last) & (not t + used > t)
        through = (last & accepted) | stuck | (attempts >= at(lanes, LIMIT, lane))
        put(lanes, ATTEMPTS, lane, attempts)
        put(lanes, STUCK, lane, 1.0 if stuck else 0.0)
        put(lanes, EVENT, lane, 1.0 if through else 0.0)

    @jit
    def attempt(lanes: np.ndarray) -> None:
        for_lanes(LANES, lane_attempt, (lanes,))

    return attempt
