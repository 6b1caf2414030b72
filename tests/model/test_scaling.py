"""The model in its own units: the same equations, exactly scaled and mirrored."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stickslip.model import rhs as model
from stickslip.model import scaling
from stickslip.parameters import Parameters, ParameterValues

INDICES = [-2 / 3, -0.5, 0.0, 0.3, 2 / 3]


def random_parameters(rng: np.random.Generator, gamma: float) -> Parameters:
    def around(value: float) -> float:
        return value * 10.0 ** rng.uniform(-1, 1)

    return Parameters(
        temperature=rng.uniform(100.0, 350.0),
        viscosity_coefficient=around(5e4),
        spring_stiffness=around(3e3),
        rheological_index=gamma,
        angular_frequency=around(10.0),
        drive_amplitude=around(0.8e-6) * rng.choice([-1.0, 1.0]),
        block_mass=around(0.4),
        film_thickness=around(1e-9),
        strain_relaxation_time=around(1e-8),
        contact_area=around(0.6e-9),
        kinetic_coefficient=around(100.0),
        thermal_coefficient=around(0.95),
        critical_temperature=rng.uniform(200.0, 350.0),
        elastic_coefficient=around(4e12),
        cubic_coefficient=around(230.0),
        quartic_coefficient=around(850.0),
        noise_intensity=10.0 ** rng.uniform(-24, -12),
    )


def own(p: ParameterValues) -> ParameterValues:
    """The parameters in their own units, as the model's functions take them."""
    q = scaling.reduced(p)
    return scaling.with_gamma(q, q.gamma)


@pytest.mark.parametrize("gamma", INDICES)
def test_the_reduced_right_hand_side_is_the_original_in_other_units(gamma: float) -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        p = random_parameters(rng, gamma)
        unit, q, omega = scaling.units_of(p), own(p), p.angular_frequency
        y = rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), rng.uniform(-30.0, 0.5)
        t, u_s = rng.uniform(0.0, 2 * math.pi), rng.choice([0.0, 1e-6, 1e-3])
        reduced = np.array(model.rhs(q, t, y, u_s))
        state = y[0] * unit.length, y[1] * unit.speed, y[2]
        original = np.array(model.rhs(p, t / omega, state, u_s * abs(unit.speed)))
        scaled = original / [unit.speed, unit.speed * omega, omega]
        # Each sum to 1e-13 of its largest term; what is lost in the slip -sin t - v by cancelling,
        # a stress that is as steep as a cube root may lose several times.
        slip = -math.sin(t) - y[1]
        phi = math.exp(y[2])
        force = abs(model.stress_and_force(q, slip, phi)[1])
        melting = (
            abs(q.temperature) + q.elastic_coefficient * (slip * q.strain_relaxation_time) ** 2
        )
        solid = q.cubic_coefficient * phi + q.quartic_coefficient * phi * phi
        terms = [
            1.0,
            force + 2 * q.spring_stiffness * abs(y[0]),
            melting + solid + q.noise_intensity / (phi * phi),
        ]
        lost = 1 + 1e-2 / abs(slip)
        assert np.all(np.abs(reduced - scaled) <= 1e-13 * lost * np.abs(terms))


@pytest.mark.parametrize("gamma", INDICES)
def test_the_reduced_jacobian_is_the_original_in_other_units(gamma: float) -> None:
    rng = np.random.default_rng(6)
    for _ in range(50):
        p = random_parameters(rng, gamma)
        unit, q, omega = scaling.units_of(p), own(p), p.angular_frequency
        y = rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), rng.uniform(-30.0, 0.5)
        t = rng.uniform(0.0, 2 * math.pi)
        if abs(math.sin(t) + y[1]) < 0.1:
            continue
        state = y[0] * unit.length, y[1] * unit.speed, y[2]
        reduced = np.array(model.jacobian(q, t, y, 1e-6))
        original = np.array(model.jacobian(p, t / omega, state, 1e-6 * abs(unit.speed)))
        sizes = np.array([unit.length, unit.speed, 1.0])
        original[:3] *= sizes[None, :] / sizes[:, None] / omega
        original[3] /= sizes * omega**2
        np.testing.assert_allclose(reduced, original, rtol=1e-11, atol=1e-300)


def test_stress_and_force_come_back_from_their_units() -> None:
    rng = np.random.default_rng(7)
    for gamma in INDICES:
        p = random_parameters(rng, gamma)
        unit, u, phi = scaling.units_of(p), rng.uniform(0.1, 1.0), 0.4
        stress, force = model.stress_and_force(own(p), u, phi)
        expected = model.stress_and_force(p, u * unit.speed, phi)
        assert (stress * unit.stress, force * unit.force) == pytest.approx(expected, rel=1e-13)


def test_a_mirrored_drive_has_mirrored_units_and_the_same_reduced_parameters() -> None:
    for gamma in INDICES:
        p = random_parameters(np.random.default_rng(8), gamma)
        other = p._replace(drive_amplitude=-p.drive_amplitude)
        assert scaling.reduced(other) == scaling.reduced(p)
        assert scaling.units_of(other) == tuple(-unit for unit in scaling.units_of(p))


SCALINGS = [
    ("drive_amplitude", "film_thickness", "contact_area"),
    ("block_mass", "spring_stiffness", "contact_area"),
]


@pytest.mark.parametrize("names", SCALINGS, ids=str)
@pytest.mark.parametrize("gamma", INDICES)
def test_scalings_by_two_leave_the_reduced_parameters_bit_for_bit(
    gamma: float, names: tuple[str, ...]
) -> None:
    rng = np.random.default_rng(9)
    for _ in range(50):
        p = random_parameters(rng, gamma)
        scaled = p._replace(**{name: 2.0 * getattr(p, name) for name in names})
        assert scaling.reduced(scaled) == scaling.reduced(p)


@pytest.mark.parametrize("gamma", INDICES)
def test_a_scaling_of_energy_by_two_leaves_the_reduced_parameters_bit_for_bit(
    gamma: float,
) -> None:
    rng = np.random.default_rng(10)
    doubled = ("thermal", "elastic", "cubic", "quartic", "viscosity")
    for _ in range(50):
        p = random_parameters(rng, gamma)
        changes = {
            f"{name}_coefficient": 2.0 * getattr(p, f"{name}_coefficient") for name in doubled
        }
        changes |= {
            "contact_area": 0.5 * p.contact_area,
            "kinetic_coefficient": 0.5 * p.kinetic_coefficient,
        }
        assert scaling.reduced(p._replace(**changes)) == scaling.reduced(p)


def test_a_scaling_of_time_by_two_leaves_the_reduced_parameters_but_for_the_fluids_power() -> None:
    rng = np.random.default_rng(11)
    for _ in range(50):
        p = random_parameters(rng, 0.0)
        faster = p._replace(
            angular_frequency=2.0 * p.angular_frequency,
            strain_relaxation_time=0.5 * p.strain_relaxation_time,
            kinetic_coefficient=2.0 * p.kinetic_coefficient,
            noise_intensity=2.0 * p.noise_intensity,
            spring_stiffness=4.0 * p.spring_stiffness,
            contact_area=4.0 * p.contact_area,
            viscosity_coefficient=0.5 * p.viscosity_coefficient,
        )
        assert scaling.reduced(faster) == scaling.reduced(p)


def test_the_fixed_ones_are_ones() -> None:
    q = own(Parameters())
    assert q.drive_amplitude == q.angular_frequency == q.block_mass == 1.0
    assert q.film_thickness == q.kinetic_coefficient == 1.0
    assert len(scaling.Reduced._fields) == 10
