"""The page of `stickslip report`: its content and safety, without any other file."""

from __future__ import annotations

import json
import re
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from support.browser import Tabs, chromium, tabs
from support.marks import one_then

from stickslip import Status
from sweeps import run
from sweeps.charts.chart import Curves, break_line, chart_of
from sweeps.charts.choice import Choice
from sweeps.page import MOST_POINTS, ReportError, name_of, write_report
from sweeps.page.explorer import explore

pytest.importorskip("bokeh", reason="bokeh is not installed")

__all__ = ["chromium", "tabs"]  # fixtures

LOOSE = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
MAP = LOOSE | {
    "title": "Odd </script><b>title</b> <!--",
    "sweep": {
        "T": {"linspace": [200, 300], "num": 9},
        "K": {"geomspace": [500, 8000], "num": 9},
        "gamma": [-2 / 3, 0],
    },
}
LINE = LOOSE | {"sweep": {"omega": {"linspace": [36, 40], "num": 9}}, "follow": "omega"}


@pytest.fixture(scope="module")
def ds() -> xr.Dataset:
    ds = run(MAP)
    ds.status[0, 0, 0] = Status.DIVERGED
    for name in ("elastic_stress_amplitude", "friction_force_amplitude", "amplitude_error"):
        ds[name][0, 0, 0] = np.nan
    return ds


@pytest.fixture(scope="module")
def page(ds: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "map.html"
    write_report(ds, path, name="map <i>.nc", orbits=20)
    return path


def payload_of(page: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(payload_text(page))
    return data


def payload_text(page: Path) -> str:
    text = page.read_text("utf-8")
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    return found[1]


def test_no_text_of_the_file_becomes_markup(page: Path) -> None:
    text = page.read_text("utf-8")
    assert "<b>title</b>" not in text
    assert "map <i>.nc" not in text
    assert "Odd &lt;/script&gt;&lt;b&gt;title" in text
    assert "<" not in payload_text(page)


def test_the_page_forbids_the_network(page: Path) -> None:
    text = page.read_text("utf-8")
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert "default-src 'none'" in policy
    assert "http" not in policy
    assert not re.search(r'<(?:script|link|img)[^>]+(?:src|href)="http', text)


def test_failed_points_have_an_orbit_and_a_row_of_a_table(page: Path) -> None:
    orbits = payload_of(page)["orbits"]
    assert len(orbits) == 20
    assert 0 in [orbit["point"] for orbit in orbits]
    text = page.read_text("utf-8")
    assert "diverged" in text
    assert Status.DIVERGED.sentence.split(".", maxsplit=1)[0] in text


@pytest.mark.stress
def test_the_same_result_makes_the_same_page(ds: xr.Dataset, page: Path, tmp_path: Path) -> None:
    write_report(ds, tmp_path / "again.html", name="map <i>.nc", orbits=20)
    assert (tmp_path / "again.html").read_bytes() == page.read_bytes()


@pytest.mark.parametrize("source", [LOOSE, LINE, LOOSE | {"sweep": {"T": [200.0, 250.0]}}])
def test_every_kind_of_result_has_a_page(source: dict[str, Any], tmp_path: Path) -> None:
    write_report(run(source), tmp_path / "a.html", name="a.nc", orbits=3)
    assert payload_of(tmp_path / "a.html")["replay"] == "stickslip replay a.nc"


def test_a_slice_can_be_taken_and_too_large_a_result_is_refused(
    ds: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_report(ds, tmp_path / "a.html", name="a.nc", at=["gamma=0"], orbits=0)
    assert payload_of(tmp_path / "a.html")["replay"].endswith("replay a.nc --at gamma=0")
    assert payload_of(tmp_path / "a.html")["fewestDigits"] == 4
    some = ["gamma=0", "T=200,250"]
    write_report(ds, tmp_path / "a.html", name="a.nc", at=some, orbits=0)
    # Rounded values may be nearest to points of the file between these two.
    assert payload_of(tmp_path / "a.html")["fewestDigits"] == 17
    assert payload_of(tmp_path / "a.html")["replay"].endswith("replay a.nc --at gamma=0")
    # Both values are nearest to one point.
    write_report(ds, tmp_path / "a.html", name="a.nc", at=["T=250,251"], orbits=0)
    assert payload_of(tmp_path / "a.html")["replay"].endswith("replay a.nc --at T=250")
    assert ds.status.size < MOST_POINTS
    monkeypatch.setattr("sweeps.page.document.MOST_POINTS", 10)
    with pytest.raises(
        ReportError, match=r"162 points, but a page holds at most 10.*--at temperature=200"
    ):
        write_report(ds, tmp_path / "b.html", name="b.nc")
    assert not (tmp_path / "b.html").exists()
    with pytest.raises(ReportError, match="162 points, but a page holds at most 10"):
        explore(ds)


def test_a_trajectory_is_not_the_result_of_a_sweep(ds: xr.Dataset, tmp_path: Path) -> None:
    course = ds.stickslip.at(T=250, K=500, gamma=0).simulate()
    with pytest.raises(ReportError, match="does not hold the result of a sweep"):
        write_report(course, tmp_path / "a.html", name="a.nc")


@pytest.mark.stress
def test_the_accessor_writes_it_too(ds: xr.Dataset, tmp_path: Path) -> None:
    part = ds.isel(temperature=slice(0, 3), spring_stiffness=0)
    assert part.stickslip.report(tmp_path / "a.html").exists()


def test_masked_points_have_no_result_on_a_page(ds: xr.Dataset, tmp_path: Path) -> None:
    ds.stickslip.ok().isel(temperature=[0, 1]).stickslip.report(tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text("utf-8")
    assert "Every point that was computed has a result." in text
    assert "<td>pending</td><td>1</td>" in text


@pytest.mark.stress
def test_a_variable_with_its_axes_in_another_order_is_the_same(
    ds: xr.Dataset, tmp_path: Path
) -> None:
    turned = ds.assign(regime=ds.regime.transpose())
    payloads = []
    for one in (ds, turned):
        write_report(one, tmp_path / "a.html", name="a.nc", orbits=0)
        payloads.append(payload_of(tmp_path / "a.html"))
    assert payloads[0] == payloads[1]


@pytest.mark.stress
@pytest.mark.parametrize("films", [["soft", "<stiff>"], [1, 2]])
def test_a_stack_of_results_has_a_page(ds: xr.Dataset, tmp_path: Path, films: list[Any]) -> None:
    """No orbit is computed with the settings of another result of the stack."""
    part = ds.isel(temperature=[4, 5], spring_stiffness=4, rheological_index=0)
    stack = xr.concat([part, part], pd.Index(films, name="film"))
    stack["periods_integrated"][1] += 1  # as if its settings were others
    write_report(stack, tmp_path / "a.html", name="a.nc", orbits=4)
    data = payload_of(tmp_path / "a.html")
    names = [parameter["name"] for parameter in data["parameters"]]
    assert {axis["name"] for axis in data["axes"]} == {"film", "temperature"} == set(names)
    assert [orbit["drawn"] for orbit in data["orbits"]] == [True, True, False, False]
    assert "with different settings" in data["orbits"][2]["words"]


def test_results_joined_along_a_parameter_have_no_orbits_of_other_settings(tmp_path: Path) -> None:
    swept = LOOSE | {"sweep": {"T": [200.0, 250.0]}}
    fine = swept | {"model": {"K": 2500}, "integrator": {"rtol": 1e-6}}
    joined = xr.concat([run(swept), run(fine)], "spring_stiffness")
    write_report(joined, tmp_path / "a.html", name="a.nc", orbits=4)
    orbits = payload_of(tmp_path / "a.html")["orbits"]
    assert [orbit["drawn"] for orbit in orbits] == [False, False, True, True]  # by stiffness


def test_kinds_alone_have_a_page(ds: xr.Dataset, tmp_path: Path) -> None:
    kinds = ds[["status", "regime"]]
    write_report(kinds, tmp_path / "a.html", name="a.nc", orbits=0)
    data = payload_of(tmp_path / "a.html")
    assert [variable["name"] for variable in data["variables"]] == ["regime", "status"]
    assert all("kinds" in view for view in data["views"])


@pytest.fixture
def opened(tabs: Tabs, page: Path) -> Iterator[Any]:
    """Open the page in a tab, which must have no errors and request nothing from elsewhere."""
    yield tabs.open(page.as_uri())
    tabs.check()


def test_a_click_draws_an_orbit_and_a_slider_cuts(opened: Any) -> None:
    box = opened.locator("#picture").bounding_box()
    opened.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"])
    opened.wait_for_function("document.getElementById('readout').innerText.includes(' K\\n')")
    before = opened.inner_text("#orbit-words")
    opened.mouse.click(box["x"] + 0.7 * box["width"], box["y"] + 0.8 * box["height"])
    opened.wait_for_function(
        "before => document.getElementById('orbit-words').innerText !== before", arg=before
    )
    assert "stickslip replay" in opened.inner_text("#orbit-words")
    assert opened.inner_text("#readout-heading") == "Pinned point"
    shown = opened.inner_text("#sliders")
    opened.locator("#sliders label:visible input").press("ArrowRight")
    opened.wait_for_function(
        "shown => document.getElementById('sliders').innerText !== shown", arg=shown
    )


def drawn(opened: Any, host: str) -> dict[str, Any]:
    """Return the columns of all shapes of the figure in a host, by the names of the shapes."""
    script = """host => {
        const root = Bokeh.documents[0].roots()[["picture", "along-x", "along-y"].indexOf(host)];
        const plain = (data) => Object.fromEntries(Object.entries(data).map(
            ([name, values]) => [name, Array.from(name === "image" ? values[0] : values)]));
        return Object.fromEntries(root.children[0].renderers.filter((shape) => shape.name).map(
            (shape) => [shape.name, plain(shape.data_source.data)]));
    }"""
    shapes: dict[str, Any] = opened.evaluate(script, host)
    return shapes


@pytest.mark.parametrize("variable", one_then("stress", ["friction_force_amplitude", "regime"]))
def test_a_map_and_its_curves_are_those_of_the_result(
    opened: Any, ds: xr.Dataset, variable: str
) -> None:
    opened.select_option("#variable", variable)
    opened.locator("#sliders label:visible input").press("End")
    opened.locator("button[data-point]").first.click()
    chart = chart_of(ds, Choice(variable))
    image = drawn(opened, "picture")["cells"]["image"]
    np.testing.assert_allclose(image, chart.image().ravel(), rtol=1e-6)
    assert np.isnan(image[0])
    line = chart_of(ds.isel(spring_stiffness=0, rheological_index=0), Choice(variable))
    along = drawn(opened, "along-x")
    if variable == "regime":
        np.testing.assert_array_equal(along["cells"]["image"], line.image()[0])
    else:
        x, y = break_line(line.across, line.curves[0].values, line.curves[0].jumps)
        np.testing.assert_allclose(along["curve 0"]["x"], x)
        np.testing.assert_allclose(along["curve 0"]["y"], y, rtol=1e-6)
        assert along["missing 0"]["x"] == [200.0]
        assert len(along["jumps 0"]["x"]) == line.curves[0].jumps.sum()


@pytest.mark.stress
def test_a_mark_leaves_most_of_a_small_cell_to_its_colour(opened: Any) -> None:
    dot = """() => Bokeh.documents[0].roots()[0].children[0].renderers
        .find((shape) => shape.name === "orbits").glyph"""
    width = opened.evaluate(f"({dot})().size.value + ({dot})().line_width.value")
    cell = opened.locator("#picture").bounding_box()["height"] / 60
    assert width**2 < 0.25 * cell**2


@pytest.mark.stress
def test_both_ways_are_drawn_with_their_jumps(tabs: Tabs, tmp_path: Path) -> None:
    ds = run(LINE)
    write_report(ds, tmp_path / "a.html", name="a.nc", orbits=0)
    chart = chart_of(ds, Choice("elastic_stress_amplitude"))
    assert isinstance(chart, Curves)
    shapes = drawn(tabs.open((tmp_path / "a.html").as_uri()), "picture")
    tabs.check()
    assert sum(curve.jumps.sum() for curve in chart.curves) > 0
    for number, curve in enumerate(chart.curves):
        x, y = break_line(chart.across, curve.values, curve.jumps)
        np.testing.assert_allclose(shapes[f"curve {number}"]["x"], x)
        np.testing.assert_allclose(shapes[f"curve {number}"]["y"], y, rtol=1e-6)


@pytest.mark.stress
def test_a_slider_cuts_curves(tabs: Tabs, tmp_path: Path) -> None:
    axes = {"T": {"linspace": [200, 300], "num": 5}, "gamma": [-2 / 3, 0], "K": [1e3, 3e3]}
    ds = run(LOOSE | {"sweep": axes})
    write_report(ds, tmp_path / "a.html", name="a.nc", orbits=0)
    tab = tabs.open((tmp_path / "a.html").as_uri())
    slider = tab.locator("#sliders label:visible input")
    for place, key in enumerate(("Home", "End")):
        slider.press(key)
        chart = chart_of(ds.isel(spring_stiffness=place), Choice("elastic_stress_amplitude"))
        for number, curve in enumerate(chart.curves):
            shape = drawn(tab, "picture")[f"curve {number}"]
            np.testing.assert_allclose(shape["y"], curve.values, rtol=1e-6)
    tabs.check()


def odd_results(ds: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return results with no numbers, no regimes, cases of one parameter, or both directions."""
    lost = ds.copy(deep=True)
    lost["status"][:] = Status.DIVERGED
    sample = {"sobol": 16, "seed": 1, "temperature": [150, 320]}
    return {
        "lost": lost,
        "without regimes": ds.drop_vars("regime"),
        "one parameter": run(LOOSE | {"sample": sample}),
        "both ways": run(LINE),
    }


@pytest.mark.stress
def test_all_variables_and_views_of_odd_results_are_drawn(
    tabs: Tabs, ds: xr.Dataset, tmp_path: Path
) -> None:
    for name, result in odd_results(ds).items():
        path = tmp_path / f"{name}.html"
        write_report(result, path, name=name, orbits=2)
        tab = tabs.open(path.as_uri())
        for view in range(tab.locator("#view option").count()):
            tab.select_option("#view", index=view)
            for variable in ("friction_force_amplitude", "regime", "status"):
                if variable in result:
                    tab.select_option("#variable", variable)
                    assert drawn(tab, "picture"), name
        tabs.check()


def test_the_command_of_a_page_has_the_cut_that_was_made_in_python(tmp_path: Path) -> None:
    swept = {"T": {"linspace": [200.0, 201.0], "num": 11}, "K": [3000.0, 3100.0], "omega": [14.0]}
    run(LOOSE | {"sweep": swept}, output=tmp_path / "a.nc")
    with xr.open_dataset(tmp_path / "a.nc") as whole:
        for part, cut, digits in (
            (whole, "", 4),
            (whole.squeeze().isel(spring_stiffness=1), " --at spring_stiffness=3100.0", 4),
            (whole.isel(temperature=[0, 3, 7]), "", 17),  # 200.3 would be another point
        ):
            write_report(part, tmp_path / "a.html", name="a.nc", orbits=0)
            payload = payload_of(tmp_path / "a.html")
            assert payload["replay"] == f"stickslip replay a.nc{cut}"
            assert payload["fewestDigits"] == digits


def test_commands_of_a_page_name_the_file_of_a_result_whatever_its_title_is():
    ds = run({"title": "A title", "sweep": {"T": [200, 250]}, **LOOSE})
    assert name_of(ds) == "FILE"
    ds.encoding["source"] = "/somewhere/mine.nc"
    page = explore(ds)
    try:
        with urllib.request.urlopen(page.address, timeout=60) as served:
            text = served.read()
            assert b'"replay":"stickslip replay mine.nc"' in text
            assert b"Arrow keys move the pin. " in text  # Esc has no effect there
    finally:
        page.stop()
