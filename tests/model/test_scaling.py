"""The nondimensional model: the same equations, exactly scaled and mirrored."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.parameters import random_parameters
from support.reduced import reduced_of
from support.symmetries import SYMMETRIES, Symmetry, transformed

from stickslip.kernels.orbits.motions import motions_of
from stickslip.model import drive, film, scaling
from stickslip.model.models import model_of
from stickslip.model.rhs import Equations
from stickslip.options import FRICTION_LAWS, Physics
from stickslip.parameters import Parameters, ParameterValues
from stickslip.variables import PARAMETERS, ParameterVariable

INDICES = [-2 / 3, -0.5, 0.0, 0.3, 2 / 3]


@pytest.fixture(scope="module", params=FRICTION_LAWS)
def law(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def model(law: str) -> Equations:
    return model_of(Physics(law)).equations


def own(law: str, p: ParameterValues) -> ParameterValues:
    """The parameters in the units of the point, as the functions of the model take them."""
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


def reduced(p: Parameters) -> dict[str, float]:
    """The reduced parameters of the paper; a scaling may change others in unknown ways."""
    q = reduced_of(p, Physics("power-law"))
    beyond = {name for name, variable in PARAMETERS.items() if not variable.in_paper}
    return {name: x for name, x in q._asdict().items() if name not in beyond}


# A scaling of time, without fluids in which a power of the rate is no power of two.
FASTER = {
    "angular_frequency": 2.0,
    "strain_relaxation_time": 0.5,
    "kinetic_coefficient": 2.0,
    "noise_intensity": 2.0,
    "spring_stiffness": 4.0,
    "contact_area": 4.0,
    "viscosity_coefficient": 0.5,
}
SCALINGS = [
    *((gamma, symmetry) for gamma in INDICES for symmetry in SYMMETRIES.values()),
    (0.0, Symmetry(FASTER, stress=1.0, force=4.0, motion=1.0)),
]


@pytest.mark.parametrize(("gamma", "symmetry"), SCALINGS)
def test_scalings_by_two_leave_the_reduced_parameters_bit_for_bit(
    gamma: float, symmetry: Symmetry
) -> None:
    rng = np.random.default_rng(9)
    for _ in range(50):
        p = random_parameters(rng, gamma)
        assert reduced(transformed(p, symmetry)) == reduced(p)


# --- the tables ----------------------------------------------------------------------------------


def test_every_parameter_is_kept_or_has_one_value() -> None:
    assert {*scaling.KEPT, *scaling.LITERALS, *scaling.OF_HARMONICS} == set(PARAMETERS)
    every = (*scaling.KEPT, *scaling.DERIVED, *scaling.OF_HARMONICS)
    assert scaling.Reduced._fields == every
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


def test_a_single_tone_is_the_unit_of_length_and_harmonics_are_no_faster(law: str) -> None:
    p = Parameters(third_harmonic=0.5, fifth_harmonic=-0.1)
    q = reduced_of(p, Physics(law))
    one, every = (scaling.model_values(None, one_tone=known)(q) for known in (True, False))
    assert (one.drive_amplitude, one.third_harmonic, one.fifth_harmonic) == (1.0, 0.0, 0.0)
    assert (every.third_harmonic, every.fifth_harmonic) == (0.5, -0.1)
    reduced = motions_of(np.array([p]), Physics(law)).points[0]
    own = scaling.model_values(None)(scaling.Reduced(*reduced.tolist()))
    assert drive.largest_speed(own) == pytest.approx(1.0, rel=1e-15)


def test_temperatures_are_scaled_so_that_they_make_energies(law: str) -> None:
    """A law may use the ratio of two temperatures, which is the same in any units."""
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


P = random_parameters(np.random.default_rng(12), -2 / 3)
TIME, LENGTH, THICKNESS, STRAIN = 0.3, -2e-6, 5e-9, -7.0
ENERGY = 1.0 / (P.kinetic_coefficient * TIME)
BY_UNIT = {
    "1": 1.0,
    "kg": P.block_mass,
    "K": ENERGY / (2 * P.thermal_coefficient),
    "N": P.block_mass * LENGTH / TIME**2,
    "N s m-1": P.block_mass / TIME,
    "N m-1": P.block_mass / TIME**2,
    "Pa s": ENERGY / STRAIN * THICKNESS * TIME / LENGTH,
    "Pa": ENERGY / STRAIN,
    "J m-3": ENERGY,
    "rad s-1": 1.0 / TIME,
    "s-1": 1.0 / TIME,
    "m s-1": LENGTH / TIME,
    "m": LENGTH,
    "s": TIME,
}


def declared(monkeypatch: pytest.MonkeyPatch, unit: str) -> int:
    """The index in `Units` of the scale of a further parameter in this unit."""
    extra = ParameterVariable("e", "e", unit, "extra", name="extra", default=3.0)
    monkeypatch.setattr(scaling, "PARAMETERS", PARAMETERS | {"extra": extra})
    return scaling._unit_of("extra")


@pytest.mark.parametrize("unit", BY_UNIT)
def test_a_further_parameter_is_scaled_by_its_unit(
    monkeypatch: pytest.MonkeyPatch, unit: str
) -> None:
    units = scaling.make_units(P, TIME, LENGTH, THICKNESS, STRAIN)
    found = units[declared(monkeypatch, unit)]
    assert found == pytest.approx(BY_UNIT[unit], rel=1e-14, abs=0)


def test_a_parameter_of_another_unit_must_say_how_it_is_scaled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(scaling.UnscaledError, match="is in 'K s-1', and nothing says how"):
        declared(monkeypatch, "K s-1")
