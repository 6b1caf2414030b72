"""The model in its own units: the same equations, exactly scaled and mirrored."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.extra_parameters import UNITS, VALUE, extra_values
from support.parameters import random_parameters
from support.reduced import reduced_of

from stickslip.model import film, scaling
from stickslip.model.models import model_of
from stickslip.model.rhs import Equations
from stickslip.options import FRICTION_LAWS, Physics
from stickslip.parameters import Parameters, ParameterValues
from stickslip.variables import PARAMETERS

INDICES = [-2 / 3, -0.5, 0.0, 0.3, 2 / 3]


@pytest.fixture(scope="module", params=FRICTION_LAWS)
def law(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def model(law: str) -> Equations:
    return model_of(Physics(law)).equations


def own(law: str, p: ParameterValues) -> ParameterValues:
    """The parameters in their own units, as the model's functions take them."""
    return scaling.model_values(None)(reduced_of(p, Physics(law)))


@pytest.mark.parametrize("gamma", INDICES)
def test_the_reduced_right_hand_side_is_the_original_in_other_units(
    law: str, model: Equations, gamma: float
) -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        p = random_parameters(rng, gamma)
        unit, q, omega = scaling.units_of(p), own(law, p), p.angular_frequency
        y = rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), rng.uniform(-30.0, 0.5)
        t, u_s = rng.uniform(0.0, 2 * math.pi), rng.choice([0.0, 1e-6, 1e-3])
        reduced = np.array(model.rhs(q, t, y, u_s))
        state = y[0] * unit.length, y[1] * unit.speed, y[2]
        original = np.array(model.rhs(p, t / omega, state, u_s * abs(unit.speed)))
        scaled = original / [unit.speed, unit.speed * omega, omega]
        # Each sum to 1e-13 of its largest term.
        slip = y[1]
        phi = math.exp(y[2])
        force = abs(model.exact(q, slip, phi)[1])
        melting = (
            max(q.temperature, q.critical_temperature)
            + q.elastic_coefficient * (slip * q.strain_relaxation_time) ** 2
        )
        solid = q.cubic_coefficient * phi + q.quartic_coefficient * phi * phi
        terms = [
            1.0,
            force + 2 * q.spring_stiffness * abs(y[0]),
            melting + solid + q.noise_intensity / (phi * phi),
        ]
        assert np.all(np.abs(reduced - scaled) <= 1e-13 * np.abs(terms))


@pytest.mark.parametrize("gamma", INDICES)
def test_the_reduced_jacobian_is_the_original_in_other_units(
    law: str, model: Equations, gamma: float
) -> None:
    rng = np.random.default_rng(6)
    for _ in range(50):
        p = random_parameters(rng, gamma)
        unit, q, omega = scaling.units_of(p), own(law, p), p.angular_frequency
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


def test_stress_and_force_come_back_from_their_units(law: str, model: Equations) -> None:
    rng = np.random.default_rng(7)
    for gamma in INDICES:
        p = random_parameters(rng, gamma)
        unit, u, phi = scaling.units_of(p), rng.uniform(0.1, 1.0), 0.4
        stress, force = model.exact(own(law, p), u, phi)
        expected = model.exact(p, u * unit.speed, phi)
        assert (stress * unit.stress, force * unit.force) == pytest.approx(
            expected, rel=1e-13, abs=0
        )


def test_a_mirrored_drive_has_mirrored_units_and_the_same_reduced_parameters(law: str) -> None:
    for gamma in INDICES:
        p = random_parameters(np.random.default_rng(8), gamma)
        other = p._replace(drive_amplitude=-p.drive_amplitude)
        assert reduced_of(other, Physics(law)) == reduced_of(p, Physics(law))
        units = scaling.units_of(p)
        assert units.time == 1 / p.angular_frequency
        turned = ("length", "speed", "force", "strain", "stress")
        assert scaling.units_of(other) == tuple(
            -unit if name in turned else unit for name, unit in units._asdict().items()
        )


def is_old(name: str) -> bool:
    return name not in PARAMETERS or PARAMETERS[name].in_paper


def reduced(p: Parameters) -> dict[str, float]:
    """The paper's reduced parameters; how a scaling changes others is not known here."""
    q = reduced_of(p, Physics("power-law"))
    return {name: x for name, x in q._asdict().items() if is_old(name)}


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
        assert reduced(scaled) == reduced(p)


@pytest.mark.parametrize("gamma", INDICES)
def test_a_scaling_of_energy_by_two_leaves_the_reduced_parameters_bit_for_bit(gamma: float) -> None:
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
        assert reduced(p._replace(**changes)) == reduced(p)


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
        assert reduced(faster) == reduced(p)


def test_the_fixed_ones_are_ones(law: str) -> None:
    q = own(law, Parameters())
    assert q.drive_amplitude == q.angular_frequency == q.block_mass == 1.0
    assert q.film_thickness == q.kinetic_coefficient == 1.0


# --- what the tables say -------------------------------------------------------------------------


def test_every_parameter_is_kept_or_has_one_value() -> None:
    assert {*scaling.KEPT, *scaling.LITERALS} == set(PARAMETERS)
    assert scaling.Reduced._fields == (*scaling.KEPT, *scaling.DERIVED)
    assert not set(scaling.KEPT) & set(scaling.LITERALS)


def test_parameters_with_one_value_are_literals_whatever_the_point(law: str) -> None:
    for gamma in INDICES:
        values = own(law, random_parameters(np.random.default_rng(3), gamma))._asdict()
        assert {name: values[name] for name in scaling.LITERALS} == scaling.LITERALS
        assert values["rheological_index"] == gamma


def test_the_rheological_index_can_be_a_literal_too(law: str) -> None:
    q = reduced_of(Parameters(rheological_index=0.3), Physics(law))
    assert scaling.model_values(-2 / 3)(q).rheological_index == -2 / 3
    assert scaling.model_values(-2 / 3)(q)[:3] == scaling.model_values(None)(q)[:3]


def test_the_highest_coefficients_are_literals_where_they_are_not_needed(law: str) -> None:
    p = Parameters(quintic_coefficient=3.0, sextic_coefficient=5.0)
    q = reduced_of(p, Physics(law))
    low, high = (scaling.model_values(None, higher=higher)(q) for higher in (False, True))
    assert (low.quintic_coefficient, low.sextic_coefficient) == (0.0, 0.0)
    assert high.quintic_coefficient == 30.0  # delta/omega
    assert high.sextic_coefficient == 50.0


def test_temperatures_are_scaled_so_that_they_make_energies(law: str) -> None:
    """What a law makes of the ratio of two temperatures is the same in any units."""
    q = own(law, Parameters(temperature=250.0))
    assert film.heating(q) == pytest.approx(2 * 0.95 * (250.0 - 290.0) * 100.0 / 10.0, rel=1e-14)
    assert q.temperature / q.critical_temperature == pytest.approx(250 / 290, rel=1e-15)


def test_a_film_at_its_critical_temperature_has_no_heating_to_the_last_bit(law: str) -> None:
    rng = np.random.default_rng(13)
    for _ in range(50):
        p = random_parameters(rng, 0.0)
        assert film.heating(own(law, p._replace(temperature=p.critical_temperature))) == 0.0


def test_a_film_without_thermal_coefficient_has_no_heating(law: str) -> None:
    assert film.heating(own(law, Parameters(thermal_coefficient=0.0))) == 0.0


P = random_parameters(np.random.default_rng(12), -2 / 3)._replace(drive_amplitude=-3e-7)
SPEED = abs(P.drive_amplitude) * P.angular_frequency
EXPECTED = {
    "1": VALUE,
    "kg": VALUE / P.block_mass,
    "K": VALUE * 2 * P.thermal_coefficient * P.kinetic_coefficient / P.angular_frequency,
    "N": VALUE / (P.block_mass * SPEED * P.angular_frequency),
    "N s m-1": VALUE / (P.block_mass * P.angular_frequency),
    "Pa s": VALUE * P.kinetic_coefficient * SPEED / P.film_thickness / P.angular_frequency,
    "rad s-1": VALUE / P.angular_frequency,
    "Pa": VALUE * P.kinetic_coefficient / P.angular_frequency,
    "J m-3": VALUE * P.kinetic_coefficient / P.angular_frequency,
    "N m-1": VALUE / (P.block_mass * P.angular_frequency**2),
    "s-1": VALUE / P.angular_frequency,
    "m s-1": VALUE / SPEED,
    "m": VALUE / abs(P.drive_amplitude),
    "s": VALUE * P.angular_frequency,
}

IMPORTS = "from stickslip.options import Physics\nfrom support.reduced import reduced_of"
REDUCED = 'reduced_of(p, Physics("power-law"))'


@pytest.mark.stress
def test_an_extra_parameter_of_any_unit_of_the_table_is_scaled_by_its_unit(tmp_path: Path) -> None:
    imports = f"{IMPORTS}\nfrom stickslip.model.scaling import model_values"
    expression = f"model_values(-0.5)({REDUCED})"
    assert set(EXPECTED) == set(UNITS)
    assert extra_values(tmp_path, imports, expression, P) == pytest.approx(
        EXPECTED, rel=1e-14, abs=0
    )


@pytest.mark.slow
def test_an_extra_parameter_of_another_unit_must_say_how_it_is_scaled(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="is in 'K s-1', and nothing says how"):
        extra_values(tmp_path, IMPORTS, REDUCED, P, ("K s-1",))
