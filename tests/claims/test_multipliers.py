"""Floquet multipliers agree with central differences at any tolerance."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support.points import orbits
from support.reference import map_of_displacements

from stickslip import Parameters

# This film freezes at a moment that displacements of a thousandth of the drive change.
CURVED = Parameters(
    temperature=193.65616,
    viscosity_coefficient=1024.2308,
    spring_stiffness=1570.7179,
    rheological_index=-0.63148182,
    angular_frequency=40.272532,
    drive_amplitude=1.1476071e-06,
    block_mass=0.23851941,
    film_thickness=4.7890836e-10,
    strain_relaxation_time=1.8536977e-09,
    contact_area=1.1666101e-10,
    kinetic_coefficient=324.01525,
    elastic_coefficient=2.43759e12,
    cubic_coefficient=176.67664,
    quartic_coefficient=752.57262,
    noise_intensity=2.0120074e-12,
)

# This liquid crosses the cusp of its law at full speed, where the solvers of the twin are slow. Its
# multiplier and the last one are from `benchmarks/stability/multipliers.py`.
CUSPED = Parameters(
    temperature=296.422,
    viscosity_coefficient=16003.3,
    spring_stiffness=2173.96,
    rheological_index=-0.665729,
    angular_frequency=45.3565,
)

NEWTONIAN = Parameters(temperature=220.0, rheological_index=0.0, angular_frequency=20.0)

# This orbit is not its own mirror image, and has an eigenvalue near -1.
ASYMMETRIC = Parameters(angular_frequency=18.1078)


@cache
def central(p: Parameters) -> float:
    """Return the multiplier by central differences of the slow twin, at the rtol=1e-10 orbit."""
    orbit = orbits(np.array(p)[None], rtol=1e-10, stationary_rtol=1e-10)
    assert orbit.orbit_periods[0] == 1
    eigenvalues = np.linalg.eigvals(map_of_displacements(p, orbit.final[0, :3], 1e-5))
    return float(np.abs(eigenvalues).max())


@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-8])
@pytest.mark.parametrize(
    ("p", "exact"),
    [(CURVED, None), (CUSPED, 0.29143), (NEWTONIAN, None), (ASYMMETRIC, 0.90914)],
    ids=["curved", "cusped", "Newtonian", "asymmetric"],
)
def test_a_multiplier_agrees_with_small_displacements_to_both_sides(
    p: Parameters, exact: float | None, rtol: float
) -> None:
    exact = central(p) if exact is None else exact
    found = orbits(np.array(p)[None], rtol=rtol, stationary_rtol=rtol).floquet_multiplier[0]
    assert found == pytest.approx(exact, abs=rtol**0.5 / (1.0 - exact))
