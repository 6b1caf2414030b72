"""`stickslip replay`: one point of a file again, compared and drawn."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
from support import messages
from support.sweeps.commands import Command

from sweeps import run
from sweeps.files.netcdf import open_result

CONFIG: dict[str, Any] = {
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
    "sweep": {"T": [200, 300], "gamma": [-2 / 3, 0]},
}
POINT = ("--at", "T=200", "--at", "gamma=-2/3")


@pytest.fixture(scope="module")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("replay") / "mine.nc"
    run(CONFIG, output=path)
    return path


@pytest.fixture
def result(command: Command, computed: Path) -> Path:
    """A result, in the folder of the test."""
    return shutil.copy(computed, Path("mine.nc"))


def test_a_point_is_computed_compared_written_and_drawn(command: Command, result: Path) -> None:
    done = command.ok("replay", "mine.nc", *POINT)
    assert "temperature = 200 K, rheological_index = -0.666667" in done.out
    assert f"all 28 variables {messages.SAME_BITS}" in done.out
    for ending in (".nc", ".png", ".pdf"):
        assert result.with_name(f"mine-replay{ending}").exists()
    ds = open_result(result.with_name("mine-replay.nc"))
    assert ds.sizes == {"elapsed_time": 2001, "period": 201}
    assert ds.title == "temperature = 200 K, rheological_index = -0.666667"


@pytest.mark.stress
def test_the_output_the_periods_and_the_start_can_be_chosen(command: Command, result: Path) -> None:
    options = ("-o", "b.nc", "--periods", "2", "--start", "initial")
    command.ok("replay", "mine.nc", *POINT, *options)
    ds = open_result(Path("b.nc"))
    assert ds.sizes["elapsed_time"] == 4001
    assert ds.lower_displacement.values[0] == 0.0


def test_other_bits_are_reported_and_end_with_3(command: Command, result: Path) -> None:
    with netCDF4.Dataset(result, "a") as file:
        file["melting_count"][:] = 77
    done = command("replay", "mine.nc", *POINT)
    assert done.code == 3
    assert "the file has different values for 1 variable" in done.err
    assert "melting_count: 77, now 4" in done.out


@pytest.mark.stress
def test_other_bits_of_another_version_are_explained(command: Command, result: Path) -> None:
    with netCDF4.Dataset(result, "a") as file:
        file["friction_force_amplitude"][:] = np.nextafter(1.0, 2.0)
        file.numerics_version = "1"
    done = command("replay", "mine.nc", *POINT)
    assert done.code == 0
    assert "the file has numerics version 1, this program " in done.err


@pytest.mark.stress
def test_a_masked_point_is_compared_with_nothing(command: Command, result: Path) -> None:
    ds = open_result(result)
    ds.where(ds.temperature > 200).to_netcdf("masked.nc")
    done = command.ok("replay", "masked.nc", *POINT)
    assert "  regime: nan\n" in done.out
    assert "the file has no computed values for it" in done.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "several points remain"),
        ((*POINT, "-o", "a.png"), "names a NetCDF file"),
        ((*POINT, "-o", "mine.nc"), "is also an input"),
        ((*POINT, "--start", "there"), "--start must be initial or stationary"),
    ],
)
def test_usage_errors_end_with_2(
    command: Command, result: Path, arguments: tuple[str, ...], message: str
) -> None:
    done = command("replay", "mine.nc", *arguments)
    assert done.code == 2
    assert message in done.err
