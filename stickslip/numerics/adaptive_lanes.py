"""The adaptive integrator in lanes: trajectories side by side, each with its own time and step.

The lanes share one flat array, which has LANES numbers for each slot. `attempt` tries one step in
every lane: a lane advances if its step is accepted; otherwise it keeps its state and tries a
shorter step next. The arithmetic is the same as in the scalar integrator (`adaptive.py`), with
choices in place of branches.
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
    """The slots of a lane; a vector begins at its slot and takes one for each component.

    The slots before the vectors do not depend on the number of components.
    """

    time: int
    end: int
    step: int
    grows: int
    """1 if the last step was accepted; after a rejection the next step may not be longer."""
    remembered: int
    """The memory of the step control for previous errors."""
    rtol: int
    begin: int
    """The start of the last attempted step ..."""
    used: int
    """... and its length."""
    accepted: int
    attempts: int
    limit: int
    """The largest number of attempts ..."""
    longest: int
    """... and the longest step."""
    stuck: int
    """1 if the step has shrunk to rounding level."""
    event: int
    """1 if the lane needs attention."""
    parameters: int
    """The first slot for the user of the lanes."""
    state: int
    old: int
    """The state at the start of the last attempted step ..."""
    d1: int
    d2: int
    """... and the coefficients of its continuous extension."""
    total: int
    """The total number of slots."""


def slots_for(width: int, room: int) -> Slots:
    """Return the slots of lanes for states of this width, with `room` slots for the user."""
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
    limits: Callable[..., tuple[float, float]] = step_control.unlimited,
) -> Any:
    """Return the function (lanes) that attempts one step of y' = rhs(p, t, y) in every lane.

    `parameters(lanes, lane)` returns p; `room` is as in `slots_for`, the other arguments as
    in `make_adaptive`. A lane that has reached its end stays there.
    """
    step, defect_error = make_step(rhs, tableau, algebra), make_defect_error(algebra)
    largest, choose = algebra.largest, algebra.choose
    slots = slots_for(algebra.width, room)
    array, vectors = lane_array(LANES), lane_vectors(LANES, algebra.width)
    get, put, get_vector, put_vector = array.get, array.put, vectors.get, vectors.put

    @inline
    def lane_attempt(lane: int, lanes: np.ndarray) -> None:
        # Choices in place of branches, because a loop over lanes with a branch is not vectorised.
        # Every lane does the work of an accepted step, and discards it after a rejection.
        p, y = parameters(lanes, lane), get_vector(lanes, slots.state, lane)
        t, end = get(lanes, slots.time, lane), get(lanes, slots.end, lane)
        h, rtol = get(lanes, slots.step, lane), get(lanes, slots.rtol, lane)
        grows = get(lanes, slots.grows, lane) > 0.0
        left = end - t
        # A step that nearly reaches the end is stretched to it.
        last = 1.0001 * h >= left
        half = 0.5 * left
        used = left if last else (h if h < half else half)  # leaves no tiny last step
        f, J = rhs(p, t, y), jacobian(p, t, y)
        y1, error, d1, d2, LU = step(p, t, y, used, f, J)
        weight = error_weight(p, y, y1, J)
        # The defect reveals what the embedded error misses, a cusp inside the step. The scalar
        # integrator computes it only if the embedded error passes; here it costs the same in both
        # cases.
        f1 = rhs(p, t + used, y1)
        embedded = largest(error, weight)
        defect = largest(defect_error(f1, LU, y, y1, d1, d2, used), weight)
        ratio = (embedded if defect <= embedded else defect) / rtol  # NaN counts
        part, ahead = limits(p, y, f, y1, f1, used)
        accurate = ratio <= 1.0
        accepted = accurate & (part >= 1.0)
        remembered = get(lanes, slots.remembered, lane)
        factor, remembers = step_control.after_success(ratio, remembered)
        longer = used * factor
        longer = longer if grows or longer < used else used
        # The last step was cut, so that its small error is no reason for a longer next one.
        longer = longer if longer < h or not last else h
        longest = get(lanes, slots.longest, lane)
        ahead = ahead if ahead < longest else longest
        longer = longer if longer < ahead else ahead
        shorter = used * (part if accurate else step_control.after_rejection(ratio))
        put(lanes, slots.step, lane, longer if accepted else shorter)
        put(lanes, slots.remembered, lane, remembers if accepted else remembered)
        # The attempted step is stored, so that the user can interpolate in it.
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
        # "Not greater" is true for NaN; the last step may be as short as the remaining time.
        stuck = (not last) & (not t + used > t)
        through = (last & accepted) | stuck | (attempts >= get(lanes, slots.limit, lane))
        put(lanes, slots.attempts, lane, attempts)
        put(lanes, slots.stuck, lane, 1.0 if stuck else 0.0)
        put(lanes, slots.event, lane, 1.0 if through else 0.0)

    @jit
    def attempt(lanes: np.ndarray) -> None:
        for_lanes(LANES, lane_attempt, (lanes,))

    return attempt
