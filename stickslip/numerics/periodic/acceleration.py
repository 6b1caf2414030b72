"""Jumps towards the limit of a sequence that plainly contracts along one direction.

Under the half-period map of an odd-symmetric system the offset that a start leaves alternates with
a ratio close to -1, and the secant step to its limit (Aitken, Steffensen) is an interpolation
between the last two states: well conditioned, and blind to the noise of the integrator, where an
extrapolation over periods divides that noise by the distance of the ratio from 1. The ratio of a
direction is the orbit's largest Floquet multiplier there.

A jump moves the first two components of the state, position and velocity; the others are slaved to
them. A chain of jumps that fails is undone by the search.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.numerics.periodic.convergence import REMEMBERED, displacement, distance, reach

# A ratio is measured where displacements are this many times the noise of the map, taken for one
# tolerance of the integrator, and believed where the noise blurs its distance from 1 by no more
# than this part; it is steady if it changes by no more than that. Growth must stand out more: where
# it is mistaken the jumps are undone, and plain iteration takes hundreds of periods.
_CLEARANCE = 30.0
_CLEARANCE_OF_GROWTH = 300.0
_BLUR = 0.3
_STEADY = 0.3
_BEND = 0.3

# Ratios above this are not trusted with a jump: an extrapolation to a hundred displacements.
_LARGEST_RATIO = 0.99

# A jump is worth its cost where more than this many tolerances remain ...
_WORTH = 0.5
# ... and the iteration is slower than this.
_SMALLEST_RATIO = 0.5
_SMALLEST_ALTERNATION = 0.1

# A jump longer than this many units of the scaled position, the largest offset that a start at rest
# leaves, is not risked, and after every jump at most half of what it went may remain.
LONGEST_JUMP = 2.0

# Jumps are few where they lead anywhere.
_MOST_JUMPS = 20

# A jump moves position and velocity alone. That the other components follow is believed where they
# differ by no more than this between the states that the jump is judged by. Where they differ more,
# the sequence may end in either of them: then a jump goes half the way only, along states that
# plain iteration passes too, and only where that is slow.
_SLAVED = 1e-3
_HALF_WAY = 0.5
_SLOWEST_PART = 0.8

# A cycle of several applications is plainly approached where its points lie farther apart than
# this many times the way that remains.
_APART = 4.0

# The first jump stops short of the limit by this part: the next ratio is then measured near the
# limit, and tells an orbit that attracts from one that does not.
_SHORTFALL = 0.01

# From this distance on the finer tolerance is taken.
_COARSE = 1e-4


@inline
def _length(way: tuple[float, float]) -> float:
    return max(abs(way[0]), abs(way[1]))


@inline
def _along(way: tuple[float, float], image: tuple[float, float]) -> float:
    """The component of `way` that is the larger one of `image`.

    The map wipes out all but the slow mode, so images differ along it. A landing after a jump may
    lie off it, by a velocity that is forgotten at once and must not count.
    """
    return way[0] if abs(image[0]) >= abs(image[1]) else way[1]


@inline
def _contraction(newer: tuple[float, float], older: tuple[float, float]) -> tuple[float, float]:
    """Signed ratio of two displacements along the newer one, and how far they are from parallel."""
    ratio = _along(newer, newer) / _along(older, newer)
    across = max(abs(newer[0] - ratio * older[0]), abs(newer[1] - ratio * older[1]))
    return ratio, across / _length(newer)


@inline
def _clear(ratio: float, length: float, noise: float) -> bool:
    """Whether a ratio measured on displacements of this length can be told from 1."""
    clearance = _CLEARANCE if abs(ratio) < 1.0 else _CLEARANCE_OF_GROWTH
    return noise <= min(_BLUR * abs(1.0 - abs(ratio)), 1.0 / clearance) * length


@jit
def _note_ratio(
    memory: Any,
    cycle: int,
    newer: tuple[float, float],
    older: tuple[float, float],
    noise: float,
) -> None:
    """Remember the contraction by `cycle` applications where it stands out from the noise.

    A growth is forgotten as soon as there is contraction, clear or not: it belonged to a bend of
    the map that the sequence has left behind.
    """
    ratio, _ = _contraction(newer, older)
    length = abs(_along(older, newer))
    better = abs(ratio) < 1.0 <= abs(memory.ratios[cycle - 1])
    if _clear(ratio, length, noise) or (better and _CLEARANCE * noise <= length):
        memory.ratios[cycle - 1] = ratio
        if cycle == memory.aim:
            length = _length(newer)
            memory.slow[0], memory.slow[1] = newer[0] / length, newer[1] / length


@jit
def note_ratios(memory: Any, noise: float) -> None:
    """Remember the ratios of contraction of all cycles where they stand out from the noise."""
    newest = memory.newest
    for cycle in range(1, memory.longest_cycle + 1):
        if 2 * cycle <= newest:
            _note_ratio(
                memory,
                cycle,
                displacement(memory, newest, newest - cycle),
                displacement(memory, newest - cycle, newest - 2 * cycle),
                noise,
            )


@inline
def _slow(ratio: float, cycle: int) -> bool:
    """Whether a contraction is slow enough, and not too slow, for a jump."""
    alternating = cycle == 1 and -1.0 < ratio <= -_SMALLEST_ALTERNATION
    return alternating or (_SMALLEST_RATIO <= abs(ratio) < 1.0 and ratio <= _LARGEST_RATIO)


@jit
def _steady_cycle(memory: Any, newest: int, noise: float) -> int:
    """Smallest cycle whose last displacements shrink by one ratio along one line; or 0."""
    for cycle in range(1, memory.longest_cycle + 1):
        if 3 * cycle > newest:
            return 0
        if _steady(memory, newest, cycle, noise):
            return cycle
    return 0


@jit
def _steady(memory: Any, newest: int, cycle: int, noise: float) -> bool:
    """Whether the last displacements by `cycle` applications plainly lead to a limit.

    Three of them shrink by one ratio, of an alternating sequence four: of one that ends on an
    asymmetric orbit the first two ratios can agree by accident, and the jump to the middle would
    land on a symmetric orbit, which may attract too. An asymmetric orbit is approached with
    displacements whose ratio tends to -1: its distance from -1 then shrinks, which the comparison
    with the earlier ratio sees.
    """
    oldest = displacement(memory, newest - 2 * cycle, newest - 3 * cycle)
    before = displacement(memory, newest - cycle, newest - 2 * cycle)
    last = displacement(memory, newest, newest - cycle)
    earlier, _ = _contraction(before, oldest)
    ratio, bend = _contraction(last, before)
    room = min(1.0 - abs(ratio), abs(ratio))
    steady = abs(ratio - earlier) <= _STEADY * room and bend <= _BEND
    if steady and ratio < 0.0:
        steady = _alternates(memory, newest, cycle, ratio, _STEADY * room)
    clear = _clear(ratio, _length(before), noise)
    return steady and clear and _slow(ratio, cycle) and _length(last) <= memory.calm


@inline
def _alternates(memory: Any, newest: int, cycle: int, ratio: float, blur: float) -> bool:
    """Whether the ratio of the two displacements before the last three is the same."""
    if 4 * cycle > newest:
        return False
    first = displacement(memory, newest - 3 * cycle, newest - 4 * cycle)
    second = displacement(memory, newest - 2 * cycle, newest - 3 * cycle)
    begun, _ = _contraction(second, first)
    return bool(abs(ratio - begun) <= blur)


@inline
def _slaved(memory: Any, newest: int, cycle: int) -> bool:
    """Whether what a jump does not move was the same at the last passages, four at most."""
    for lag in range(cycle, min(3 * cycle, newest) + 1, cycle):
        for component in range(2, memory.states.shape[1]):
            moved = memory.states[(newest - lag) % REMEMBERED, component]
            moved -= memory.states[newest % REMEMBERED, component]
            if not abs(moved) <= _SLAVED:
                return False
    return True


@inline
def _apart(memory: Any, newest: int, cycle: int, length: float) -> bool:
    """Whether the points of the cycle are farther apart than the way `length` that remains."""
    for lag in range(1, cycle):
        if not _length(displacement(memory, newest, newest - lag)) >= _APART * length:
            return False
    return True


@inline
def _part(memory: Any, newest: int, cycle: int, ratio: float, length: float) -> float:
    """The part of the remaining way `length` that a jump is to go; 0 for no jump."""
    if not _slaved(memory, newest, cycle):
        free = memory.allowed == np.inf
        return _HALF_WAY if free and abs(ratio) >= _SLOWEST_PART else 0.0
    whole = 1.0 if memory.jumps > 0 else 1.0 - _SHORTFALL
    return min(whole, memory.allowed / length, memory.stride / length)


@jit
def jump(memory: Any, tolerance: float, noise: float) -> tuple[float, float]:
    """The way to the limit where the sequence plainly leads to one; (0, 0) otherwise."""
    newest = memory.newest
    cycle = memory.aim
    followed = cycle > 0 and newest == cycle
    if not followed:
        cycle = _steady_cycle(memory, newest, noise)
    if cycle == 0 or memory.jumps >= _MOST_JUMPS:
        return 0.0, 0.0
    last = displacement(memory, newest, newest - cycle)
    if not followed:
        length = _length(last)
        memory.slow[0], memory.slow[1] = last[0] / length, last[1] / length
    slow = memory.slow[0], memory.slow[1]
    ratio = memory.ratios[cycle - 1]
    amount = reach(ratio) * _along(last, slow) * _along(slow, slow)
    length = abs(amount)
    safe = ratio < 0.0 or length <= memory.longest_jump
    safe = safe and _slow(ratio, cycle) and _apart(memory, newest, cycle, length)
    part = _part(memory, newest, cycle, ratio, length)
    if not (safe and part * length > _WORTH * tolerance):
        return 0.0, 0.0
    _store_jump(memory, cycle, length, part)
    return part * amount * slow[0], part * amount * slow[1]


@inline
def jump_outran(memory: Any) -> bool:
    """Whether what a jump does not move is another one after it: it was slaved to the way there.

    The sequence may end elsewhere then, where it passes through all the states in between.
    """
    newest, aim = memory.newest, memory.aim
    if aim == 0 or newest != aim or memory.paired == 0:
        return False
    for component in range(2, memory.states.shape[1]):
        moved = memory.states[newest % REMEMBERED, component] - memory.states[0, component]
        if not abs(moved) <= _SLAVED:
            return True
    return False


@inline
def jump_failed(memory: Any, noise: float) -> bool:
    """Whether the first displacement after a jump is not shorter than the one before it."""
    newest, aim = memory.newest, memory.aim
    if aim == 0 or newest != aim:
        return False
    moved = abs(_along(displacement(memory, newest, 0), (memory.slow[0], memory.slow[1])))
    return not moved <= max(memory.residue, _CLEARANCE * noise)


@jit
def _store_jump(memory: Any, cycle: int, length: float, part: float) -> None:
    """Note a jump from the newest state, with what is needed to judge it and to undo it."""
    newest = memory.newest
    newer, older = newest % REMEMBERED, (newest - cycle) % REMEMBERED
    if memory.jumps == 0:
        for component in range(memory.states.shape[1]):
            memory.stored[component] = memory.states[newer, component]
        memory.stored_mirrored = memory.mirrored
        memory.calm = 0.5 * _length(displacement(memory, newest, newest - cycle))
    memory.jumps += 1
    memory.aim, memory.common = cycle, _common_divisor(cycle, memory.common)
    slow = memory.slow[0], memory.slow[1]
    shift = abs(_along(displacement(memory, newest, newest - cycle), slow))
    memory.residue = (1.0 - 0.5 * part) * shift  # without the jump it would stay the same
    memory.longest_jump = min((1.0 - 0.5 * part) * length, memory.longest_jump)
    memory.gone = part * length
    memory.paired = 1
    memory.landing[0], memory.landing[1] = memory.states[older, 0], memory.states[older, 1]
    memory.image[0], memory.image[1] = memory.states[newer, 0], memory.states[newer, 1]


@inline
def _common_divisor(a: int, b: int) -> int:
    while b > 0:
        a, b = b, a % b
    return a


@jit
def compare_landing(memory: Any, noise: float) -> None:
    """The ratio of contraction between the landing after a jump and the one before."""
    newest, aim = memory.newest, memory.aim
    if memory.paired == 0 or newest != aim:
        return
    states, new = memory.states, newest % REMEMBERED
    before = states[0, 0] - memory.landing[0], states[0, 1] - memory.landing[1]
    after = states[new, 0] - memory.image[0], states[new, 1] - memory.image[1]
    _note_ratio(memory, aim, after, before, noise)


@jit
def nearly_repeats(memory: Any, newest: int, tolerance: float) -> bool:
    """Whether the sequence repeats well enough for the finer tolerance to be worth its cost."""
    enough = max(_COARSE, 10.0 * tolerance)
    for cycle in range(1, memory.longest_cycle + 1):
        ratio = memory.ratios[cycle - 1]
        if cycle <= newest and abs(ratio) < 1.0:
            step = distance(memory, newest, newest - cycle)
            if step * max(abs(reach(ratio)), 0.1) <= enough:
                return True
    return False
