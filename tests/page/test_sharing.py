"""A page that is passed around: its address, keys, screen readers, and small windows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache
from typing import Any

import pytest
import xarray as xr
from support.browser import Tabs, chromium, tabs
from support.marks import marked, one_then

from sweeps import run
from sweeps.charts.choice import places_at
from sweeps.page import write_report

pytest.importorskip("bokeh", reason="bokeh is not installed")

__all__ = ["chromium", "tabs"]  # fixtures

pytestmark = pytest.mark.slow  # a browser opens many pages

Opened = Callable[..., Any]

LOOSE = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
SWEEPS = {
    "map": {
        "sweep": {
            "T": {"linspace": [200, 300], "num": 9},
            "K": {"geomspace": [500, 8000], "num": 9},
            "gamma": [-2 / 3, 0],
        }
    },
    "curves": {"sweep": {"T": {"linspace": [200, 300], "num": 5}, "gamma": [-2 / 3, 0, 2 / 3]}},
    "cloud": {"sample": {"sobol": 16, "seed": 1, "T": [150, 320], "omega": [5, 60]}},
    "both ways": {"sweep": {"omega": {"linspace": [36, 40], "num": 9}}, "follow": "omega"},
    "down": {"sweep": {"T": {"linspace": [200, 300], "num": 5}, "gamma": [0.5, 0, -2 / 3]}},
    "linked": {
        "sweep": {"omega": [10, 20]},
        "cases": {
            "T": {"linspace": [290, 210], "num": 12},
            "K": {"geomspace": [500, 8000], "num": 12},
        },
    },
    "single": {},
}


@cache
def result_of(name: str) -> xr.Dataset:
    return run(LOOSE | SWEEPS[name])


@pytest.fixture(scope="module")
def address_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], str]:
    """Return the address of the page of a sweep, made when it is first asked for."""
    folder = tmp_path_factory.mktemp("report")

    @cache
    def address_of(name: str) -> str:
        path = folder / f"{name}.html"
        write_report(result_of(name), path, name=f"{name}.nc", orbits=2)
        return path.as_uri()

    return address_of


@pytest.fixture(scope="module")
def as_it_is(chromium: Any, address_of: Callable[[str], str]) -> Iterator[Callable[[str], Any]]:
    """Open a page once, for all tests that leave it as it is."""
    with ExitStack() as contexts:
        own = Tabs(chromium, contexts)
        yield cache(lambda name: own.open(address_of(name), width=1400, height=900))
        own.check()


@pytest.fixture(scope="module")
def follow(chromium: Any, address_of: Callable[[str], str]) -> Iterator[Callable[[str], Any]]:
    """Make an open map follow the fragment of an address, as a click on a link does."""
    with ExitStack() as contexts:
        own = Tabs(chromium, contexts)
        tab = own.open(address_of("map"))

        def follow(end: str) -> Any:
            tab.evaluate(
                """end => new Promise((done) => {
                    addEventListener("hashchange", () => setTimeout(done), { once: true });
                    location.hash = end;
                })""",
                end,
            )
            return tab

        yield follow
        own.check()


@pytest.fixture
def opened(tabs: Tabs, address_of: Callable[[str], str]) -> Iterator[Opened]:
    """Open pages, which must have no errors and no warnings."""
    yield lambda name, end="", **window: tabs.open(address_of(name) + end, **window)
    tabs.check()


def has_address(tab: Any, *words: str) -> None:
    """Wait until the address has all of these parts, shortly after a change."""
    script = "words => words.every(word => location.hash.slice(1).split('&').includes(word))"
    try:
        tab.wait_for_function(script, arg=list(words), timeout=5000)
    except Exception as error:
        raise AssertionError(f"{words} are not in {tab.evaluate('location.hash')}") from error


def readout(tab: Any, row: int) -> str:
    text: str = tab.inner_text(f"#readout tr:nth-child({row}) td")
    return text


def click_in(tab: Any, across: float, down: float) -> None:
    box = tab.locator("#picture").bounding_box()
    tab.mouse.click(box["x"] + across * box["width"], box["y"] + down * box["height"])


def test_a_link_opens_what_was_looked_at(opened: Opened) -> None:
    tab = opened("map")
    assert tab.evaluate("location.hash") == ""
    history = tab.evaluate("history.length")
    tab.select_option("#view", index=1)
    tab.select_option("#variable", "friction_force_amplitude")
    tab.check("#log")
    click_in(tab, 0.5, 0.5)
    has_address(tab, "pinned=yes", "variable=friction_force_amplitude", "scale=log")
    assert tab.evaluate("history.length") == history
    address = tab.evaluate("location.hash")
    seen = [tab.inner_text(f"#{part}") for part in ("readout", "legend", "readout-heading")]
    other = opened("map", address)
    assert [other.inner_text(f"#{p}") for p in ("readout", "legend", "readout-heading")] == seen
    assert other.eval_on_selector("#view", "view => view.selectedIndex") == 1
    assert other.is_checked("#log")
    assert other.evaluate("location.hash") == address


@pytest.mark.stress
def test_only_what_is_pinned_or_chosen_changes_the_address(opened: Opened) -> None:
    tab = opened("map")
    box = tab.locator("#picture").bounding_box()
    tab.mouse.move(box["x"] + box["width"] / 3, box["y"] + box["height"] / 3)
    tab.wait_for_timeout(500)
    assert tab.evaluate("location.hash") == ""


@pytest.mark.stress
def test_values_of_an_address_are_those_of_the_axes_to_a_few_digits(opened: Opened) -> None:
    tab = opened("map", "#temperature=226&spring_stiffness=1.0e3&rheological_index=0&pinned=yes")
    assert [readout(tab, row) for row in (1, 2, 3)] == ["225 K", "1000 N/m", "0"]
    tab.keyboard.press("ArrowLeft")
    has_address(tab, "at.temperature=212.5", "at.spring_stiffness=1000", "at.rheological_index=0")
    tab.evaluate("location.hash = '#temperature=300'")  # as a click on another link
    tab.wait_for_function("() => document.getElementById('readout').innerText.includes('300 K')")
    assert tab.inner_text("#readout-heading") == "Point"


@pytest.mark.stress
@pytest.mark.parametrize(
    ("address", "variable"),
    [
        ("#T=225&K=1000&gamma=0&variable=F_max&pinned=yes", "friction_force_amplitude"),
        ("#T=225&K=1000&γ=0&variable=regime&pinned=yes", "regime"),
    ],
)
def test_an_address_may_have_the_symbols_of_the_paper(
    follow: Callable[[str], Any], address: str, variable: str
) -> None:
    tab = follow(address)
    assert [readout(tab, row) for row in (1, 2, 3)] == ["225 K", "1000 N/m", "0"]
    assert tab.input_value("#variable") == variable
    assert tab.inner_text("#readout-heading") == "Pinned point"
    assert not tab.locator("#strange").is_visible()


@pytest.mark.parametrize(
    ("address", "words", "heading"),
    [
        ("temprature=250&K=2000&pinned=yes", "temprature", "Point"),
        ("T=warm&K=&gamma=NaN&pinned=yes", "T=warm, K=, gamma=NaN", "Point"),
        ("T=2500&K=1e999&pinned=yes", "T=2500, K=1e999", "Point"),
        ("T=250&variable=constructor&view=<b>&pinned=yes",
         "variable=constructor, view=<b>", "Pinned point"),
        ("T=250&constructor=1&scale=log2&pinned=maybe",
         "constructor, scale=log2, pinned=maybe", "Point"),
        ("T=310&pinned=yes", "", "Pinned point"),
    ],
)  # fmt: skip
def test_the_page_names_the_parts_of_an_address_that_it_does_not_have(
    follow: Callable[[str], Any], address: str, words: str, heading: str
) -> None:
    tab = follow(address)
    line = tab.locator("#strange[role=status]")
    sentence = f"The address names {words}, which this page does not have." if words else ""
    ranges = (
        "It has temperature from 200 to 300, spring_stiffness from 500 to 8000, "
        "rheological_index from -0.6667 to 0."
    )
    assert line.text_content() == (f"{sentence} {ranges}" if words else "")
    assert line.is_visible() == bool(words)
    assert tab.inner_text("#readout-heading") == heading


@pytest.mark.stress
def test_that_line_disappears_with_the_next_change_and_nothing_moves(opened: Opened) -> None:
    tab = opened("map", "#temprature=250")
    before = tab.locator("#picture").bounding_box()["y"]
    click_in(tab, 0.5, 0.5)
    tab.locator("#strange").wait_for(state="hidden")
    assert tab.locator("#picture").bounding_box()["y"] == before
    tab.evaluate("location.hash = '#T=300&pressure=1'")
    tab.locator("#strange", has_text="pressure").wait_for(state="visible")


@pytest.mark.parametrize(
    "garbage",
    [
        "#view=none&variable=constructor&temperature=warm&spring_stiffness=&pinned=maybe",
        *marked(
            "stress",
            [
                "#%E0%A4%A&&==&temperature=NaN&spring_stiffness=1e999&scale=log2",
                "#look",
                "#%E2%80%A8%0A",
            ],
        ),
    ],
)
def test_garbage_in_the_address_changes_nothing(
    follow: Callable[[str], Any], as_it_is: Callable[[str], Any], garbage: str
) -> None:
    plain, tab = as_it_is("map"), follow(garbage)
    for part in ("readout", "legend", "readout-heading"):
        assert tab.inner_text(f"#{part}") == plain.inner_text(f"#{part}")


@pytest.mark.parametrize(
    ("name", "axis", "values"),
    one_then(
        "stress",
        [
            ("down", "rheological_index", ["-0.6667", "0", "0.5"]),
            ("linked", "case", ["0", "7", "11"]),
        ],
    ),
)
def test_an_address_names_points_that_are_not_in_rising_order(
    opened: Opened, name: str, axis: str, values: list[str]
) -> None:
    for value in values:
        tab = opened(name, f"#at.{axis}={value}&pinned=yes")
        assert f"--at {axis}={value}" in tab.inner_text("#replay")
        assert tab.text_content("#strange") == ""
    tab = opened(name, f"#at.{axis}=100")
    assert f"{axis} from {values[0]} to {values[-1]}" in tab.text_content("#strange")


@pytest.mark.stress
def test_the_way_along_a_followed_axis_is_in_the_address(opened: Opened) -> None:
    tab = opened("both ways", "#direction=down&angular_frequency=37.4&variable=regime&pinned=yes")
    assert "downward" in tab.inner_text("#readout")
    assert "37.5 rad/s" in tab.inner_text("#readout")
    tab.keyboard.press("ArrowRight")
    has_address(tab, "at.direction=down", "at.angular_frequency=38", "variable=regime")


def test_arrow_keys_move_the_pin_on_a_map(opened: Opened) -> None:
    tab = opened("map", "#temperature=250&spring_stiffness=2000")
    tab.focus("#picture")
    tab.keyboard.press("ArrowUp")
    has_address(tab, "at.temperature=250", "at.spring_stiffness=2828", "pinned=yes")
    tab.keyboard.press("ArrowRight")
    tab.keyboard.press("ArrowDown")
    has_address(tab, "at.temperature=262.5", "at.spring_stiffness=2000")
    assert tab.text_content("#spoken").startswith("T = 262.5 K, K = 2000 N/m, γ = −2/3: ")
    for key, end in (("End", "300"), ("ArrowRight", "300"), ("Home", "200"), ("ArrowLeft", "200")):
        tab.keyboard.press(key)
        has_address(tab, f"at.temperature={end}")
    assert tab.evaluate("scrollY") == 0
    tab.keyboard.press("Escape")
    assert tab.inner_text("#readout-heading") == "Point"


@pytest.mark.stress
def test_keys_leave_no_crosshair_at_the_mouse(opened: Opened) -> None:
    tab = opened("map", "#T=250&pinned=yes")
    drawn = """() => Bokeh.documents[0].roots()[0].children[0].toolbar.tools
        .find((tool) => tool.type === "CrosshairTool").overlay
        .map((line) => Number.isFinite(line.location))"""
    box = tab.locator("#picture").bounding_box()
    tab.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.3 * box["height"])
    tab.wait_for_function(f"() => ({drawn})().every(Boolean)")
    tab.keyboard.press("ArrowRight")
    assert tab.evaluate(f"({drawn})()") == [False, False]
    tab.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.3 * box["height"])
    tab.wait_for_function(f"() => ({drawn})().every(Boolean)")


@pytest.mark.stress
def test_a_command_has_as_few_digits_as_its_point_needs(opened: Opened) -> None:
    tab = opened("map", "#T=262.5&K=2828&gamma=-0.667&pinned=yes")
    command = tab.inner_text("#replay").split(" --at ")[1:]
    assert command == ["temperature=262.5", "spring_stiffness=2828", "rheological_index=-0.6667"]
    place = places_at(result_of("map"), command)
    assert place == {"temperature": 5, "spring_stiffness": 5, "rheological_index": 0}


@pytest.mark.stress
def test_the_frame_of_the_focus_is_clear_of_the_legend(opened: Opened) -> None:
    tab = opened("map", "#variable=regime")
    legend, picture = (tab.locator(part).bounding_box() for part in ("#legend", "#picture"))
    assert picture["y"] - (legend["y"] + legend["height"]) >= 6  # the frame takes 4


@pytest.mark.stress
def test_arrow_keys_move_the_pin_along_curves_and_between_them(opened: Opened) -> None:
    tab = opened("curves", "#temperature=250&rheological_index=0&pinned=yes")
    tab.keyboard.press("ArrowLeft")
    has_address(tab, "at.temperature=225", "at.rheological_index=0")
    tab.keyboard.press("ArrowUp")  # a pseudoplastic film carries more
    has_address(tab, "at.temperature=225", "at.rheological_index=-0.6667")
    for _ in range(3):
        tab.keyboard.press("ArrowDown")
    has_address(tab, "at.temperature=225", "at.rheological_index=0.6667")


@pytest.mark.stress
def test_arrow_keys_go_to_the_next_point_of_a_cloud(opened: Opened) -> None:
    tab = opened("cloud", "#pinned=yes")
    by_temperature = result_of("cloud").sortby("temperature")["case"].values.tolist()
    tab.keyboard.press("Home")
    has_address(tab, f"at.case={by_temperature[0]}")
    for case in by_temperature[1:4]:
        tab.keyboard.press("ArrowRight")
        has_address(tab, f"at.case={case}")


@pytest.mark.stress
def test_keys_still_serve_controls_and_readers(opened: Opened) -> None:
    tab = opened("map", "", height=500)
    tab.keyboard.press("ArrowDown")  # nothing is pinned: it scrolls
    tab.wait_for_function("() => scrollY > 0")
    tab.evaluate("scrollTo(0, 0)")
    tab.focus("#variable")
    tab.keyboard.press("ArrowDown")
    has_address(tab, "variable=friction_force_amplitude")
    assert tab.inner_text("#readout-heading") == "Point"
    tab.keyboard.press("Escape")
    tab.evaluate("document.activeElement.blur()")
    tab.keyboard.press("ArrowRight")
    has_address(tab, "pinned=yes")
    before = tab.evaluate("scrollY")
    tab.keyboard.press("ArrowDown")
    tab.wait_for_timeout(300)
    assert tab.evaluate("scrollY") == before


@pytest.mark.parametrize("name", one_then("stress", [*SWEEPS]))
def test_everything_is_named_for_screen_readers(as_it_is: Callable[[str], Any], name: str) -> None:
    tab = as_it_is(name)
    unnamed = """() => [...document.querySelectorAll("select, input")].filter(
        ({ labels, ariaLabel }) => !(labels.length ? labels[0].textContent : ariaLabel)?.trim())"""
    assert tab.evaluate(f"({unnamed})().map((control) => control.outerHTML)") == []
    for part in ("portrait", "courses", "along-x", "along-y"):
        assert tab.get_attribute(f"#{part}", "role") == "img"
        assert tab.get_attribute(f"#{part}", "aria-label")
    assert tab.locator("th:not([scope])").count() == 0
    assert tab.locator("th:empty").count() == 0
    assert tab.locator("section:not([aria-label], [aria-labelledby])").count() == 0
    dangling = """() => ["aria-labelledby", "aria-describedby"].flatMap((kind) =>
        [...document.querySelectorAll(`[${kind}]`)].map((one) => one.getAttribute(kind))
    ).filter((id) => !document.getElementById(id))"""
    assert tab.evaluate(dangling) == []
    assert tab.locator("main").count() == tab.locator("header h1").count() == 1


@pytest.mark.stress
def test_the_picture_and_sliders_say_what_they_show(opened: Opened) -> None:
    tab = opened("map", "#variable=regime")
    assert tab.get_attribute("#picture", "aria-label") == "map over T and K: regime"
    assert tab.get_attribute("#picture", "tabindex") == "0"
    hint = tab.get_attribute("#picture", "aria-describedby")
    assert "Arrow keys" in tab.inner_text(f"#{hint}")
    assert tab.get_attribute("#spoken", "aria-live") == "polite"
    slider = "#sliders label:visible input"
    tab.press(slider, "End")
    assert tab.get_attribute(slider, "aria-valuetext") == "γ = 0"
    tab.hover("#picture")
    assert tab.text_content("#spoken") == ""


@pytest.mark.parametrize("name", one_then("stress", [*SWEEPS]))
def test_indices_are_lowered_or_not_there(as_it_is: Callable[[str], Any], name: str) -> None:
    tab = as_it_is(name)
    words = tab.text_content("main")
    assert "T_c" not in words
    assert "_max" not in words


@pytest.mark.parametrize("name", one_then("stress", [*SWEEPS]))
def test_a_page_fits_a_phone(opened: Opened, name: str) -> None:
    tab = opened(name, width=390, height=844, has_touch=True, is_mobile=True)
    tab.eval_on_selector("details", "details => { details.open = true; }")
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    if tab.locator("#picture").is_visible():
        for control in tab.locator(".controls select:visible, .controls label:visible").all():
            assert control.bounding_box()["height"] >= 24


@pytest.mark.stress
def test_a_tap_pins_and_a_swipe_over_the_map_scrolls(opened: Opened) -> None:
    tab = opened("map", width=390, height=844, has_touch=True, is_mobile=True)
    box = tab.locator("#picture").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.touchscreen.tap(x, y)
    has_address(tab, "pinned=yes")
    fingers = tab.context.new_cdp_session(tab)
    for kind, moved in [("touchStart", 0), *(("touchMove", 12 * n) for n in range(1, 16))]:
        touch = [{"x": x, "y": y - moved}]
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touch})
    fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    tab.wait_for_function("() => scrollY > 0")


@pytest.mark.parametrize("name", one_then("stress", ["map", "curves", "cloud", "both ways"]))
def test_the_picture_and_its_numbers_are_seen_at_first_glance(
    as_it_is: Callable[[str], Any], name: str
) -> None:
    tab = as_it_is(name)
    for part in ("#picture", "#readout"):
        box = tab.locator(part).bounding_box()
        assert box["y"] + box["height"] <= 900
