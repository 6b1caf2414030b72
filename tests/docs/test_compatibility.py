"""The promises of docs/compatibility.md, tested on files and names of 1.0.0."""

from __future__ import annotations

import gzip
import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from support import messages
from support.marks import one_then
from support.public_names import public_names
from support.sweeps.commands import Command
from support.sweeps.sweeping import everything

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.variables import RESULTS
from sweeps.files.netcdf import open_result
from sweeps.points import version_differences

ROOT = Path(__file__).parents[2]
RELEASED = ROOT / "tests" / "golden" / "1.0.0"
POINTS = {
    "followed": ["T=200", "omega=15", "direction=down"],
    "stochastic": ["case=1"],
    "unfinished": ["T=225", "gamma=-2/3"],
    "fit": ["T=200"],
}
SWEEPS = [name for name in POINTS if name != "fit"]
Unpacked = Callable[[str], Path]


@pytest.fixture
def command(shell: Command) -> Command:
    return shell


@pytest.fixture
def unpacked(command: Command) -> Unpacked:
    """A file of 1.0.0, and its config, by name, in the folder of the test."""

    def unpack(name: str) -> Path:
        path = Path(f"{name}.nc")
        path.write_bytes(gzip.decompress((RELEASED / f"{name}.nc.gz").read_bytes()))
        if (config := RELEASED / f"{name}.yaml").exists():
            Path(config.name).write_text(config.read_text())
        return path

    return unpack


# --- names ---


def test_no_name_of_the_release_has_gone_or_means_something_else() -> None:
    released = (RELEASED / "names.txt").read_text("utf-8").splitlines()
    assert len(released) > 500
    assert set(released) - set(public_names()) == set()


def test_the_page_lists_what_an_install_brings() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    users = ("report", "explore", "fit", "posterior", "table", "dask")
    extras = [name for extra in users for name in project["optional-dependencies"][extra]]
    extras = [name for name in extras if not name.startswith("stickslip[")]
    page, packages = (
        (ROOT / "docs" / f"{name}.md").read_text("utf-8") for name in ("compatibility", "install")
    )
    packages = packages.split("| packages |")[1].split("\n\n")[0]
    listed = re.findall(r"`([\w.]+)`", packages)
    needed = {re.split(r"[<>=]", name)[0] for name in (*project["dependencies"], *extras)}
    assert needed | {*users, ".parquet"} == set(listed)
    for version in re.findall(r"Python :: (3\.\d+)", str(project["classifiers"])):
        assert version in page
        assert f'"{version}"' in (ROOT / ".github" / "workflows" / "tests.yml").read_text("utf-8")


@pytest.mark.parametrize("name", SWEEPS)
def test_variables_of_a_released_file_have_the_names_and_units_of_today(
    unpacked: Unpacked, name: str
) -> None:
    with xr.open_dataset(unpacked(name)) as ds:
        for variable, data in ds.data_vars.items():
            declared = RESULTS[str(variable)]
            assert data.attrs["units"] == declared.units, variable
            assert data.dtype == np.dtype(declared.dtype), variable
        assert ds.status.sizes == open_result(Path(f"{name}.nc")).status.sizes


# --- files ---


@pytest.mark.parametrize("name", ["trajectory", *one_then("stress", [*POINTS])])
def test_a_released_file_is_described_drawn_and_exported(
    command: Command, unpacked: Unpacked, name: str
) -> None:
    path = unpacked(name)
    info = command("info", path.name)
    assert (info.code, info.err) == (0, "")
    assert re.match("title: .*A file of 1.0.0", info.out)
    assert "source: stickslip 1.0.0, " in info.out
    for arguments, made in [
        (("plot", path.name, "-o", "a.png"), "a.png"),
        (("export", path.name, "-o", "a.csv"), "a.csv"),
    ]:
        done = command(*arguments)
        assert done.code == 0, done.err
        assert Path(made).stat().st_size > 1000


@pytest.mark.stress
def test_released_borders_are_described_exported_and_drawn_over_their_map(
    command: Command, unpacked: Unpacked
) -> None:
    pytest.importorskip("bokeh")
    path = unpacked("borders").name
    assert "A file of 1.0.0" in command("info", path).out
    over = ("--boundaries", path)
    for arguments, made in [
        (("sweep", "borders.yaml", "-o", "map.nc"), "map.nc"),
        (("export", path, "-o", "a.csv"), "a.csv"),
        (("plot", "map.nc", *over, "-x", "T", "-y", "omega", "-o", "a.png"), "a.png"),
        (("report", "map.nc", *over, "-o", "a.html"), "a.html"),
    ]:
        done = command(*arguments)
        assert done.code == 0, done.err
        assert Path(made).stat().st_size > 1000


@pytest.mark.stress
@pytest.mark.parametrize("name", SWEEPS)
def test_a_page_of_a_released_file_is_made(command: Command, unpacked: Unpacked, name: str) -> None:
    pytest.importorskip("bokeh")
    done = command("report", unpacked(name).name, "-o", "a.html")
    assert done.code == 0, done.err
    assert "A file of 1.0.0" in Path("a.html").read_text("utf-8")


@pytest.mark.parametrize("name", one_then("stress", [*reversed(POINTS)]))
def test_a_point_of_a_released_file_is_computed_again(
    command: Command, unpacked: Unpacked, name: str
) -> None:
    """With the same bits, or within the error that the file states where bits may differ."""
    path = unpacked(name)
    at = [part for text in POINTS[name] for part in ("--at", text)]
    done = command("replay", path.name, *at)
    assert done.code == 0, done.err
    assert Path(f"{name}-replay.nc").exists()
    ds = open_result(path)
    if not version_differences(ds.attrs):
        assert f"variables {messages.SAME_BITS}" in done.out
    point = ds.stickslip.at(**dict(text.split("=") for text in POINTS[name]))
    again = point.orbit()
    for amplitude in ("elastic_stress_amplitude", "friction_force_amplitude"):
        error = point.stored["amplitude_error"] + 1e-9
        assert getattr(again, amplitude) == pytest.approx(point.stored[amplitude], rel=error)


# --- growing ---

MORE = "temperature=[200, 225, 250, 275, 300]"
GROW = ("sweep", "unfinished.yaml", "--set", MORE, "-o", "unfinished.nc")


def test_a_released_file_is_finished_and_grown_by_the_same_numerics_version(
    command: Command, unpacked: Unpacked
) -> None:
    before = open_result(unpacked("unfinished"))
    done = command(*GROW)
    if str(before.numerics_version) != str(NUMERICS_VERSION):
        assert done.code == 2, done.out
        return
    assert done.code == 0, done.err
    assert "4 in unfinished.nc; 6 to compute\n" in done.err
    after = open_result(Path("unfinished.nc"))
    assert np.all(after.status == 0)
    kept = after.sel(temperature=[200, 225])
    for name, values in before.sel(temperature=[200, 225]).data_vars.items():
        np.testing.assert_array_equal(kept[name], values, err_msg=str(name))


def test_a_released_file_is_refused_and_kept_by_another_numerics_version(
    command: Command, unpacked: Unpacked
) -> None:
    with netCDF4.Dataset(unpacked("unfinished"), "a") as file:
        file.numerics_version = str(NUMERICS_VERSION - 1)
    before = everything()
    done = command(*GROW)
    assert (done.code, done.out) == (2, "")
    assert f"{messages.OTHER_VERSION}{NUMERICS_VERSION - 1}; this is" in done.err
    assert done.err.endswith("--overwrite replaces it, -o writes elsewhere\n")
    assert everything() == before
