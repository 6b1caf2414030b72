"""Tables: every digit, words for flags, units in a second table."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from stickslip import Status, simulate
from stickslip.variables import RESULT_COLUMNS
from sweeps import run
from sweeps.files import export as module
from sweeps.files.chunks import Chunks
from sweeps.files.export import TableError, export

CONFIG: dict[str, Any] = {
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
    "sweep": {"T": [200, 250, 300]},
    "cases": {"k": [5e4, 6e4], "K": [2000, 3000]},
}


@pytest.fixture(scope="module")
def ds() -> xr.Dataset:
    ds = run(CONFIG)
    ds.status[0, 0] = Status.DIVERGED
    ds.friction_force_amplitude[0, 0] = np.nan
    return ds


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_row_for_each_point_with_all_digits(ds: xr.Dataset, tmp_path: Path) -> None:
    table, _ = export(ds, tmp_path / "a.csv")
    rows = rows_of(table)
    assert list(rows[0]) == [
        *("temperature", "case", "viscosity_coefficient", "spring_stiffness"),
        *RESULT_COLUMNS,
    ]
    assert len(rows) == 6
    for number, row in enumerate(rows):
        point = ds.isel(temperature=number // 2, case=number % 2)
        assert float(row["temperature"]) == point.temperature
        assert float(row["spring_stiffness"]) == point.spring_stiffness
        assert float(row["elastic_stress_amplitude"]) == point.elastic_stress_amplitude
        assert int(row["melting_count"]) == point.melting_count
    assert (rows[0]["status"], rows[0]["friction_force_amplitude"]) == ("diverged", "")
    assert (rows[1]["status"], rows[1]["regime"]) == ("ok", "stick_slip_symmetric")


def test_units_and_what_is_fixed_stand_beside_it(ds: xr.Dataset, tmp_path: Path) -> None:
    _, beside = export(ds, tmp_path / "a.csv")
    described = {row["name"]: row for row in rows_of(beside)}
    assert beside.name == "a.columns.csv"
    assert described["friction_force_amplitude"]["units"] == "N"
    assert described["temperature"]["fixed_value"] == ""
    assert float(described["angular_frequency"]["fixed_value"]) == 10.0


def test_chunks_make_the_same_table(
    ds: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = export(ds, tmp_path / "a.csv")[0].read_bytes()
    monkeypatch.setattr(module, "Chunks", lambda shape: Chunks(shape, most=2))
    assert export(ds, tmp_path / "b.csv")[0].read_bytes() == whole


def test_parquet_has_the_bits_and_the_units(ds: xr.Dataset, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    (path,) = export(ds, tmp_path / "a.parquet")
    table = parquet.read_table(path)
    stored = np.asarray(table["elastic_stress_amplitude"])
    np.testing.assert_array_equal(stored, ds.elastic_stress_amplitude.values.ravel())
    assert table["status"].to_pylist()[:2] == ["diverged", "ok"]
    described = json.loads(table.schema.metadata[b"stickslip_columns"])
    assert {"name": "temperature", "units": "K"}.items() <= described[0].items()


def test_a_single_point_is_one_row(tmp_path: Path) -> None:
    single = {name: CONFIG[name] for name in ("integrator", "stationary")}
    table, _ = export(run(single), tmp_path / "a.csv")
    assert len(rows_of(table)) == 1


def test_a_followed_axis_has_its_direction(tmp_path: Path) -> None:
    followed = {"sweep": {"omega": [37.0, 38.0]}, "follow": "omega"}
    table, _ = export(run(CONFIG | followed | {"cases": {}}), tmp_path / "a.csv")
    assert [row["direction"] for row in rows_of(table)] == ["up", "down"] * 2


def test_the_samples_of_a_trajectory_are_rows(tmp_path: Path) -> None:
    ds = simulate(periods=1, samples_per_period=10)
    rows = rows_of(export(ds, tmp_path / "a.csv")[0])
    assert len(rows) == 11
    assert float(rows[3]["friction_force"]) == ds.friction_force[3]
    assert float(rows[3]["elapsed_time"]) == ds.elapsed_time[3]


def test_without_pyarrow_it_is_said_what_to_do(
    ds: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyarrow.parquet", None)
    with pytest.raises(TableError, match=r'pip install "stickslip\[table\]".*\.csv needs nothing'):
        export(ds, tmp_path / "a.parquet")
    with pytest.raises(TableError, match=r"a table ends in \.csv or \.parquet"):
        export(ds, tmp_path / "a.xlsx")
