"""Random points end on the orbits of plain iteration, with errors that are bounded as stated."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from support.points import error_scales, orbits

from stickslip import Parameters, Status

PATH = Path(__file__).parents[1] / "golden" / "random_orbits.csv"
ROWS = [
    {name: float(value) for name, value in row.items()}
    for row in csv.DictReader(PATH.read_text("utf-8").splitlines())
]
CLOSED = [row for row in ROWS if row["orbit_periods"] > 0]


def compared(rows: list[dict[str, float]]) -> tuple[np.ndarray, np.ndarray]:
    """True and stated errors (n,) of points that are all ok and of the right period."""
    points = np.array(
        [Parameters(**{n: v for n, v in row.items() if n in Parameters._fields}) for row in rows]
    )
    found = orbits(points)
    assert np.all(found.status == Status.OK)
    np.testing.assert_array_equal(found.orbit_periods, [row["orbit_periods"] for row in rows])
    np.testing.assert_array_equal(found.melting_count, [row["melting_count"] for row in rows])
    errors = []
    for name, floor in zip(
        ("elastic_stress_amplitude", "friction_force_amplitude"), error_scales(points), strict=True
    ):
        exact = np.array([row[name] for row in rows])
        errors.append(abs(getattr(found, name) - exact) / np.maximum(exact, floor))
    return np.maximum(*errors), found.amplitude_error


@pytest.mark.slow
def test_random_points_are_on_their_orbits_with_errors_as_stated() -> None:
    true, stated = compared(CLOSED)
    # 1e-8 is what the references are good for.
    assert np.mean(true <= stated + 1e-8) >= 0.99
    assert true.max() <= 1e-5
