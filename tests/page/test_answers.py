"""The answers to requests of the page, and the summary of a point."""

from __future__ import annotations

import base64
import json
import re
import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.points import error_scales, row

from stickslip import Orbit, Parameters, Status, stationary_orbit
from stickslip.kernels.interruption import check_interruption
from stickslip.options import NOISE_TREATMENTS
from sweeps.config.load import from_mapping, from_yaml
from sweeps.page import answers as module
from sweeps.page.answers import (
    absolute_errors,
    amplitude_text,
    answer_lines,
    as_json,
    summary_html,
)
from sweeps.page.subject import (
    ShownPoint,
    point_alone,
    point_of_result,
    subject_of_paper,
    subject_of_result,
)
from sweeps.page.turns import DRAWN, Motion, Turns, compute
from sweeps.points import point_of


def answer(parts: dict[str, str], subject: Any = None) -> dict[str, Any]:
    """Return the last line of an answer, as a browser reads it."""
    *_, last = answer_lines(parts, subject or subject_of_paper(), Turns())
    return dict(json.loads(as_json(last)))


def test_the_states_come_before_the_orbit():
    states = [line["state"] for line in answer_lines({"T": "250"}, subject_of_paper(), Turns())]
    assert states == ["waiting", "compiling", "computing", "done"]


def test_the_numbers_are_those_of_the_orbit():
    orbit = stationary_orbit(Parameters(temperature=250))
    found = answer({"T": "250"})
    assert found["shown"]["friction_force_amplitude"] == 1e3 * orbit.friction_force_amplitude
    assert found["shown"]["temperature"] == 250
    assert found["shown"]["lyapunov_exponent"] is None
    assert (found["periods"], found["label"]) == (
        pytest.approx(orbit.orbit_periods),
        "T = 250 K; the rest as in the paper",
    )
    assert from_yaml(found["config"]).parameters() == Parameters(temperature=250)
    assert "--set temperature=250" in found["command"]


def test_the_courses_are_those_of_the_orbit():
    found = answer({"T": "250"})
    course = subject_of_paper().first.point.simulate(samples_per_period=2000)
    assert sorted(found["courses"]) == sorted(DRAWN)
    force = np.frombuffer(base64.b64decode(found["courses"]["friction_force"]), "<f4")
    assert force.size == course.sizes["elapsed_time"]
    assert force.max() == pytest.approx(found["shown"]["friction_force_max"], rel=1e-2)


def test_a_request_without_a_point_gets_the_first_one(result: xr.Dataset):
    subject = subject_of_result(result, "a.nc")
    found = answer({"tab": "a", "number": "1"}, subject)
    assert {name: float(text) for name, text in found["at"].items()} == {
        "at.temperature": 250.0,
        "at.spring_stiffness": result.spring_stiffness.values[4],
    }
    assert "The same numbers as in the file, to the last bit." in found["summary"]


def test_a_point_of_the_file_is_computed_as_there(result: xr.Dataset):
    place = {"at.temperature": "230", "at.spring_stiffness": "500"}
    found = answer(place, subject_of_result(result, "a.nc"))
    orbit = point_of(result, temperature=230, spring_stiffness=500).orbit()
    assert found["shown"]["friction_force_amplitude"] == 1e3 * orbit.friction_force_amplitude
    assert found["at"] == place
    assert found["parts"]["integrator.rtol"] == "1e-4"


@pytest.mark.parametrize("treatment", [name for name in NOISE_TREATMENTS if name != "stochastic"])
def test_settings_are_read_as_in_a_config(treatment: str):
    settings = {"noise.treatment": treatment, "integrator.rtol": "1e-8"}
    assert answer({**settings, "phi_0": "0.1"})["settings"].items() >= settings.items()


def test_a_film_without_noise_that_begins_solid_has_its_numbers():
    found = answer({"noise.treatment": "none", "phi_0": "0.01"})
    parameters = Parameters(initial_order_parameter=0.01)
    orbit = stationary_orbit(parameters, noise="none")
    assert found["courses"] is not None
    assert found["shown"]["friction_force_amplitude"] == 1e3 * orbit.friction_force_amplitude


def test_the_texts_of_a_point_without_an_orbit_give_the_motion_that_is_drawn():
    """They begin at its start, since `start: stationary` is refused for such a point."""
    found = answer({"T": "250", "stationary.max_periods": "1"})
    config = from_yaml(found["config"])
    assert (config.simulation.start, config.simulation.periods) == ("initial", 6)
    assert found["periods"] == pytest.approx(6)
    assert "--set simulation.start=initial --periods 6" in found["command"]


def test_an_invalid_value_is_refused_by_the_name_of_its_box():
    found = answer({"T": "-5", "k": "1,5", "K": "2000"})
    assert found["state"] == "refused"
    assert found["refused"] == {
        "temperature": "temperature must be at least 0, not -5.0",
        "viscosity_coefficient": "viscosity_coefficient must be a number, not '1,5'; write it with "
        "a decimal point",
    }
    assert set(found["parts"]) == {"temperature", "viscosity_coefficient", "spring_stiffness"}
    assert answer({"temprature": "1"})["sentence"].startswith("temprature is neither")
    assert answer({"number": "one"})["state"] == "refused"


def test_a_sentence_reports_an_orbit_that_cannot_be_computed(monkeypatch: pytest.MonkeyPatch):
    def compute(shown_point: ShownPoint) -> Motion:
        return Motion(shown_point, trouble="It cannot be.")

    monkeypatch.setattr(module, "compute", compute)
    found = answer({"T": "250"})
    assert found["state"] == "done"
    assert found["courses"] is None
    assert "It cannot be." in found["summary"]


def test_a_later_request_of_the_tab_makes_the_older_void(monkeypatch: pytest.MonkeyPatch):
    turns, begun, asked = Turns(), threading.Event(), threading.Event()

    def compute(shown_point: ShownPoint) -> Any:
        begun.set()
        assert asked.wait(60)
        check_interruption()  # as between two kernels
        raise AssertionError("a later request was there")

    monkeypatch.setattr(module, "compute", compute)
    lines: list[str] = []

    def first() -> None:
        parts = {"T": "250", "tab": "a", "number": "1"}
        lines.extend(line["state"] for line in answer_lines(parts, subject_of_paper(), turns))

    thread = threading.Thread(target=first)
    thread.start()
    assert begun.wait(60)
    with turns.take("a", 2):
        asked.set()
        thread.join(60)
    assert lines[-1] == "void"


# --- the summary of a point -----------------------------------------------------------------------


LOOSE = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}


def shown_point(config: dict[str, Any] = LOOSE) -> ShownPoint:
    return point_alone(from_mapping(config), Parameters())


def words(html: str) -> str:
    return re.sub(r"\s+", " ", re.sub("<[^>]+>", " ", html))


def test_amplitudes_have_as_many_digits_as_are_known():
    name = "elastic_stress_amplitude"
    assert amplitude_text(name, 4.304778e6, 4.3e6 * 3e-8) == "4.304778 MPa"
    assert amplitude_text(name, 4.304778e6, 4.3e6 * 2e-3) == "4.3 MPa"
    assert amplitude_text("friction_force_amplitude", 2.8e-3, 0.0) == "2.800000 mN"
    assert amplitude_text(name, 3e-16, 0.5) == "below 5.0\u00a0×\u00a010<sup>−7</sup> MPa"
    assert amplitude_text(name, float("nan"), 1.0) == "—"


@pytest.mark.parametrize("fifth_harmonic", [0.0, 0.2])
def test_errors_of_small_amplitudes_are_relative_to_the_springs(fifth_harmonic: float):
    """All tones of the drive move the springs, and the block."""
    orbit = stationary_orbit(Parameters(temperature=330.0), rtol=1e-4)
    place = {"temperature": 330.0, "angular_frequency": 100.0, "fifth_harmonic": fifth_harmonic}
    errors = absolute_errors(orbit, Parameters(**place))
    stress, force = (scale.item() for scale in error_scales(row(**place)))
    assert errors["elastic_stress_amplitude"] == pytest.approx(orbit.amplitude_error * stress)
    larger = max(orbit.friction_force_amplitude, force)
    assert errors["friction_force_amplitude"] == pytest.approx(orbit.amplitude_error * larger)


def test_a_summary_has_regime_and_status():
    motion = compute(shown_point())
    orbit, summary = motion.orbit, words(summary_html(motion))
    assert isinstance(orbit, Orbit)
    assert "stick-slip, symmetric . The film melts and freezes" in summary
    assert "ok . The stationary orbit was reached and measured." in summary
    assert f"{orbit.elastic_stress_amplitude / 1e6:.3g}" in summary
    assert f"Floquet multiplier |μ| {orbit.floquet_multiplier:#.3g}" in summary
    assert motion.courses is not None
    assert motion.courses.sizes["elapsed_time"] == 2001


def test_a_summary_has_energy_and_harmonics_with_their_units():
    motion = compute(shown_point({}))
    orbit, summary = motion.orbit, words(summary_html(motion))
    assert isinstance(orbit, Orbit)
    assert f"energy dissipated per period {1e9 * orbit.dissipated_energy:#.3g} ± " in summary
    assert summary.count(" ± ") == 3
    errors = re.findall(r"± (\d\.\d) × 10 − ?(\d+) (nJ|mN)", summary)
    assert [unit for _, _, unit in errors] == ["nJ", "mN", "mN"], summary
    mantissa, power, _ = errors[0]
    error = float(f"{mantissa}e-{power}")
    assert error == pytest.approx(1e9 * orbit.dissipated_energy_error, rel=0.06)
    out_of_phase = orbit.dissipated_energy / (np.pi * 0.8e-6)
    assert f"force in phase with its velocity F″ {1e3 * out_of_phase:#.3g} ± " in summary
    assert "mean of |F|" in summary


def test_a_failure_has_a_sentence_and_the_start_is_drawn():
    motion = compute(shown_point({"stationary": {"max_periods": 1}}))
    summary = words(summary_html(motion))
    assert Status.NOT_STATIONARY.sentence.replace("`", "") in summary
    assert "The motion is drawn from its start." in summary
    assert "—" in summary
    assert motion.courses is not None


def test_a_film_that_could_never_freeze_has_a_sentence():
    config = from_mapping({"noise": {"treatment": "none"}, "model": {"phi_0": 0.5}})
    motion = compute(point_alone(config, Parameters()))
    assert motion.orbit is None
    assert words(summary_html(motion)).strip().startswith("Initial_order_parameter (phi_0) = 0")


def test_an_unexpected_error_is_a_sentence(monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise RuntimeError("no <b>luck</b>")

    monkeypatch.setattr("sweeps.page.turns.periods_of", fail)
    summary = summary_html(compute(shown_point()))
    assert "Unexpected RuntimeError: no &lt;b&gt;luck&lt;/b&gt;" in summary


def test_a_point_of_a_file_is_compared_with_it(result: xr.Dataset):
    place = {"temperature": 2, "spring_stiffness": 7}
    point = point_of_result(result, place)
    assert "The same numbers as in the file" in words(summary_html(compute(point)))
    stored = {**point.point.stored, "friction_force_amplitude": 0.5}
    changed = replace(point, point=replace(point.point, stored=stored))
    summary = words(summary_html(compute(changed)))
    assert "The file has different numbers: friction_force_amplitude = 0.5." in summary
    pending = replace(point, point=replace(point.point, stored={"status": Status.PENDING}))
    assert "This point has no result in the file yet." in words(summary_html(compute(pending)))


def test_without_an_orbit_the_summary_is_the_reason():
    html = summary_html(Motion(shown_point(), trouble="No <luck>."))
    assert html == '<p class="trouble">No &lt;luck&gt;.</p>'
