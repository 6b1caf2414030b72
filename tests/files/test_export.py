"""Tables: every digit, words for flags, units in a second table."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from stickslip import Status, simulate
from stickslip.variables import RESULT_COLUMNS, RESULTS
from sweeps import run
from sweeps.config.load import from_mapping
from sweeps.engine.trajectories import trajectories
from sweeps.exits import StorageError
from sweeps.files import export as module
from sweeps.files.export import TableError, files_of, refuse_other_data, tables
from sweeps.files.outputs import Outputs
from sweeps.files.result_rows import Chunks

FLOATS = [name for name in RESULT_COLUMNS if RESULTS[name].dtype == "f8"]
# Numbers that a writer changes if it rounds or drops a sign.
ODD = [-2 / 3, 0.1 + 0.2, 1e-18, 5e-324, 1.7976931348623157e308, -0.0]

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
    ds.melting_count[0, 0] = ds.orbit_periods[0, 0] = -1
    ds.asymmetry[:] = np.reshape(ODD, (3, 2))
    return ds


def export(ds: xr.Dataset, path: Path, source: Path | None = None) -> list[Path]:
    """Write the table as the command does; older files are replaced."""
    with Outputs(files_of(path), overwrite=True, like=source).held() as outputs:
        outputs.write(tables(ds, path))
    return outputs.paths


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
        assert row["case"] == str(int(point.case))
    for name in FLOATS:
        read = np.array([float(row[name] or "nan") for row in rows])
        assert read.tobytes() == ds[name].values.ravel().tobytes(), name
    assert (rows[1]["status"], rows[1]["regime"]) == ("ok", "stick_slip_symmetric")
    counts = ds.melting_count.values.ravel()[1:]
    assert [int(row["melting_count"]) for row in rows[1:]] == counts.tolist()


def test_missing_values_are_empty_cells(ds: xr.Dataset, tmp_path: Path) -> None:
    first = rows_of(export(ds, tmp_path / "a.csv")[0])[0]
    assert first["status"] == "diverged"
    empty = ["friction_force_amplitude", "melting_count", "orbit_periods", "lyapunov_exponent"]
    assert [first[name] for name in empty] == [""] * 4
    assert int(first["periods_integrated"]) == ds.periods_integrated[0, 0]


def test_masked_flags_are_empty_cells(ds: xr.Dataset, tmp_path: Path) -> None:
    failed = ds.copy(deep=True)
    failed.status[0, 0] = Status.DIVERGED
    for name in ("a.csv", "a.parquet"):
        export(failed.stickslip.ok(), tmp_path / name)
    for frame in (pd.read_csv(tmp_path / "a.csv"), pd.read_parquet(tmp_path / "a.parquet")):
        assert frame.regime.isna().tolist() == [True] + [False] * (ds.status.size - 1)
        assert frame.status.dropna().unique().tolist() == ["ok"]
    assert "nan" not in (tmp_path / "a.csv").read_text()


def test_flags_of_a_user_are_words_if_each_value_has_one(ds: xr.Dataset, tmp_path: Path) -> None:
    verdict = (ds.status * 0 + 1).astype("i1")
    one = {"flag_values": np.int8(1), "flag_meanings": "good"}  # as NetCDF reads a single value
    bits = {"flag_masks": np.array([1, 2], "i1"), "flag_meanings": "good checked"}
    own = ds.assign(verdict=verdict.assign_attrs(one), marks=verdict.assign_attrs(bits))
    rows = rows_of(export(own, tmp_path / "a.csv")[0])
    assert {(row["verdict"], row["marks"]) for row in rows} == {("good", "1")}


def test_units_and_fixed_parameters_are_in_a_second_table(ds: xr.Dataset, tmp_path: Path) -> None:
    _, beside = export(ds, tmp_path / "a.csv")
    described = {row["name"]: row for row in rows_of(beside)}
    assert beside.name == "a.columns.csv"
    assert described["friction_force_amplitude"]["units"] == "N"
    assert described["viscosity_coefficient"]["units"] == "Pa s^(gamma+1)"
    assert described["temperature"]["fixed_value"] == ""
    assert float(described["angular_frequency"]["fixed_value"]) == 10.0


def test_chunks_make_the_same_table(
    ds: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = export(ds, tmp_path / "a.csv")[0].read_bytes()
    monkeypatch.setattr(module, "Chunks", lambda shape: Chunks(shape, most=2))
    assert export(ds, tmp_path / "b.csv")[0].read_bytes() == whole


def test_parquet_has_the_bits_and_the_units(
    ds: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    monkeypatch.setattr(module, "Chunks", lambda shape: Chunks(shape, most=2))
    (path,) = export(ds, tmp_path / "a.parquet")
    assert parquet.ParquetFile(path).num_row_groups == 3
    table = parquet.read_table(path)
    for name in FLOATS:
        read = table[name].to_numpy(zero_copy_only=False)  # an empty cell is read as NaN
        assert read.tobytes() == ds[name].values.ravel().tobytes(), name
    assert table["friction_force_amplitude"].null_count == 1
    assert table["melting_count"].to_pylist() == [None, *ds.melting_count.values.ravel()[1:]]
    assert table["status"].to_pylist()[:2] == ["diverged", "ok"]
    about = table.schema.field("friction_force_amplitude").metadata
    assert about == {b"units": b"N", b"meaning": b"amplitude of the friction force"}
    fixed = json.loads(table.schema.metadata[b"fixed_values"])
    assert fixed["rheological_index"] == -2 / 3
    assert fixed["noise_intensity"] == 1e-18
    assert "temperature" not in fixed
    assert table.schema.metadata[b"config"].decode() == ds.attrs["config"]


def test_a_single_point_is_one_row(tmp_path: Path) -> None:
    single = {name: CONFIG[name] for name in ("integrator", "stationary")}
    table, _ = export(run(single), tmp_path / "a.csv")
    assert len(rows_of(table)) == 1


def test_a_followed_axis_has_its_direction(tmp_path: Path) -> None:
    followed = {"sweep": {"omega": [37.0, 38.0]}, "follow": "omega"}
    table, _ = export(run(CONFIG | followed | {"cases": {}}), tmp_path / "a.csv")
    assert [row["direction"] for row in rows_of(table)] == ["up", "down"] * 2


def test_the_samples_of_trajectories_are_rows(tmp_path: Path) -> None:
    short = {"periods": 1, "samples_per_period": 10}
    one = simulate(**short)
    several = trajectories(from_mapping({"sweep": {"T": [200, 250]}, "simulation": short}))
    for ds in (one, several):
        rows = rows_of(export(ds, tmp_path / "a.csv")[0])
        for name in ("elapsed_time", "friction_force"):
            values = ds[name].values.ravel()
            assert [float(row[name]) for row in rows] == values.tolist()
    assert [row["temperature"] for row in rows] == ["200.0"] * 11 + ["250.0"] * 11


def test_an_older_table_stays_if_a_new_one_fails(
    ds: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = export(ds, tmp_path / "a.csv")
    before = [path.read_bytes() for path in paths]

    class Failing(Chunks):
        def box(self, number: int) -> tuple[slice, ...]:
            if number == 1:  # a chunk is written by then
                raise OSError("Input/output error")
            return super().box(number)

    monkeypatch.setattr(module, "Chunks", lambda shape: Failing(shape, most=2))
    with pytest.raises(StorageError, match=r"cannot write .*a\.csv: Input/output error"):
        export(ds.assign(asymmetry=-ds.asymmetry), tmp_path / "a.csv")
    assert [path.read_bytes() for path in paths] == before
    assert len(list(tmp_path.iterdir())) == 2


def test_without_pyarrow_the_message_has_a_remedy(
    ds: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(
        TableError, match=r"pip install 'pyarrow>=16'.*\.csv table needs no extra package"
    ):
        export(ds, tmp_path / "a.parquet")
    assert files_of(Path("a.csv")) == [Path("a.csv"), Path("a.columns.csv")]
    with pytest.raises(TableError, match=r"a table must end in \.csv or \.parquet"):
        export(ds, tmp_path / "a.xlsx")


def test_a_text_that_a_spreadsheet_would_run_is_quoted(ds: xr.Dataset, tmp_path: Path) -> None:
    hostile = ds.copy()
    hostile["=HYPERLINK(0)"] = hostile.asymmetry.assign_attrs(units="@SUM(1)", long_name="+1")
    flags = hostile.status.attrs
    flags["flag_meanings"] = flags["flag_meanings"].replace("ok", "=ok")
    table, columns = export(hostile, tmp_path / "a.csv")
    assert "'=HYPERLINK(0)" in rows_of(table)[0]
    assert {row["status"] for row in rows_of(table)} == {"'=ok", "diverged"}
    (described,) = [row for row in rows_of(columns) if "HYPERLINK" in row["name"]]
    assert list(described.values()) == ["'=HYPERLINK(0)", "'@SUM(1)", "'+1", ""]
    assert float(rows_of(table)[-1]["asymmetry"]) == ODD[-1]  # a number keeps its sign


def test_a_table_is_as_private_as_its_result(ds: xr.Dataset, tmp_path: Path) -> None:
    source = tmp_path / "a.nc"
    source.touch(mode=0o600)
    for path in (*export(ds, tmp_path / "a.csv", source), *export(ds, tmp_path / "b.csv")):
        assert path.stat().st_mode & 0o077 == (0 if path.name.startswith("a") else 0o044)


def test_quantiles_are_a_row_for_each_point_and_level(ds: xr.Dataset, tmp_path: Path) -> None:
    found = ds.stickslip.quantiles([0.1, 0.5])
    export(found, tmp_path / "a.csv")
    table = pd.read_csv(tmp_path / "a.csv")
    assert table["temperature"].tolist() == [200, 200, 250, 250, 300, 300]
    assert table["quantile"].tolist() == [0.1, 0.5] * 3
    force = found.friction_force_amplitude.transpose("temperature", "quantile")
    assert table["friction_force_amplitude"].tolist() == force.values.ravel().tolist()


def test_the_results_of_a_stack_are_told_apart_by_their_numbers(
    ds: xr.Dataset, tmp_path: Path
) -> None:
    export(xr.concat([ds, ds], "film"), tmp_path / "a.csv")
    rows = rows_of(tmp_path / "a.csv")
    assert [row["film"] for row in rows] == ["0"] * 6 + ["1"] * 6


def test_a_dataset_without_a_value_is_refused(ds: xr.Dataset, tmp_path: Path) -> None:
    refuse_other_data(ds, tmp_path / "a.nc")
    with pytest.raises(TableError, match=r"a\.nc is empty: no value along temperature"):
        refuse_other_data(ds.isel(temperature=slice(0)), tmp_path / "a.nc")
