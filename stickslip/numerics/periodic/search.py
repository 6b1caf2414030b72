"""The search for the orbit on which a driven system settles, one application of its map at a time.

The system may have the odd symmetry (x, v, w, t) -> (-x, -v, w, t + T/2). Half a drive period from
phase 0, followed by a change of signs, is then a map of the state space into itself. A symmetric
orbit is a fixed point of this half-period map; an orbit that closes after n periods is a cycle of
up to 2n applications. For a method that maps a whole period at a time, an application is a period.

The memory of a search is a single record, so that each of many lanes has its own. An integrator
calls `judge` with the scaled state after each application, and carries out the verdict.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.numerics.linear import Vector
from stickslip.numerics.periodic.acceleration import (
    LONGEST_JUMP,
    compare_landing,
    jump,
    jump_failed,
    jump_outran,
    nearly_repeats,
)
from stickslip.numerics.periodic.convergence import (
    LONGEST_CYCLE,
    REMEMBERED,
    SOONEST_CYCLE,
    UNKNOWN,
    closing_cycle,
    displacement,
    reach,
    stalled,
    wanders,
)
from stickslip.numerics.periodic.ratios import known_to_contract, note_ratios

GO_ON, JUMP, FINER, RESTORE, SETTLED, EXHAUSTED, WANDERING = range(7)
"""Verdicts: continue; add (dx, dv) to the scaled state; reduce the tolerance of the integrator to a
tenth, and add (dx, dv); return to the stored state and the initial tolerance; the orbit is found;
the budget of applications is spent; no cycle is in sight."""

LONGEST_CYCLE_IN_PERIODS = LONGEST_CYCLE // 2
"""The length of the longest orbit that is recognised, in drive periods."""

_SOONEST_CYCLE_IN_PERIODS = SOONEST_CYCLE // 2

# After this many drive periods, or half of the budget, a sequence that neither approaches a cycle
# nor closes counts as wandering, even if it is near one.
_DUE_PERIODS = 384
# The patience of a late search: three turns of the longest cycle, and half a turn for the approach.
_PATIENCE_OF_LATE = 7 * LONGEST_CYCLE_IN_PERIODS // 2

# A cycle must be found closed over two drive periods, and at each of its points, because a fast
# transient can mimic it once.
_CONFIRMED_PERIODS = 2

# After this many undone chains of jumps the search continues without jumps.
_MOST_FAILURES = 8

_FINEST = 3  # reductions of the tolerance: one for the last steps to the orbit, two if it stalls


@cache
def memory_of(width: int) -> np.dtype[np.void]:
    """Return the record type of the memory of a search, for states of this width."""
    return np.dtype(
        [
            ("per_period", "i8"),  # applications per drive period: 2 for the half-period map
            ("longest_cycle", "i8"),  # in applications
            ("patience", "i8"),  # applications before the sequence may count as wandering
            ("applications", "i8"),  # since the start
            ("mirrored", "i8"),  # 1 if the frame is the mirror image of that at the start
            ("newest", "i8"),  # applications since the sequence was last restarted
            ("held", "i8"),  # number of times in a row that the same cycle was found closed
            ("cycle", "i8"),  # that cycle, in applications
            ("fineness", "i8"),  # number of reductions of the tolerance
            ("initial_fineness", "i8"),  # _FINEST if the map has no tolerance
            ("plain", "i8"),  # 1 if jumps are not allowed, or no longer
            ("allowed", "f8"),  # longest jump that the caller allows
            ("inwards", "f8"),  # longest jump to the middle of a spiral
            ("repeating", "i8"),  # 1 if such jumps need the other components to repeat
            ("centre", "f8"),  # the slow process acts near the state (centre, 0)
            ("stiffness", "f8"),  # in the norm of distances from this state
            ("gain", "f8"),  # a limit farther from it than `gain` times the way to the limit ...
            ("least", "f8"),  # ... plus this is out of reach of the process
            ("contracting", "i8"),  # latest run of applications in which no motions separate
            ("peak", "f8"),  # of the components that a jump does not move, in the last application
            ("jumps", "i8"),  # since the state to restore was stored
            ("failures", "i8"),  # number of undone chains of jumps
            ("aim", "i8"),  # the cycle at whose limit jumps aim
            ("common", "i8"),  # greatest common divisor of all cycles at which jumps aimed
            ("paired", "i8"),  # 1 if `landing` can be compared with the next displacement
            ("stored_mirrored", "i8"),
            ("longest_jump", "f8"),
            ("gone", "f8"),  # length of the last jump
            ("stride", "f8"),  # longest jump after one that outran the film
            ("residue", "f8"),  # longest displacement after a successful jump
            ("calm", "f8"),  # jumps resume when displacements are shorter than this
            ("slow", "f8", 2),  # direction of the slow mode; its larger component is 1
            ("landing", "f8", 2),  # (x, v) before ...
            ("image", "f8", 2),  # ... and after `aim` applications
            ("stored", "f8", width),  # the state before the first jump
            ("turning", "i8"),  # the cycle of the spiral that a jump followed; 0 for none
            ("ratios", "f8", LONGEST_CYCLE),  # of contraction, by cycle
            ("states", "f8", (REMEMBERED, width)),
            ("peaks", "f8", REMEMBERED),  # in the applications that ended in these states
        ],
        align=True,
    )


@jit
def start(
    memory: Any, z: Vector, per_period: int, accelerate: bool, refinable: bool, late: bool
) -> None:
    """Prepare the record `memory` for a search from the scaled state `z`.

    `per_period` is the number of applications in a drive period: 1, or 2 for the half-period map of
    a system with the odd symmetry. `accelerate` allows jumps; `refinable` means that the map has a
    tolerance, which the search may reduce. A `late` search continues a sequence in which an earlier
    search found no cycle: it looks for longer cycles, with the finer tolerance from the beginning.
    """
    longest = LONGEST_CYCLE_IN_PERIODS if late else _SOONEST_CYCLE_IN_PERIODS
    memory.per_period, memory.longest_cycle = per_period, per_period * longest
    memory.patience = per_period * _PATIENCE_OF_LATE if late else 0
    memory.applications, memory.mirrored, memory.failures = 0, 0, 0
    memory.jumps, memory.aim, memory.common, memory.paired = 0, 0, 0, 0
    memory.plain, memory.allowed, memory.contracting = 0 if accelerate else 1, np.inf, 0
    memory.initial_fineness = (1 if late else 0) if refinable else _FINEST
    memory.fineness = memory.initial_fineness
    memory.longest_jump, memory.calm, memory.residue = LONGEST_JUMP, np.inf, 0.0
    memory.inwards, memory.repeating, memory.centre, memory.stiffness = np.inf, 0, 0.0, 1.0
    memory.gain, memory.least = np.inf, np.inf
    memory.gone, memory.stride, memory.turning, memory.peak = 0.0, np.inf, 0, 0.0
    for cycle in range(memory.longest_cycle):
        memory.ratios[cycle] = UNKNOWN
    for i in range(2):
        memory.slow[i], memory.landing[i], memory.image[i] = 0.0, 0.0, 0.0
    _begin_again(memory, z, 0.0, 0.0)


@inline
def limit_spirals(memory: Any) -> None:
    """Allow jumps to the middle of a spiral only if the components that a jump leaves repeat."""
    memory.repeating = 1


@inline
def keep_clear(memory: Any, centre: float, stiffness: float, gain: float, least: float) -> None:
    """Allow jumps to the middle of a spiral only if a slow process cannot act on the way there.

    A sequence winds around the middle many times as it approaches, and the process may act at any
    angle near the state (centre, 0). With distances measured as sqrt(v^2 + stiffness x^2), the
    process cannot reach a limit that is farther from this state than `gain` times the length of
    the jump plus `least`; jumps to such a limit are allowed. With an infinite gain no limit is
    known to be out of reach.
    """
    memory.centre, memory.stiffness, memory.gain, memory.least = centre, stiffness, gain, least
    memory.inwards = 0.0


@inline
def limit_jumps(memory: Any, longest: float, contracting: bool, peak: float = 0.0) -> None:
    """Limit jumps to `longest` in units of the scaled position, 0 for none, inf for any.

    A finite limit is for a slow process that a jump would outrun: the components that a jump does
    not move must then stand still, unless the process is out of reach. `contracting` means that
    neighbouring motions did not separate in the last application; `peak` is the largest value of
    the other components in it, which must not change either.
    """
    memory.allowed, memory.inwards, memory.peak = longest, longest, peak
    memory.gain, memory.least, memory.repeating = np.inf, np.inf, 0
    memory.contracting = memory.contracting + 1 if contracting else 0


@inline
def _begin_again(memory: Any, z: Vector, dx: float, dv: float) -> None:
    """Restart the sequence at the state z + (dx, dv)."""
    memory.newest, memory.held, memory.cycle = 0, 0, 0
    _remember(memory, z)
    memory.states[0, 0] += dx
    memory.states[0, 1] += dv


@inline
def _remember(memory: Any, z: Vector) -> None:
    for component in range(memory.states.shape[1]):
        memory.states[memory.newest % REMEMBERED, component] = z[component]
    memory.peaks[memory.newest % REMEMBERED] = memory.peak


@inline
def _doubtful(memory: Any, cycle: int) -> bool:
    """Return whether jumps may have reached a different orbit from plain iteration.

    The orbit must be of the kind the jumps aimed at, and attracting: a jump towards a symmetric
    orbit can land on an unstable one, while the plain sequence ends on an asymmetric orbit.
    """
    attracting = abs(memory.ratios[cycle - 1]) < 1.0 or known_to_contract(memory)
    return not (memory.common % cycle == 0 and attracting)


@jit
def judge(
    memory: Any, z: Vector, tolerance: float, noise: float, budget: int
) -> tuple[int, float, float]:
    """Return the verdict, and a jump (dx, dv), after an application that ended in the state `z`.

    `z` is scaled; `tolerance` is the required distance from the limit, `noise` the tolerance of the
    integrator, `budget` the largest number of applications.
    """
    memory.applications += 1
    memory.newest += 1
    if memory.per_period == 2:
        memory.mirrored = 1 - memory.mirrored
    _remember(memory, z)
    note_ratios(memory, noise)  # also without jumps, for the last correction and the error
    compare_landing(memory, noise)
    cycle = closing_cycle(memory, memory.newest, tolerance)
    memory.held = memory.held + 1 if cycle > 0 and cycle == memory.cycle else min(cycle, 1)
    memory.cycle = cycle
    if _confirmed(memory, cycle):
        if memory.jumps == 0 or not _doubtful(memory, cycle):
            return SETTLED, 0.0, 0.0
        return _undo(memory, _MOST_FAILURES)
    if memory.applications >= budget:
        return EXHAUSTED, 0.0, 0.0
    if jump_outran(memory):
        memory.stride = 0.5 * memory.gone
        return _undo(memory, 1)
    if jump_failed(memory, noise):
        return _undo(memory, 1)
    verdict, dx, dv = _proceed(memory, z, tolerance, noise)
    due = memory.applications >= min(_DUE_PERIODS * memory.per_period, budget // 2)
    late = due or memory.patience > 0
    # Wandering is not judged in the mirror image, because amplitudes of single periods depend on
    # where the periods begin.
    in_sight = memory.mirrored > 0 or not wanders(memory, memory.newest, tolerance, noise, late)
    if verdict != GO_ON or in_sight:
        return verdict, dx, dv
    # A failed jump may have led into a region where the sequence wanders, unlike plain iteration.
    return _undo(memory, _MOST_FAILURES) if memory.jumps > 0 else (WANDERING, 0.0, 0.0)


@inline
def _confirmed(memory: Any, cycle: int) -> bool:
    """Return whether a cycle was found closed often enough, at the finer tolerance."""
    whole = cycle % 2 == 1 or memory.mirrored == 0  # an asymmetric orbit, not its mirror image
    enough = max(_CONFIRMED_PERIODS * memory.per_period, cycle)
    return memory.held >= enough and memory.fineness > 0 and whole


@jit
def _undo(memory: Any, failures: int) -> tuple[int, float, float]:
    """Return to the state before the first jump, and count the failure."""
    memory.failures += failures
    if memory.failures >= _MOST_FAILURES:
        memory.plain = 1
    memory.jumps, memory.aim, memory.common, memory.paired = 0, 0, 0, 0
    memory.longest_jump, memory.fineness = LONGEST_JUMP, memory.initial_fineness
    memory.mirrored = memory.stored_mirrored
    memory.newest, memory.held, memory.cycle = 0, 0, 0
    for component in range(memory.states.shape[1]):
        memory.states[0, component] = memory.stored[component]
    return RESTORE, 0.0, 0.0


@jit
def _proceed(memory: Any, z: Vector, tolerance: float, noise: float) -> tuple[int, float, float]:
    """Return the verdict to jump, to use a finer tolerance, to do both, or to continue."""
    newest = memory.newest
    if memory.jumps > 0 and newest < memory.aim:  # the last jump is not judged yet
        return GO_ON, 0.0, 0.0
    finer = False
    if memory.fineness == 0:
        near = memory.plain == 0 and nearly_repeats(memory, newest, tolerance)
        finer = memory.held > 0 or near
    if memory.fineness < _FINEST:
        finer = finer or stalled(memory, newest, tolerance)
    dx, dv = 0.0, 0.0
    if memory.plain == 0 and memory.held == 0:
        dx, dv = jump(memory, tolerance, noise)
    jumped = dx != 0.0 or dv != 0.0
    if finer:
        memory.fineness += 1
        memory.paired = 0
    if finer or jumped:
        _begin_again(memory, z, dx, dv)
    return (FINER if finer else JUMP if jumped else GO_ON), dx, dv


@inline
def found(memory: Any) -> tuple[int, float]:
    """Return the cycle of a settled orbit, in applications, and its contraction, 0 if unknown."""
    cycle = memory.cycle
    ratio = memory.ratios[cycle - 1]
    return cycle, ratio if abs(ratio) < 1.0 else 0.0


@jit
def last_correction(memory: Any) -> tuple[float, float]:
    """Return the way (dx, dv) from the settled state to the limit of its sequence.

    It is shorter than the tolerance. But the remaining offset would enter the extrema of a
    symmetric orbit to first order, because only half of the orbit is measured. On a spiral the
    direction is unknown, and the way is (0, 0).
    """
    newest, (cycle, ratio) = memory.newest, found(memory)
    if memory.turning == cycle:
        return 0.0, 0.0
    moved = displacement(memory, newest, newest - cycle)
    return reach(ratio) * moved[0], reach(ratio) * moved[1]
