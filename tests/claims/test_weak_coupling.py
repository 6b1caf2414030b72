"""A film that hardly couples the blocks: the lower one oscillates freely, faster than the drive."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import Parameters, Status, simulate, stationary_orbit

# Contacts of 1e-14 m2, which lock the block by a hundredth of a micronewton. About the orbits of
# these the block oscillates more and more.
UNSTABLE = [
    Parameters(
        temperature=235.27367760490068, viscosity_coefficient=2.1639130990976243,
        spring_stiffness=11111.104121125056, rheological_index=-0.3361213117904447,
        angular_frequency=0.912911805995512, drive_amplitude=5.643896270362189e-07,
        contact_area=7.696930291259333e-15,
    ),
    Parameters(
        temperature=226.89126238378236, viscosity_coefficient=0.10521055831649116,
        spring_stiffness=135281.74076725807, rheological_index=0.46676855906811854,
        angular_frequency=2.337304168949199, drive_amplitude=2.2646527091259402e-07,
        contact_area=1.3020315002022645e-14,
    ),
]  # fmt: skip
STATES = [
    (7.842223524771337e-18, -1.6973094433276753e-12, -0.672744700053091),
    (3.5738409537297085e-19, -6.801861047758478e-13, -0.6264100732943534),
]
NAMES = ["pseudoplastic", "dilatant"]

STABLE = [
    Parameters(
        temperature=280.50029237453805, viscosity_coefficient=0.0648498243826171,
        spring_stiffness=200551.45791369514, rheological_index=0.18669576206911442,
        angular_frequency=0.762099854217328, drive_amplitude=1.46847670584908e-07,
        contact_area=3.6433780371303915e-15,
    ),
    Parameters(
        temperature=228.58013800881417, viscosity_coefficient=0.4291397429682408,
        spring_stiffness=5501.219939608028, rheological_index=0.5762824562967247,
        angular_frequency=1.7687209862788602, drive_amplitude=1.311996195692037e-07,
        contact_area=3.9248354324166937e-14,
    ),
]  # fmt: skip


def growth(p: Parameters, state: tuple[float, ...]) -> float:
    """Return the growth in a drive period of a small oscillation about a motion."""
    x, v, phi = state
    push = 1e-5 * p.drive_amplitude * p.angular_frequency
    one, other = (
        simulate(p, periods=3, samples_per_period=1, start=(x, start, phi), rtol=1e-10)
        for start in (v, v + push)
    )
    rate = np.sqrt(2.0 * p.spring_stiffness / p.block_mass)
    apart = np.hypot(
        rate * (other.lower_displacement - one.lower_displacement),
        other.lower_velocity - one.lower_velocity,
    ).values
    return float((apart[-1] / apart[0]) ** (1.0 / 3.0))


@pytest.mark.parametrize(("p", "state"), list(zip(UNSTABLE, STATES, strict=True)), ids=NAMES)
def test_the_block_oscillates_more_and_more_about_an_orbit(
    p: Parameters, state: tuple[float, ...]
) -> None:
    assert growth(p, state) > 1.03


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
@pytest.mark.parametrize("p", UNSTABLE, ids=NAMES)
def test_such_an_orbit_is_no_result(p: Parameters, rtol: float) -> None:
    orbit = stationary_orbit(p, rtol=rtol)
    assert orbit.status == Status.UNSTABLE
    assert np.isnan(orbit.friction_force_amplitude)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
@pytest.mark.parametrize("p", STABLE, ids=["slowly", "quickly"])
def test_the_multiplier_is_the_decay_of_oscillations_that_the_steps_do_not_resolve(
    p: Parameters, rtol: float
) -> None:
    orbit = stationary_orbit(p, rtol=rtol)
    assert orbit.floquet_multiplier == pytest.approx(growth(p, orbit.state), rel=2e-3)
