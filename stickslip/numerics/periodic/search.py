"""The search for the orbit on which a driven system settles, fed with one application at a time.

The system may have the odd symmetry (x, v, w, t) -> (-x, -v, w, t + T/2). Half a drive period from
phase 0, with the signs turned at its end, is then a map of the state into itself. A symmetric orbit
is a fixed point of this half-period map, an orbit that closes after n periods a cycle of at most 2n
applications. Where a method maps a whole period at a time, an application is a period.

The search keeps its whole memory in one record, so that each of many lanes has its own. A drive
calls `judge` with the scaled state after each application, and does what it says.
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
"""Verdicts: go on; add (dx, dv) to the scaled state; cut the tolerance of the integrator to a
tenth (and add (dx, dv)); take the stored state back, with the tolerance of the beginning; the orbit
is found; the budget of applications is spent; no cycle is in sight."""

LONGEST_CYCLE_IN_PERIODS = LONGEST_CYCLE // 2
"""Orbits that close after 1 to this many drive periods are recognised."""

_SOONEST_CYCLE_IN_PERIODS = SOONEST_CYCLE // 2

# Drive periods after which a sequence that neither approaches a cycle nor closes wanders, whatever
# it is near to, but at most half of the budget; and those before a late one may be said to: three
# times round the longest cycle, and a half for the way to it.
_DUE_PERIODS = 384
_PATIENCE_OF_LATE = 7 * LONGEST_CYCLE_IN_PERIODS // 2

# The verdict must hold over two drive periods, and at every point of the cycle: fast transients
# can mimic it once.
_CONFIRMED_PERIODS = 2

# Chains of jumps that are undone before the search goes on without jumps.
_MOST_FAILURES = 8

_FINEST = 3  # cuts of the tolerance: one for the last steps to the orbit, two where it stalls


@cache
def memory_of(width: int) -> np.dtype[np.void]:
    """The record that a search remembers, for states of so many components."""
    return np.dtype(
        [
            ("per_period", "i8"),  # applications a drive period: 2 for the half-period map
            ("longest_cycle", "i8"),  # in applications
            ("patience", "i8"),  # applications before the sequence may be said to wander
            ("applications", "i8"),  # since the start
            ("mirrored", "i8"),  # 1 where the state is the mirror image of the start's
            ("newest", "i8"),  # applications since the sequence was last begun again
            ("held", "i8"),  # times in a row that the same cycle was found closed
            ("cycle", "i8"),  # that cycle, in applications
            ("fineness", "i8"),  # times that the tolerance was cut
            ("initial_fineness", "i8"),  # _FINEST where the map has no tolerance
            ("plain", "i8"),  # 1 where no jump is allowed (any more)
            ("allowed", "f8"),  # longest jump that the caller allows
            ("contracting", "i8"),  # applications in which, as the caller knows, no motions part
            ("peak", "f8"),  # in the application just made, of what a jump does not move
            ("jumps", "i8"),  # since the state to restore was stored
            ("failures", "i8"),  # chains of jumps that were undone
            ("aim", "i8"),  # the cycle whose limit the jumps aim at
            ("common", "i8"),  # greatest common divisor of the cycles that jumps aimed at
            ("paired", "i8"),  # 1 where `landing` can be compared with the next displacement
            ("stored_mirrored", "i8"),
            ("longest_jump", "f8"),  # longest jump allowed
            ("gone", "f8"),  # length of the last jump
            ("stride", "f8"),  # longest part of a way that a jump may go
            ("residue", "f8"),  # longest displacement by which the last jump is a success
            ("calm", "f8"),  # displacements must be shorter before jumps begin again
            ("slow", "f8", 2),  # direction of the slow mode, its larger component 1
            ("landing", "f8", 2),  # (x, v) before ...
            ("image", "f8", 2),  # ... and after `aim` applications
            ("stored", "f8", width),  # the state before the first jump
            ("turning", "i8"),  # the cycle into which the sequence winds, 0 for none
            ("ratios", "f8", LONGEST_CYCLE),  # of contraction, by cycle
            ("states", "f8", (REMEMBERED, width)),
            ("peaks", "f8", REMEMBERED),  # of the applications that led to these states
        ],
        align=True,
    )


@jit
def start(
    memory: Any, z: Vector, per_period: int, accelerate: bool, refinable: bool, late: bool
) -> None:
    """Make the record `memory` ready for a search from the scaled state `z`.

    `per_period` applications make a drive period: 1, or 2 for the half-period map of a system with
    the odd symmetry. `accelerate` allows jumps; `refinable` says that the map has a tolerance that
    can be cut. A `late` search goes on with a sequence in which an earlier one found no cycle: it
    looks for longer ones, with the finer tolerance from the beginning.
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
    memory.gone, memory.stride, memory.turning, memory.peak = 0.0, np.inf, 0, 0.0
    for cycle in range(memory.longest_cycle):
        memory.ratios[cycle] = UNKNOWN
    for i in range(2):
        memory.slow[i], memory.landing[i], memory.image[i] = 0.0, 0.0, 0.0
    _begin_again(memory, z, 0.0, 0.0)


@inline
def limit_jumps(memory: Any, longest: float, contracting: bool, peak: float = 0.0) -> None:
    """Allow jumps of so many units of the scaled position, 0 for none, inf for any.

    The caller knows of a slow part that a jump would outrun. Where the limit is finite, what a jump
    does not move must also stand still. Or it knows that the application just made was
    `contracting`: that neighbouring motions did not part in it; or the `peak` in it of what a jump
    does not move, which must not change either.
    """
    memory.allowed, memory.peak = longest, peak
    memory.contracting = memory.contracting + 1 if contracting else 0


@inline
def _begin_again(memory: Any, z: Vector, dx: float, dv: float) -> None:
    """Judge the sequence only from the state z + (dx, dv) on."""
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
    """Whether jumps led to an orbit that plain iteration might not end on.

    It must be of the kind that the jumps aimed at, and attract: a jump towards a symmetric orbit
    can land on an unstable one where the plain sequence ends on an asymmetric one.
    """
    attracting = abs(memory.ratios[cycle - 1]) < 1.0 or known_to_contract(memory)
    return not (memory.common % cycle == 0 and attracting)


@jit
def judge(
    memory: Any, z: Vector, tolerance: float, noise: float, budget: int
) -> tuple[int, float, float]:
    """What to do after an application of the map that led to the scaled state `z`.

    `tolerance` is the distance from the limit to reach, `noise` the present tolerance of the
    integrator, `budget` the number of applications allowed.
    """
    memory.applications += 1
    memory.newest += 1
    if memory.per_period == 2:
        memory.mirrored = 1 - memory.mirrored
    _remember(memory, z)
    note_ratios(memory, noise)  # without jumps too: the last correction and the error ask for them
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
    # Not in the mirror image: the amplitudes of single periods depend on where these begin.
    in_sight = memory.mirrored > 0 or not wanders(memory, memory.newest, tolerance, noise, late)
    if verdict != GO_ON or in_sight:
        return verdict, dx, dv
    # A jump that led nowhere may have led to where plain iteration does not wander.
    return _undo(memory, _MOST_FAILURES) if memory.jumps > 0 else (WANDERING, 0.0, 0.0)


@inline
def _confirmed(memory: Any, cycle: int) -> bool:
    """Whether a cycle was found closed often enough, at the tolerance that counts."""
    whole = cycle % 2 == 1 or memory.mirrored == 0  # an asymmetric orbit, not its mirror image
    enough = max(_CONFIRMED_PERIODS * memory.per_period, cycle)
    return memory.held >= enough and memory.fineness > 0 and whole


@jit
def _undo(memory: Any, failures: int) -> tuple[int, float, float]:
    """Take the state before the first jump back, and count the failure."""
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
    """Jump, take the finer tolerance, or both, or just go on."""
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
    """The cycle of a settled orbit, in applications, and its contraction; 0 where unmeasured."""
    cycle = memory.cycle
    ratio = memory.ratios[cycle - 1]
    return cycle, ratio if abs(ratio) < 1.0 else 0.0


@jit
def last_correction(memory: Any) -> tuple[float, float]:
    """The way (dx, dv) from the settled state to the limit of its sequence, as far as it is known.

    It is shorter than the tolerance, but the offset that is left would enter the extrema of a
    symmetric orbit, of which only half is looked at, to first order. On a spiral its direction is
    not known: (0, 0).
    """
    newest, (cycle, ratio) = memory.newest, found(memory)
    if memory.turning == cycle:
        return 0.0, 0.0
    moved = displacement(memory, newest, newest - cycle)
    return reach(ratio) * moved[0], reach(ratio) * moved[1]
