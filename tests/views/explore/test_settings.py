"""The small controls of how the page computes."""

from __future__ import annotations

import pytest

from stickslip.options import NOISE_TREATMENTS
from sweeps.config.load import from_mapping
from sweeps.views.explore.settings import Settings


def settings_of(**sections: object) -> tuple[Settings, list[str]]:
    """Controls at a config, and what they tell."""
    told: list[str] = []
    return Settings(from_mapping(sections), lambda: told.append("changed")), told


def test_they_begin_at_the_config():
    settings, told = settings_of(
        integrator={"rtol": 3e-5}, noise={"treatment": "none"}, model={"phi_0": 0.5}
    )
    assert (settings.tolerance.value, settings.noise.value) == ("3e-5", "none")
    assert "3e-5" in settings.tolerance.options
    assert told == []


def test_a_tolerance_is_also_that_of_stationarity():
    settings, told = settings_of()
    settings.tolerance.value = "1e-8"
    config = settings.applied(from_mapping({}))
    assert (config.integrator.rtol, config.stationary.rtol) == (1e-8, 1e-8)
    assert told == ["changed"]


def test_what_was_not_changed_stays_as_it_is():
    config = from_mapping({"integrator": {"rtol": 1e-8}, "stationary": {"rtol": 1e-5}})
    settings, told = settings_of()
    settings.show(config)
    assert settings.tolerance.value == "1e-8"
    assert settings.applied(config) == config
    assert told == []


@pytest.mark.parametrize("treatment", NOISE_TREATMENTS)
def test_the_treatment_of_the_noise(treatment: str):
    settings, _ = settings_of()
    settings.noise.value = treatment
    assert settings.applied(from_mapping({})).noise.treatment == treatment


def test_the_strain_is_chosen_where_the_method_knows_another() -> None:
    settings, told = settings_of(film={"strain": "relaxing"})
    assert (settings.strain.value, settings.strain.visible, told) == ("relaxing", True, [])
    settings.strain.value = "adiabatic"
    assert (
        settings.applied(from_mapping({"film": {"strain": "relaxing"}})).film.strain == "adiabatic"
    )
    other, _ = settings_of(integrator={"method": "euler-cromer", "dt": 1e-8})
    assert not other.strain.visible
