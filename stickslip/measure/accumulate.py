"""The record of an orbit: extrema, work and phases of the film, accumulated along the motion.

A record is an array with the slots of `RECORD_TABLE`, in the units of the integration. Lanes keep
it in consecutive slots. Each method decides where in a step it calls these functions; they have no
branches, so that loops over lanes vectorise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import sine_and_cosine
from stickslip.compiled.fields import make_function
from stickslip.numerics.lane_array import lane_array

# The reduction of a slot: to the highest or the lowest value, which are neighbours and change
# places in the mirror image of a motion; to a sum; to the largest value of a quantity without a
# sign; or to a phase of the film, which is a label.
HIGHEST, LOWEST, SUM, LARGEST, PHASE = range(5)


class Moment(NamedTuple):
    """A motion at one instant, in the units of a record; the argument of integrands."""

    x: float
    V: float
    u: float
    phi: float
    sigma_el: float
    F: float
    power: float
    """The power of the drive minus the dissipation in film and block."""

    loss: float
    """The power of the drive minus that which the block gains."""

    motion: float
    """`block.harmonic_force`, or F in methods that measure the force itself."""

    phase: float
    """The phase of the drive [rad]."""


class Slot(NamedTuple):
    """A slot of a record: its meaning, its reduction and its unit.

    `unit` is an index into `results.slot_units`. If a sum is an integral over time, `integrand` is
    an inline function of a Moment, with the same value in the mirror image of the motion.
    """

    meaning: str
    reducer: int
    unit: int
    integrand: Callable[..., float] | None = None


STRESS, FORCE, WORK, TIME, NUMBER, IMPULSE, SIZE, SQUARE = range(8)
"""The units of slots; the last three belong to the integrals of F, |F| and F^2 over time."""


@inline
def _power(m: Moment) -> float:
    return m.power


@inline
def _loss(m: Moment) -> float:
    return m.loss


@inline
def _absolute_power(m: Moment) -> float:
    return abs(m.F * m.V)


@inline
def _one(m: Moment) -> float:  # noqa: ARG001 - an integrand, as the others
    return 1.0


@inline
def _in_phase(m: Moment) -> float:
    return m.F * sine_and_cosine(m.phase)[1]


@inline
def _out_of_phase(m: Moment) -> float:
    return -m.F * sine_and_cosine(m.phase)[0]


@inline
def _motion_in_phase(m: Moment) -> float:
    return m.motion * sine_and_cosine(m.phase)[1]


@inline
def _motion_out_of_phase(m: Moment) -> float:
    return -m.motion * sine_and_cosine(m.phase)[0]


@inline
def _square(m: Moment) -> float:
    return m.F * m.F


@inline
def _size(m: Moment) -> float:
    return abs(m.F)


RECORD_TABLE = (
    Slot("largest elastic stress", HIGHEST, STRESS),
    Slot("least elastic stress", LOWEST, STRESS),
    Slot("largest friction force", HIGHEST, FORCE),
    Slot("least friction force", LOWEST, FORCE),
    Slot("work done on the block", SUM, WORK, _power),
    Slot("work of the drive minus the work on the block", SUM, WORK, _loss),
    Slot("integral of |F V|", SUM, WORK, _absolute_power),
    Slot("largest order parameter", LARGEST, NUMBER),
    Slot("meltings", SUM, NUMBER),
    Slot("time in the solid phase", SUM, TIME),
    Slot("time before the first known phase", SUM, TIME),
    Slot("first known phase of the film", PHASE, NUMBER),
    Slot("last known phase of the film", PHASE, NUMBER),
    Slot("changes from a soft solid to a hard one, and back", SUM, NUMBER),
    Slot("first known one of these", PHASE, NUMBER),
    Slot("last known one of these", PHASE, NUMBER),
    Slot("elapsed time", SUM, TIME, _one),
    Slot("integral of F cos(omega t)", SUM, IMPULSE, _in_phase),
    Slot("integral of -F sin(omega t)", SUM, IMPULSE, _out_of_phase),
    Slot("F cos(omega t), by the block's motion", SUM, IMPULSE, _motion_in_phase),
    Slot("-F sin(omega t), by its motion", SUM, IMPULSE, _motion_out_of_phase),
    Slot("integral of F^2", SUM, SQUARE, _square),
    Slot("integral of |F|", SUM, SIZE, _size),
)
"""The only list of the slots of a record, in their order."""

RECORD = len(RECORD_TABLE)
"""The length of a record."""

# This statement fails if a slot has no name here, or a name no slot.
(
    STRESS_MAX,
    STRESS_MIN,
    FORCE_MAX,
    FORCE_MIN,
    BLOCK_WORK,
    LOSS,
    ABSOLUTE_WORK,
    PHI_MAX,
    MELTINGS,
    SOLID_TIME,
    UNSEEN_TIME,
    FIRST_PHASE,
    LAST_PHASE,
    SOLID_CHANGES,
    FIRST_SOLID,
    LAST_SOLID,
    ELAPSED,
    IN_PHASE,
    OUT_OF_PHASE,
    MOTION_IN_PHASE,
    MOTION_OUT_OF_PHASE,
    SQUARED_FORCE,
    FORCE_SIZE,
) = range(RECORD)


def slots_of(*reducers: int) -> tuple[int, ...]:
    """Return the slots with one of these reducers."""
    return tuple(i for i, slot in enumerate(RECORD_TABLE) if slot.reducer in reducers)


EXTREMA = slots_of(HIGHEST, LOWEST)
"""The slots with extrema of observables."""

INTEGRALS = (LOSS, IN_PHASE, OUT_OF_PHASE, MOTION_IN_PHASE, MOTION_OUT_OF_PHASE)
"""The slots with integrals that have an error estimate."""

SENSITIVE = (*EXTREMA, *INTEGRALS)
"""The slots with known derivatives with respect to the initial state of a record."""

_HIGHEST = slots_of(HIGHEST)

_EMPTY = tuple(
    {HIGHEST: -math.inf, LOWEST: math.inf}.get(slot.reducer, 0.0) for slot in RECORD_TABLE
)
"""An empty record."""

UNSEEN, MELTED, SOLID = 0.0, 1.0, 2.0
"""Phases of the film, which keeps its phase between the two thresholds."""

LIQUID, SOFT, HARD = 1.0, 2.0, 3.0
"""Phases of a film with two solids."""


class Accumulator(NamedTuple):
    """Inline functions that update the record of a lane."""

    clear: Callable[..., None]
    """(lanes, lane): empty the record."""

    see_extremum: Callable[..., None]
    """(lanes, lane, slot, value, accepted): update the maximum in `slot` and the minimum in the
    next one, if the value is `accepted`."""

    see_phase: Callable[..., None]
    """(lanes, lane, phi, solid, melted, duration, accepted): update the largest order parameter and
    the times, and count meltings, from phi >= solid to phi <= melted. `phi` is the value at the end
    of an interval of this `duration`, or represents the interval."""

    see_solid: Callable[..., None]
    """(lanes, lane, is_liquid, is_soft, is_hard, accepted): count direct changes between a soft and
    a hard solid. If none of the three holds, the film keeps its phase."""

    add: Callable[..., None]
    """(lanes, lane, slot, value, accepted): add to a sum."""

    mirror: Callable[..., None]
    """(lanes, lane): change the signs of stress and force, so that maxima become minima."""


@cache
def accumulator(lanes: int, first: int) -> Accumulator:
    """Return the accumulator of records that begin at the slot `first` of an array of `lanes`."""
    array = lane_array(lanes)
    get, put = array.get, array.put

    @inline
    def clear(lanes: np.ndarray, lane: int) -> None:
        for slot in range(RECORD):
            put(lanes, first + slot, lane, _EMPTY[slot])

    @inline
    def see_extremum(lanes: np.ndarray, lane: int, slot: int, value: float, accepted: bool) -> None:
        high, low = get(lanes, first + slot, lane), get(lanes, first + slot + 1, lane)
        put(lanes, first + slot, lane, value if accepted & (value > high) else high)
        put(lanes, first + slot + 1, lane, value if accepted & (value < low) else low)

    @inline
    def see_phase(
        lanes: np.ndarray,
        lane: int,
        phi: float,
        solid: float,
        melted: float,
        duration: float,
        accepted: bool,
    ) -> None:
        begin, last = get(lanes, first + FIRST_PHASE, lane), get(lanes, first + LAST_PHASE, lane)
        phase = MELTED if accepted & (phi <= melted) else last
        phase = SOLID if accepted & (phi >= solid) else phase
        melts = (phase == MELTED) & (last == SOLID)
        count = get(lanes, first + MELTINGS, lane)
        put(lanes, first + MELTINGS, lane, count + (1.0 if melts else 0.0))
        put(lanes, first + FIRST_PHASE, lane, phase if begin == UNSEEN else begin)
        put(lanes, first + LAST_PHASE, lane, phase)
        spent = duration if accepted else 0.0
        solid_time = get(lanes, first + SOLID_TIME, lane)
        unseen_time = get(lanes, first + UNSEEN_TIME, lane)
        put(lanes, first + SOLID_TIME, lane, solid_time + (spent if phase == SOLID else 0.0))
        put(lanes, first + UNSEEN_TIME, lane, unseen_time + (spent if phase == UNSEEN else 0.0))
        largest = get(lanes, first + PHI_MAX, lane)
        put(lanes, first + PHI_MAX, lane, phi if accepted & (phi > largest) else largest)

    @inline
    def see_solid(
        lanes: np.ndarray,
        lane: int,
        is_liquid: bool,
        is_soft: bool,
        is_hard: bool,
        accepted: bool,
    ) -> None:
        begin, last = get(lanes, first + FIRST_SOLID, lane), get(lanes, first + LAST_SOLID, lane)
        kind = LIQUID if accepted & is_liquid else last
        kind = SOFT if accepted & is_soft else kind
        kind = HARD if accepted & is_hard else kind
        changes = (kind != last) & (kind >= SOFT) & (last >= SOFT)
        count = get(lanes, first + SOLID_CHANGES, lane)
        put(lanes, first + SOLID_CHANGES, lane, count + (1.0 if changes else 0.0))
        put(lanes, first + FIRST_SOLID, lane, kind if begin == UNSEEN else begin)
        put(lanes, first + LAST_SOLID, lane, kind)

    @inline
    def add(lanes: np.ndarray, lane: int, slot: int, value: float, accepted: bool) -> None:
        total = get(lanes, first + slot, lane)
        # A choice instead of a factor 0, because a rejected value may be infinite or NaN.
        put(lanes, first + slot, lane, total + value if accepted else total)

    @inline
    def mirror(lanes: np.ndarray, lane: int) -> None:
        for slot in _HIGHEST:
            high = get(lanes, first + slot, lane)
            put(lanes, first + slot, lane, -get(lanes, first + slot + 1, lane))
            put(lanes, first + slot + 1, lane, -high)

    return Accumulator(clear, see_extremum, see_phase, see_solid, add, mirror)


def make_see_integrals(record: Accumulator, weights: tuple[float, ...]) -> Callable[..., None]:
    """Return the function that adds a step to the integrals of a record, with quadrature weights.

    Its arguments are (lanes, lane, moments, duration, accepted), with `moments` at the nodes. Its
    source is generated, because indexing the moments by a variable would prevent vectorisation.
    """
    lines, names = [], dict[str, Any](add=record.add)
    for slot, (_, _, _, integrand) in enumerate(RECORD_TABLE):
        if integrand is not None:
            names[f"integrand{slot}"] = integrand
            values = [f"integrand{slot}(moments[{node}])" for node in range(len(weights))]
            terms = (f" + {w!r} * {value}" for w, value in zip(weights, values, strict=True))
            # The leading 0 leaves only one way to fuse operations.
            mean = values[0] if weights == (1.0,) else f"0.0{''.join(terms)}"
            lines.append(f"add(lanes, lane, {slot}, duration * ({mean}), accepted)")
    arguments = "lanes, lane, moments, duration, accepted"
    return make_function(f"see_integrals[{len(weights)}]", arguments, lines, names)
