"""Kinds of motion as whole numbers: the regime alone, or with the counts of the orbit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import RESULTS
from sweeps.borders.bisection import NO_KIND

Kind = Literal["regime", "orbit"]

# How many bits of a number each part has, the last one lowest: the order is that of the regimes.
_BITS = {"regime": 8, "orbit_periods": 16, "melting_count": 31}

PARTS: dict[str, tuple[str, ...]] = {"regime": ("regime",), "orbit": tuple(_BITS)}
"""The result variables in which motions of different kinds differ."""

NEEDED = ("status", "regime", "orbit_periods", "melting_count")
"""The result variables that tell the kind of a motion."""

_RESULTS = [status for status in Status if status.is_result]


def numbered(values: Callable[[str], NDArray[np.generic]], kind: Kind) -> NDArray[np.int64]:
    """Return the numbers of kinds of motion, `NO_KIND` of points without a result.

    `values` gives a result variable, in any shape. Chance decides how often a film melts while an
    aperiodic motion is watched: its counts are left out.
    """
    regime = values("regime").astype(np.int64)
    known = np.isin(values("status"), _RESULTS) & (regime != RESULTS["regime"].missing)
    numbers = np.zeros(regime.shape, dtype=np.int64)
    for name, bits in _BITS.items():
        counts = name == "regime" or (kind == "orbit" and regime != Regime.APERIODIC)
        part = np.where(known & counts, values(name), 0).astype(np.int64)
        numbers = (numbers << bits) + part
    return np.where(known, numbers, NO_KIND)


def part_of(numbers: NDArray[np.int64], name: str) -> NDArray[np.int64]:
    """Return the regimes or the counts that kinds of these numbers have."""
    later = list(_BITS)[list(_BITS).index(name) + 1 :]
    return (numbers >> sum(_BITS[other] for other in later)) % (1 << _BITS[name])
