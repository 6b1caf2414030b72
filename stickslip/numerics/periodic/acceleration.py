"""Jumps towards the limit of a sequence that clearly contracts along one direction.

Under the half-period map of an odd-symmetric system the offset left by the start alternates with a
ratio close to -1, and the secant step to its limit (Aitken, Steffensen) is an interpolation between
the last two states: well conditioned and insensitive to the noise of the integrator, whereas an
extrapolation over whole periods divides that noise by the distance of the ratio from 1. The ratio
along the slow direction is the orbit's largest Floquet multiplier.

The limit of a spiral, which has no such direction, is its middle (`spirals.py`).

A jump moves the first two components of the state, position and velocity; the others are slaved to
them. The search undoes a chain of jumps that fails.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.numerics.periodic.convergence import (
    REMEMBERED,
    SOONEST_CYCLE,
    displacement,
    distance,
    reach,
)
from stickslip.numerics.periodic.ratios import (
    BEND,
    CLEARANCE,
    along,
    alternates_inwards,
    contraction,
    length_of,
    note_ratio,
    stands_out,
)
from stickslip.numerics.periodic.spirals import held_for, middle_of_spiral

# A ratio is steady if it changes by no more than this fraction of its distance from 1. If the
# sequence is known to contract although that cannot be seen, the ratio may change by no more than
# the first of these, and the displacements bend by no more than the second.
_STEADY = 0.3
_UNSTEADY, _STRAIGHT = 0.05, 0.05

# Ratios above this are not trusted with a jump: it would extrapolate to a hundred displacements.
_LARGEST_RATIO = 0.99

# A jump is worth its cost if more than this many tolerances remain ...
_WORTH = 0.5
# ... and the iteration is slower than this.
_SMALLEST_RATIO = 0.5
_SMALLEST_ALTERNATION = 0.1

# No jump is longer than this many units of the scaled position, the largest offset left by a start
# at rest; and after every jump at most half of its length may remain.
LONGEST_JUMP = 2.0

# Successful searches need only a few jumps.
_MOST_JUMPS = 20

# A jump moves position and velocity alone. The other components are believed to follow if they
# differ by no more than this between the states that the jump is based on. If they differ more, the
# sequence may end on either side: then a jump goes only half the way, through states that plain
# iteration passes too, and only if plain iteration is slow.
_SLAVED = 1e-3
_HALF_WAY = 0.5
_SLOWEST_PART = 0.8

# A cycle of several applications is clearly approached if its points are farther apart than this
# many times the remaining distance.
_APART = 4.0

# The first jump stops short of the limit by this fraction: the next ratio is then measured near the
# limit, and shows whether the orbit attracts.
_SHORTFALL = 0.01

# Within this distance the finer tolerance is used.
_COARSE = 1e-4

# Spirals: the cycles that they may lead to, and how many of these a displacement spans (more for a
# slowly turning spiral). A spiral that shrinks fast is simply followed to its end: that takes as
# few applications, and a few displacements of any transient look like one.
_CYCLES_OF_SPIRALS = 4
_SPANS = (1, 4, 16)


@inline
def _slow(ratio: float, cycle: int) -> bool:
    """Tell whether a contraction is slow enough, but not too slow, for a jump."""
    alternating = cycle == 1 and -1.0 < ratio <= -_SMALLEST_ALTERNATION
    return alternating or (_SMALLEST_RATIO <= abs(ratio) < 1.0 and ratio <= _LARGEST_RATIO)


@jit
def _steady_cycle(memory: Any, newest: int, noise: float) -> int:
    """Smallest cycle whose last displacements shrink by the same ratio along one line; or 0."""
    for cycle in range(1, min(memory.longest_cycle, SOONEST_CYCLE) + 1):
        if 3 * cycle > newest:
            return 0
        if _steady(memory, newest, cycle, noise):
            return cycle
    return 0


@jit
def _steady(memory: Any, newest: int, cycle: int, noise: float) -> bool:
    """Tell whether the last displacements by `cycle` applications clearly lead to a limit.

    Three of them must shrink by the same ratio, or four if the sequence alternates: on the way to
    an asymmetric orbit two ratios can agree by accident, and the jump to the middle would land on a
    symmetric orbit, which may also be attracting. On approach to an asymmetric orbit the ratio
    tends to -1: its distance from -1 shrinks, which the comparison with the earlier ratio reveals.
    """
    oldest = displacement(memory, newest - 2 * cycle, newest - 3 * cycle)
    before = displacement(memory, newest - cycle, newest - 2 * cycle)
    last = displacement(memory, newest, newest - cycle)
    earlier, _ = contraction(before, oldest)
    ratio, bend = contraction(last, before)
    room = min(1.0 - abs(ratio), abs(ratio))
    inwards = cycle == 1 and alternates_inwards(memory, ratio, bend, length_of(before), noise)
    if inwards and _slaved(memory, newest, 1, 3):
        return abs(ratio - earlier) <= _UNSTEADY and bend <= _STRAIGHT
    steady = abs(ratio - earlier) <= _STEADY * room and bend <= BEND
    if steady and ratio < 0.0:
        steady = _alternates(memory, newest, cycle, ratio, _STEADY * room)
    clear = stands_out(ratio, length_of(before), noise)
    return steady and clear and _slow(ratio, cycle) and length_of(last) <= memory.calm


@inline
def _alternates(memory: Any, newest: int, cycle: int, ratio: float, blur: float) -> bool:
    """Tell whether the first two of the last four displacements have the same ratio."""
    if 4 * cycle > newest:
        return False
    first = displacement(memory, newest - 3 * cycle, newest - 4 * cycle)
    second = displacement(memory, newest - 2 * cycle, newest - 3 * cycle)
    begun, _ = contraction(second, first)
    return bool(abs(ratio - begun) <= blur)


@inline
def _slaved(memory: Any, newest: int, cycle: int, longest: int) -> bool:
    """Tell whether the components that a jump does not move repeated for `longest` applications.

    Their peaks between these states must repeat too: a film that almost freezes in one application
    may freeze in the next, and a jump would skip that.
    """
    for lag in range(cycle, min(longest, newest) + 1, cycle):
        raised = memory.peaks[(newest - lag) % REMEMBERED] - memory.peaks[newest % REMEMBERED]
        if not abs(raised) <= _SLAVED:
            return False
        for component in range(2, memory.states.shape[1]):
            moved = memory.states[(newest - lag) % REMEMBERED, component]
            moved -= memory.states[newest % REMEMBERED, component]
            if not abs(moved) <= _SLAVED:
                return False
    return True


@inline
def _apart(memory: Any, newest: int, cycle: int, length: float) -> bool:
    """Tell whether the points of the cycle are much farther apart than the remaining `length`."""
    for lag in range(1, cycle):
        if not length_of(displacement(memory, newest, newest - lag)) >= _APART * length:
            return False
    return True


@inline
def _part(
    memory: Any, slaved: bool, ratio: float, way: tuple[float, float], allowed: float
) -> float:
    """Fraction of the remaining `way` that a jump is to cover; 0 for no jump.

    It is no longer than `allowed` unless the limit is out of reach.
    """
    allowed = np.inf if _out_of_reach(memory, way) else allowed
    if not slaved:
        free = allowed == np.inf
        return _HALF_WAY if free and abs(ratio) >= _SLOWEST_PART else 0.0
    whole, length = 1.0 if memory.jumps > 0 else 1.0 - _SHORTFALL, length_of(way)
    return min(whole, allowed / length, memory.stride / length)


@inline
def _out_of_reach(memory: Any, way: tuple[float, float]) -> bool:
    """Return True if the slow process that caps jumps cannot act on the `way` to the limit."""
    states, newest = memory.states, memory.newest % REMEMBERED
    x, v = states[newest, 0] + way[0] - memory.centre, states[newest, 1] + way[1]
    rho = math.sqrt(way[1] * way[1] + memory.stiffness * way[0] * way[0])
    return bool(math.sqrt(v * v + x * x) > memory.gain * rho + memory.least)


@jit
def jump(memory: Any, tolerance: float, noise: float) -> tuple[float, float]:
    """Jump (dx, dv) to the limit if the sequence clearly leads to one; else (0, 0)."""
    newest = memory.newest
    cycle = memory.aim
    followed = cycle > 0 and newest == cycle and memory.turning == 0
    if not followed:
        cycle = _steady_cycle(memory, newest, noise)
    if memory.jumps >= _MOST_JUMPS:
        return 0.0, 0.0
    if cycle == 0:
        return _jump_inwards(memory, tolerance, noise)
    last = displacement(memory, newest, newest - cycle)
    if not followed:
        length = length_of(last)
        memory.slow[0], memory.slow[1] = last[0] / length, last[1] / length
    slow = memory.slow[0], memory.slow[1]
    ratio = memory.ratios[cycle - 1]
    amount = reach(ratio) * along(last, slow) * along(slow, slow)
    length = abs(amount)
    safe = ratio < 0.0 or length <= memory.longest_jump
    safe = safe and _slow(ratio, cycle) and _apart(memory, newest, cycle, length)
    slaved = _slaved(memory, newest, cycle, 3 * cycle)
    part = _part(memory, slaved, ratio, (amount * slow[0], amount * slow[1]), memory.allowed)
    # Where spirals must keep clear: a few displacements of a slow one look like a line.
    part = part if ratio < 0.0 or memory.gain == np.inf else 0.0
    if not (safe and part * length > _WORTH * tolerance):
        return 0.0, 0.0
    _store_jump(memory, cycle, length, part)
    return part * amount * slow[0], part * amount * slow[1]


@jit
def _jump_inwards(memory: Any, tolerance: float, noise: float) -> tuple[float, float]:
    """Jump (dx, dv) to the middle of a spiral if the sequence clearly follows one; else (0, 0)."""
    newest = memory.newest
    for span in _SPANS:
        for cycle in range(1, _CYCLES_OF_SPIRALS + 1):
            if 4 * span * cycle > newest:
                break
            dx, dv, radius = middle_of_spiral(memory, newest, span * cycle, noise)
            radius = radius ** (1.0 / span)
            length = length_of((dx, dv))
            part = 0.0
            if radius >= _SLOWEST_PART and _apart(memory, newest, cycle, length):
                held = held_for(memory, span * cycle, radius**span)
                slaved = _slaved(memory, newest, cycle, held)
                allowed = memory.inwards if slaved or memory.repeating == 0 else 0.0
                part = _part(memory, slaved, radius, (dx, dv), allowed)
            if part * length > _WORTH * tolerance:
                last = displacement(memory, newest, newest - cycle)
                memory.slow[0], memory.slow[1] = (
                    last[0] / length_of(last),
                    last[1] / length_of(last),
                )
                # The remaining way, in lengths of the last displacement, though not along it.
                remains = length / length_of(last)
                memory.ratios[cycle - 1] = remains / (1.0 + remains)
                _store_jump(memory, cycle, length, part)
                memory.turning, memory.paired = cycle, 0
                return part * dx, part * dv
    return 0.0, 0.0


@inline
def jump_outran(memory: Any) -> bool:
    """Tell whether the components that a jump does not move changed after it.

    They then depended on the skipped states, and plain iteration may end elsewhere.
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
    """Tell whether the first displacement after a jump is not shorter than the one before it."""
    newest, aim = memory.newest, memory.aim
    if aim == 0 or newest != aim:
        return False
    way = displacement(memory, newest, 0)
    moved = abs(along(way, (memory.slow[0], memory.slow[1])))
    moved = length_of(way) if memory.turning > 0 else moved
    return not moved <= max(memory.residue, CLEARANCE * noise)


@jit
def _store_jump(memory: Any, cycle: int, length: float, part: float) -> None:
    """Store a jump from the newest state, with the data needed to judge and to undo it."""
    newest = memory.newest
    newer, older = newest % REMEMBERED, (newest - cycle) % REMEMBERED
    if memory.jumps == 0:
        for component in range(memory.states.shape[1]):
            memory.stored[component] = memory.states[newer, component]
        memory.stored_mirrored = memory.mirrored
        memory.calm = 0.5 * length_of(displacement(memory, newest, newest - cycle))
    memory.jumps, memory.turning = memory.jumps + 1, 0
    memory.aim, memory.common = cycle, _common_divisor(cycle, memory.common)
    slow = memory.slow[0], memory.slow[1]
    shift = abs(along(displacement(memory, newest, newest - cycle), slow))
    memory.residue = (1.0 - 0.5 * part) * shift  # a useless jump would leave the whole shift
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
    """Note the ratio of contraction from the states before and after a jump and their images."""
    newest, aim = memory.newest, memory.aim
    if memory.paired == 0 or newest != aim:
        return
    states, new = memory.states, newest % REMEMBERED
    before = states[0, 0] - memory.landing[0], states[0, 1] - memory.landing[1]
    after = states[new, 0] - memory.image[0], states[new, 1] - memory.image[1]
    note_ratio(memory, aim, after, before, noise)


@jit
def nearly_repeats(memory: Any, newest: int, tolerance: float) -> bool:
    """Tell whether the sequence repeats well enough to justify the finer tolerance."""
    enough = max(_COARSE, 10.0 * tolerance)
    for cycle in range(1, memory.longest_cycle + 1):
        ratio = memory.ratios[cycle - 1]
        if cycle <= newest and abs(ratio) < 1.0:
            step = distance(memory, newest, newest - cycle)
            if step * max(abs(reach(ratio)), 0.1) <= enough:
                return True
    return False
