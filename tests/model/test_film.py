"""The film: the closed forms of Eqs. 12-19, the three landscapes of Fig. 2, both transitions."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.differences import slope_of

from stickslip.model import film, solids
from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS

PAPER = Parameters()
B_CUBIC, C_QUARTIC = PAPER.cubic_coefficient, PAPER.quartic_coefficient
SPINODAL = B_CUBIC**2 / (4 * C_QUARTIC)
"""b^2/4c: above this melting function a film can only be liquid."""

ENERGIES = [name for name, v in PARAMETERS.items() if v.units == "J m-3"]
FULL = PAPER._replace(**{name: 100.0 for name in ENERGIES if getattr(PAPER, name) == 0.0})
"""A film with all terms of the registry, also later ones."""

films = st.sampled_from([PAPER, FULL])


def at(T: float, **changes: float) -> Parameters:
    """The paper's film at another temperature."""
    return PAPER._replace(temperature=T, **changes)


def free_energy_slope(p: Parameters, phi: float, eps: float) -> float:
    """df/dphi by a complex step through the plain Python of the free energy: exact to rounding."""
    step = 1e-30
    return film.free_energy.py_func(p, complex(phi, step), eps).imag / step


def unstable_order_parameter(p: Parameters, B: float) -> float:
    """The lower root of Eq. 16, which separates the basins of liquid and solid."""
    half = 0.5 * p.cubic_coefficient / p.quartic_coefficient
    return half - math.sqrt(half * half - B / p.quartic_coefficient)


# --- closed forms --------------------------------------------------------------------------------


def test_at_rest_the_melting_function_vanishes_at_T_c() -> None:
    assert film.melting_function(at(290.0), 0.0) == film.heating(at(290.0)) == 0.0


def test_strain_adds_to_the_melting_function_what_a_higher_temperature_does() -> None:
    eps = 3e-6
    warmer = PAPER.elastic_coefficient * eps**2 / (2 * PAPER.thermal_coefficient)
    for T in (150.0, 290.0):
        strained = film.melting_function(at(T), eps)
        assert film.melting_function(at(T + warmer), 0.0) == pytest.approx(
            strained, rel=1e-12, abs=0
        )


@pytest.mark.parametrize("T", [150.0, 200.0, 285.0])
def test_at_the_melting_strain_the_melting_function_is_the_spinodal(T: float) -> None:
    p = at(T)
    B = film.melting_function(p, solids.melting_strain(p))
    assert pytest.approx(SPINODAL, rel=1e-12, abs=0) == B


def test_a_film_that_is_liquid_at_any_strain_or_not_elastic_has_no_melting_strain() -> None:
    for p in (at(299.0), at(200.0, elastic_coefficient=0.0)):
        assert solids.melting_strain(p) == 0.0


# --- stationary states and kinetics --------------------------------------------------------------

temperatures = st.floats(0.0, 298.0)
order_parameters = st.floats(0.0, 2.0)
strains = st.floats(-2e-5, 2e-5)


@given(T=temperatures, part=st.floats(0.0, 0.9999))
def test_the_roots_of_eq_16_are_roots_of_the_free_energy_slope(T: float, part: float) -> None:
    p = at(T)
    eps = part * solids.melting_strain(p)
    B = film.melting_function(p, eps)
    for root in (solids.solid_order_parameter, unstable_order_parameter):
        phi = root(p, B)
        terms = abs(phi) * (abs(B) + B_CUBIC * abs(phi) + C_QUARTIC * phi**2)
        assert abs(free_energy_slope(p, phi, eps)) <= 1e-12 * (terms + 1e-3)


@given(T=temperatures, part=st.floats(0.0, 0.99))
def test_the_upper_root_attracts_and_the_lower_one_repels(T: float, part: float) -> None:
    p = at(T)
    B = film.melting_function(p, part * solids.melting_strain(p))
    plus, rate = solids.solid_order_parameter(p, B), film.order_parameter_rate
    assert rate(p, plus * 1.001, B) < 0
    assert rate(p, plus * 0.999, B) > 0
    minus = unstable_order_parameter(p, B)
    if minus > 1e-6:
        assert rate(p, minus * 1.001, B) > 0
        assert rate(p, minus * 0.999, B) < 0


def test_beyond_the_spinodal_the_solid_branch_keeps_its_last_value() -> None:
    for B in (SPINODAL, SPINODAL * 1.0001, 1e6):
        assert solids.solid_order_parameter(PAPER, B) == pytest.approx(B_CUBIC / (2 * C_QUARTIC))


def size_of_force(p: Parameters, phi: float) -> float:
    """The sum of the sizes of all terms but B of the force on ln(phi)."""
    return sum(getattr(p, name) * phi ** PARAMETERS[name].phi_power for name in ENERGIES)


@pytest.mark.parametrize("name", ENERGIES)
def test_every_energy_density_of_the_registry_is_a_coefficient_of_the_free_energy(
    name: str,
) -> None:
    """It multiplies the declared power of phi in the force, with the declared sign."""

    def share(phi: float) -> float:
        one, two = (FULL._replace(**{name: value}) for value in (1.0, 2.0))
        return film.log_force(two, phi, 0.0) - film.log_force(one, phi, 0.0)

    power, sign = PARAMETERS[name].phi_power, PARAMETERS[name].phi_sign
    assert power > 0
    assert PARAMETERS[name].lower == 0.0
    for phi in (0.25, 0.5):
        assert share(phi) == pytest.approx(sign * phi**power, rel=1e-9, abs=0)


@given(p=films, phi=st.floats(1e-3, 2.0), eps=strains, T=st.floats(0.0, 500.0))
def test_the_log_force_is_the_slope_of_the_free_energy_over_phi(
    p: Parameters, phi: float, eps: float, T: float
) -> None:
    p = p._replace(temperature=T)
    slope = slope_of(lambda x: film.free_energy(p, x, eps), phi, 1e-3 * phi)
    force = film.log_force(p, phi, film.melting_function(p, eps))
    B = film.melting_function(p, eps)
    assert force == pytest.approx(slope / phi, abs=1e-9 * (abs(B) + size_of_force(p, phi)))


@given(p=films, psi=st.floats(-30.0, 1.0))
def test_the_slope_of_the_log_force_is_its_derivative_by_ln_phi(p: Parameters, psi: float) -> None:
    slope = slope_of(lambda x: film.log_force(p, math.exp(x), 3.0), psi, 1e-3)
    found = film.log_force_slope(p, math.exp(psi))
    assert found == pytest.approx(slope, abs=1e-9 * (1 + size_of_force(p, math.exp(psi))))


@given(p=films, phi=order_parameters)
def test_the_balance_has_the_coefficients_of_the_force(p: Parameters, phi: float) -> None:
    powers = range(1, film.HIGHEST_POWER + 1)
    found = sum(film.balance_coefficient(p, power) * phi**power for power in powers)
    assert found == pytest.approx(solids.balance(p, phi), abs=1e-13 * size_of_force(p, phi))


def test_the_shear_modulus_is_the_slope_of_the_elastic_stress() -> None:
    stress = film.elastic_stress(PAPER, 0.4, 3e-6) - film.elastic_stress(PAPER, 0.4, 1e-6)
    assert film.shear_modulus(PAPER, 0.4) == pytest.approx(stress / 2e-6, rel=1e-12, abs=0)


def test_the_elastic_stress_is_the_strain_derivative_of_the_free_energy() -> None:
    p, eps, phi, step = at(200.0), 3e-6, 0.4, 1e-9
    high, low = (film.free_energy(p, phi, eps + way * step) for way in (1, -1))
    stress = film.elastic_stress(p, phi, eps)
    assert (high - low) / (2 * step) == pytest.approx(stress, rel=1e-9, abs=0)


# --- without the cubic term ----------------------------------------------------------------------


def test_without_the_cubic_term_the_transition_is_continuous() -> None:
    p, below = at(200.0, cubic_coefficient=0.0), np.array([1e-2, 1e-4, 1e-6, 1e-8])
    heat = 2 * p.thermal_coefficient * below  # at T = T_c - below
    phi = [solids.solid_order_parameter(p, -B) for B in heat]
    assert phi == pytest.approx(np.sqrt(heat / C_QUARTIC), rel=1e-12, abs=0)
    assert phi[-1] < 1e-5
    assert solids.solid_order_parameter(p, 2e-9) == 0.0


def test_without_the_cubic_term_there_is_no_hysteresis() -> None:
    for T in (0.0, 150.0, 289.9):
        p = at(T, cubic_coefficient=0.0)
        melting = solids.melting_strain(p)
        # ... at which the film solidifies too: B = 0.
        assert film.melting_function(p, melting) == pytest.approx(0.0, abs=1e-13 * 600)
        assert melting > 0


# --- thresholds ----------------------------------------------------------------------------------


def test_a_film_counts_as_solid_from_half_b_over_c() -> None:
    assert solids.solid_threshold(at(200.0)) == pytest.approx(230 / 1700, rel=1e-15, abs=0)
    assert solids.solid_threshold(at(320.0)) == solids.solid_threshold(at(200.0))


def test_without_the_cubic_term_a_film_counts_as_solid_from_half_its_unstrained_value() -> None:
    threshold = solids.solid_threshold(at(200.0, cubic_coefficient=0.0))
    unstrained = math.sqrt(2 * PAPER.thermal_coefficient * 90.0 / C_QUARTIC)
    assert threshold == pytest.approx(0.5 * unstrained, rel=1e-14, abs=0)
    assert solids.solid_threshold(at(300.0, cubic_coefficient=0.0)) == 0.0


def test_the_bound_of_the_order_parameter_is_the_unstrained_solid_or_half_b_over_c() -> None:
    assert solids.largest_order_parameter(at(200.0)) == pytest.approx(0.603782, abs=5e-7)
    assert solids.largest_order_parameter(at(298.2)) == pytest.approx(230 / 1700, rel=1e-15, abs=0)
    assert solids.largest_order_parameter(at(400.0)) == pytest.approx(230 / 1700, rel=1e-15, abs=0)


@given(phi=order_parameters, eps=strains, T=st.floats(0.0, 500.0))
def test_no_order_parameter_above_the_bound_grows_at_any_strain(
    phi: float, eps: float, T: float
) -> None:
    p = at(T)
    if phi > solids.largest_order_parameter(p) * (1 + 1e-9):
        assert film.order_parameter_rate(p, phi, film.melting_function(p, eps)) < 0
