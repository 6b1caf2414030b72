"""The search for the orbit on which a driven system settles, as a machine fed with half periods.

The system has the odd symmetry (x, v, film, t) -> (-x, -v, film, t + T/2). Half a drive period from
phase 0, with the signs of x and v turned at its end, is therefore a map S of the state into
itself. A symmetric orbit is a fixed point of S, an orbit that closes after n periods a cycle of at
most 2n applications. The offset that a start leaves decays with a ratio of 0.96 to 0.999 a period;
under S it alternates with a ratio close to -1, and the secant step to its limit is an
interpolation between the last two states: well conditioned, and blind to the noise of the
integrator, where an extrapolation over periods divides that noise by the distance of the ratio
from 1.

The machine keeps its whole memory in one row of floats, so that each of many lanes has its own.
A drive calls `judge` with the scaled state after each application of S, and does what it says.
"""

from __future__ import annotations

import numpy as np

from stickslip.compiled.decorators import inline, jit

GO_ON, JUMP, FINER, RESTORE, SETTLED, EXHAUSTED = range(6)
"""Verdicts: go on; add (dx, dv) to the scaled state; cut the tolerance of the integrator to a
tenth (and add (dx, dv)); take the stored state back, with the tolerance of the beginning; the orbit
is found; the budget of half periods is spent."""

LONGEST_CYCLE = 16
"""Cycles of 1 to this many half periods are recognised."""

_LAGS = 16
_REMEMBERED = 2 * _LAGS * LONGEST_CYCLE + 1

# The row: counters, the state to restore, the landing before the last, ratios by cycle, states.
(
    HALVES,  # applications of S since the start
    MIRRORED,  # 1 where the state is the mirror image of the one that the start leads to
    NEWEST,  # applications since the sequence was last begun afresh
    HELD,  # times in a row that the same cycle was found closed
    CYCLE,  # that cycle, in half periods
    FINENESS,  # times that the tolerance was cut
    COARSEST,  # what FINENESS began with: FINEST where the map has no tolerance
    PLAIN,  # 1 where no jump is allowed (any more)
    JUMPS,  # since the state to restore was stored
    FAILURES,  # chains of jumps that were undone
    AIM,  # the cycle whose limit the jumps aim at
    LONGEST,  # longest jump allowed
    RESIDUE,  # longest displacement by which the last jump counts as a success
    CALM,  # displacements must be shorter than this before another chain of jumps is begun
    COMMON,  # greatest common divisor of the cycles that jumps aimed at
    SLOW_X,  # direction of the slow mode, its larger component 1
    SLOW_V,
    PAIR,  # 1 where LANDING holds a pair that the next displacement can be compared with
    LANDING_X,  # x, v before ...
    LANDING_V,
    IMAGE_X,  # ... and after an application of S^AIM
    IMAGE_V,
    STORED_X,  # the state before the first jump
    STORED_V,
    STORED_FILM,
    STORED_MIRRORED,
    _RATIOS,
) = range(27)
_STATES = _RATIOS + LONGEST_CYCLE
MEMORY = _STATES + 3 * _REMEMBERED

_UNKNOWN = 2.0  # no ratio measured yet

# A difference this small a part of the tolerance cannot hide a drift that matters: with a ratio
# of 0.999 a period it leaves one tolerance to go.
_NEGLIGIBLE = 1e-3

# Staying within this part of the tolerance for 16 cycles bounds the drift of a noisy sequence: with
# a ratio of 0.99 a period it leaves one tolerance to go.
_QUIET = 0.2
_DRIFTLESS = 0.7

# The verdict must hold over two drive periods, and at every point of the cycle: fast transients
# can mimic it once.
_CONFIRMATIONS = 4

# Cycles closer together than this many tolerances are one.
_INDISTINCT = 10.0

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

# A jump longer than this many drive amplitudes, the largest offset that a start at rest can leave,
# is not risked, and every jump is at most half as long as the one before.
_LONGEST_JUMP = 2.0

# Jumps are few where they lead anywhere, and seldom fail twice.
_MOST_JUMPS = 20
_MOST_FAILURES = 8

# A jump moves x and v alone. That the film follows is believed where ln(phi), scaled, differs by
# no more than this between the states that the jump is judged by. A film that is solid after one
# half period and melted after the other may end as either: then a jump goes half the way only,
# along states that plain iteration passes too, and only where that is slow.
_SLAVED = 1e-3
_HALF_WAY = 0.5
_SLOWEST_PART = 0.8

# A cycle of several half periods is plainly approached where its points lie farther apart than
# this many times the way that remains.
_APART = 4.0

# The first jump stops short of the limit by this part: the next ratio is then measured near the
# limit, and tells an orbit that attracts from one that does not.
_SHORTFALL = 0.01

# From this distance on the finer tolerance is taken.
_COARSE = 1e-4

# A sequence has stalled if, within this many tolerances of repeating, it moved in so many periods
# nearly as far as in as many before.
_PATIENCE = 64
_STALLED_RATIO = 0.9
_NEAR = 100.0
_FINEST = 3  # cuts of the tolerance: one for the last steps to the orbit, two where it stalls


@inline
def start(
    memory: np.ndarray, z: tuple[float, float, float], accelerate: bool, refinable: bool
) -> None:
    """Make the row `memory` (MEMORY,) ready for a search from the scaled state `z`.

    `accelerate` allows jumps; `refinable` says that the map has a tolerance that can be cut.
    """
    for slot in range(_STATES):
        memory[slot] = 0.0
    memory[PLAIN] = 0.0 if accelerate else 1.0
    memory[COARSEST] = 0.0 if refinable else _FINEST
    memory[FINENESS] = memory[COARSEST]
    memory[LONGEST], memory[CALM] = _LONGEST_JUMP, np.inf
    for cycle in range(LONGEST_CYCLE):
        memory[_RATIOS + cycle] = _UNKNOWN
    _begin_afresh(memory, z[0], z[1], z[2])


@inline
def _begin_afresh(memory: np.ndarray, x: float, v: float, film: float) -> None:
    """Judge the sequence from this state on only."""
    memory[NEWEST], memory[HELD], memory[CYCLE] = 0.0, 0.0, 0.0
    memory[_STATES], memory[_STATES + 1], memory[_STATES + 2] = x, v, film


@inline
def _slot(number: int) -> int:
    return _STATES + 3 * (number % _REMEMBERED)


@inline
def _distance(memory: np.ndarray, newer: int, older: int) -> float:
    """Largest scaled difference between two remembered states."""
    i, j = _slot(newer), _slot(older)
    largest, total = 0.0, 0.0
    for component in range(3):
        difference = abs(memory[i + component] - memory[j + component])
        largest = max(largest, difference)
        total += difference
    return largest + 0.0 * total  # max() drops a NaN, a sum does not


@inline
def _way(memory: np.ndarray, newer: int, older: int) -> tuple[float, float]:
    """Displacement of (x, v) between two remembered states."""
    i, j = _slot(newer), _slot(older)
    return memory[i] - memory[j], memory[i + 1] - memory[j + 1]


@inline
def _length(way: tuple[float, float]) -> float:
    return max(abs(way[0]), abs(way[1]))


@inline
def _along(way: tuple[float, float], image: tuple[float, float]) -> float:
    """The component of `way` that is the larger one of `image`.

    S wipes out all but the slow mode, so images differ along it. A landing after a jump may lie
    off it, by a velocity that is forgotten at once and must not count.
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
    memory: np.ndarray,
    cycle: int,
    newer: tuple[float, float],
    older: tuple[float, float],
    noise: float,
) -> None:
    """Remember the contraction by S^cycle where it stands out from the noise.

    A growth is forgotten as soon as there is contraction, clear or not: it belonged to a bend of
    the map that the sequence has left behind.
    """
    ratio, _ = _contraction(newer, older)
    length = abs(_along(older, newer))
    better = abs(ratio) < 1.0 <= abs(memory[_RATIOS + cycle - 1])
    if _clear(ratio, length, noise) or (better and _CLEARANCE * noise <= length):
        memory[_RATIOS + cycle - 1] = ratio
        if cycle == memory[AIM]:
            length = _length(newer)
            memory[SLOW_X], memory[SLOW_V] = newer[0] / length, newer[1] / length


@jit
def _note_ratios(memory: np.ndarray, noise: float) -> None:
    newest = int(memory[NEWEST])
    for cycle in range(1, LONGEST_CYCLE + 1):
        if 2 * cycle <= newest:
            _note_ratio(
                memory,
                cycle,
                _way(memory, newest, newest - cycle),
                _way(memory, newest - cycle, newest - 2 * cycle),
                noise,
            )


@inline
def _reach(ratio: float) -> float:
    """Remaining way to the limit in units of the last displacement, with its sign."""
    return ratio / (1.0 - ratio)


@jit
def _remaining_distance(memory: np.ndarray, newest: int, lag: int) -> float:
    """Estimated distance of the newest state from the limit, seen at `lag`; inf if it grows."""
    moved = _distance(memory, newest, newest - lag)
    before = _distance(memory, newest - lag, newest - 2 * lag)
    return moved * moved / (before - moved) if moved < before else np.inf


@jit
def _repeats(memory: np.ndarray, newest: int, cycle: int, tolerance: float) -> bool:
    """Whether the orbit closes after `cycle` half periods, within `tolerance` of its limit.

    Where the ratio of contraction was measured above the noise, it says how much remains.
    Otherwise every lag that the sequence is long enough for must say so: a short one can be
    deceived by noise, a long one by a fast transient. A sequence that repeats to a small part of
    the tolerance, or does not contract but stays within a larger part for long, has nothing left
    to estimate.
    """
    if cycle > newest:
        return False
    step = _distance(memory, newest, newest - cycle)
    if not step <= tolerance:
        return False
    if step <= _NEGLIGIBLE * tolerance:
        return True
    ratio = memory[_RATIOS + cycle - 1]
    if memory[PLAIN] == 0.0 and abs(ratio) < 1.0:
        return step * abs(_reach(ratio)) <= tolerance
    lag, farthest = cycle, 0.0 if 2 * cycle <= newest else np.inf
    while lag <= _LAGS * cycle and 2 * lag <= newest:
        farthest = max(farthest, _remaining_distance(memory, newest, lag))
        lag *= 2
    noisy = farthest == np.inf and newest > 2 * cycle
    return farthest <= tolerance or (noisy and _quiet(memory, newest, cycle, tolerance))


@jit
def _quiet(memory: np.ndarray, newest: int, cycle: int, tolerance: float) -> bool:
    """Whether the last 16 cycles wander, without a drift, in a small part of the tolerance.

    With a drift the later half of the lags reaches twice as far as the earlier half.
    """
    if newest < _LAGS * cycle:
        return False
    near = _farthest(memory, newest, cycle, _LAGS // 2)
    far = _farthest(memory, newest, cycle, _LAGS)
    return far <= _QUIET * tolerance and near >= _DRIFTLESS * far


@jit
def _farthest(memory: np.ndarray, newest: int, cycle: int, lags: int) -> float:
    """Largest distance of the newest state from those of so many cycles before; NaN counts."""
    farthest = 0.0
    for lag in range(cycle, lags * cycle + 1, cycle):
        distance = _distance(memory, newest, newest - lag)
        if not distance <= farthest:
            farthest = distance
    return farthest


@jit
def _closing_cycle(memory: np.ndarray, newest: int, tolerance: float) -> int:
    """Smallest number of half periods after which the orbit closes; 0 where it does not yet."""
    for cycle in range(1, LONGEST_CYCLE + 1):
        if _repeats(memory, newest, cycle, tolerance):
            for shorter in range(1, cycle):
                close = _distance(memory, newest, newest - shorter) <= _INDISTINCT * tolerance
                if cycle % shorter == 0 and close:
                    return shorter
            return cycle
    return 0


@jit
def _stalled(memory: np.ndarray, newest: int, tolerance: float) -> bool:
    """Whether a sequence near its limit no longer approaches it.

    An adaptive method maps a period with jumps of the order of its tolerance, where the pattern
    of accepted steps changes. Where the orbit attracts slowly these jumps, not the orbit, decide
    what the sequence does: it wanders about the limit and never settles.
    """
    for cycle in range(1, LONGEST_CYCLE + 1):
        lag = cycle * ((_PATIENCE + cycle - 1) // cycle)
        if 2 * lag <= newest:
            moved = _distance(memory, newest, newest - lag)
            before = _distance(memory, newest - lag, newest - 2 * lag)
            if _STALLED_RATIO * before <= moved <= _NEAR * tolerance:
                return True
    return False


@inline
def _slow(ratio: float, cycle: int) -> bool:
    """Whether a contraction is slow enough, and not too slow, for a jump."""
    alternating = cycle == 1 and -1.0 < ratio <= -_SMALLEST_ALTERNATION
    return alternating or (_SMALLEST_RATIO <= abs(ratio) < 1.0 and ratio <= _LARGEST_RATIO)


@jit
def _steady_cycle(memory: np.ndarray, newest: int, noise: float) -> int:
    """Smallest cycle whose last three displacements shrink by one ratio along one line; or 0."""
    for cycle in range(1, LONGEST_CYCLE + 1):
        if 3 * cycle > newest:
            return 0
        if _steady(memory, newest, cycle, noise):
            return cycle
    return 0


@jit
def _steady(memory: np.ndarray, newest: int, cycle: int, noise: float) -> bool:
    """Whether the last three displacements by S^cycle plainly lead to a limit.

    An asymmetric orbit is approached with displacements whose ratio tends to -1: its distance
    from -1 then shrinks, which the comparison with the earlier ratio sees.
    """
    oldest = _way(memory, newest - 2 * cycle, newest - 3 * cycle)
    before = _way(memory, newest - cycle, newest - 2 * cycle)
    last = _way(memory, newest, newest - cycle)
    earlier, _ = _contraction(before, oldest)
    ratio, bend = _contraction(last, before)
    room = min(1.0 - abs(ratio), abs(ratio))
    steady = abs(ratio - earlier) <= _STEADY * room and bend <= _BEND
    clear = _clear(ratio, _length(before), noise)
    return steady and clear and _slow(ratio, cycle) and _length(last) <= memory[CALM]


@inline
def _slaved(memory: np.ndarray, newest: int, cycle: int) -> bool:
    """Whether the film was in one and the same state at the last passages, four at most."""
    film = memory[_slot(newest) + 2]
    for lag in range(cycle, min(3 * cycle, newest) + 1, cycle):
        if not abs(memory[_slot(newest - lag) + 2] - film) <= _SLAVED:
            return False
    return True


@inline
def _apart(memory: np.ndarray, newest: int, cycle: int, length: float) -> bool:
    """Whether the points of the cycle are farther apart than the way `length` that remains."""
    for lag in range(1, cycle):
        if not _length(_way(memory, newest, newest - lag)) >= _APART * length:
            return False
    return True


@inline
def _part(memory: np.ndarray, newest: int, cycle: int, ratio: float) -> float:
    """The part of the remaining way that a jump is to go; 0 for no jump."""
    if not _slaved(memory, newest, cycle):
        return _HALF_WAY if abs(ratio) >= _SLOWEST_PART else 0.0
    return 1.0 if memory[JUMPS] > 0.0 else 1.0 - _SHORTFALL


@jit
def _jump(memory: np.ndarray, tolerance: float, noise: float) -> tuple[float, float]:
    """The way to the limit where the sequence plainly leads to one; (0, 0) otherwise."""
    newest = int(memory[NEWEST])
    cycle = int(memory[AIM])
    followed = cycle > 0 and newest == cycle
    if not followed:
        cycle = _steady_cycle(memory, newest, noise)
    if cycle == 0 or memory[JUMPS] >= _MOST_JUMPS:
        return 0.0, 0.0
    last = _way(memory, newest, newest - cycle)
    if not followed:
        length = _length(last)
        memory[SLOW_X], memory[SLOW_V] = last[0] / length, last[1] / length
    slow = memory[SLOW_X], memory[SLOW_V]
    ratio = memory[_RATIOS + cycle - 1]
    amount = _reach(ratio) * _along(last, slow) * _along(slow, slow)
    length = abs(amount)
    safe = ratio < 0.0 or length <= memory[LONGEST]
    safe = safe and _slow(ratio, cycle) and _apart(memory, newest, cycle, length)
    part = _part(memory, newest, cycle, ratio)
    if not (safe and part * length > _WORTH * tolerance):
        return 0.0, 0.0
    _store_jump(memory, cycle, length, part)
    return part * amount * slow[0], part * amount * slow[1]


@inline
def _failed(memory: np.ndarray, noise: float) -> bool:
    """Whether the first displacement after a jump is not shorter than the one before it."""
    newest, aim = int(memory[NEWEST]), int(memory[AIM])
    if aim == 0 or newest != aim:
        return False
    moved = abs(_along(_way(memory, newest, 0), (memory[SLOW_X], memory[SLOW_V])))
    return not moved <= max(memory[RESIDUE], _CLEARANCE * noise)


@jit
def _store_jump(memory: np.ndarray, cycle: int, length: float, part: float) -> None:
    """Note a jump from the newest state, with what is needed to judge it and to undo it."""
    newest = int(memory[NEWEST])
    newer, older = _slot(newest), _slot(newest - cycle)
    if memory[JUMPS] == 0.0:
        memory[STORED_X], memory[STORED_V] = memory[newer], memory[newer + 1]
        memory[STORED_FILM], memory[STORED_MIRRORED] = memory[newer + 2], memory[MIRRORED]
        memory[CALM] = 0.5 * _length(_way(memory, newest, newest - cycle))
    memory[JUMPS] += 1.0
    memory[AIM], memory[COMMON] = cycle, _common_divisor(cycle, int(memory[COMMON]))
    slow = memory[SLOW_X], memory[SLOW_V]
    displacement = abs(_along(_way(memory, newest, newest - cycle), slow))
    memory[RESIDUE] = (1.0 - 0.5 * part) * displacement  # without the jump it would stay the same
    memory[LONGEST] = min(0.5 * length, memory[LONGEST])
    memory[PAIR] = 1.0
    memory[LANDING_X], memory[LANDING_V] = memory[older], memory[older + 1]
    memory[IMAGE_X], memory[IMAGE_V] = memory[newer], memory[newer + 1]


@inline
def _common_divisor(a: int, b: int) -> int:
    while b > 0:
        a, b = b, a % b
    return a


@jit
def _compare_landing(memory: np.ndarray, noise: float) -> None:
    """The ratio of contraction between the landing after a jump and the one before."""
    newest, aim = int(memory[NEWEST]), int(memory[AIM])
    if memory[PAIR] == 0.0 or newest != aim:
        return
    old, new = _slot(0), _slot(newest)
    before = memory[old] - memory[LANDING_X], memory[old + 1] - memory[LANDING_V]
    after = memory[new] - memory[IMAGE_X], memory[new + 1] - memory[IMAGE_V]
    _note_ratio(memory, aim, after, before, noise)


@jit
def _near(memory: np.ndarray, newest: int, tolerance: float) -> bool:
    """Whether the sequence repeats well enough for the finer tolerance to be worth its cost."""
    distance = max(_COARSE, 10.0 * tolerance)
    for cycle in range(1, LONGEST_CYCLE + 1):
        ratio = memory[_RATIOS + cycle - 1]
        if cycle <= newest and abs(ratio) < 1.0:
            step = _distance(memory, newest, newest - cycle)
            if step * max(abs(_reach(ratio)), 0.1) <= distance:
                return True
    return False


@inline
def _doubtful(memory: np.ndarray, cycle: int) -> bool:
    """Whether jumps led to an orbit that plain iteration might not end on.

    It must be of the kind that the jumps aimed at, and attract: a jump towards a symmetric orbit
    can land on an unstable one where the plain sequence ends on an asymmetric one.
    """
    attracting = abs(memory[_RATIOS + cycle - 1]) < 1.0
    return not (memory[COMMON] % cycle == 0 and attracting)


@jit
def judge(
    memory: np.ndarray,
    z: tuple[float, float, float],
    tolerance: float,
    noise: float,
    budget: int,
) -> tuple[int, float, float]:
    """What to do after an application of S that led to the scaled state `z`.

    `tolerance` is the distance from the limit to reach, `noise` the present tolerance of the
    integrator, `budget` the number of half periods allowed.
    """
    memory[HALVES] += 1.0
    memory[MIRRORED] = 1.0 - memory[MIRRORED]
    memory[NEWEST] += 1.0
    newest = int(memory[NEWEST])
    slot = _slot(newest)
    memory[slot], memory[slot + 1], memory[slot + 2] = z
    if memory[PLAIN] == 0.0:
        _note_ratios(memory, noise)
        _compare_landing(memory, noise)
    cycle = _closing_cycle(memory, newest, tolerance)
    memory[HELD] = memory[HELD] + 1.0 if cycle > 0 and cycle == memory[CYCLE] else min(cycle, 1)
    memory[CYCLE] = cycle
    whole = cycle % 2 == 1 or memory[MIRRORED] == 0.0  # an asymmetric orbit, not its mirror image
    if memory[HELD] >= max(_CONFIRMATIONS, cycle) and memory[FINENESS] > 0.0 and whole:
        if memory[JUMPS] == 0.0 or not _doubtful(memory, cycle):
            return SETTLED, 0.0, 0.0
        return _undo(memory, _MOST_FAILURES)
    if memory[HALVES] >= budget:
        return EXHAUSTED, 0.0, 0.0
    if _failed(memory, noise):
        return _undo(memory, 1.0)
    return _proceed(memory, z, tolerance, noise)


@jit
def _undo(memory: np.ndarray, failures: float) -> tuple[int, float, float]:
    """Take the state before the first jump back, and be warned."""
    memory[FAILURES] += failures
    if memory[FAILURES] >= _MOST_FAILURES:
        memory[PLAIN] = 1.0
    memory[JUMPS], memory[AIM], memory[COMMON], memory[PAIR] = 0.0, 0.0, 0.0, 0.0
    memory[LONGEST], memory[FINENESS] = _LONGEST_JUMP, memory[COARSEST]
    memory[MIRRORED] = memory[STORED_MIRRORED]
    _begin_afresh(memory, memory[STORED_X], memory[STORED_V], memory[STORED_FILM])
    return RESTORE, 0.0, 0.0


@jit
def _proceed(
    memory: np.ndarray, z: tuple[float, float, float], tolerance: float, noise: float
) -> tuple[int, float, float]:
    """Jump, take the finer tolerance, or both, or just go on."""
    newest = int(memory[NEWEST])
    finer = False
    if memory[FINENESS] == 0.0:
        finer = memory[HELD] > 0.0 or (memory[PLAIN] == 0.0 and _near(memory, newest, tolerance))
    if memory[FINENESS] < _FINEST:
        finer = finer or _stalled(memory, newest, tolerance)
    dx, dv = 0.0, 0.0
    if memory[PLAIN] == 0.0 and memory[HELD] == 0.0:
        dx, dv = _jump(memory, tolerance, noise)
    jumped = dx != 0.0 or dv != 0.0
    if finer:
        memory[FINENESS] += 1.0
        memory[PAIR] = 0.0
    if finer or jumped:
        _begin_afresh(memory, z[0] + dx, z[1] + dv, z[2])
    return (FINER if finer else JUMP if jumped else GO_ON), dx, dv


@inline
def stored(memory: np.ndarray) -> tuple[float, float, float]:
    """The scaled state to go back to after RESTORE."""
    return memory[STORED_X], memory[STORED_V], memory[STORED_FILM]


@inline
def found(memory: np.ndarray) -> tuple[int, float]:
    """The cycle of a settled orbit, in half periods, and its contraction; 0 where unmeasured."""
    cycle = int(memory[CYCLE])
    ratio = memory[_RATIOS + cycle - 1]
    return cycle, ratio if abs(ratio) < 1.0 else 0.0


@jit
def last_correction(memory: np.ndarray) -> tuple[float, float]:
    """The way (dx, dv) from the settled state to the limit of its sequence, for what it is worth.

    It is shorter than the tolerance, but the offset that is left would enter the extrema of a
    symmetric orbit, of which only half is looked at, to first order.
    """
    newest, (cycle, ratio) = int(memory[NEWEST]), found(memory)
    way = _way(memory, newest, newest - cycle)
    reach = _reach(ratio)
    return reach * way[0], reach * way[1]
