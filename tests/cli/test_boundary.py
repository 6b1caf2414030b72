"""`stickslip boundary`: borders of a file, as another file or a table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from support.sweeps.commands import Command
from support.sweeps.writing import write_dataset

from sweeps import run
from sweeps.files.netcdf import open_result

LOOSE = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
AXES = {
    "T": {"linspace": [230, 300], "num": 8},
    "omega": {"linspace": [20, 60], "num": 7},
}


@pytest.fixture(scope="module")
def line() -> xr.Dataset:
    return run(LOOSE | {"sweep": {"omega": {"linspace": [12, 60], "num": 17}}})


@pytest.fixture(scope="module")
def small() -> xr.Dataset:
    return run(LOOSE | {"sweep": AXES})


@pytest.fixture(scope="module")
def borders(small: xr.Dataset) -> xr.Dataset:
    return small.stickslip.boundaries(1e-2)


def test_the_command_writes_the_borders_of_the_function(
    command: Command, small: xr.Dataset, borders: xr.Dataset
) -> None:
    write_dataset(small, Path("map.nc"))
    done = command.ok("boundary", "map.nc", "--accuracy", "1e-2")
    xr.testing.assert_equal(open_result(Path("map-boundaries.nc")), borders)
    assert "stick_slip_symmetric" in done.out
    again = command("boundary", "map.nc")
    assert again.code == 2
    assert "--overwrite" in again.err
    command.ok(
        "plot", "map.nc", "--variable", "regime", "--boundaries", "map-boundaries.nc", "-o", "a.svg"
    )
    assert Path("a.svg").is_file()
    refused = command("plot", "map.nc", "--boundaries", "map.nc")
    assert refused.code == 2
    assert "not a file of borders" in refused.err
    command.ok("boundary", "map.nc", "--accuracy", "1e-2", "-o", "lines.csv")
    rows = pd.read_csv("lines.csv")
    assert list(rows.columns[:3]) == ["line", "temperature", "angular_frequency"]
    np.testing.assert_array_equal(rows.temperature, borders.temperature)
    assert set(rows.type) <= {"grazing", "fold", "meeting"}
    command.ok("export", "map-boundaries.nc")
    pd.testing.assert_frame_equal(pd.read_csv("map-boundaries.csv"), rows)


def test_the_command_prints_the_borders_of_an_axis(command: Command, line: xr.Dataset) -> None:
    write_dataset(line.expand_dims(spring_stiffness=[3000.0]), Path("line.nc"))
    done = command("boundary", "line.nc", "--at", "omega=20", "-o", "a.nc")
    assert done.code == 2  # a single point is left
    done = command.ok("boundary", "line.nc", "--accuracy", "1e-5", "-o", "a.csv")
    assert "rad s-1: stick_slip_asymmetric | stick_slip_symmetric, fold" in done.out
    write_dataset(line.sel(angular_frequency=slice(50, 60)), Path("part.nc"))
    done = command("boundary", "part.nc")
    assert done.code == 2
    assert "of one kind" in done.err
    assert not Path("part-boundaries.nc").exists()


@pytest.mark.stress
def test_the_command_prints_how_many_brackets_stayed_wide(command: Command) -> None:
    slow = run({"model": {"T": 166}, "sweep": {"omega": [34.5625, 35.25]}})
    write_dataset(slow, Path("slow.nc"))
    for accuracy, is_wide in (("1e-2", False), ("1e-5", True)):
        done = command.ok("boundary", "slow.nc", "--accuracy", accuracy, "-o", f"{accuracy}.nc")
        assert ("1 bracket wider than requested, where motions close late" in done.out) == is_wide


@pytest.mark.stress
def test_a_report_has_borders_on_its_map(
    command: Command, small: xr.Dataset, borders: xr.Dataset
) -> None:
    pytest.importorskip("bokeh", reason="bokeh is not installed")
    write_dataset(small, Path("map.nc"))
    write_dataset(borders, Path("lines.nc"))
    for name, options in (("without", []), ("with", ["--boundaries", "lines.nc"])):
        command.ok("report", "map.nc", "--orbits", "0", "-o", f"{name}.html", *options)
    drawn = [
        Path(f"{name}.html").read_text("utf-8").count('"border: ') for name in ("without", "with")
    ]
    assert drawn == [0, np.isin([0, 1], borders.type).sum()]
    write_dataset(borders.assign_coords(spring_stiffness=1000.0), Path("other.nc"))
    for options, message in (
        (["report", "map.nc", "--boundaries", "map.nc"], "not a file of borders"),
        (
            ["report", "map.nc", "--boundaries", "other.nc"],
            "borders are at K = 1000 N/m, which this result lacks",
        ),
        (
            ["report", "map.nc", "--boundaries", "lines.nc", "--at", "T=230"],
            "not both axes of this result",
        ),
        (
            ["explore", "map.nc", "--boundaries", "other.nc"],
            "borders are at K = 1000 N/m, which this result lacks",
        ),
        (["explore", "--boundaries", "lines.nc"], "the map of a result file: give one"),
    ):
        refused = command(*options)
        assert refused.code == 2
        assert message in refused.err


def test_a_page_of_several_maps_asks_for_one(
    small: xr.Dataset, borders: xr.Dataset, tmp_path: Path
) -> None:
    pytest.importorskip("bokeh", reason="bokeh is not installed")
    stiffnesses = [2000.0, 3000.0]
    several = xr.concat(
        [small.assign_coords(spring_stiffness=k) for k in stiffnesses],
        "spring_stiffness",
        combine_attrs="override",
    )
    with pytest.raises(ValueError, match=r"has 2 values here; .* --at spring_stiffness=2000"):
        several.stickslip.report(tmp_path / "a.html", boundaries=borders)
    with pytest.raises(ValueError, match=r"has 2 values here; .* --at spring_stiffness=2000"):
        several.stickslip.explore(borders)
