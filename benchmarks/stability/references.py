"""500 random points against plain iteration by the scalar drive at 1e-10, stored in the tests."""

from __future__ import annotations

import csv
from typing import Any

import numpy as np
from shared.points import (
    AMPLITUDES,
    DESCRIPTION,
    column,
    description,
    error_bars,
    good,
    orbits,
    worse_errors,
)

from stability.reference_orbits import PATH
from stickslip.options import Options
from stickslip.parameters import Parameters

_RESOLVED = 1e-9  # what the references are good for


def run(quick: bool) -> dict[str, Any]:
    """Count wrong orbits at the default, and measure how the stated errors bound the true."""
    with PATH.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))[:: 25 if quick else 1]
    points = np.array(
        [Parameters(**{name: float(row[name]) for name in DESCRIPTION}) for row in rows]
    )
    exact = np.array([[float(row[name]) for name in AMPLITUDES] for row in rows])
    closed = np.array([int(row["orbit_periods"]) > 0 for row in rows])
    results = orbits(points, Options())
    both = closed & good(results)
    true = worse_errors(points, results, exact)
    stated = column(results, "amplitude_error")
    cycles = np.array([int(row["orbit_periods"]) for row in rows])
    wrong = both & (true > 100.0 * stated + 1e-4)
    return {
        "points": len(points),
        "closed": int(closed.sum()),
        "ok": int(good(results).sum()),
        "other_period": int((both & (cycles != column(results, "orbit_periods"))).sum()),
        "wrong": [
            description(points[i], true=float(true[i]), stated=float(stated[i]))
            for i in np.flatnonzero(wrong)
        ],
        **error_bars(points, results, exact, both, _RESOLVED),
    }
