"""500 random points against plain iteration by the scalar integrator at 1e-10, from the tests."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from shared.points import AMPLITUDES, DESCRIPTION, descriptions, orbits

from stickslip.parameters import Parameters

_TABLE = Path(__file__).parents[2] / "tests" / "golden" / "random_orbits.csv"
_RESOLVED = 1e-9  # what the references are good for


def run(quick: bool) -> dict[str, Any]:
    """Count wrong orbits at the default, and measure how the stated errors bound the true."""
    with _TABLE.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))[:: 25 if quick else 1]
    columns = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    points = np.array(
        [Parameters(**{name: float(row[name]) for name in DESCRIPTION}) for row in rows]
    )
    exact, cycles = np.stack([columns[name] for name in AMPLITUDES], 1), columns["orbit_periods"]
    found = orbits(points)
    both = (cycles > 0) & found.ok
    true, stated = found.errors(exact), found.amplitude_error
    return {
        "points": len(points),
        "closed": int((cycles > 0).sum()),
        "ok": int(found.ok.sum()),
        "other_period": int((both & (cycles != found.orbit_periods)).sum()),
        "wrong": descriptions(
            points, both & (true > 100.0 * stated + 1e-4), true=true, stated=stated
        ),
        **found.error_bars(exact, both, _RESOLVED),
    }
