"""Jumps towards the limit of a sequence that clearly contracts along one direction.

Under the half-period map of an odd-symmetric system the initial offset alternates with a ratio
close to -1. The secant step to the limit (Aitken, Steffensen) then interpolates between the last
two states; it is well conditioned and insensitive to the noise of the integrator. An extrapolation
over whole periods would divide that noise by the distance of the ratio from 1. The ratio along the
slow direction is the largest Floquet multiplier of the orbit.

A spiral has no slow direction; its limit is its middle (`spirals.py`).

A jump moves the first two components of the state, position and velocity, to which the others are
slaved. The search undoes a chain of jumps that fails.
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

# A ratio is steady if it changes by no more than this fraction of the distance of its modulus from
# 1, or from 0 if that is nearer. If the sequence is known to contract although the noise hides it,
# the ratio may change by no more than `_UNSTEADY`, and displacements may bend by no more than
# `_STRAIGHT`.
_STEADY = 0.3
_UNSTEADY, _STRAIGHT = 0.05, 0.05

# A ratio above this allows no jump, which would extrapolate over a hundred displacements.
_LARGEST_RATIO = 0.99

# A jump pays if it is longer than this many tolerances ...
_WORTH = 0.5
# ... and the ratio of the iteration is above these, the second of them for an alternation.
_SMALLEST_RATIO = 0.5
_SMALLEST_ALTERNATION = 0.1

# The longest jump, in units of the scaled position, is the largest offset of a start at rest. After
# each jump no more than half of its length may remain.
LONGEST_JUMP = 2.0

# Successful searches need only a few jumps.
_MOST_JUMPS = 20

# A jump moves position and velocity alone. The other components count as slaved if they differ by
# no more than this between the states that determine the jump. If they differ more, the sequence
# may end on either side. A jump then goes only half the way, through states that plain iteration
# passes as well, and only if plain iteration is slower than the last ratio.
_SLAVED = 1e-3
_HALF_WAY = 0.5
_SLOWEST_PART = 0.8

# A sequence clearly approaches a cycle of several applications if the points of the cycle are
# farther apart than this many times the remaining distance.
_APART = 4.0

# The first jump stops short of the limit by this fraction, so that the next ratio is measured near
# the limit, and shows whether the orbit attracts.
_SHORTFALL = 0.01

# The finer tolerance is used from this distance on.
_COARSE = 1e-4

# The longest cycle at the end of a spiral, and the number of cycles that a displacement spans (more
# for a slowly turning spiral). Plain iteration follows a spiral that shrinks fast: that takes as
# few applications, and a few displacements of any transient look like such a spiral.
_CYCLES_OF_SPIRALS = 4
_SPANS = (1, 4, 16)


@inline
def _slow(ratio: float, cycle: int) -> bool:
    """Return whether a contraction is slow enough for a jump, but not too slow."""
    alternating = cycle == 1 and -1.0 < ratio <= -_SMALLEST_ALTERNATION
    return alternating or (_SMALLEST_RATIO <= abs(ratio) < 1.0 and ratio <= _LARGEST_RATIO)


@jit
def _steady_cycle(memory: Any, newest: int, noise: float) -> int:
    """Smallest cycle whose last displacements shrink by a constant ratio along a line; or 0."""
    for cycle in range(1, min(memory.longest_cycle, SOONEST_CYCLE) + 1):
        if 3 * cycle > newest:
            return 0
        if _steady(memory, newest, cycle, noise):
            return cycle
    return 0


@jit
def _steady(memory: Any, newest: int, cycle: int, noise: float) -> bool:
    """Return whether the last displacements over `cycle` applications clearly approach a limit.

    Three of them must shrink by the same ratio, or four if the sequence alternates. On the way to
    an asymmetric orbit two ratios can agree by accident, and a jump to the middle would then land
    on a symmetric orbit, which may attract as well. During that approach the ratio tends to -1; the
    comparison with the earlier ratio shows that its distance from -1 shrinks.
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
    """Return whether the first two of the last four displacements have the same ratio."""
    if 4 * cycle > newest:
        return False
    first = displacement(memory, newest - 3 * cycle, newest - 4 * cycle)
    second = displacement(memory, newest - 2 * cycle, newest - 3 * cycle)
    begun, _ = contraction(second, first)
    return bool(abs(ratio - begun) <= blur)


@inline
def _slaved(memory: Any, newest: int, cycle: int, longest: int) -> bool:
    """Return whether the components that a jump does not move repeated for `longest` applications.

    Their peaks between these states must repeat as well, because a film that almost freezes in one
    application may freeze in the next, and a jump would skip that.
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
    """Return whether the points of the cycle are much farther apart than the remaining `length`."""
    for lag in range(1, cycle):
        if not length_of(displacement(memory, newest, newest - lag)) >= _APART * length:
            return False
    return True


@inline
def _part(
    memory: Any, slaved: bool, ratio: float, way: tuple[float, float], allowed: float
) -> float:
    """Fraction of the remaining `way` that a jump covers; 0 for no jump.

    The jump is no longer than `allowed`, unless the limit is out of reach of the slow process.
    """
    allowed = np.inf if _out_of_reach(memory, way) else allowed
    if not slaved:
        free = allowed == np.inf
        return _HALF_WAY if free and abs(ratio) >= _SLOWEST_PART else 0.0
    whole, length = 1.0 if memory.jumps > 0 else 1.0 - _SHORTFALL, length_of(way)
    return min(whole, allowed / length, memory.stride / length)


@inline
def _out_of_reach(memory: Any, way: tuple[float, float]) -> bool:
    """Return whether the slow process that limits jumps cannot act on the `way` to the limit."""
    states, newest = memory.states, memory.newest % REMEMBERED
    x, v = states[newest, 0] + way[0] - memory.centre, states[newest, 1] + way[1]
    rho = math.sqrt(way[1] * way[1] + memory.stiffness * way[0] * way[0])
    return bool(math.sqrt(v * v + x * x) > memory.gain * rho + memory.least)


@jit
def jump(memory: Any, tolerance: float, noise: float) -> tuple[float, float]:
    """Return a jump (dx, dv) to the limit, or (0, 0) if no limit is clearly in sight."""
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
    # A few displacements of a slow spiral look like a line, so the limits for spirals hold too.
    part = part if ratio < 0.0 or memory.gain == np.inf else 0.0
    if not (safe and part * length > _WORTH * tolerance):
        return 0.0, 0.0
    _store_jump(memory, cycle, length, part)
    return part * amount * slow[0], part * amount * slow[1]


@jit
def _jump_inwards(memory: Any, tolerance: float, noise: float) -> tuple[float, float]:
    """Return a jump (dx, dv) to the middle of a spiral, or (0, 0) if there is no clear spiral."""
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
                step = length_of(last)
                memory.slow[0], memory.slow[1] = last[0] / step, last[1] / step
                # The remaining way, in lengths of the last displacement, though not along it.
                remains = length / step
                memory.ratios[cycle - 1] = remains / (1.0 + remains)
                _store_jump(memory, cycle, length, part)
                memory.turning, memory.paired = cycle, 0
                return part * dx, part * dv
    return 0.0, 0.0


@inline
def jump_outran(memory: Any) -> bool:
    """Return whether the components that a jump does not move changed after it.

    Then they depended on the skipped states, and plain iteration may end elsewhere.
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
    """Return whether the first displacement after a jump is not shorter than the one before it."""
    newest, aim = memory.newest, memory.aim
    if aim == 0 or newest != aim:
        return False
    way = displacement(memory, newest, 0)
    moved = abs(along(way, (memory.slow[0], memory.slow[1])))
    moved = length_of(way) if memory.turning > 0 else moved
    return not moved <= max(memory.residue, CLEARANCE * noise)


@jit
def _store_jump(memory: Any, cycle: int, length: float, part: float) -> None:
    """Store a jump from the newest state, with the data for judging and undoing it."""
    newest = memory.newest
    newer, older = newest % REMEMBERED, (newest - cycle) % REMEMBERED
    if memory.jumps == 0:
        for component in range(memory.states.shape[1]):
            memory.stored[component] = memory.states[newer, component]
        memory.stored_mirrored = memory.mirrored
        memory.calm = 0.5 * length_of(displacement(memory, newest, newest - cycle))
    memory.jumps, memory.turning = memory.jumps + 1, 0
    memory.aim, memory.common = cycle, math.gcd(cycle, memory.common)
    slow = memory.slow[0], memory.slow[1]
    shift = abs(along(displacement(memory, newest, newest - cycle), slow))
    memory.residue = (1.0 - 0.5 * part) * shift  # a useless jump leaves the whole shift
    memory.longest_jump = min((1.0 - 0.5 * part) * length, memory.longest_jump)
    memory.gone = part * length
    memory.paired = 1
    memory.landing[0], memory.landing[1] = memory.states[older, 0], memory.states[older, 1]
    memory.image[0], memory.image[1] = memory.states[newer, 0], memory.states[newer, 1]


@jit
def compare_landing(memory: Any, noise: float) -> None:
    """Measure the contraction from the states before and after a jump, and their images."""
    newest, aim = memory.newest, memory.aim
    if memory.paired == 0 or newest != aim:
        return
    states, new = memory.states, newest % REMEMBERED
    before = states[0, 0] - memory.landing[0], states[0, 1] - memory.landing[1]
    after = states[new, 0] - memory.image[0], states[new, 1] - memory.image[1]
    note_ratio(memory, aim, after, before, noise)


@jit
def nearly_repeats(memory: Any, newest: int, tolerance: float) -> bool:
    """Return whether the sequence repeats well enough to justify the finer tolerance."""
    enough = max(_COARSE, 10.0 * tolerance)
    for cycle in range(1, memory.longest_cycle + 1):
        ratio = memory.ratios[cycle - 1]
        if cycle <= newest and abs(ratio) < 1.0:
            step = distance(memory, newest, newest - cycle)
            if step * max(abs(reach(ratio)), 0.1) <= enough:
                return True
    return False
