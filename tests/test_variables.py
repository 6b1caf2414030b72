"""The registry: its names, symbols and units are those that people script against."""

import math

import matplotlib.mathtext
import numpy as np
import pytest

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import (
    BY_SYMBOL,
    ENERGY_COEFFICIENTS,
    PARAMETERS,
    PHASES,
    RESULT_COLUMNS,
    RESULTS,
    TRAJECTORY,
    ResultVariable,
    Variable,
    canonical_name,
    unbounded,
)

EVERY = [*PARAMETERS.values(), *TRAJECTORY.values(), *PHASES.values(), *RESULTS.values()]

PARAMETER_SYMBOLS = {
    "temperature": ("T", "K"),
    "viscosity_coefficient": ("k", "Pa s"),
    "spring_stiffness": ("K", "N m-1"),
    "rheological_index": ("gamma", "1"),
    "angular_frequency": ("omega", "rad s-1"),
    "drive_amplitude": ("X_m", "m"),
    "block_mass": ("M", "kg"),
    "initial_displacement": ("x_0", "m"),
    "initial_velocity": ("v_0", "m s-1"),
    "initial_order_parameter": ("phi_0", "1"),
    "film_thickness": ("h", "m"),
    "strain_relaxation_time": ("tau", "s"),
    "contact_area": ("A", "m2"),
    "kinetic_coefficient": ("delta", "m3 J-1 s-1"),
    "thermal_coefficient": ("alpha", "J K-1 m-3"),
    "critical_temperature": ("T_c", "K"),
    "elastic_coefficient": ("a", "Pa"),
    "cubic_coefficient": ("b", "J m-3"),
    "quartic_coefficient": ("c", "J m-3"),
    "noise_intensity": ("D", "s-1"),
    "quintic_coefficient": ("d", "J m-3"),
    "sextic_coefficient": ("e", "J m-3"),
}
TRAJECTORY_UNITS = {
    "elapsed_time": "s",
    "upper_displacement": "m",
    "lower_displacement": "m",
    "upper_velocity": "m s-1",
    "lower_velocity": "m s-1",
    "order_parameter": "1",
    "elastic_strain": "1",
    "elastic_stress": "Pa",
    "viscous_stress": "Pa",
    "friction_force": "N",
}
RESULT_UNITS = {
    "elastic_stress_amplitude": "Pa",
    "friction_force_amplitude": "N",
    "elastic_stress_max": "Pa",
    "elastic_stress_min": "Pa",
    "friction_force_max": "N",
    "friction_force_min": "N",
    "amplitude_error": "1",
    "power_balance_error": "1",
    "orbit_periods": "1",
    "melting_count": "1",
    "solid_transition_count": "1",
    "asymmetry": "1",
    "periods_integrated": "1",
    "solid_fraction": "1",
    "regime": "1",
    "floquet_multiplier": "1",
    "lyapunov_exponent": "1",
    "elastic_stress_amplitude_spread": "Pa",
    "friction_force_amplitude_spread": "N",
    "status": "1",
}


def test_parameters_are_those_of_the_interface():
    assert {v.name: (v.symbol, v.units) for v in PARAMETERS.values()} == PARAMETER_SYMBOLS


def test_trajectory_variables_are_those_of_the_interface():
    assert {v.name: v.units for v in TRAJECTORY.values()} == TRAJECTORY_UNITS


def test_result_variables_are_those_of_the_interface():
    assert {v.name: v.units for v in RESULTS.values()} == RESULT_UNITS


@pytest.mark.parametrize("registry", [PARAMETERS, TRAJECTORY, PHASES, RESULTS])
def test_a_variable_is_registered_under_its_name(registry: dict[str, Variable]):
    assert list(registry) == [variable.name for variable in registry.values()]


@pytest.mark.parametrize("registry", [PARAMETERS, TRAJECTORY, PHASES, RESULTS])
def test_registry_cannot_be_changed(registry: dict[str, Variable]):
    with pytest.raises(TypeError):
        registry["temperature"] = None


def test_names_differ_without_regard_to_case():
    # CF compares names without case, and parameters and results share a file.
    names = [name.lower() for name in (*PARAMETERS, *RESULTS)]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("variable", EVERY, ids=lambda v: v.name)
def test_variable_says_what_it_is(variable: Variable):
    assert variable.name.isidentifier()
    assert variable.name == variable.name.lower()
    assert len(variable.name) > 1  # a bare k and K would be one name in CF
    assert variable.symbol
    assert variable.meaning
    assert not variable.meaning.endswith(".")


@pytest.mark.parametrize("variable", EVERY, ids=lambda v: v.name)
def test_symbol_can_be_drawn(variable: Variable):
    matplotlib.mathtext.MathTextParser("path").parse(f"${variable.tex}$")


@pytest.mark.parametrize("variable", EVERY, ids=lambda v: v.name)
def test_unit_is_known_to_udunits(variable: Variable):
    cf_units = pytest.importorskip("cf_units")
    unit = cf_units.Unit(variable.units)
    assert unit.is_dimensionless() == (variable.units == "1")


def test_symbols_name_parameters_uniquely():
    assert len(BY_SYMBOL) == len(PARAMETERS)
    assert not set(BY_SYMBOL) & set(PARAMETERS)


@pytest.mark.parametrize("variable", PARAMETERS.values(), ids=lambda v: v.name)
def test_name_and_symbol_lead_to_the_name(variable: Variable):
    assert canonical_name(variable.name) == variable.name
    assert canonical_name(variable.symbol) == variable.name


def test_case_tells_k_from_K():
    assert canonical_name("k") == "viscosity_coefficient"
    assert canonical_name("K") == "spring_stiffness"


@pytest.mark.parametrize("name", ["", "temprature", "Temperature", "F", "elastic_stress"])
def test_anything_else_is_no_parameter(name: str):
    assert canonical_name(name) is None


@pytest.mark.parametrize("variable", PARAMETERS.values(), ids=lambda v: v.name)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_parameter_may_be_infinite_or_nan(variable: Variable, value: float):
    assert "finite" in variable.complaint(value)


# --- what a parameter declares --------------------------------------------------------------------


@pytest.mark.parametrize("variable", PARAMETERS.values(), ids=lambda v: v.name)
def test_a_default_is_a_valid_float(variable: Variable):
    assert type(variable.default) is float
    assert variable.complaint(variable.default) is None


def test_all_parameters_but_those_of_a_soft_solid_are_the_papers():
    others = [name for name, variable in PARAMETERS.items() if not variable.in_paper]
    assert others == ["quintic_coefficient", "sextic_coefficient"]


def test_powers_of_the_order_parameter_are_those_of_the_free_energy():
    # The force on ln(phi) is 2 alpha (T - T_c) - b phi + c phi^2 - d phi^3 + e phi^4.
    terms = {v.name: (v.phi_power, v.phi_sign) for v in PARAMETERS.values() if v.phi_power}
    declared = {"cubic": (1, -1), "quartic": (2, 1), "quintic": (3, -1), "sextic": (4, 1)}
    assert {name: terms[f"{name}_coefficient"] for name in declared} == declared


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"c": 850.0}, None),
        ({"e": 1.0}, None),
        ({"d": 7.0, "e": 1.0}, None),
        ({"c": 850.0, "d": 7.0}, "quintic_coefficient (d) > 0 needs a sextic_coefficient (e)"),
        ({}, "quartic_coefficient (c) = 0 needs a sextic_coefficient (e)"),
    ],
)
def test_the_highest_term_must_bound_the_order_parameter(given: dict[str, float], told: str | None):
    found = unbounded(*(given.get(PARAMETERS[name].symbol, 0.0) for name in ENERGY_COEFFICIENTS))
    assert (found is None) if told is None else str(found).startswith(told)


# --- what a result declares -----------------------------------------------------------------------

COUNTS = {"orbit_periods", "melting_count", "solid_transition_count", "periods_integrated"}


def test_columns_are_in_the_order_of_the_registry():
    assert tuple(RESULTS) == RESULT_COLUMNS


@pytest.mark.parametrize("variable", RESULTS.values(), ids=lambda v: v.name)
def test_a_result_says_how_it_is_stored_and_what_stands_for_none(variable: ResultVariable):
    if variable.name == "status":
        assert (variable.dtype, variable.missing) == ("i1", Status.PENDING)
    elif variable.name == "regime":
        assert (variable.dtype, variable.missing) == ("i1", Regime.UNKNOWN)
    elif variable.name in COUNTS:
        assert (variable.dtype, variable.missing) == ("i4", -1)
    else:
        assert variable.dtype == "f8"
        assert math.isnan(variable.missing)


@pytest.mark.parametrize("variable", RESULTS.values(), ids=lambda v: v.name)
def test_what_stands_for_none_can_be_stored(variable: ResultVariable):
    stored = np.array(variable.missing, dtype=variable.dtype)
    np.testing.assert_equal(float(stored), float(variable.missing))


def test_a_length_or_speed_that_may_be_negative_has_a_direction() -> None:
    """The lanes' units turn with the sign of X_m, and such parameters with them."""
    for variable in PARAMETERS.values():
        if variable.units in ("m", "m s-1") and variable.lower < 0.0:
            assert variable.directed, variable.name
