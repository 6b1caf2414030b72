"""Properties of curves."""

from __future__ import annotations

import numpy as np


def spread(values: np.ndarray) -> float:
    return float(np.ptp(values) / np.max(values))


def falls(values: np.ndarray) -> bool:
    return bool(np.all(np.diff(values) < 0))


def rises(values: np.ndarray) -> bool:
    return bool(np.all(np.diff(values) > 0))
