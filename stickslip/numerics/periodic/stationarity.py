"""When does the orbit of a periodically driven system repeat? The stroboscopic sequence judged.

A stroboscopic state is the state at the end of a drive period. The sequence may converge with a
ratio of 0.99 a period, so the last difference says little: what counts is the remaining distance
to the limit. For a geometric sequence seen at a lag, with D1 the newest displacement over the
lag and D0 the one before, it is D1^2/(D0 - D1) (Aitken). Long lags make the estimate firm where
the differences themselves are near the noise of the integrator.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.numerics.adaptive import OK
from stickslip.numerics.linear import Vector
from stickslip.status import Status

NOT_STATIONARY = int(Status.NOT_STATIONARY)

LONGEST_CYCLE = 8
"""Orbits that close after 1 to this many drive periods are recognised."""

_LAGS = 16
_REMEMBERED = 2 * _LAGS * LONGEST_CYCLE + 1

# A difference this small a part of the tolerance cannot hide a drift that matters: with a ratio
# of 0.999 a period it leaves one tolerance to go.
_NEGLIGIBLE = 1e-3

# Staying within this part of the tolerance for 16 cycles bounds the drift of a noisy sequence: with
# a ratio of 0.99 a period it leaves one tolerance to go.
_QUIET = 0.2
_DRIFTLESS = 0.7

# The verdict must hold this many periods in a row: fast transients can mimic it once.
_CONFIRMATIONS = 2

# Cycles closer together than this many tolerances are one.
_INDISTINCT = 10.0


@inline
def _distance(states: np.ndarray, newer: int, older: int) -> float:
    """Largest scaled difference between two remembered stroboscopic states."""
    i, j = newer % _REMEMBERED, older % _REMEMBERED
    largest, total = 0.0, 0.0
    for component in range(3):
        difference = abs(states[i, component] - states[j, component])
        largest = max(largest, difference)
        total += difference
    return largest + 0.0 * total  # max() drops a NaN, a sum does not


@jit
def remaining_distance(states: np.ndarray, newest: int, lag: int) -> float:
    """Estimated distance of the newest state from the limit, seen at `lag`; inf if it grows."""
    moved = _distance(states, newest, newest - lag)
    before = _distance(states, newest - lag, newest - 2 * lag)
    return moved * moved / (before - moved) if moved < before else np.inf


@jit
def _repeats(states: np.ndarray, newest: int, cycle: int, tolerance: float) -> bool:
    """Whether the orbit closes after `cycle` periods and is within `tolerance` of its limit.

    Every lag that the sequence is long enough for must say so: a short one can be deceived by
    noise, a long one by a fast transient. A sequence that repeats to a small part of the
    tolerance, or does not contract but stays within a larger part for long, has nothing left to
    estimate.
    """
    if cycle > newest:
        return False
    step = _distance(states, newest, newest - cycle)
    if not step <= tolerance:
        return False
    if step <= _NEGLIGIBLE * tolerance:
        return True
    lag, farthest = cycle, 0.0 if 2 * cycle <= newest else np.inf
    while lag <= _LAGS * cycle and 2 * lag <= newest:
        farthest = max(farthest, remaining_distance(states, newest, lag))
        lag *= 2
    noisy = farthest == np.inf and newest > 2 * cycle
    return farthest <= tolerance or (noisy and _quiet(states, newest, cycle, tolerance))


@jit
def _quiet(states: np.ndarray, newest: int, cycle: int, tolerance: float) -> bool:
    """Whether the last 16 cycles wander, without a drift, in a small part of the tolerance.

    With a drift the later half of the lags reaches twice as far as the earlier half.
    """
    if newest < _LAGS * cycle:
        return False
    near = _reach(states, newest, cycle, _LAGS // 2)
    far = _reach(states, newest, cycle, _LAGS)
    return far <= _QUIET * tolerance and near >= _DRIFTLESS * far


@jit
def _reach(states: np.ndarray, newest: int, cycle: int, lags: int) -> float:
    """Largest distance of the newest state from those of so many cycles before; NaN counts."""
    farthest = 0.0
    for lag in range(cycle, lags * cycle + 1, cycle):
        distance = _distance(states, newest, newest - lag)
        if not distance <= farthest:
            farthest = distance
    return farthest


@jit
def closing_cycle(states: np.ndarray, newest: int, tolerance: float) -> int:
    """Smallest number of periods after which the orbit closes; 0 where it does not yet.

    `states` is the ring of remembered states (257, 3), scaled so that `tolerance` applies to each
    component; `newest` counts the periods, the start being number 0.
    """
    for cycle in range(1, LONGEST_CYCLE + 1):
        if _repeats(states, newest, cycle, tolerance):
            for shorter in range(1, cycle):
                close = _distance(states, newest, newest - shorter) <= _INDISTINCT * tolerance
                if cycle % shorter == 0 and close:
                    return shorter
            return cycle
    return 0


def make_settle(period_map: Callable[..., Any], scaled: Callable[..., Vector]) -> Any:
    """The search for the stationary orbit by plain iteration of `period_map`.

    `period_map(p, settings, y, memory, budget, record)` gives (y, memory, steps, status) after one
    drive period; `scaled(p, y)` the components by which states are compared.

    The search maps (p, settings, y, memory, budget, record) to (y, memory, cycle, periods, steps,
    status). `settings` has `stationary_rtol` and `max_periods`.
    """

    @jit
    def settle(
        p: Any, settings: Any, y: Vector, memory: float, budget: int, record: Any
    ) -> tuple[Vector, float, int, int, int, int]:
        states = np.empty((_REMEMBERED, 3))
        states[0] = scaled(p, y)
        steps, held, previous = 0, 0, 0
        for period in range(1, settings.max_periods + 1):
            y, memory, used, status = period_map(p, settings, y, memory, budget - steps, record)
            steps += used
            if status != OK:
                return y, memory, 0, period, steps, status
            states[period % _REMEMBERED] = scaled(p, y)
            cycle = closing_cycle(states, period, settings.stationary_rtol)
            held = held + 1 if cycle > 0 and cycle == previous else min(cycle, 1)
            previous = cycle
            if held >= _CONFIRMATIONS:
                return y, memory, cycle, period, steps, OK
        return y, memory, 0, settings.max_periods, steps, NOT_STATIONARY

    return settle
