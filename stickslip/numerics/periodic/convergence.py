"""When has a sequence of states reached its cycle? Periodic orbits of a driven system judged.

The states are those of a stroboscopic (Poincaré) map: one for each application of the map. The
sequence may converge with a ratio of 0.99 an application, so the last difference says little: what
counts is the remaining distance to the limit. For a geometric sequence seen at a lag, with D1 the
newest displacement over the lag and D0 the one before, it is D1^2/(D0 - D1) (Aitken's delta-squared
process). Long lags make the estimate firm where the differences are near the noise of the
integrator.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit

LONGEST_CYCLE = 256
"""Cycles of 1 to this many applications are recognised, at most."""

SOONEST_CYCLE = 64
"""Of these, cycles up to this many applications before a sequence has proved to be late: to look at
all of them after each application takes longer than the application of a simple film."""

# Lags that say how much of the way to the limit remains; fewer for the longest cycles.
_LAGS = 16
REMEMBERED = 513
"""States that are remembered: twice round the longest cycle."""

UNKNOWN = 2.0
"""The ratio of contraction where none was measured yet."""

# A difference this small a part of the tolerance cannot hide a drift that matters: with a ratio
# of 0.999 a period it leaves one tolerance to go.
_NEGLIGIBLE = 1e-3

# Staying within this part of the tolerance for 16 cycles bounds the drift of a noisy sequence: with
# a ratio of 0.99 a period it leaves one tolerance to go.
_QUIET = 0.2
_DRIFTLESS = 0.7

# A displacement longer than its ratio makes it by this part of the tolerance is a drift.
_DRIFT = 0.3

# Cycles closer together than this many tolerances are one. Of a noisy sequence any of many long
# ones closes by chance: a cycle of more periods than this is none unless its points are apart.
_INDISTINCT = 10.0
_SHORT_PERIODS = 8

# A sequence has stalled if, within this many tolerances of repeating, it moved in so many periods
# nearly as far as in as many before.
_PATIENCE = 64
_STALLED_RATIO = 0.9
_NEAR = 100.0

# A sequence is watched for so many drive periods before it is said to wander. A cycle is approached
# where its displacements seldom grow, and left where they seldom shrink, whatever the pace, noise
# and a few exceptions allowed for: where neither is true, every other one grows.
_WATCHED_PERIODS = 128
_SELDOM = 0.1
_NOISE_ALLOWED = 10.0

# The longest way to a cycle: the longest offset that a start leaves, and as much again.
_LONGEST_WAY = 4.0

# Times besides the last that a displacement within the noise is looked at for whether it declines.
_LOOKS = 4


@inline
def distance(memory: Any, newer: int, older: int) -> float:
    """Largest scaled difference between two remembered states; NaN where either is NaN."""
    states, i, j = memory.states, newer % REMEMBERED, older % REMEMBERED
    largest, total = 0.0, 0.0
    for component in range(states.shape[1]):
        difference = abs(states[i, component] - states[j, component])
        largest = max(largest, difference)
        total += difference
    return largest + 0.0 * total  # max() drops a NaN, a sum does not


@inline
def displacement(memory: Any, newer: int, older: int) -> tuple[float, float]:
    """Displacement of (x, v) between two remembered states."""
    states, i, j = memory.states, newer % REMEMBERED, older % REMEMBERED
    return states[i, 0] - states[j, 0], states[i, 1] - states[j, 1]


@inline
def reach(ratio: float) -> float:
    """Remaining way to the limit in units of the last displacement, with its sign."""
    return ratio / (1.0 - ratio)


@jit
def _remaining_distance(memory: Any, newest: int, lag: int) -> float:
    """Estimated distance of the newest state from the limit, seen at `lag`; inf if it grows."""
    moved = distance(memory, newest, newest - lag)
    before = distance(memory, newest - lag, newest - 2 * lag)
    return moved * moved / (before - moved) if moved < before else np.inf


@jit
def _repeats(memory: Any, newest: int, cycle: int, tolerance: float) -> bool:
    """Whether the orbit closes after `cycle` applications, within `tolerance` of its limit.

    Where the ratio of contraction was measured above the noise, it says how much remains.
    Otherwise every lag that the sequence is long enough for must say so: a short one can be
    deceived by noise, a long one by a fast transient. A sequence that repeats to a small part of
    the tolerance, or does not contract but stays within a larger part for long, has nothing left
    to estimate.
    """
    if cycle > newest:
        return False
    step = distance(memory, newest, newest - cycle)
    if not step <= tolerance:
        return False
    if step <= _NEGLIGIBLE * tolerance:
        return True
    ratio = memory.ratios[cycle - 1]
    if memory.plain == 0 and abs(ratio) < 1.0 and _contracts(memory, newest, cycle, tolerance):
        return step * abs(reach(ratio)) <= tolerance
    lag, farthest = cycle, 0.0 if 2 * cycle <= newest else np.inf
    while lag <= _LAGS * cycle and 2 * lag <= min(newest, REMEMBERED - 1):
        farthest = max(farthest, _remaining_distance(memory, newest, lag))
        lag *= 2
    noisy = farthest == np.inf and newest > 2 * cycle
    return farthest <= tolerance or (noisy and _quiet(memory, newest, cycle, tolerance))


@inline
def _contracts(memory: Any, newest: int, cycle: int, tolerance: float) -> bool:
    """Whether the last displacement is as short as the ratio that was measured makes it.

    The ratio may belong to a fast mode that has died out, and hide a slow one that still drifts.
    """
    if 2 * cycle > newest:
        return True
    step = distance(memory, newest, newest - cycle)
    before = distance(memory, newest - cycle, newest - 2 * cycle)
    return step <= abs(memory.ratios[cycle - 1]) * before + _DRIFT * tolerance


@jit
def _quiet(memory: Any, newest: int, cycle: int, tolerance: float) -> bool:
    """Whether the last 16 cycles stay, without a drift, in a small part of the tolerance.

    With a drift the later half of the lags reaches twice as far as the earlier half.
    """
    lags = min(_LAGS, (REMEMBERED - 1) // cycle)
    if newest < lags * cycle:
        return False
    near = _farthest(memory, newest, cycle, lags // 2)
    far = _farthest(memory, newest, cycle, lags)
    return far <= _QUIET * tolerance and near >= _DRIFTLESS * far


@jit
def _farthest(memory: Any, newest: int, cycle: int, lags: int) -> float:
    """Largest distance of the newest state from those of so many cycles before; NaN counts."""
    farthest = 0.0
    for lag in range(cycle, lags * cycle + 1, cycle):
        away = distance(memory, newest, newest - lag)
        if not away <= farthest:
            farthest = away
    return farthest


@jit
def closing_cycle(memory: Any, newest: int, tolerance: float) -> int:
    """Smallest number of applications after which the orbit closes; 0 where it does not yet."""
    for cycle in range(1, memory.longest_cycle + 1):
        if _repeats(memory, newest, cycle, tolerance):
            shorter = _indistinct_cycle(memory, newest, cycle, tolerance)
            if shorter == cycle or cycle <= _SHORT_PERIODS * memory.per_period:
                return shorter
    return 0


@jit
def _indistinct_cycle(memory: Any, newest: int, cycle: int, tolerance: float) -> int:
    """The shortest part of a cycle that nearly closes as well; the cycle where none does."""
    for shorter in range(1, cycle):
        close = distance(memory, newest, newest - shorter) <= _INDISTINCT * tolerance
        if cycle % shorter == 0 and close:
            return shorter
    return cycle


@jit
def stalled(memory: Any, newest: int, tolerance: float) -> bool:
    """Whether a sequence near its limit no longer approaches it.

    An adaptive method maps a period with jumps of the order of its tolerance, where the pattern
    of accepted steps changes. Where the orbit attracts slowly these jumps, not the orbit, decide
    what the sequence does: it wanders about the limit and never settles.
    """
    for cycle in range(1, memory.longest_cycle + 1):
        lag = cycle * ((_PATIENCE + cycle - 1) // cycle)
        if 2 * lag <= newest:
            moved = distance(memory, newest, newest - lag)
            before = distance(memory, newest - lag, newest - 2 * lag)
            if _STALLED_RATIO * before <= moved <= _NEAR * tolerance:
                return True
    return False


@jit
def wanders(memory: Any, newest: int, tolerance: float, noise: float, due: bool) -> bool:
    """Whether the sequence, watched for 128 drive periods, has to do with no cycle in sight.

    Looked at twice in so many periods. `noise` is the tolerance of the integrator. Where a verdict
    is `due`, only what approaches a cycle without exception goes on: neither what leaves one nor
    what stays near one without closing.
    """
    watched, periods = _WATCHED_PERIODS * memory.per_period, newest // memory.per_period
    if newest < max(watched, memory.patience) or periods % (_WATCHED_PERIODS // 2) != 0:
        return False
    blur = max(_NOISE_ALLOWED * noise, tolerance)
    for cycle in range(1, min(memory.longest_cycle, SOONEST_CYCLE) + 1):
        if due:
            goes_on = _approaches(memory, newest, cycle, watched, blur)
        else:
            near = _farthest(memory, newest, cycle, watched // cycle) <= _NEAR * tolerance
            goes_on = near or _in_sight(memory, newest, cycle, watched, blur)
        if goes_on:
            return False
    return True


@jit
def _in_sight(memory: Any, newest: int, cycle: int, watched: int, blur: float) -> bool:
    """Whether the sequence approaches the cycle, or leaves it, at whatever pace.

    Along a line its displacements by `cycle` applications then seldom grew, or seldom shrank. On a
    spiral they grow and shrink by turns, but the areas between them go one way. Areas that stay as
    they are say nothing: a motion round and round without end has such.
    """
    rarely_grew, rarely_shrank = _trend(memory, newest, cycle, watched, blur, _SELDOM, _moved)
    if rarely_grew or rarely_shrank:
        return True
    rarely_grew, rarely_shrank = _trend(memory, newest, cycle, watched, blur, _SELDOM, _swept)
    return rarely_grew != rarely_shrank


@jit
def _approaches(memory: Any, newest: int, cycle: int, watched: int, blur: float) -> bool:
    """Whether the sequence has approached the cycle all the time.

    A weakly damped film that is kicked every forty periods does so most of the time. What has
    approached in geometric progression for so long moves by little now: a way of length w, of
    which a part 1 - r is gone at a time, has steps of w (1 - r) r^n, for no r above w / (e n).
    """
    never_grew, _ = _trend(memory, newest, cycle, watched, blur, 0.0, _moved)
    if never_grew:
        steps = newest // cycle
        short = distance(memory, newest, newest - cycle) * (math.e * steps) <= _LONGEST_WAY
        return short and _declines(memory, newest, cycle, watched)
    never_grew, never_shrank = _trend(memory, newest, cycle, watched, blur, 0.0, _swept)
    return never_grew and not never_shrank


@inline
def _declines(memory: Any, newest: int, cycle: int, watched: int) -> bool:
    """Whether the displacements are shorter each time they are looked at: not so what is noise."""
    apart = (watched - cycle) // _LOOKS
    before = np.inf
    for look in range(_LOOKS, -1, -1):
        newer = newest - look * apart
        moved = distance(memory, newer, newer - cycle)
        if not moved < before:
            return False
        before = moved
    return True


@jit
def _trend(
    memory: Any,
    newest: int,
    cycle: int,
    watched: int,
    blur: float,
    exceptions: float,
    extent: Any,
) -> tuple[bool, bool]:
    """Whether `extent` did not grow, and did not shrink, by more than what of it is noise.

    But for a part of `exceptions`.
    """
    first = newest - watched + 3 * cycle
    grew, shrank, most = 0, 0, int(exceptions * (newest - first + 1))
    for newer in range(first, newest + 1):
        now, noise = extent(memory, newer, cycle, blur)
        before, _ = extent(memory, newer - cycle, cycle, blur)
        grew += 1 if now > before + noise else 0
        shrank += 1 if now < before - noise else 0
        if grew > most and shrank > most:
            break
    return grew <= most, shrank <= most


@jit
def _moved(memory: Any, newer: int, cycle: int, blur: float) -> tuple[float, float]:
    """The length of the displacement by `cycle` applications, and what of it is noise."""
    return distance(memory, newer, newer - cycle), blur


@jit
def _swept(memory: Any, newer: int, cycle: int, blur: float) -> tuple[float, float]:
    """The area in (x, v) between the last two displacements, and what of it is noise.

    A linear map multiplies it by its determinant, whatever the shape of the spiral.
    """
    last = displacement(memory, newer, newer - cycle)
    before = displacement(memory, newer - cycle, newer - 2 * cycle)
    longest = max(abs(last[0]), abs(last[1]), abs(before[0]), abs(before[1]))
    return abs(last[0] * before[1] - last[1] * before[0]), blur * longest
