"""A film that freezes in a short passage of the strain through zero does so at any tolerance.

With a fast drive, or a thin or stiff film, the strain is small enough for freezing only in a small
part of a period. Before and after it the order parameter is at the level of the noise.
"""

from __future__ import annotations

import numpy as np
import pytest
from support.points import orbits

from stickslip import Parameters, Status, simulate, stationary_orbit
from stickslip.regime import Regime

NAMES = (*Parameters._fields[:7], *Parameters._fields[10:14], "noise_intensity")

# Stress amplitudes [Pa] from SciPy's Radau with steps of at most a three-thousandth of a period.
FREEZING = [
    ((43.0523382, 8432.68109, 8110.22063, 0.0, 13.0560192, 9.23463701e-08, 0.37246079,
      7.84230796e-10, 6.9183445e-07, 6.66292244e-11, 75.1857128, 2.4847511e-24), 1.45426e7),
    ((42.7026556, 250.657322, 10296.0875, 0.0, 62.4501088, 5.32360645e-06, 1.4047575,
      1.98030914e-09, 5.53053229e-08, 1.05391628e-09, 3098.34829, 1.79141051e-17), 1.4672e7),
]  # fmt: skip


@pytest.mark.parametrize(("values", "stress"), FREEZING)
@pytest.mark.parametrize("options", [{"rtol": 1e-4}, {"rtol": 1e-5},
                                     {"rtol": 1e-4, "accelerate": False}])  # fmt: skip
def test_a_loose_tolerance_does_not_miss_a_short_passage(values, stress, options) -> None:
    found = stationary_orbit(Parameters(**dict(zip(NAMES, values, strict=True))), **options)
    assert found.status is Status.OK
    assert found.elastic_stress_amplitude == pytest.approx(stress, rel=1e-3)


# Largest stresses [Pa] of the first four periods, from Radau and at tolerances of 1e-8 and 1e-10.
TRAVELLING = [
    ((48.9487816, 55190.8207, 2504.85624, -1 / 3, 69.5072067, 4.45396109e-07, 0.116377727,
      4.13540054e-10, 2.64770466e-06, 6.41709823e-12, 104908.059, 8.35769045e-21), 1.395e7),
    ((233.915322, 0.00360894156, 1776.81443, 1.08548012, 82.321577, 4.52339634e-07, 0.163840139,
      1.9370556e-09, 5.36823341e-06, 7.71084787e-11, 521868.093, 2.30727481e-16), 2.608e6),
    # At 1e-4 the state once became infinite.
    ((233.516726, 69.3335646, 975.441572, -0.081070845, 5.48686869, 2.49195892e-07, 0.844534084,
      1.36343439e-09, 0.000385417425, 7.31246804e-11, 190575.757, 2.3477559e-13), 2.593e6),
]  # fmt: skip


@pytest.mark.parametrize(("values", "stress"), TRAVELLING)
@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_a_trajectory_does_not_miss_it_either(values, stress, rtol) -> None:
    p = Parameters(**dict(zip(NAMES, values, strict=True)))
    ds = simulate(p, periods=4, samples_per_period=20_000, rtol=rtol)
    assert float(np.abs(ds.elastic_stress).max()) == pytest.approx(stress, rel=2e-2)


def _drawn(count: int) -> np.ndarray:
    """Return films with passages of 40 to 150 e-folds over 1e-1 to 1e-5 of the drive's strain."""
    rng, points = np.random.default_rng(2611), []
    for i in range(count):
        T, omega, X_m = rng.uniform(20, 280), rng.uniform(5, 80), 10 ** rng.uniform(-7, -6)
        ratio, growth = 10 ** rng.uniform(1, 5), rng.uniform(40, 150)
        heating = 1.9 * (290 - T)
        tau = ratio * np.sqrt(heating / 4e12) * 1e-9 / (X_m * omega)
        gamma, M, K = (-0.5, 0.0, 2 / 3)[i % 3], 0.3, 10 ** rng.uniform(3, 4)
        force = 0.1 * max(2 * K, M * omega**2) * X_m
        points.append(
            Parameters(
                temperature=T, angular_frequency=omega, drive_amplitude=X_m, block_mass=M,
                spring_stiffness=K, rheological_index=gamma, strain_relaxation_time=tau,
                kinetic_coefficient=0.75 * growth * ratio * omega / heating, contact_area=1e-10,
                viscosity_coefficient=force / 1e-10 / (X_m * omega / 1e-9) ** (gamma + 1),
            )
        )  # fmt: skip
    return np.array(points)


@pytest.mark.stress
@pytest.mark.parametrize("options", [{}, {"strain": "relaxing"}, {"accelerate": False}])
def test_the_regime_of_random_films_does_not_depend_on_the_tolerance(options) -> None:
    points = _drawn(24)
    fine = orbits(points, rtol=1e-8, **options)
    assert np.mean(fine.regime != Regime.LIQUID) > 0.3
    for rtol in (1e-4, 1e-6):
        found = orbits(points, rtol=rtol, **options)
        both = (found.status == Status.OK) & (fine.status == Status.OK)
        assert both.sum() >= 20
        assert np.array_equal(
            found.regime[both] == Regime.LIQUID, fine.regime[both] == Regime.LIQUID
        )
