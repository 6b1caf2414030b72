"""The served page in a real browser: controls compute a point, and a click opens one."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest
import xarray as xr
from support.browser import Tab, chromium, opened_tab
from support.marks import marked, one_then
from support.serving import running
from support.sweeps.processes import wait_until

from stickslip import Orbit, Parameters, stationary_orbit
from sweeps.config.load import from_yaml
from sweeps.page import answers, turns
from sweeps.page.answers import absolute_errors, amplitude_text
from sweeps.page.explorer import server_of
from sweeps.page.subject import ShownPoint, subject_of_paper, subject_of_result
from sweeps.points import point_of

__all__ = ["chromium"]  # a fixture

pytestmark = pytest.mark.slow  # a browser starts


class View(Tab):
    """A tab with the page in it."""

    def __init__(self, page: Any, server: Any, end: str = "") -> None:
        super().__init__(page)
        self.here = (f"http://127.0.0.1:{server.port}/",)
        page.goto(server.address + end)
        page.wait_for_selector("[data-name=regime]")

    def reset(self) -> None:
        self.page.locator("#reset").click()
        self.says("the paper's values")

    def box(self, name: str) -> Any:
        return self.page.locator(f"#box-{name}")

    def types(self, name: str, text: str) -> None:
        self.box(name).fill(text)
        self.box(name).press("Enter")

    def text(self, name: str) -> str:
        return self.page.locator(f"[data-name={name}]").inner_text()

    def amplitudes(self, orbit: Orbit, parameters: Parameters) -> list[Any]:
        """Locate the amplitudes of an orbit, which are there if the page shows this orbit."""
        return [
            self.page.locator(
                f"[data-name={name}]", has_text=amplitude_text(name, getattr(orbit, name), error)
            )
            for name, error in absolute_errors(orbit, parameters).items()
        ]

    def shows(self, parameters: Parameters, **options: float) -> None:
        """Wait until the page shows the amplitudes of the orbit at some parameters."""
        orbit = stationary_orbit(parameters, **options)
        for amplitude in self.amplitudes(orbit, parameters):
            amplitude.wait_for()

    def heading(self) -> str:
        """Return the heading of the page."""
        return self.page.locator("#where").inner_text()

    def says(self, text: str) -> None:
        self.page.get_by_text(text).first.wait_for()


@pytest.fixture(scope="module")
def server() -> Iterator[Any]:
    """Serve the paper's values."""
    with running(server_of(subject_of_paper())) as there:
        yield there


@pytest.fixture(scope="module")
def page(chromium: Any, server: Any) -> Iterator[View]:
    """Open the page in a tab."""
    with opened_tab(chromium) as tab:
        yield (seen := View(tab, server))
        assert seen.errors == []
        assert seen.requests_elsewhere(*seen.here) == []


@pytest.fixture
def view(page: View) -> View:
    """Return the page as it first opens."""
    page.reset()
    return page


def test_it_begins_with_the_papers_orbit(view: View):
    view.shows(Parameters())
    assert view.text("regime") == "stick-slip, symmetric"
    assert view.text("status") == "ok"
    assert view.text("orbit_periods") == "1"


def test_a_typed_value_moves_the_amplitudes(view: View):
    view.types("temperature", "250")
    view.shows(Parameters(temperature=250))
    view.types("spring_stiffness", "1e3")
    view.shows(Parameters(temperature=250, spring_stiffness=1e3))
    view.says("T = 250 K, K = 1000 N/m")


def test_a_slider_moves_the_amplitudes(view: View):
    view.page.locator("#slider-temperature").focus()
    for _ in range(20):
        view.page.keyboard.press("ArrowRight")
    box = view.box("temperature")
    assert 200 < float(box.input_value()) < 260
    wait_until(lambda: f"T = {box.input_value()} K" in view.heading())
    view.shows(Parameters(temperature=float(box.input_value())))


def test_settings_are_those_of_a_config(view: View):
    view.page.get_by_text("How it is computed").click()
    view.page.locator("[data-setting='integrator.rtol']").select_option("1e-8")
    wait_until(lambda: "integrator.rtol=1e-8" in end_of_address(view))
    view.shows(Parameters(), rtol=1e-8)


def test_an_invalid_value_is_refused_in_a_sentence(view: View):
    view.types("temperature", "-5")
    view.says("temperature must be at least 0, not -5.0. The page shows 200 K.")
    view.types("viscosity_coefficient", "1,5")
    view.says("viscosity_coefficient must be a number, not '1,5'; write it with a decimal point")
    view.types("temperature", "210")
    view.shows(Parameters(temperature=210))
    assert view.page.get_by_text("must be at least").count() == 0
    view.reset()
    view.shows(Parameters())
    assert view.box("viscosity_coefficient").input_value() == "50000"
    assert view.page.get_by_text("must be").count() == 0


def test_the_point_can_be_copied(view: View):
    view.types("temperature", "230")
    view.says("T = 230 K")
    view.page.get_by_text("Copy this point").click()
    written = view.page.locator("#copy-config")
    wait_until(lambda: "230" in written.input_value())
    assert from_yaml(written.input_value()).parameters() == Parameters(temperature=230)
    command = view.page.locator("#copy-command").input_value()
    assert "--set temperature=230 " in command


def test_a_long_computation_is_announced_and_passed_over(
    view: View, monkeypatch: pytest.MonkeyPatch
):
    end, prepared = threading.Event(), turns.prepare

    def prepare(shown_point: Any) -> None:
        if shown_point.point.parameters.temperature == 260.0:
            assert end.wait(60)
        prepared(shown_point)

    monkeypatch.setattr(answers, "prepare", prepare)
    view.types("temperature", "260")
    view.says("compiling for this processor")
    view.types("temperature", "270")
    view.shows(Parameters(temperature=270))
    assert view.page.get_by_text("compiling").count() == 0
    end.set()


@pytest.mark.stress
def test_each_tab_has_its_own_point(view: View, chromium: Any, server: Any):
    with opened_tab(chromium) as tab:
        other = View(tab, server)
        other.types("temperature", "250")
        other.says("T = 250 K")
        assert view.box("temperature").input_value() == "200"


@pytest.fixture(scope="module")
def map_page(chromium: Any, result: xr.Dataset) -> Iterator[View]:
    subject = subject_of_result(result, "a <map>.nc")
    with running(server_of(subject)) as server, opened_tab(chromium) as page:
        yield (seen := View(page, server))
        assert seen.errors == []
        assert seen.requests_elsewhere(*seen.here) == []


@pytest.fixture
def map_view(map_page: View) -> View:
    """Return the page as it first opens."""
    map_page.page.locator("#reset").click()
    map_page.says("T = 250 K, K = 2000 N/m")
    return map_page


def test_a_click_on_the_map_opens_that_point(map_view: View, result: xr.Dataset):
    map_view.says("a <map>.nc")
    assert map_view.box("temperature").input_value() == "250"
    click(map_view, 0.35, 0.3)
    wait_until(lambda: map_view.box("temperature").input_value() != "250")
    temperature = float(map_view.box("temperature").input_value())
    stiffness = float(map_view.box("spring_stiffness").input_value())
    point = point_of(result, temperature=temperature, spring_stiffness=stiffness)
    assert point.parameters.temperature == temperature
    for amplitude in map_view.amplitudes(point.orbit(), point.parameters):
        amplitude.wait_for()
    map_view.says("The same numbers as in the file, to the last bit.")


@pytest.mark.stress
def test_from_a_point_of_the_file_sliders_go_on(map_view: View, result: xr.Dataset):
    point = point_of(result, temperature=250, spring_stiffness=2000)
    map_view.types("temperature", "225.5")
    map_view.shows(point.parameters._replace(temperature=225.5), rtol=1e-4)
    assert map_view.page.get_by_text("as in the file").count() == 0


def click(view: View, across: float, up: float) -> None:
    """Click on the map at these fractions of its width and height."""
    frame = view.page.locator("#picture .bk-Canvas").first.bounding_box()
    x = frame["x"] + across * frame["width"]
    view.page.mouse.click(x, frame["y"] + (1.0 - up) * frame["height"])


# The text on an orbit is beside or above its portrait, and not beneath it.
_APART = """() => {
  const [words, portrait] = ["orbit-words", "portrait"].map((id) => document.getElementById(id));
  const [one, other] = [words.getBoundingClientRect(), portrait.getBoundingClientRect()];
  return one.left + words.scrollWidth <= other.left || one.bottom <= other.top;
}"""


@pytest.mark.parametrize("width", [390, *marked("stress", [700, 1160, 1200, 1400])])
def test_it_fits_narrow_screens_and_phones(map_view: View, width: int):
    map_view.page.set_viewport_size({"width": width, "height": 844})
    try:
        wait_until(lambda: map_view.page.evaluate("document.documentElement.scrollWidth") <= width)
        wait_until(lambda: map_view.page.evaluate(_APART))
    finally:
        map_view.page.set_viewport_size({"width": 1500, "height": 950})


def end_of_address(view: View) -> str:
    return view.page.evaluate("location.hash").removeprefix("#")


def test_the_address_says_what_is_shown_and_opens_it_again(view: View):
    view.types("temperature", "240")
    view.types("rheological_index", "1/6")
    view.says("T = 240 K, γ = 1/6")
    wait_until(lambda: end_of_address(view) == "temperature=240&rheological_index=1%2F6")
    view.page.evaluate("location.hash = 'T=225.5&integrator.rtol=1e-8'")
    view.says("T = 225.5 K")
    view.shows(Parameters(temperature=225.5), rtol=1e-8)
    wait_until(lambda: "temperature=225.5&integrator.rtol=1e-8" in end_of_address(view))
    view.types("temperature", "230")
    view.says("T = 230 K")
    wait_until(lambda: "230" in end_of_address(view))


def test_an_address_that_cannot_be_shown_is_refused_in_a_sentence(view: View):
    view.page.evaluate("location.hash = 'temprature=240'")
    view.says("This page cannot show the address: temprature is neither")
    view.page.evaluate("location.hash = 'at.temperature=240'")
    view.says("The address names at.temperature, which this page does not have.")
    assert view.box("temperature").input_value() == "200"


@pytest.mark.parametrize(
    "end", one_then("stress", ["temprature=240", "T=-5", "integrator.rtol=none"])
)
def test_after_a_refused_address_the_controls_go_on(view: View, end: str):
    view.page.evaluate(f"location.hash = '{end}'")
    view.says("This page cannot show the address")
    view.types("spring_stiffness", "1000")
    view.shows(Parameters(spring_stiffness=1000))
    view.types("temperature", "250")
    view.shows(Parameters(spring_stiffness=1000, temperature=250))
    assert not view.page.get_by_text("cannot show the address").first.is_visible()


@pytest.mark.stress
def test_a_page_whose_address_is_refused_opens_as_without_it(chromium: Any, server: Any):
    orbit = stationary_orbit(Parameters())
    for end, why in (("K=-5", "spring_stiffness must be"), ("kept.T=-5", "temperature must be")):
        with opened_tab(chromium) as tab:
            seen = View(tab, server, f"#{end}")
            seen.says(f"This page cannot show the address: {why}")
            for amplitude in seen.amplitudes(orbit, Parameters()):
                amplitude.wait_for()


def test_a_refused_value_does_not_lose_the_one_before_it(
    view: View, monkeypatch: pytest.MonkeyPatch
):
    end, prepared = threading.Event(), turns.prepare

    def prepare(shown_point: Any) -> None:
        assert end.wait(60)
        prepared(shown_point)

    monkeypatch.setattr(answers, "prepare", prepare)
    view.types("spring_stiffness", "1000")
    view.types("temperature", "-5")
    view.says("temperature must be at least 0")
    end.set()
    view.shows(Parameters(spring_stiffness=1000))
    view.says("temperature must be at least 0, not -5.0. The page shows 200 K.")


@pytest.mark.stress
def test_two_orbits_lie_over_each_other_and_in_the_address(view: View, chromium: Any):
    view.page.locator("#keep").click()
    view.types("temperature", "250")
    view.says("Kept: the paper's values")
    view.shows(Parameters(temperature=250))
    view.types("temperature", "230")
    view.shows(Parameters(temperature=230))
    view.page.get_by_text("Drop the kept orbit").click()
    view.page.get_by_text("Keep this orbit").click()
    view.types("temperature", "240")
    wait_until(lambda: end_of_address(view) == "temperature=240&kept.temperature=230")
    with opened_tab(chromium) as tab:
        tab.goto(view.page.evaluate("location.href"))
        tab.get_by_text("Kept: T = 230 K").wait_for()
        tab.get_by_text("T = 240 K").first.wait_for()
    view.page.get_by_text("Drop the kept orbit").click()
    wait_until(lambda: "kept" not in end_of_address(view))


def test_the_blocks_play_pause_and_step(view: View):
    clock = view.page.locator("#clock")
    assert clock.inner_text().startswith("t = 0.0000 s")
    view.page.get_by_text("Play", exact=True).click()
    wait_until(lambda: not clock.inner_text().startswith("t = 0.0000 s"))
    view.page.get_by_text("Pause", exact=True).click()
    before = clock.inner_text()
    view.page.get_by_label("one step forward").click()
    assert clock.inner_text() != before
    view.page.get_by_label("one step back").click()
    assert clock.inner_text() == before
    view.page.locator("#time").fill("0")
    order = subject_of_paper().first.point.simulate(samples_per_period=2000).order_parameter
    assert clock.inner_text() == f"t = 0.0000 s, φ = {float(order[0]):.3f}"


def test_every_control_has_a_name(view: View):
    assert view.page.get_by_role("slider", name="temperature").count() == 1
    assert view.page.get_by_role("textbox", name="viscosity coefficient, Pa·sᵞ⁺¹").count() == 1


def test_arrow_keys_open_the_next_point_of_the_map(map_view: View):
    map_view.page.locator("#picture").focus()
    for key, temperature, stiffness in (
        ("ArrowRight", "260", "2000"),
        ("ArrowUp", "260", "2828.43"),
        ("ArrowLeft", "250", "2828.43"),
    ):
        map_view.page.keyboard.press(key)
        wait_until(lambda: map_view.box("temperature").input_value() == temperature)  # noqa: B023
        wait_until(lambda: map_view.box("spring_stiffness").input_value() == stiffness)  # noqa: B023
    wait_until(lambda: "at.temperature=250" in end_of_address(map_view))


def test_arrow_keys_go_on_from_a_point_that_is_not_computed_yet(
    map_view: View, monkeypatch: pytest.MonkeyPatch
):
    computed, pressed = turns.compute, threading.Event()

    def compute(shown_point: ShownPoint) -> turns.Motion:
        assert pressed.wait(60)
        return computed(shown_point)

    monkeypatch.setattr(answers, "compute", compute)
    map_view.page.locator("#picture").focus()
    for key in ("ArrowRight", "ArrowUp", "ArrowRight"):
        map_view.page.keyboard.press(key)
    pressed.set()
    map_view.says("T = 270 K, K = 2828.43 N/m")


@pytest.mark.stress
def test_zooming_is_in_the_address(map_view: View):
    frame = map_view.page.locator("#picture .bk-Canvas").first.bounding_box()
    map_view.page.mouse.move(frame["x"] + frame["width"] / 2, frame["y"] + frame["height"] / 2)
    map_view.page.evaluate("location.hash = 'zoom=220,260,600,3000&pinned=no'")
    wait_until(lambda: "zoom=220" in end_of_address(map_view))
