"""The adaptive drive in lanes: many trajectories side by side, each with its own time and step.

The lanes live in one flat array, slot after slot of LANES numbers. `attempt` lets every lane try
one step; what is accepted advances, the others keep their state and take a shorter step next. The
arithmetic is that of the scalar drive (adaptive.py), with choices instead of branches.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.simd import LANES, for_lanes
from stickslip.numerics import step_control
from stickslip.numerics.lane_array import lane_array, lane_vectors
from stickslip.numerics.linear import Algebra, Vector
from stickslip.numerics.rosenbrock import make_defect_error, make_step
from stickslip.numerics.tableaus import RosenbrockTableau


class Slots(NamedTuple):
    """Where the numbers of a lane lie; the vectors take one slot a component from there on.

    What comes before the vectors lies where it is for any number of components.
    """

    time: int
    end: int
    step: int
    grows: int
    """1 where the last step was accepted: after a rejection the next may not be longer."""
    remembered: int
    """What the step control remembers of the errors."""
    rtol: int
    begin: int
    """Where the step tried last began ..."""
    used: int
    """... and how long it was."""
    accepted: int
    attempts: int
    limit: int
    """The number of attempts allowed."""
    stuck: int
    """1 where the step has shrunk to rounding."""
    event: int
    """1 where any of this needs attention."""
    parameters: int
    """The first of the slots in which the user of the lanes keeps what is his."""
    state: int
    old: int
    """The state at the begin of the step tried last ..."""
    d1: int
    d2: int
    """... and the coefficients of its continuous extension."""
    total: int
    """How many there are."""


def slots_for(width: int, room: int) -> Slots:
    """The slots of lanes whose state has so many components, with `room` for what a user keeps."""
    scalars = Slots._fields.index("state")
    vectors = (scalars - 1 + room + width * i for i in range(len(Slots._fields) - scalars))
    return Slots(*range(scalars), *vectors)


def make_attempt(
    rhs: Callable[..., Vector],
    jacobian: Callable[..., tuple[Vector, ...]],
    error_weight: Callable[..., Vector],
    parameters: Callable[..., Any],
    tableau: RosenbrockTableau,
    algebra: Algebra,
    room: int,
) -> Any:
    """One attempted step in every lane, of y' = rhs(p, t, y) with p = parameters(lanes, lane).

    `room` as of `slots_for`; the other arguments are those of `make_adaptive`. What comes
    back maps the array of lanes to nothing: lanes that have arrived at their end stay there.
    """
    step, defect_error = make_step(rhs, tableau, algebra), make_defect_error(algebra)
    largest, choose = algebra.largest, algebra.choose
    slots = slots_for(algebra.width, room)
    array, vectors = lane_array(LANES), lane_vectors(LANES, algebra.width)
    get, put, get_vector, put_vector = array.get, array.put, vectors.get, vectors.put

    @inline
    def lane_attempt(lane: int, lanes: np.ndarray) -> None:
        # Choices in place of branches: with a branch in it a loop over lanes is not made of vector
        # operations. Every lane does the work of an accepted step, a rejected one drops it.
        p, y = parameters(lanes, lane), get_vector(lanes, slots.state, lane)
        t, end = get(lanes, slots.time, lane), get(lanes, slots.end, lane)
        h, rtol = get(lanes, slots.step, lane), get(lanes, slots.rtol, lane)
        grows = get(lanes, slots.grows, lane) > 0.0
        left = end - t
        last = 1.0001 * h >= left
        half = 0.5 * left
        used = left if last else (h if h < half else half)  # no sliver is left for the end
        f, J = rhs(p, t, y), jacobian(p, t, y)
        y1, error, d1, d2, LU = step(p, t, y, used, f, J)
        weight = error_weight(p, y, J)
        # The defect sees what the embedded error does not: a cusp inside the step. The scalar drive
        # asks it only where the embedded error would pass; here it costs as much in either case.
        f1 = rhs(p, t + used, y1)
        embedded = largest(error, weight)
        seen = largest(defect_error(f1, LU, y, y1, d1, d2, used), weight)
        ratio = (embedded if seen <= embedded else seen) / rtol  # NaN counts
        accepted = ratio <= 1.0
        remembered = get(lanes, slots.remembered, lane)
        factor, remembers = step_control.after_success(ratio, remembered)
        longer = used * factor
        longer = longer if grows or longer < used else used
        # The last step was cut to fit: its small error is no reason for a longer one than before.
        longer = longer if longer < h or not last else h
        shorter = used * step_control.after_rejection(ratio)
        put(lanes, slots.step, lane, longer if accepted else shorter)
        put(lanes, slots.remembered, lane, remembers if accepted else remembered)
        # The step as it was tried stays, for those who look inside it after the attempt.
        put(lanes, slots.begin, lane, t)
        put(lanes, slots.used, lane, used)
        put_vector(lanes, slots.old, lane, y)
        put_vector(lanes, slots.d1, lane, d1)
        put_vector(lanes, slots.d2, lane, d2)
        put(lanes, slots.time, lane, (end if last else t + used) if accepted else t)
        put_vector(lanes, slots.state, lane, choose(accepted, y1, y))
        put(lanes, slots.grows, lane, 1.0 if accepted else 0.0)
        put(lanes, slots.accepted, lane, 1.0 if accepted else 0.0)
        attempts = get(lanes, slots.attempts, lane) + 1.0
        # "Not greater", since a NaN is neither; the last step may be as short as what is left.
        stuck = (not last) & (not t + used > t)
        through = (last & accepted) | stuck | (attempts >= get(lanes, slots.limit, lane))
        put(lanes, slots.attempts, lane, attempts)
        put(lanes, slots.stuck, lane, 1.0 if stuck else 0.0)
        put(lanes, slots.event, lane, 1.0 if through else 0.0)

    @jit
    def attempt(lanes: np.ndarray) -> None:
        for_lanes(LANES, lane_attempt, (lanes,))

    return attempt
