"""Results as tables, for people without NetCDF: a row for each point, CSV or Parquet.

The columns are the coordinates along which points differ, then the result variables, with the names
of the file and in its units; status and regime are words. What a spreadsheet would stumble over,
units, meanings and the fixed parameters, stands in a second small table beside a CSV file, and in
the metadata of a Parquet file.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweeps.exits import ExpectedError
from sweeps.files.atomic import replacing, storage_errors
from sweeps.files.chunks import Chunks

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

ENDINGS = (".csv", ".parquet")


class TableError(ExpectedError, ValueError):
    """A table that cannot be made; the message says what helps."""


def export(ds: xr.Dataset, path: Path) -> list[Path]:
    """Write the table of a Dataset, read variable by variable, to `path`; returns the files.

    `ds` is the result of a sweep, or a trajectory, whose samples are the rows. Floats have all
    their digits; NaN is an empty cell. An older table is replaced completely or not at all.

    Raises TableError where the ending is neither .csv nor .parquet or what writes it is missing,
    StorageError where it cannot be written.
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise TableError(f"{path}: a table ends in {' or '.join(ENDINGS)}")
    if ending == ".parquet":
        _require_pyarrow()
    with storage_errors(f"cannot write {path}", path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
        if ending == ".parquet":
            _write_parquet(ds, path)
            return [path]
        _write_csv(ds, path)
        beside = path.with_name(f"{path.stem}.columns.csv")
        with replacing(beside) as temporary:
            _described(ds).to_csv(temporary, index=False)
        return [path, beside]


def _require_pyarrow() -> None:
    try:
        import pyarrow.parquet  # noqa: F401 - only whether it is there
    except ImportError:
        raise TableError(
            "Parquet is written by pyarrow, which is not installed: "
            'pip install "stickslip[table]"; '
            "a table that ends in .csv needs nothing more"
        ) from None


def _write_csv(ds: xr.Dataset, path: Path) -> None:
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        for number, frame in enumerate(_frames(ds)):
            text = io.StringIO()
            frame.to_csv(text, index=False, header=number == 0, lineterminator="\n")
            file.write(text.getvalue())


def _write_parquet(ds: xr.Dataset, path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    described = _described(ds).to_json(orient="records")
    with replacing(path) as temporary:
        writer: pq.ParquetWriter | None = None
        try:
            for frame in _frames(ds):
                table = pa.Table.from_pandas(frame, preserve_index=False)
                if writer is None:
                    schema = table.schema.with_metadata({"stickslip_columns": described})
                    writer = pq.ParquetWriter(temporary, schema)
                writer.write_table(table.cast(writer.schema))
        finally:
            if writer is not None:
                writer.close()


def _frames(ds: xr.Dataset) -> Iterator[pd.DataFrame]:
    """The table chunk by chunk, its rows in the order of the points or samples."""
    import pandas as pd

    template = ds["status"] if "status" in ds.variables else ds["lower_displacement"]
    dims, columns = list(map(str, template.dims)), _columns(ds, template)
    chunks = Chunks(template.shape)
    for number in range(len(chunks)):
        part = ds.isel(dict(zip(dims, chunks.box(number), strict=True)))
        shape = dict(zip(dims, chunks.shape(number), strict=True))
        yield pd.DataFrame({name: _values(part[name], shape) for name in columns})


def _columns(ds: xr.Dataset, template: xr.DataArray) -> list[str]:
    """What differs from row to row, axes first: coordinates, then variables."""
    along = [str(name) for name in ds.coords if ds[name].ndim and name not in template.dims]
    names = [*map(str, template.dims), *along, *map(str, ds.data_vars)]
    return [n for n in names if n in ds.variables and set(ds[n].dims) <= set(template.dims)]


def _values(variable: xr.DataArray, shape: Mapping[str, int]) -> Any:
    """A column: the values (rows,), spread over the dimensions that a variable lacks."""
    lacking = {dim: size for dim, size in shape.items() if dim not in variable.dims}
    whole = variable.variable.set_dims(lacking | dict(variable.sizes))  # type: ignore[no-untyped-call]
    values = whole.transpose(*shape).values
    if "flag_meanings" not in variable.attrs:
        return values.ravel()
    words = dict(
        zip(variable.attrs["flag_values"], variable.attrs["flag_meanings"].split(), strict=True)
    )
    return [words.get(code, str(code)) for code in values.ravel()]


def _described(ds: xr.Dataset) -> pd.DataFrame:
    """The second table: units and meanings of the columns, and the values of what is fixed."""
    import pandas as pd

    fixed = {str(name): ds[name].item() for name in ds.coords if not ds[name].ndim}
    template = ds["status"] if "status" in ds.variables else ds["lower_displacement"]
    rows = [
        {
            "name": name,
            "units": ds[name].attrs.get("units", ""),
            "meaning": ds[name].attrs.get("long_name", ""),
            "fixed_value": fixed.get(name, ""),
        }
        for name in [*_columns(ds, template), *fixed]
    ]
    return pd.DataFrame(rows).drop_duplicates("name")
