"""The registry: the names, symbols and units that scripts rely on."""

import math

import matplotlib.mathtext
import pytest

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import (
    PARAMETERS,
    PHASES,
    RESULTS,
    TRAJECTORY,
    ResultVariable,
    Variable,
    canonical_name,
)

EVERY = [*PARAMETERS.values(), *TRAJECTORY.values(), *PHASES.values(), *RESULTS.values()]

SYMBOLS = [
    "T", "k", "K", "gamma", "omega", "X_m", "M", "x_0", "v_0", "phi_0", "h", "tau", "A", "delta",
    "alpha", "T_c", "a", "b", "c", "D", "d", "e", "a_3", "a_5",
]  # fmt: skip


# Names, units and meanings are compared with the pages by tests/docs.
def test_symbols_do_not_change():
    assert [variable.symbol for variable in PARAMETERS.values()] == SYMBOLS


@pytest.mark.parametrize("registry", [PARAMETERS, TRAJECTORY, PHASES, RESULTS])
def test_a_variable_is_registered_under_its_name_for_good(registry: dict[str, Variable]):
    assert list(registry) == [variable.name for variable in registry.values()]
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


@pytest.mark.parametrize("variable", PARAMETERS.values(), ids=lambda v: v.name)
def test_name_and_symbol_lead_to_the_name(variable: Variable):
    assert canonical_name(variable.name) == variable.name
    assert canonical_name(variable.symbol) == variable.name


@pytest.mark.parametrize("name", ["", "temprature", "Temperature", "F", "elastic_stress"])
def test_other_names_are_no_parameters(name: str):
    assert canonical_name(name) is None


# --- parameters -----------------------------------------------------------------------------------


def test_only_a_soft_solid_and_the_harmonics_go_beyond_the_paper():
    others = [name for name, variable in PARAMETERS.items() if not variable.in_paper]
    assert others == [
        "quintic_coefficient", "sextic_coefficient", "third_harmonic", "fifth_harmonic"
    ]  # fmt: skip


def test_powers_of_the_order_parameter_agree_with_the_free_energy():
    # The force on ln(phi) is 2 alpha (T - T_c) - b phi + c phi^2 - d phi^3 + e phi^4.
    terms = {v.name: (v.phi_power, v.phi_sign) for v in PARAMETERS.values() if v.phi_power}
    declared = {"cubic": (1, -1), "quartic": (2, 1), "quintic": (3, -1), "sextic": (4, 1)}
    assert {name: terms[f"{name}_coefficient"] for name in declared} == declared


# --- results --------------------------------------------------------------------------------------

COUNTS = {"orbit_periods", "melting_count", "solid_transition_count", "periods_integrated"}


@pytest.mark.parametrize("variable", RESULTS.values(), ids=lambda v: v.name)
def test_a_result_declares_its_type_and_its_missing_value(variable: ResultVariable):
    if variable.name == "status":
        assert (variable.dtype, variable.missing) == ("i1", Status.PENDING)
    elif variable.name == "regime":
        assert (variable.dtype, variable.missing) == ("i1", Regime.UNKNOWN)
    elif variable.name in COUNTS:
        assert (variable.dtype, variable.missing) == ("i4", -1)
    else:
        assert variable.dtype == "f8"
        assert math.isnan(variable.missing)


def test_a_length_or_speed_that_may_be_negative_has_a_direction() -> None:
    """The units of lanes change sign with X_m, and such parameters with them."""
    for variable in PARAMETERS.values():
        if variable.units in ("m", "m s-1") and variable.lower < 0.0:
            assert variable.directed, variable.name
