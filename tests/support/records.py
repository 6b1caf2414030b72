"""Records of orbits that break nothing, for tests of what is made of them."""

from __future__ import annotations

import numpy as np

from stickslip.measure.accumulate import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    FIRST_PHASE,
    FIRST_SOLID,
    FORCE_MAX,
    FORCE_MIN,
    LAST_PHASE,
    LAST_SOLID,
    MELTINGS,
    PHI_MAX,
    RECORD,
    SOLID_CHANGES,
    SOLID_TIME,
    STRESS_MAX,
    STRESS_MIN,
    UNSEEN,
    UNSEEN_TIME,
)
from stickslip.measure.results import (
    RecordUnits,
)

SI = RecordUnits(1.0, 1.0, 1.0, 1.0, 1.0)


def record_of(**slots: float) -> np.ndarray:
    """A record of an orbit that breaks nothing, with some slots changed."""
    found = {
        "STRESS_MAX": 3e6, "STRESS_MIN": -1e6, "FORCE_MAX": 2e-3, "FORCE_MIN": -1e-3,
        "BLOCK_WORK": 0.0, "ABSOLUTE_WORK": 1e-8, "PHI_MAX": 0.6,
        "MELTINGS": 0.0, "SOLID_TIME": 0.0, "UNSEEN_TIME": 0.0,
        "FIRST_PHASE": UNSEEN, "LAST_PHASE": UNSEEN,
        "SOLID_CHANGES": 0.0, "FIRST_SOLID": UNSEEN, "LAST_SOLID": UNSEEN,
    } | slots  # fmt: skip
    record = np.empty(RECORD)
    for name, value in found.items():
        record[SLOTS[name]] = value
    return record


SLOTS = {
    "STRESS_MAX": STRESS_MAX, "STRESS_MIN": STRESS_MIN, "FORCE_MAX": FORCE_MAX,
    "FORCE_MIN": FORCE_MIN, "BLOCK_WORK": BLOCK_WORK, "ABSOLUTE_WORK": ABSOLUTE_WORK,
    "PHI_MAX": PHI_MAX, "MELTINGS": MELTINGS, "SOLID_TIME": SOLID_TIME, "UNSEEN_TIME": UNSEEN_TIME,
    "FIRST_PHASE": FIRST_PHASE, "LAST_PHASE": LAST_PHASE,
    "SOLID_CHANGES": SOLID_CHANGES, "FIRST_SOLID": FIRST_SOLID, "LAST_SOLID": LAST_SOLID,
}  # fmt: skip
