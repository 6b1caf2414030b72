"""What benchmarks use of the inside of the package, below `stickslip.orbit`: all of it stands here.

So a change of the kernels touches no other benchmark.
"""

from __future__ import annotations

import numpy as np

from stickslip.measure.accumulate import FORCE_MAX, FORCE_MIN, STRESS_MAX, STRESS_MIN
from stickslip.model.state import STATE
from stickslip.options import DEFAULTS

PHYSICS, WIDTH = DEFAULTS.physics, len(STATE)


def amplitudes_of(records: np.ndarray) -> np.ndarray:
    """Return amplitudes of stress and force (n, 2) of records of whole orbits (n, RECORD)."""
    return 0.5 * (records[:, [STRESS_MAX, FORCE_MAX]] - records[:, [STRESS_MIN, FORCE_MIN]])
