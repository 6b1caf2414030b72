"""The force of a block that a solid or stiff film locks to the drive: |2K - M omega^2| |X_m|.

Where springs and inertia nearly balance, the force is small and the slip that makes it tiny: an
integrator that knows the velocity of the block to its tolerance knows nothing of it.
"""

from __future__ import annotations

import pytest

from stickslip import Parameters, Status, stationary_orbit

# What the slip itself, some parts in 1e5 of the drive, changes of the closed form.
LAG = 1e-5

BALANCED = [
    {"temperature": 243.0, "viscosity_coefficient": 193385.0, "rheological_index": -0.8,
     "angular_frequency": 31.47, "spring_stiffness": 192.6},
    {"temperature": 162.6426, "viscosity_coefficient": 244973.0, "rheological_index": -2 / 3,
     "angular_frequency": 27.37541, "spring_stiffness": 154.853},
]  # fmt: skip


def closed_form(p: Parameters) -> float:
    """Amplitude of the friction force [N] on a block that moves with the drive (Eq. 3)."""
    inertia = p.block_mass * p.angular_frequency**2
    return abs(2.0 * p.spring_stiffness - inertia) * abs(p.drive_amplitude)


@pytest.mark.parametrize("changes", BALANCED)
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_the_force_of_a_locked_block_is_that_of_springs_and_inertia(
    changes: dict[str, float], rtol: float
) -> None:
    p = Parameters(**changes)
    orbit = stationary_orbit(p, rtol=rtol)
    assert orbit.status is Status.OK
    assert abs(orbit.friction_force_amplitude / closed_form(p) - 1.0) <= LAG
