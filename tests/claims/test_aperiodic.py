"""Orbits that close late or never: recognised, and measured as what they are.

The values are those of other solvers over 2000 drive periods.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.marks import marked
from support.points import orbits

from stickslip import Parameters, Status
from stickslip.regime import Regime

NAMES = ("temperature", "viscosity_coefficient", "spring_stiffness", "rheological_index",
         "angular_frequency")  # fmt: skip

# Exponent a period; mean and deviation of the stress amplitude of single periods [MPa], meltings a
# period.
CHAOTIC = [
    ((205.9, 22802, 2349.9, -2 / 3, 35.874), 3.309, 1.135, 1.39),
    ((151.78, 42088, 3606.9, -0.7822, 33.081), 4.711, 1.986, 0.70),
    ((262.39, 125.43, 5275.6, -0.5, 5.2979), 0.675, 0.027, 1.00),
    ((207.2, 784.25, 2167.4, -2 / 3, 13.929), 0.412, 0.871, 0.18),
]
# Periods after which it closes; highest stress and deviation [MPa], meltings a period.
LONG = [
    ((192.34, 11043, 2470.9, -2 / 3, 17.113), 10, 4.726, 1.748, 1.20),
    ((170.66, 35654, 2661.7, -0.8867, 30.54), 19, 5.966, 1.658, 0.21),
]


def point(values: tuple[float, ...]) -> np.ndarray:
    return np.array(Parameters(**dict(zip(NAMES, values, strict=True))))[None]


@pytest.mark.parametrize(
    ("values", "mean", "deviation", "meltings", "window"),
    [
        (*CHAOTIC[0], 200),
        *marked("stress", [(*row, 200) for row in CHAOTIC[1:]]),
        *marked("stress", [(*row, 2000) for row in CHAOTIC]),
    ],
)
def test_chaos_is_measured_over_a_window(
    values: tuple[float, ...], mean: float, deviation: float, meltings: float, window: int
) -> None:
    found = orbits(point(values), window=window)
    assert (found.status, found.regime) == (Status.APERIODIC, Regime.APERIODIC)
    assert found.orbit_periods == 0
    assert found.lyapunov_exponent > 0.005
    assert np.isnan(found.floquet_multiplier)
    # Three standard errors are stated; the reference has its own, of ten times as many periods.
    stated = found.amplitude_error * found.elastic_stress_amplitude / 3.0
    assert found.elastic_stress_amplitude == pytest.approx(
        mean * 1e6, abs=4.0 * math.hypot(stated[0], stated[0] * math.sqrt(window / 2000))
    )
    assert found.melting_count / window == pytest.approx(meltings, abs=0.1)
    assert found.elastic_stress_amplitude_spread == pytest.approx(deviation * 1e6, rel=0.5)
    assert found.power_balance_error < 1e-6
    assert found.periods_integrated <= 128 + 600 + window


@pytest.mark.parametrize(
    ("values", "periods", "highest", "deviation", "meltings"),
    [LONG[0], *marked("stress", LONG[1:])],
)
def test_an_orbit_that_closes_late_is_periodic(
    values: tuple[float, ...], periods: int, highest: float, deviation: float, meltings: float
) -> None:
    found = orbits(point(values))
    assert (found.status, found.regime) == (Status.OK, Regime.SUBHARMONIC)
    assert found.orbit_periods == periods
    assert found.elastic_stress_max == pytest.approx(highest * 1e6, rel=1e-3)
    assert found.elastic_stress_amplitude_spread == pytest.approx(deviation * 1e6, rel=2e-3)
    assert found.melting_count / periods == pytest.approx(meltings, abs=5e-3)
    assert found.floquet_multiplier < 1.0
    assert np.isnan(found.lyapunov_exponent)


def test_a_slow_spiral_is_followed_to_its_orbit() -> None:
    # A thin liquid film at a high frequency: the free motion of the block dies out in thousands of
    # periods, growing and shrinking by turns. The force is that of 6000 periods of plain iteration.
    p = Parameters(
        temperature=100.0,
        viscosity_coefficient=1e3,
        spring_stiffness=300.0,
        angular_frequency=133.0,
        drive_amplitude=1.70017e-6,
        block_mass=1.25,
        kinetic_coefficient=10.0,
    )
    found = orbits(np.array(p)[None], max_periods=5000)
    assert (found.status, found.orbit_periods) == (Status.OK, 1)
    assert found.floquet_multiplier == pytest.approx(0.9976, abs=3e-4)
    assert found.friction_force_amplitude == pytest.approx(3.65538e-5, rel=2e-6)
