"""Records of plausible orbits, for tests of the results from them."""

from __future__ import annotations

import numpy as np

from stickslip.measure import accumulate
from stickslip.measure.accumulate import RECORD, UNSEEN
from stickslip.measure.results import RecordUnits

SI = RecordUnits(1.0, 1.0, 1.0, 1.0)


def record_of(**slots: float) -> np.ndarray:
    """Return the record of a plausible orbit, with some slots changed."""
    found = {
        "STRESS_MAX": 3e6, "STRESS_MIN": -1e6, "FORCE_MAX": 2e-3, "FORCE_MIN": -1e-3,
        "BLOCK_WORK": 0.0, "LOSS": 6e-9, "ABSOLUTE_WORK": 1e-8, "PHI_MAX": 0.6,
        "MELTINGS": 0.0, "SOLID_TIME": 0.0, "UNSEEN_TIME": 0.0,
        "FIRST_PHASE": UNSEEN, "LAST_PHASE": UNSEEN,
        "SOLID_CHANGES": 0.0, "FIRST_SOLID": UNSEEN, "LAST_SOLID": UNSEEN,
        "ELAPSED": 2.0, "IN_PHASE": 2e-4, "OUT_OF_PHASE": 1e-3,
        "MOTION_IN_PHASE": 2e-4, "MOTION_OUT_OF_PHASE": 1e-3, "SQUARED_FORCE": 2e-6,
        "FORCE_SIZE": 1.6e-3,
    } | slots  # fmt: skip
    assert len(found) == RECORD, "a slot of the record has no value here"
    record = np.empty(RECORD)
    for name, value in found.items():
        record[getattr(accumulate, name)] = value
    return record
