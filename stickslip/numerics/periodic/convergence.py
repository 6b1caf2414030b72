"""Tests of a sequence of states: whether it has reached a cycle, approaches one, or wanders.

A stroboscopic (Poincaré) map produces the states, one for each application. The sequence may
converge with a ratio of 0.99 per application, so that the last difference says little. The tests
therefore use the remaining distance to the limit. For a geometric sequence sampled at a lag, this
is D1^2/(D0 - D1), where D1 is the newest displacement over the lag and D0 the previous one
(Aitken's delta-squared process). Long lags make the estimate robust if the differences are near the
noise of the integrator.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit

LONGEST_CYCLE = 256
"""The length of the longest cycle that is recognised, in applications."""

SOONEST_CYCLE = 64
"""The longest cycle in a first search, in applications. For a simple film, the tests of all cycles
after each application would take longer than the application."""

# The longest lag in estimates of the remaining distance, in cycles; shorter for the longest cycles.
_LAGS = 16
REMEMBERED = 513
"""The number of stored states: twice round the longest cycle."""

UNKNOWN = 2.0
"""The ratio of contraction before it is measured."""

# A difference below this fraction of the tolerance cannot hide an important drift: at a ratio of
# 0.999 per period, one tolerance remains.
_NEGLIGIBLE = 1e-3

# A noisy sequence that stays within the first fraction of the tolerance for 16 cycles has a bounded
# drift: at a ratio of 0.99 per period, one tolerance remains.
_QUIET = 0.2
_DRIFTLESS = 0.7

# A displacement that exceeds the prediction of the ratio by this part of the tolerance is a drift.
_DRIFT = 0.3

# Points within this many tolerances are the same. In a noisy sequence one of many long cycles
# closes by accident, so that in cycles of more periods than this all points must be distinct.
_INDISTINCT = 10.0
_SHORT_PERIODS = 8

# A sequence has stalled if over the first number of applications it moved by no more than the last
# number of tolerances, but by at least the second number times its movement over as many before.
_PATIENCE = 64
_STALLED_RATIO = 0.9
_NEAR = 100.0

# The verdict that a sequence wanders takes this many drive periods. A sequence approaches a cycle
# if its displacements seldom grow, and leaves it if they seldom shrink, at any pace, apart from
# noise and a few exceptions. In a wandering sequence every other displacement grows.
_WATCHED_PERIODS = 128
_SELDOM = 0.1
_NOISE_ALLOWED = 10.0

# The longest way to a cycle: twice the longest initial offset.
_LONGEST_WAY = 4.0

# The last displacement is compared with this many earlier ones, to detect a decline in the noise.
_LOOKS = 4


@inline
def distance(memory: Any, newer: int, older: int) -> float:
    """Largest scaled difference between two stored states; NaN if one of them is NaN."""
    states, i, j = memory.states, newer % REMEMBERED, older % REMEMBERED
    largest, total = 0.0, 0.0
    for component in range(states.shape[1]):
        difference = abs(states[i, component] - states[j, component])
        largest = max(largest, difference)
        total += difference
    return largest + 0.0 * total  # max() drops a NaN, a sum does not


@inline
def displacement(memory: Any, newer: int, older: int) -> tuple[float, float]:
    """Displacement of (x, v) between two stored states."""
    states, i, j = memory.states, newer % REMEMBERED, older % REMEMBERED
    return states[i, 0] - states[j, 0], states[i, 1] - states[j, 1]


@inline
def reach(ratio: float) -> float:
    """Remaining way to the limit in units of the last displacement, with its sign."""
    return ratio / (1.0 - ratio)


@jit
def _remaining_distance(memory: Any, newest: int, lag: int) -> float:
    """Estimated distance of the newest state from the limit, at a `lag`; inf if it grows."""
    moved = distance(memory, newest, newest - lag)
    before = distance(memory, newest - lag, newest - 2 * lag)
    return moved * moved / (before - moved) if moved < before else np.inf


@jit
def _repeats(memory: Any, newest: int, cycle: int, tolerance: float) -> bool:
    """Return whether the orbit closes after `cycle` applications, within `tolerance` of its limit.

    A ratio of contraction measured above the noise gives the remaining distance. Otherwise the
    estimates at all lags for which the sequence is long enough must agree: noise can falsify a
    short one, a fast transient a long one. No estimate is necessary for a sequence that repeats to
    a small fraction of the tolerance, or does not contract but stays within a larger fraction for
    long.
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
    """Return whether the last displacement is as short as the measured ratio predicts.

    The ratio may belong to a fast mode that has decayed, and hide a slow mode that still drifts.
    """
    if 2 * cycle > newest:
        return True
    step = distance(memory, newest, newest - cycle)
    before = distance(memory, newest - cycle, newest - 2 * cycle)
    return step <= abs(memory.ratios[cycle - 1]) * before + _DRIFT * tolerance


@jit
def _quiet(memory: Any, newest: int, cycle: int, tolerance: float) -> bool:
    """Return whether the last 16 cycles stayed within a small part of the tolerance without drift.

    With a drift, all lags together would reach twice as far as the shorter half of them.
    """
    lags = min(_LAGS, (REMEMBERED - 1) // cycle)
    if newest < lags * cycle:
        return False
    near = _farthest(memory, newest, cycle, lags // 2)
    far = _farthest(memory, newest, cycle, lags)
    return far <= _QUIET * tolerance and near >= _DRIFTLESS * far


@jit
def _farthest(memory: Any, newest: int, cycle: int, lags: int) -> float:
    """Largest distance of the newest state from those up to `lags` cycles before; NaN counts."""
    farthest = 0.0
    for lag in range(cycle, lags * cycle + 1, cycle):
        away = distance(memory, newest, newest - lag)
        if not away <= farthest:
            farthest = away
    return farthest


@jit
def closing_cycle(memory: Any, newest: int, tolerance: float) -> int:
    """Smallest number of applications after which the orbit closes; 0 if it does not close yet."""
    for cycle in range(1, memory.longest_cycle + 1):
        if _repeats(memory, newest, cycle, tolerance):
            shorter = _indistinct_cycle(memory, newest, cycle, tolerance)
            if shorter == cycle or cycle <= _SHORT_PERIODS * memory.per_period:
                return shorter
    return 0


@jit
def _indistinct_cycle(memory: Any, newest: int, cycle: int, tolerance: float) -> int:
    """Shortest part of a cycle that nearly closes too, or the cycle itself."""
    for shorter in range(1, cycle):
        close = distance(memory, newest, newest - shorter) <= _INDISTINCT * tolerance
        if cycle % shorter == 0 and close:
            return shorter
    return cycle


@jit
def stalled(memory: Any, newest: int, tolerance: float) -> bool:
    """Return whether a sequence near its limit no longer approaches it.

    The map of an adaptive method has jumps of the order of its tolerance, where the pattern of
    accepted steps changes. If the orbit attracts slowly, these jumps dominate: the sequence wanders
    about the limit and never settles.
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
    """Return whether the sequence neither approaches nor leaves a cycle in 128 drive periods.

    The test takes place twice in 128 periods. `noise` is the tolerance of the integrator. If a
    verdict is `due`, the search continues only if the sequence approaches a cycle without
    exception, but not if the sequence leaves a cycle, or stays near one without closing.
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
    """Return whether the sequence approaches the cycle, or leaves it, at any pace.

    Along a line its displacements over `cycle` applications then seldom grew, or seldom shrank. On
    a spiral they grow and shrink in turn, but the areas between them only shrink, or only grow.
    Constant areas prove nothing, because a motion that circles forever has them too.
    """
    rarely_grew, rarely_shrank = _trend(memory, newest, cycle, watched, blur, _SELDOM, _moved)
    if rarely_grew or rarely_shrank:
        return True
    rarely_grew, rarely_shrank = _trend(memory, newest, cycle, watched, blur, _SELDOM, _swept)
    return rarely_grew != rarely_shrank


@jit
def _approaches(memory: Any, newest: int, cycle: int, watched: int, blur: float) -> bool:
    """Return whether the sequence has approached the cycle all the time.

    A weakly damped film with a kick every forty periods does so most of the time. A geometric
    approach over so many applications must have become slow: if each step covers a fraction 1 - r
    of the remaining way, the nth step of a way w is w (1 - r) r^n, which is below w/(e n) for any
    r.
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
    """Return whether displacements at a few times become shorter each time, unlike noise."""
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
    """Return whether `extent` never grew, and whether it never shrank, by more than its noise.

    A fraction of `exceptions` is allowed.
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
    """Length of the displacement over `cycle` applications, and its noise."""
    return distance(memory, newer, newer - cycle), blur


@jit
def _swept(memory: Any, newer: int, cycle: int, blur: float) -> tuple[float, float]:
    """Area in (x, v) between the last two displacements, and its noise.

    A linear map multiplies it by its determinant, for any shape of spiral.
    """
    last = displacement(memory, newer, newer - cycle)
    before = displacement(memory, newer - cycle, newer - 2 * cycle)
    longest = max(abs(last[0]), abs(last[1]), abs(before[0]), abs(before[1]))
    return abs(last[0] * before[1] - last[1] * before[0]), blur * longest
