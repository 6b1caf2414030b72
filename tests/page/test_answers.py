"""What a page is told that asks for a point: the orbit as in Python, or why there is none."""

from __future__ import annotations

import base64
import json
import threading
from typing import Any

import numpy as np
import pytest
import xarray as xr

pytest.importorskip("bokeh", reason="bokeh is not installed")
from stickslip import Parameters, stationary_orbit
from stickslip.kernels.interruption import check_interruption
from stickslip.options import NOISE_TREATMENTS
from sweeps.config.load import from_yaml
from sweeps.page import answers as module
from sweeps.page.answers import answer_lines, as_json
from sweeps.page.subject import ShownPoint, subject_of_paper, subject_of_result
from sweeps.page.turns import DRAWN, Motion, Turns
from sweeps.points import point_of


def answer(parts: dict[str, str], subject: Any = None) -> dict[str, Any]:
    """The last line, as a browser reads it."""
    *_, last = answer_lines(parts, subject or subject_of_paper(), Turns())
    return dict(json.loads(as_json(last)))


def test_it_tells_what_is_done_and_then_the_orbit():
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


def test_nothing_asked_for_is_what_the_page_begins_with(result: xr.Dataset):
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
def test_settings_are_taken_as_in_a_config(treatment: str):
    asked = {"noise.treatment": treatment, "integrator.rtol": "1e-8", "phi_0": "0.1"}
    found = answer(asked)
    assert found["settings"]["noise.treatment"] == treatment
    assert found["settings"]["integrator.rtol"] == "1e-8"


def test_what_is_not_valid_is_refused_by_the_name_of_its_box():
    found = answer({"T": "-5", "k": "1,5", "K": "2000"})
    assert found["state"] == "refused"
    assert found["refused"] == {
        "temperature": "temperature must be at least 0, not -5.0",
        "viscosity_coefficient": "viscosity_coefficient must be a number, not '1,5'; write it with "
        "a decimal point",
    }
    assert answer({"temprature": "1"})["sentence"].startswith("temprature is neither")
    assert answer({"number": "one"})["state"] == "refused"


def test_an_orbit_that_cannot_be_computed_is_told_in_a_sentence(monkeypatch: pytest.MonkeyPatch):
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
