"""Random points end on the orbits of plain iteration, within the stated errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from support.points import amplitude_errors, orbits

from stickslip import Parameters, Status

PATH = Path(__file__).parents[1] / "golden" / "random_orbits.csv"


@pytest.mark.slow
def test_random_points_are_on_their_orbits_within_the_stated_errors() -> None:
    table = pd.read_csv(PATH, dtype=str).astype(float)  # exact in the last bit
    closed = table[table.orbit_periods > 0]
    given = closed[[name for name in Parameters._fields if name in closed]]
    points = np.array([Parameters(**row) for row in given.to_dict("records")])
    found = orbits(points)
    assert np.all(found.status == Status.OK)
    np.testing.assert_array_equal(found.orbit_periods, closed.orbit_periods)
    np.testing.assert_array_equal(found.melting_count, closed.melting_count)
    stress, force = closed.elastic_stress_amplitude, closed.friction_force_amplitude
    true = amplitude_errors(found, points, stress.to_numpy(), force.to_numpy())
    # 1e-8 is the accuracy of the references.
    assert np.mean(true <= found.amplitude_error + 1e-8) >= 0.99
    assert true.max() <= 1e-5
