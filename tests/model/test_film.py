"""The film: the closed forms of Eqs. 12-20, the three landscapes of Fig. 2, both transitions."""

import inspect
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.model import film

ALPHA, T_C, A_EL, B_CUBIC, C_QUARTIC, DELTA = 0.95, 290.0, 4e12, 230.0, 850.0, 100.0
LANDAU = (ALPHA, T_C, A_EL, B_CUBIC, C_QUARTIC)
AREA = 0.6e-9
SPINODAL = B_CUBIC**2 / (4 * C_QUARTIC)
"""b^2/4c: the melting function from which a film is liquid only."""

FIG_2_STRAIN = 2.1e-6


def free_energy_slope(phi: float, eps: float, T: float, b: float = B_CUBIC) -> float:
    """df/dphi by complex step: exact to rounding, for the plain Python of the free energy."""
    step = 1e-30
    f = film.free_energy.py_func(complex(phi, step), eps, T, ALPHA, T_C, A_EL, b, C_QUARTIC)
    return f.imag / step


def extrema_of_free_energy(T: float, eps: float) -> list[tuple[str, float]]:
    """Minima and maxima of f over phi >= 0, with the edge phi = 0 seen from its right."""
    phi = np.linspace(0.0, 0.6, 6001)
    f = np.array([film.free_energy(x, eps, T, *LANDAU) for x in phi])
    rises = np.diff(f) > 0
    found = [("minimum", 0.0)] if rises[0] else [("maximum", 0.0)]
    for i in range(1, len(rises)):
        if rises[i] and not rises[i - 1]:
            found.append(("minimum", float(phi[i])))
        if rises[i - 1] and not rises[i]:
            found.append(("maximum", float(phi[i])))
    return found


# --- closed forms --------------------------------------------------------------------------------


def test_the_spinodal_of_the_paper_is_15_5588() -> None:
    assert pytest.approx(15.5588, abs=5e-5) == SPINODAL


def test_the_melting_temperature_at_rest_is_298_18885_K() -> None:
    assert film.melting_temperature(0.0, *LANDAU) == pytest.approx(298.18885, abs=5e-6)


def test_the_solidification_temperature_at_rest_is_T_c() -> None:
    assert film.solidification_temperature(0.0, ALPHA, T_C, A_EL) == 290.0


def test_strain_lowers_both_transition_temperatures_by_the_same_amount() -> None:
    eps = 3e-6
    drop = A_EL * eps**2 / (2 * ALPHA)
    melting = film.melting_temperature(0.0, *LANDAU) - film.melting_temperature(eps, *LANDAU)
    freezing = T_C - film.solidification_temperature(eps, ALPHA, T_C, A_EL)
    assert melting == pytest.approx(drop, rel=1e-12)
    assert freezing == pytest.approx(drop, rel=1e-12)


def test_the_solid_at_200_K_and_rest_has_the_order_parameter_0_603782() -> None:
    B = film.melting_function(0.0, 200.0, ALPHA, T_C, A_EL)
    phi = film.solid_order_parameter(B, B_CUBIC, C_QUARTIC)
    assert phi == pytest.approx(0.603782, abs=5e-7)


def test_the_film_melts_at_200_K_at_the_strain_6_8293e_6() -> None:
    assert film.melting_strain(200.0, *LANDAU) == pytest.approx(6.8293e-6, abs=5e-11)


def test_the_film_solidifies_at_200_K_at_the_strain_6_5383e_6() -> None:
    eps = film.solidification_strain(200.0, ALPHA, T_C, A_EL)
    assert eps == pytest.approx(6.5383e-6, abs=5e-11)


@pytest.mark.parametrize("T", [150.0, 200.0, 285.0])
def test_at_the_melting_strain_the_melting_function_is_the_spinodal(T: float) -> None:
    eps = film.melting_strain(T, *LANDAU)
    assert film.melting_function(eps, T, ALPHA, T_C, A_EL) == pytest.approx(SPINODAL, rel=1e-12)
    assert film.melting_temperature(eps, *LANDAU) == pytest.approx(T, rel=1e-13)


@pytest.mark.parametrize("T", [150.0, 200.0, 285.0])
def test_at_the_solidification_strain_the_melting_function_is_zero(T: float) -> None:
    eps = film.solidification_strain(T, ALPHA, T_C, A_EL)
    assert film.melting_function(eps, T, ALPHA, T_C, A_EL) == pytest.approx(0.0, abs=1e-11)
    assert film.solidification_temperature(eps, ALPHA, T_C, A_EL) == pytest.approx(T, rel=1e-13)


def test_a_film_that_is_liquid_at_any_strain_has_no_transition_strain() -> None:
    assert math.isnan(film.melting_strain(299.0, *LANDAU))
    assert math.isnan(film.solidification_strain(291.0, ALPHA, T_C, A_EL))


def quasi_static_maximum(stress: np.ndarray) -> float:
    """Maximum of a curve sampled densely, by the parabola through its three highest points."""
    i = int(stress.argmax())
    left, top, right = stress[i - 1 : i + 2]
    return float(top + (left - right) ** 2 / (8 * (2 * top - left - right)))


def test_the_quasi_static_film_bears_4_2885_MPa_and_2_8009_mN_at_200_K() -> None:
    tau, h, k, gamma = 1e-8, 1e-9, 5e4, -2 / 3
    strains = np.linspace(0.0, film.melting_strain(200.0, *LANDAU) * (1 - 1e-12), 20_001)
    B = [film.melting_function(eps, 200.0, ALPHA, T_C, A_EL) for eps in strains]
    phi = [film.solid_order_parameter(x, B_CUBIC, C_QUARTIC) for x in B]
    elastic = np.array(
        [film.elastic_stress(y, eps, A_EL) for y, eps in zip(phi, strains, strict=True)]
    )
    force = AREA * (elastic + k * (strains * (h / tau) / h) ** (gamma + 1))
    assert quasi_static_maximum(elastic) == pytest.approx(4.2885e6, abs=50)
    assert quasi_static_maximum(force) == pytest.approx(2.8009e-3, abs=5e-8)
    assert strains[force.argmax()] > strains[elastic.argmax()]


# --- Fig. 2: the landscape -----------------------------------------------------------------------


def test_fig_2_at_265_K_the_only_minimum_is_a_solid_one() -> None:
    kinds = extrema_of_free_energy(265.0, FIG_2_STRAIN)
    assert [kind for kind, _ in kinds] == ["maximum", "minimum"]
    assert kinds[0][1] == 0.0
    assert kinds[1][1] > 0.0


def test_fig_2_at_286_K_a_maximum_parts_the_liquid_from_the_solid_minimum() -> None:
    kinds = extrema_of_free_energy(286.0, FIG_2_STRAIN)
    assert [kind for kind, _ in kinds] == ["minimum", "maximum", "minimum"]
    B = film.melting_function(FIG_2_STRAIN, 286.0, ALPHA, T_C, A_EL)
    assert kinds[0][1] == 0.0
    minus = film.unstable_order_parameter(B, B_CUBIC, C_QUARTIC)
    plus = film.solid_order_parameter(B, B_CUBIC, C_QUARTIC)
    assert kinds[1][1] == pytest.approx(minus, abs=2e-4)
    assert kinds[2][1] == pytest.approx(plus, abs=2e-4)


def test_fig_2_at_310_K_the_only_minimum_is_the_liquid() -> None:
    assert extrema_of_free_energy(310.0, FIG_2_STRAIN) == [("minimum", 0.0)]


# --- stationary states and kinetics --------------------------------------------------------------

temperatures = st.floats(0.0, 298.0)


@given(T=temperatures, part=st.floats(0.0, 0.9999))
def test_the_roots_of_eq_16_are_roots_of_the_free_energy_slope(T: float, part: float) -> None:
    eps = part * film.melting_strain(T, *LANDAU)
    B = film.melting_function(eps, T, ALPHA, T_C, A_EL)
    for root in (film.solid_order_parameter, film.unstable_order_parameter):
        phi = root(B, B_CUBIC, C_QUARTIC)
        terms = abs(phi) * (abs(B) + B_CUBIC * abs(phi) + C_QUARTIC * phi**2)
        assert abs(free_energy_slope(phi, eps, T)) <= 1e-12 * (terms + 1e-3)


@given(T=temperatures, part=st.floats(0.0, 0.99))
def test_the_upper_root_attracts_and_the_lower_one_repels(T: float, part: float) -> None:
    B = film.melting_function(part * film.melting_strain(T, *LANDAU), T, ALPHA, T_C, A_EL)
    plus = film.solid_order_parameter(B, B_CUBIC, C_QUARTIC)
    rate = film.order_parameter_rate
    assert rate(plus * 1.001, B, B_CUBIC, C_QUARTIC, DELTA) < 0
    assert rate(plus * 0.999, B, B_CUBIC, C_QUARTIC, DELTA) > 0
    minus = film.unstable_order_parameter(B, B_CUBIC, C_QUARTIC)
    if minus > 1e-6:
        assert rate(minus * 1.001, B, B_CUBIC, C_QUARTIC, DELTA) > 0
        assert rate(minus * 0.999, B, B_CUBIC, C_QUARTIC, DELTA) < 0


def test_beyond_the_spinodal_there_is_no_solid() -> None:
    assert math.isnan(film.solid_order_parameter(SPINODAL * 1.0001, B_CUBIC, C_QUARTIC))
    assert math.isnan(film.unstable_order_parameter(SPINODAL * 1.0001, B_CUBIC, C_QUARTIC))


@given(phi=st.floats(0.0, 2.0), eps=st.floats(-2e-5, 2e-5), T=st.floats(0.0, 500.0))
def test_the_rate_is_minus_delta_times_the_slope_of_the_free_energy(
    phi: float, eps: float, T: float
) -> None:
    B = film.melting_function(eps, T, ALPHA, T_C, A_EL)
    rate = film.order_parameter_rate(phi, B, B_CUBIC, C_QUARTIC, DELTA)
    slope = free_energy_slope(phi, eps, T)
    terms = phi * (abs(B) + 2 * ALPHA * abs(T - T_C) + B_CUBIC * phi + C_QUARTIC * phi**2)
    assert rate == pytest.approx(-DELTA * slope, abs=1e-13 * DELTA * terms + 1e-50)


@given(psi=st.floats(-30.0, 1.0))
def test_the_slope_of_the_log_force_is_its_derivative_by_ln_phi(psi: float) -> None:
    step = 1e-3
    shifts = np.array([-2, -1, 1, 2]) * step
    values = [film.log_force(math.exp(psi + s), 3.0, B_CUBIC, C_QUARTIC) for s in shifts]
    derivative = np.dot([1, -8, 8, -1], values) / (12 * step)
    phi = math.exp(psi)
    slope = film.log_force_slope(phi, B_CUBIC, C_QUARTIC)
    assert slope == pytest.approx(derivative, abs=1e-9 * (1 + phi * (B_CUBIC + C_QUARTIC * phi)))


def test_the_shear_modulus_is_the_slope_of_the_elastic_stress() -> None:
    stress = film.elastic_stress(0.4, 3e-6, A_EL) - film.elastic_stress(0.4, 1e-6, A_EL)
    assert film.shear_modulus(0.4, A_EL) == pytest.approx(stress / 2e-6, rel=1e-12)


def test_the_elastic_stress_is_the_strain_derivative_of_the_free_energy() -> None:
    eps, phi, step = 3e-6, 0.4, 1e-9
    high = film.free_energy(phi, eps + step, 200.0, *LANDAU)
    low = film.free_energy(phi, eps - step, 200.0, *LANDAU)
    stress = film.elastic_stress(phi, eps, A_EL)
    assert (high - low) / (2 * step) == pytest.approx(stress, rel=1e-9)


# --- without the cubic term ----------------------------------------------------------------------


def test_without_the_cubic_term_the_transition_is_continuous() -> None:
    below = np.array([1e-2, 1e-4, 1e-6, 1e-8])
    phi = [
        film.solid_order_parameter(2 * ALPHA * -d, 0.0, C_QUARTIC) for d in below
    ]  # at T = T_c - d
    assert phi == pytest.approx(np.sqrt(2 * ALPHA * below / C_QUARTIC), rel=1e-12)
    assert phi[-1] < 1e-5
    assert math.isnan(film.solid_order_parameter(2 * ALPHA * 1e-9, 0.0, C_QUARTIC))


def test_without_the_cubic_term_there_is_no_hysteresis() -> None:
    landau = (ALPHA, T_C, A_EL, 0.0, C_QUARTIC)
    for T in (0.0, 150.0, 289.9):
        assert film.melting_strain(T, *landau) == pytest.approx(
            film.solidification_strain(T, ALPHA, T_C, A_EL), rel=1e-14
        )
    for eps in (0.0, 2e-6, 6e-6):
        assert film.melting_temperature(eps, *landau) == pytest.approx(
            film.solidification_temperature(eps, ALPHA, T_C, A_EL), rel=1e-14
        )


def test_with_the_cubic_term_the_order_parameter_jumps_at_melting() -> None:
    at_melting = film.solid_order_parameter(SPINODAL * (1 - 1e-12), B_CUBIC, C_QUARTIC)
    assert at_melting == pytest.approx(B_CUBIC / (2 * C_QUARTIC), rel=1e-5)


# --- thresholds ----------------------------------------------------------------------------------


def test_a_film_counts_as_solid_from_half_b_over_c() -> None:
    args = (ALPHA, T_C, B_CUBIC, C_QUARTIC)
    assert film.solid_threshold(200.0, *args) == pytest.approx(230 / 1700, rel=1e-15)
    assert film.solid_threshold(320.0, *args) == film.solid_threshold(200.0, *args)


def test_without_the_cubic_term_a_film_counts_as_solid_from_half_its_unstrained_value() -> None:
    threshold = film.solid_threshold(200.0, ALPHA, T_C, 0.0, C_QUARTIC)
    assert threshold == pytest.approx(0.5 * math.sqrt(2 * ALPHA * 90.0 / C_QUARTIC), rel=1e-14)
    assert film.solid_threshold(300.0, ALPHA, T_C, 0.0, C_QUARTIC) == 0.0


def test_a_film_counts_as_melted_below_a_tenth_of_the_solid_threshold() -> None:
    assert film.MELTED_PART == 0.1


def test_the_bound_of_the_order_parameter_is_the_unstrained_solid_or_half_b_over_c() -> None:
    args = (ALPHA, T_C, B_CUBIC, C_QUARTIC)
    assert film.largest_order_parameter(200.0, *args) == pytest.approx(0.603782, abs=5e-7)
    assert film.largest_order_parameter(298.2, *args) == pytest.approx(230 / 1700, rel=1e-15)
    assert film.largest_order_parameter(400.0, *args) == pytest.approx(230 / 1700, rel=1e-15)


@given(phi=st.floats(0.0, 2.0), eps=st.floats(-2e-5, 2e-5), T=st.floats(0.0, 500.0))
def test_no_order_parameter_above_the_bound_grows_at_any_strain(
    phi: float, eps: float, T: float
) -> None:
    bound = film.largest_order_parameter(T, ALPHA, T_C, B_CUBIC, C_QUARTIC)
    B = film.melting_function(eps, T, ALPHA, T_C, A_EL)
    if phi > bound * (1 + 1e-9):
        assert film.order_parameter_rate(phi, B, B_CUBIC, C_QUARTIC, DELTA) < 0


# --- parity --------------------------------------------------------------------------------------

SAMPLES = {
    "phi": (0.0, 1e-12, 0.1, 0.603782, 2.0),
    "eps": (-7e-6, 0.0, 2.1e-6, 6.9e-6, 6.6e-6),
    "T": (200.0, 289.9, 250.0, 150.0, 10.0),
    "B": (-171.0, -1.0, 0.0, 10.0, 15.5),
    "delta": (100.0, 1.0, 1e3, 1e-3, 50.0),
    "alpha": (0.95,) * 5,
    "T_c": (290.0,) * 5,
    "a": (4e12,) * 5,
    "b": (230.0, 230.0, 0.0, 1.0, 300.0),
    "c": (850.0, 850.0, 850.0, 1.0, 1e3),
}

FUNCTIONS = [
    film.free_energy,
    film.elastic_stress,
    film.shear_modulus,
    film.melting_function,
    film.solid_order_parameter,
    film.unstable_order_parameter,
    film.melting_temperature,
    film.solidification_temperature,
    film.melting_strain,
    film.solidification_strain,
    film.order_parameter_rate,
    film.log_force,
    film.log_force_slope,
    film.solid_threshold,
    film.largest_order_parameter,
]


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: f.__name__)
def test_compiled_and_plain_python_agree(function) -> None:
    names = list(inspect.signature(function.py_func).parameters)
    for values in zip(*(SAMPLES[name] for name in names), strict=True):
        compiled = function(*values)
        if math.isnan(compiled):  # plain Python raises instead
            with pytest.raises(ValueError, match=r"domain|nonnegative"):
                function.py_func(*values)
        else:
            # Contraction of a*b + c changes the last digit of the largest term.
            plain = function.py_func(*values)
            assert compiled == pytest.approx(plain, rel=1e-13, abs=1e-11)
