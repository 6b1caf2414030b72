"""A result file is completely the old one or the new one; a damaged file is never a result."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import netCDF4
import numpy as np
import pytest
import xarray as xr
from support import messages
from support.sweeps.commands import entries
from support.sweeps.writing import write_dataset

from stickslip.datasets import result_attributes
from stickslip.status import Status
from stickslip.variables import PARAMETERS
from sweeps.exits import StorageError
from sweeps.files.netcdf import content_hash, open_result, readable


def dataset(value: float = 1.0) -> xr.Dataset:
    return xr.Dataset(
        {
            "force": ("x", np.array([value, np.nan, 3.0]), {"units": "N", "long_name": "force"}),
            "count": ("x", np.array([1, -1, 3], dtype=np.int32), {"units": "1"}),
            "status": (
                "x",
                np.array([0, 1, 127], dtype=np.int8),
                {
                    "flag_values": np.array([0, 1, 127], dtype=np.int8),
                    "flag_meanings": "ok not_stationary pending",
                },
            ),
        },
        {"x": ("x", np.array([1.0, 2.0, 4.0]), {"units": "m"}), "fixed": ((), 5.0, {"units": "K"})},
        {"title": "a title", "history": "now", "config": "a: 1\nb: 'ü'\n"},
    )


# --- writing and reading ---


def test_a_written_file_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "new" / "folder" / "a.nc"
    write_dataset(dataset(), path)
    assert entries(path.parent) == ["a.nc"]
    found = open_result(path)
    xr.testing.assert_identical(found, dataset())
    for name, variable in dataset().variables.items():
        assert found[name].dtype == variable.dtype
    path.unlink()  # the file is not held open
    assert found.force[0] == 1.0


def result() -> xr.Dataset:
    """Two points of a sweep."""
    return xr.Dataset(
        {
            "friction_force_amplitude": (
                "temperature",
                [1e-3, np.nan],
                result_attributes("friction_force_amplitude"),
            ),
            "melting_count": (
                "temperature",
                np.array([2, -1], np.int32),
                result_attributes("melting_count"),
            ),
            "status": ("temperature", np.array([0, 2], np.int8), result_attributes("status")),
        },
        {"temperature": ("temperature", [200.0, 250.0], PARAMETERS["temperature"].attributes)},
    )


MANY = len(Status)


@pytest.mark.parametrize(
    ("name", "attribute", "value", "message"),
    [
        ("friction_force_amplitude", "units", "kN", "has units = 'kN', where 'N' is expected"),
        ("temperature", "units", "degC", "has units = 'degC', where 'K' is expected"),
        ("temperature", "units", "days since 2000-01-01", "where 'K' is expected"),
        ("friction_force_amplitude", "missing_value", 1e-3, "has missing_value = 0.001, but sh"),
        ("temperature", "missing_value", 200.0, "has missing_value = 200.0, but should have none"),
        ("status", "missing_value", np.int8(2), "has missing_value = 2, but should have none"),
        ("melting_count", "scale_factor", 2.0, "has scale_factor = 2.0, but should have none"),
        ("temperature", "add_offset", -273.15, "has add_offset = -273.15, but should have none"),
        ("melting_count", "_Unsigned", "true", "has _Unsigned = 'true', but should have none"),
        ("status", "dtype", "bool", "has dtype = 'bool', but should have none"),
        ("friction_force_amplitude", "valid_max", 1e-4, "has valid_max = 0.0001, but should"),
        (
            "status",
            "flag_meanings",
            "fine " * MANY,
            "'fine' for the value 0, where 'ok' is expected",
        ),
        ("status", "flag_meanings", "ok", "flag_values and flag_meanings that do not match"),
        (
            "status",
            "flag_values",
            np.arange(1, 1 + MANY, dtype=np.int8),
            "with 'ok' for the value 1",
        ),
    ],
)
def test_attributes_that_would_change_values_are_refused(
    tmp_path: Path, name: str, attribute: str, value: Any, message: str
) -> None:
    path = tmp_path / "a.nc"
    write_dataset(result(), path)
    with netCDF4.Dataset(path, "r+") as file:
        file[name].setncattr(attribute, value)
    for whole in (True, False):
        with pytest.raises(StorageError) as caught:
            open_result(path, whole=whole)
        assert f"{path}: {name} has" in str(caught.value)
        assert message in str(caught.value)
        assert str(caught.value).endswith("restore it, or compute it again")


def test_a_fill_value_that_hides_a_result_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    result().to_netcdf(path, encoding={"melting_count": {"_FillValue": 2}})
    with pytest.raises(StorageError, match="melting_count has _FillValue = 2, but only NaN"):
        open_result(path)


def test_attributes_that_other_programs_drop_or_add_are_allowed(tmp_path: Path) -> None:
    """By xarray, which gives coordinates a fill value, by later versions, and by users."""
    path, later = tmp_path / "a.nc", result()
    flags = later.status.attrs
    flags["flag_values"] = np.append(flags["flag_values"], np.int8(99))
    flags["flag_meanings"] += " of_a_later_version"
    later["mu"] = (later.friction_force_amplitude * 2).assign_attrs(units="1", missing_value=9e9)
    later.melting_count.attrs.clear()
    later.to_netcdf(path)
    assert open_result(path).status.attrs["flag_meanings"].endswith("of_a_later_version")


def test_a_small_file_is_read_at_once(tmp_path: Path) -> None:
    """The library would crash the process if the disk failed while the file was open."""
    path = tmp_path / "a.nc"
    write_dataset(dataset(), path)
    with open_result(path, whole=False) as lazily:
        path.write_bytes(b"")
        xr.testing.assert_identical(lazily.load(), dataset())


def test_a_new_file_replaces_the_old_one_completely(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path("a.nc")  # without a folder in its name
    write_dataset(dataset(1.0), path)
    write_dataset(dataset(2.0).drop_vars("count"), path)
    assert "count" not in open_result(path)
    assert open_result(path).force[0] == 2.0
    assert entries(tmp_path) == ["a.nc"]


# --- failures ---


WRITE = xr.Dataset.to_netcdf
FULL = OSError(errno.ENOSPC, "No space left on device")
HDF = RuntimeError("NetCDF: HDF error")


def written(*args: Any, **kwargs: Any) -> None:
    WRITE(*args, **kwargs)
    raise HDF


def flawed(ds: xr.Dataset, *args: Any, **kwargs: Any) -> None:
    WRITE(ds.assign(force=ds.force + 1e-9), *args, **kwargs)


@pytest.mark.parametrize(
    ("owner", "name", "broken", "message"),
    [
        (xr.Dataset, "to_netcdf", Mock(side_effect=FULL), "No space left on device"),
        (xr.Dataset, "to_netcdf", written, "NetCDF: HDF error"),
        (xr.Dataset, "to_netcdf", flawed, "the file does not read back .*"),
        (xr, "open_dataset", Mock(side_effect=HDF), "NetCDF: HDF error"),
        (os, "open", Mock(side_effect=FULL), "No space left on device"),
        (os, "fsync", Mock(side_effect=FULL), "No space left on device"),
        (Path, "replace", Mock(side_effect=FULL), "No space left on device"),
        (xr, "open_dataset", Mock(side_effect=KeyboardInterrupt()), None),
    ],
)
def test_a_step_that_fails_leaves_the_old_file_and_no_other(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    owner: Any,
    name: str,
    broken: Callable[..., Any],
    message: str | None,
) -> None:
    path = tmp_path / "a.nc"
    write_dataset(dataset(), path)
    old = path.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(owner, name, broken)
        with pytest.raises(StorageError if message else KeyboardInterrupt) as caught:
            write_dataset(dataset(2.0), path)
    assert message is None or re.fullmatch(f"cannot write {path}: {message}", str(caught.value))
    assert path.read_bytes() == old
    assert entries(tmp_path) == ["a.nc"]


# --- opening ---


@pytest.mark.parametrize(
    "damage",
    [
        lambda _: b"",
        lambda _: b"\x00" * 4096,
        lambda _: b"no NetCDF file\n",
        lambda good: good[: len(good) // 2],
        lambda good: good[:-1],
        lambda good: good[:8],
        lambda good: good[100:],
    ],
    ids=["empty", "zeros", "text", "half", "last byte", "signature", "headless"],
)
def test_a_damaged_file_is_refused_by_name(tmp_path: Path, damage: Any) -> None:
    path = tmp_path / "a.nc"
    write_dataset(dataset(), path)
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(StorageError, match=rf"a\.nc {messages.NOT_NETCDF}"):
        open_result(path)


def test_a_broken_pipe_is_no_damage_of_the_file() -> None:
    with pytest.raises(BrokenPipeError), readable(Path("a.nc")):
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")  # of standard output


# --- identity ---


def changed(change: Callable[[xr.Dataset], Any]) -> xr.Dataset:
    ds = dataset()
    result = change(ds)
    return result if isinstance(result, xr.Dataset) else ds


def setting(name: str, index: Any, value: float) -> Callable[[xr.Dataset], None]:
    def change(ds: xr.Dataset) -> None:
        ds[name].values[index] = value

    return change


@pytest.mark.parametrize(
    "change",
    [
        setting("force", 0, np.nextafter(1.0, 2.0)),
        setting("force", 1, 0.0),
        setting("count", 2, 4),
        setting("status", 2, 0),
        lambda ds: ds.assign_coords(x=ds.x * 2),
        lambda ds: ds.assign_coords(fixed=6.0),
        lambda ds: ds.drop_vars("fixed"),
        lambda ds: ds.drop_vars("count"),
        lambda ds: ds.rename(force="power"),
        lambda ds: ds.rename_dims(x="y"),
        lambda ds: ds.assign(count=ds["count"].astype(np.int64)),
        lambda ds: ds.assign(status=ds.status.astype(np.uint8)),  # the same bytes
        lambda ds: ds.force.attrs.update(units="kN"),
        lambda ds: ds.force.attrs.update(comment="more"),
        lambda ds: ds.x.attrs.pop("units"),
        lambda ds: ds.status.attrs.update(flag_values=np.array([0, 1, 2], dtype=np.int8)),
        lambda ds: ds.attrs.update(title="another"),
        lambda ds: ds.attrs.update(config="a: 2\n"),
        lambda ds: ds.attrs.pop("title"),
        lambda ds: ds.attrs.update(more="1"),
    ],
)
def test_the_hash_sees_every_change(change: Callable[[xr.Dataset], Any]) -> None:
    assert content_hash(changed(change)) != content_hash(dataset())


def test_the_hash_does_not_see_history_and_order() -> None:
    ds = dataset()
    expected = content_hash(ds)
    assert len(expected) == 64
    ds.attrs["history"] = "later"
    assert content_hash(ds) == expected
    del ds.attrs["history"]
    assert content_hash(ds) == expected
    assert content_hash(ds[["status", "count", "force"]]) == expected
    ds.attrs = dict(reversed(ds.attrs.items()))
    assert content_hash(ds) == expected


def test_the_hash_survives_the_file(tmp_path: Path) -> None:
    write_dataset(dataset(), tmp_path / "a.nc")
    assert content_hash(open_result(tmp_path / "a.nc")) == content_hash(dataset())


def test_texts_of_any_kind_have_one_hash() -> None:
    ds = xr.Dataset(coords={"film": ["thin", "thick"]})
    kinds = [np.dtypes.StringDType(na_object=np.nan), np.dtype("O")]
    hashes = {content_hash(ds.assign_coords(film=ds.film.astype(kind))) for kind in kinds}
    assert hashes == {content_hash(ds)}
