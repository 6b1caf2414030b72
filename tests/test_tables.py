"""Tables of parameters and orbits in notebooks."""

from __future__ import annotations

from stickslip import Parameters, stationary_orbit
from stickslip.tables import value_table
from stickslip.variables import PARAMETERS, RESULT_COLUMNS


def test_parameters_are_in_a_table_with_changed_values_in_bold() -> None:
    shown = Parameters(temperature=228.0)._repr_html_()
    assert shown.count("<tr") == len(PARAMETERS)
    assert shown.count("bold") == 1
    bold = shown[shown.index("bold") :]
    assert bold.index("temperature") < bold.index("228") < bold.index(">K<")


def test_an_orbit_says_how_it_ended_and_what_was_measured() -> None:
    orbit = stationary_orbit(rtol=1e-4)
    shown = orbit._repr_html_()
    assert orbit.status.sentence in shown
    assert shown.count("<tr") == len(RESULT_COLUMNS)
    assert ">stick_slip_symmetric<" in shown
    assert f"{orbit.friction_force_amplitude:.7g}" in shown


def test_symbols_and_units_have_true_indices_and_powers() -> None:
    assert "σ<sub>el,max</sub>" in stationary_orbit(rtol=1e-4)._repr_html_()
    shown = Parameters()._repr_html_()
    assert "m<sup>3</sup> J<sup>−1</sup> s<sup>−1</sup>" in shown
    assert ">Pa s<sup>γ+1</sup><" in shown
    assert ">φ<sub>0</sub><" in shown


def test_the_content_of_a_table_is_escaped() -> None:
    table = value_table({"temperature": "<script>"}, PARAMETERS)
    assert "<script>" not in table
