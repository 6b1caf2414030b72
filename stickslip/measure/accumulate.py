"""The record of an orbit: extrema, work, phases of the film, accumulated along the way.

A record is an array of the slots of `RECORD_TABLE`, in whatever units the equations are integrated
in. Lanes keep it in neighbouring slots of theirs. A method decides where a step is looked at, and
feeds these functions; they are free of branches, so that loops over lanes vectorise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.numerics.lane_array import lane_array

# How a slot comes about from what is seen: the largest and the least value, which lie side by side
# and exchange their places in the mirror image of a motion; a sum; the largest of what has no sign;
# a phase of the film, which is a name.
HIGHEST, LOWEST, SUM, LARGEST, PHASE = range(5)


class Moment(NamedTuple):
    """A motion at a moment, in the units of a record, as integrands see it."""

    x: float
    V: float
    u: float
    phi: float
    sigma_el: float
    F: float
    power: float
    """The power of the drive less what film and block dissipate."""


class Slot(NamedTuple):
    """A slot of a record: what it holds, how that comes about, and in which unit.

    `unit` is the place of its unit in what `results.slot_units` makes of `RecordUnits`. Where a sum
    is an integral over time, `integrand` is what is integrated: an inline function of a Moment, the
    same in the mirror image of the motion.
    """

    meaning: str
    reducer: int
    unit: int
    integrand: Callable[..., float] | None = None


STRESS, FORCE, WORK, TIME, NUMBER = range(5)
"""Units of slots."""


@inline
def _power(m: Moment) -> float:
    return m.power


@inline
def _absolute_power(m: Moment) -> float:
    return abs(m.F * m.V)


RECORD_TABLE = (
    Slot("largest elastic stress", HIGHEST, STRESS),
    Slot("least elastic stress", LOWEST, STRESS),
    Slot("largest friction force", HIGHEST, FORCE),
    Slot("least friction force", LOWEST, FORCE),
    Slot("work done on the block", SUM, WORK, _power),
    Slot("integral of |F V|", SUM, WORK, _absolute_power),
    Slot("largest order parameter", LARGEST, NUMBER),
    Slot("meltings", SUM, NUMBER),
    Slot("time in the solid phase", SUM, TIME),
    Slot("time before a phase was seen", SUM, TIME),
    Slot("phase of the film that was seen first", PHASE, NUMBER),
    Slot("phase that was seen last", PHASE, NUMBER),
    Slot("changes from a soft solid to a hard one, and back", SUM, NUMBER),
    Slot("which of the two was seen first", PHASE, NUMBER),
    Slot("which was seen last", PHASE, NUMBER),
)
"""The slots of a record, in their order: the one list of them."""

RECORD = len(RECORD_TABLE)
"""Length of a record."""

# A slot of the table without a name here, or the other way round, is an error of this line.
(
    STRESS_MAX,
    STRESS_MIN,
    FORCE_MAX,
    FORCE_MIN,
    BLOCK_WORK,
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
) = range(RECORD)


def slots_of(*reducers: int) -> tuple[int, ...]:
    """The slots with one of these reducers."""
    return tuple(i for i, slot in enumerate(RECORD_TABLE) if slot.reducer in reducers)


EXTREMA = slots_of(HIGHEST, LOWEST)
"""The slots of a record that are extrema of observables."""

_HIGHEST = slots_of(HIGHEST)

_EMPTY = tuple(
    {HIGHEST: -math.inf, LOWEST: math.inf}.get(slot.reducer, 0.0) for slot in RECORD_TABLE
)
"""A record of nothing."""

UNSEEN, MELTED, SOLID = 0.0, 1.0, 2.0
"""Phases of the film; between the thresholds of the count it keeps the one that it had."""

LIQUID, SOFT, HARD = 1.0, 2.0, 3.0
"""The same where there are two solids."""


class Accumulator(NamedTuple):
    """What updates the record of a lane; inline functions."""

    clear: Callable[..., None]
    """(lanes, lane): make the record ready for an orbit."""

    see_extremum: Callable[..., None]
    """(lanes, lane, slot, value, seen): let `value` count for the maximum in `slot` and for the
    minimum behind it, where it is `seen`."""

    see_phase: Callable[..., None]
    """(lanes, lane, phi, solid, melted, duration, seen): update the largest order parameter, and
    count a melting: from phi >= solid to phi <= melted. `phi` ends or stands for an interval of
    this `duration`."""

    see_solid: Callable[..., None]
    """(lanes, lane, is_liquid, is_soft, is_hard, seen): count a change between a soft and a hard
    solid, without the liquid between them; in none of the three a film keeps its phase."""

    add: Callable[..., None]
    """(lanes, lane, slot, value, seen): add to a sum."""

    mirror: Callable[..., None]
    """(lanes, lane): turn the signs of stress and force: maxima become minima."""


@cache
def accumulator(lanes: int, first: int) -> Accumulator:
    """The accumulator for records that begin in the slot `first` of so many lanes."""
    array = lane_array(lanes)
    get, put = array.get, array.put

    @inline
    def clear(lanes: np.ndarray, lane: int) -> None:
        for slot in range(RECORD):
            put(lanes, first + slot, lane, _EMPTY[slot])

    @inline
    def see_extremum(lanes: np.ndarray, lane: int, slot: int, value: float, seen: bool) -> None:
        high, low = get(lanes, first + slot, lane), get(lanes, first + slot + 1, lane)
        put(lanes, first + slot, lane, value if seen & (value > high) else high)
        put(lanes, first + slot + 1, lane, value if seen & (value < low) else low)

    @inline
    def see_phase(
        lanes: np.ndarray,
        lane: int,
        phi: float,
        solid: float,
        melted: float,
        duration: float,
        seen: bool,
    ) -> None:
        begin, last = get(lanes, first + FIRST_PHASE, lane), get(lanes, first + LAST_PHASE, lane)
        phase = MELTED if seen & (phi <= melted) else last
        phase = SOLID if seen & (phi >= solid) else phase
        melts = (phase == MELTED) & (last == SOLID)
        count = get(lanes, first + MELTINGS, lane)
        put(lanes, first + MELTINGS, lane, count + (1.0 if melts else 0.0))
        put(lanes, first + FIRST_PHASE, lane, phase if begin == UNSEEN else begin)
        put(lanes, first + LAST_PHASE, lane, phase)
        spent = duration if seen else 0.0
        solid_time = get(lanes, first + SOLID_TIME, lane)
        unseen_time = get(lanes, first + UNSEEN_TIME, lane)
        put(lanes, first + SOLID_TIME, lane, solid_time + (spent if phase == SOLID else 0.0))
        put(lanes, first + UNSEEN_TIME, lane, unseen_time + (spent if phase == UNSEEN else 0.0))
        largest = get(lanes, first + PHI_MAX, lane)
        put(lanes, first + PHI_MAX, lane, phi if seen & (phi > largest) else largest)

    @inline
    def see_solid(
        lanes: np.ndarray,
        lane: int,
        is_liquid: bool,
        is_soft: bool,
        is_hard: bool,
        seen: bool,
    ) -> None:
        begin, last = get(lanes, first + FIRST_SOLID, lane), get(lanes, first + LAST_SOLID, lane)
        kind = LIQUID if seen & is_liquid else last
        kind = SOFT if seen & is_soft else kind
        kind = HARD if seen & is_hard else kind
        changes = (kind != last) & (kind >= SOFT) & (last >= SOFT)
        count = get(lanes, first + SOLID_CHANGES, lane)
        put(lanes, first + SOLID_CHANGES, lane, count + (1.0 if changes else 0.0))
        put(lanes, first + FIRST_SOLID, lane, kind if begin == UNSEEN else begin)
        put(lanes, first + LAST_SOLID, lane, kind)

    @inline
    def add(lanes: np.ndarray, lane: int, slot: int, value: float, seen: bool) -> None:
        total = get(lanes, first + slot, lane)
        # What is not seen need not be finite: a choice, not a factor.
        put(lanes, first + slot, lane, total + value if seen else total)

    @inline
    def mirror(lanes: np.ndarray, lane: int) -> None:
        for slot in _HIGHEST:
            high = get(lanes, first + slot, lane)
            put(lanes, first + slot, lane, -get(lanes, first + slot + 1, lane))
            put(lanes, first + slot + 1, lane, -high)

    return Accumulator(clear, see_extremum, see_phase, see_solid, add, mirror)


def make_see_integrals(record: Accumulator, weights: tuple[float, ...]) -> Callable[..., None]:
    """What adds a step to the integrals of a record, by a quadrature with these weights.

    It maps (lanes, lane, moments, duration, seen) to None; `moments` at the nodes.
    """
    see: Any = _see_nothing
    for slot, (_, _, _, integrand) in enumerate(RECORD_TABLE):
        if integrand is not None:
            see = _and_integral(see, record.add, slot, _quadrature(integrand, weights))
    return see


@inline
def _see_nothing(lanes: np.ndarray, lane: int, moments: Any, duration: float, seen: bool) -> None:
    pass


def _and_integral(see_others: Any, add: Any, slot: int, mean: Any) -> Any:
    @inline
    def see(lanes: np.ndarray, lane: int, moments: Any, duration: float, seen: bool) -> None:
        see_others(lanes, lane, moments, duration, seen)
        add(lanes, lane, slot, duration * mean(moments), seen)

    return see


def _quadrature(integrand: Any, weights: tuple[float, ...]) -> Any:
    """The weighted mean of an integrand over `moments`, an inline function.

    No loop: moments that are looked up by number would keep lanes from vectors.
    """

    @inline
    def single(moments: Any) -> float:
        return integrand(moments[0])

    @inline
    def first(moments: Any) -> float:
        return 0.0 + weights[0] * integrand(moments[0])  # fused one way only

    mean: Any = single if weights == (1.0,) else first
    for node in range(1, len(weights)):
        mean = _and_node(mean, integrand, node, weights[node])
    return mean


def _and_node(others: Any, integrand: Any, node: int, weight: float) -> Any:
    @inline
    def mean(moments: Any) -> float:
        return others(moments) + weight * integrand(moments[node])

    return mean
