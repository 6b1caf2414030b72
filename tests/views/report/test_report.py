"""The page of `stickslip report`: what it holds, that it is safe and needs nothing else."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.browser import Tab, chromium, opened_tab

from stickslip import Status
from sweeps import run
from sweeps.views.report import MOST_POINTS, ReportError, write_report

pytest.importorskip("bokeh", reason="bokeh is not installed")
__all__ = ["chromium"]  # a fixture

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
    text = page.read_text("utf-8")
    found = re.search(
        r'<script type="application/json" id="payload">(.*?)</script>', text, re.DOTALL
    )
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data


def test_nothing_of_the_file_becomes_markup(page: Path) -> None:
    text = page.read_text("utf-8")
    assert "<b>title</b>" not in text
    assert "map <i>.nc" not in text
    assert "Odd &lt;/script&gt;&lt;b&gt;title" in text
    payload = re.search(r'id="payload">(.*?)</script>', text, re.DOTALL)
    assert payload
    assert "<" not in payload[1]


def test_the_page_forbids_the_network(page: Path) -> None:
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page.read_text("utf-8"))
    assert policy
    assert "default-src 'none'" in policy[1]
    assert "http" not in policy[1]
    assert not re.search(r'<(?:script|link|img)[^>]+(?:src|href)="http', page.read_text("utf-8"))


def test_failed_points_have_an_orbit_first_and_stand_in_a_table(page: Path) -> None:
    orbits = payload_of(page)["orbits"]
    assert len(orbits) == 20
    assert 0 in [orbit["point"] for orbit in orbits]
    text = page.read_text("utf-8")
    assert "diverged" in text
    assert Status.DIVERGED.sentence.split(".", maxsplit=1)[0] in text


def test_the_same_result_makes_the_same_page(ds: xr.Dataset, page: Path, tmp_path: Path) -> None:
    write_report(ds, tmp_path / "again.html", name="map <i>.nc", orbits=20)
    assert (tmp_path / "again.html").read_bytes() == page.read_bytes()


@pytest.mark.parametrize("source", [LOOSE, LINE, LOOSE | {"sweep": {"T": [200.0, 250.0]}}])
def test_every_kind_of_result_has_a_page(source: dict[str, Any], tmp_path: Path) -> None:
    write_report(run(source), tmp_path / "a.html", name="a.nc", orbits=3)
    assert payload_of(tmp_path / "a.html")["file"] == "a.nc"


def test_a_slice_can_be_taken_and_too_large_a_result_is_refused(
    ds: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_report(ds, tmp_path / "a.html", name="a.nc", at=["gamma=0"], orbits=0)
    assert payload_of(tmp_path / "a.html")["at"] == ["gamma=0"]
    assert ds.status.size < MOST_POINTS
    monkeypatch.setattr("sweeps.views.report.build.MOST_POINTS", 10)
    with pytest.raises(ReportError, match=r"162 points, and a page holds 10.*--at temperature=200"):
        write_report(ds, tmp_path / "b.html", name="b.nc")
    assert not (tmp_path / "b.html").exists()


def test_a_trajectory_is_no_result_of_a_sweep(ds: xr.Dataset, tmp_path: Path) -> None:
    course = ds.stickslip.at(T=250, K=500, gamma=0).simulate()
    with pytest.raises(ReportError, match="holds no result of a sweep"):
        write_report(course, tmp_path / "a.html", name="a.nc")


def test_the_accessor_writes_it_too(ds: xr.Dataset, tmp_path: Path) -> None:
    part = ds.isel(temperature=slice(0, 3), spring_stiffness=0)
    assert part.stickslip.report(tmp_path / "a.html").exists()


def test_in_a_browser_a_click_draws_an_orbit_and_nothing_is_fetched(
    chromium: Any, page: Path
) -> None:
    with opened_tab(chromium) as opened:
        tab = Tab(opened)
        opened.goto(page.as_uri())
        opened.wait_for_selector("#picture .bk-Figure, #picture div")
        box = opened.locator("#picture").bounding_box()
        opened.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"])
        opened.wait_for_function("document.querySelectorAll('#readout tr').length > 10")
        before = opened.inner_text("#orbit-words")
        opened.mouse.click(box["x"] + 0.7 * box["width"], box["y"] + 0.8 * box["height"])
        opened.wait_for_function(
            "before => document.getElementById('orbit-words').innerText !== before", arg=before
        )
        assert "stickslip replay" in opened.inner_text("#orbit-words")
        slider = opened.locator("#sliders input").first
        shown = opened.inner_text("#sliders")
        slider.press("ArrowRight")
        opened.wait_for_function(
            "shown => document.getElementById('sliders').innerText !== shown", arg=shown
        )
        assert tab.errors == []
        assert tab.requests_elsewhere("file:") == []
