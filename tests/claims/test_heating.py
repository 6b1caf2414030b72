"""The film stays at the temperature of its walls, by the numbers in docs/decisions/heating.md."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from stickslip import Parameters, simulate

PAGE = Path(__file__).parents[2] / "docs" / "decisions" / "heating.md"

HEAT_CAPACITY = 2e6  # J m-3 K-1
COOLING_TIME = 1e-11  # s, of the borders, which cool more slowly
CONDUCTIVITY = 1.0  # W m-1 K-1, of the blocks
PER_KELVIN = 0.012  # relative change of the stress amplitude, Fig. 7 at 200 K


@pytest.fixture(scope="module")
def dissipation() -> tuple[float, float]:
    """The largest and the mean dissipation per volume [W m-3] over the orbits of Figs. 3 to 5."""
    peaks, means = [], []
    for omega in (10.0, 15.0, 32.0, 38.0):
        p = Parameters(angular_frequency=omega)
        ds = simulate(p, periods=1, start="stationary", samples_per_period=50_000)
        slip = ds.upper_velocity - ds.lower_velocity
        power = ((ds.elastic_stress + ds.viscous_stress) * slip / p.film_thickness).values
        peaks.append(power.max())
        means.append(np.trapezoid(power, ds.elapsed_time) / float(ds.elapsed_time[-1]))
    return max(peaks), max(means)


def walls(dissipation: float) -> float:
    """Return how much warmer [K] the walls are at the contact, in steady heat flow."""
    p = Parameters()
    radius = math.sqrt(p.contact_area / math.pi)
    return dissipation * p.film_thickness * radius / (4.0 * CONDUCTIVITY)


def test_the_film_keeps_the_temperature_of_its_walls(dissipation: tuple[float, float]) -> None:
    peak, mean = dissipation
    film = COOLING_TIME * peak / HEAT_CAPACITY
    assert film * PER_KELVIN < 1e-6
    assert walls(peak) < 0.01
    page = PAGE.read_text("utf-8")
    stated = [float(x) for x in re.findall(r"\b(\d(?:\.\d)?e-?\d+) (?:W m⁻³|K\b|of its)", page)]
    for value in (peak, film, film * PER_KELVIN, walls(peak), walls(mean)):
        assert any(0.8 < value / number < 1.25 for number in stated), (value, stated)
