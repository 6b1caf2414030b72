"""Results as tables, for users without NetCDF: one row per point, CSV or Parquet.

The columns are the coordinates that vary, then the variables, with the names and units of the
file; status and regime are words. The first line holds the names: spreadsheets would take comments
above it for data. Units, meanings and the fixed parameters are in a second, small table beside a
CSV file, or in the metadata of a Parquet file.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.variables import PARAMETERS, RESULTS
from sweeps.exits import ExpectedError
from sweeps.files.attributes import flags_of
from sweeps.files.result_rows import Chunks
from sweeps.grid import QUANTILE

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    import xarray as xr

ENDINGS = (".csv", ".parquet")

# Variables with a value for each row, in a sweep, a trajectory or borders.
_TEMPLATES = ("status", "lower_displacement", "line")

_DESCRIPTION = ["name", "units", "meaning", "fixed_value"]  # the columns of the second table


class TableError(ExpectedError, ValueError):
    """A table that cannot be made; the message says what would help."""


def files_of(path: Path) -> list[Path]:
    """Return the files of a table: the table and, for CSV, the table of its columns.

    Raises TableError if the ending is neither .csv nor .parquet, or pyarrow is missing.
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise TableError(f"{path}: the name of a table must end in {' or '.join(ENDINGS)}")
    if ending == ".csv":
        return [path, path.with_name(f"{path.stem}.columns.csv")]
    try:
        import pyarrow.parquet  # noqa: F401 - only whether it is there
    except ImportError:
        raise TableError(
            "Parquet needs pyarrow, which is not installed: pip install 'pyarrow>=16'; "
            "a .csv table needs no extra package"
        ) from None
    return [path]


def refuse_other_data(ds: xr.Dataset, name: Path) -> None:
    """Raise TableError if a Dataset is empty, or is no result, trajectory or set of borders."""
    if not set(_TEMPLATES) & ds.variables.keys():
        raise TableError(f"{name} holds no result of a sweep, no trajectory and no borders")
    if empty := [str(dim) for dim, size in ds.sizes.items() if size == 0]:
        raise TableError(f"{name} is empty: no value along {', '.join(empty)}")


def tables(ds: xr.Dataset, path: Path) -> dict[Path, Callable[[Path], None]]:
    """Return for each file of a table the function that writes it, chunk by chunk.

    `ds` is the result of a sweep, a trajectory (its samples are the rows), or borders. Floats have
    all their digits. For points without a result, NaN and the -1 of counts become empty cells. In a
    CSV file, texts that a spreadsheet would run as a formula get an apostrophe in front.

    Raises TableError as `files_of` does.
    """
    files, ds = files_of(path), _numbered(ds)
    if len(files) == 1:
        return {path: lambda place: _write_parquet(ds, place)}
    described = _described(ds).map(_quoted)
    return {
        path: lambda place: _write_csv(ds, place),
        files[1]: lambda place: described.to_csv(place, index=False, lineterminator="\n"),
    }


def _numbered(ds: xr.Dataset) -> xr.Dataset:
    """Return a result with numbers along stacks that have no coordinate, to tell the rows apart."""
    dims = ds["status"].dims if "status" in ds.variables else ()
    bare = [dim for dim in dims if dim not in ds.variables and dim not in PARAMETERS]
    return ds.assign_coords({dim: np.arange(ds.sizes[dim]) for dim in bare})


def _write_csv(ds: xr.Dataset, path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        for number, frame in enumerate(_frames(ds)):
            texts = frame.select_dtypes(["object", "string"]).columns
            frame[texts] = frame[texts].map(_quoted)
            frame = frame.rename(columns=_quoted)
            frame.to_csv(file, index=False, header=number == 0, lineterminator="\n")


def _quoted(cell: object) -> object:
    """Return a cell, with an apostrophe in front if a spreadsheet would take it for a formula."""
    formula = isinstance(cell, str) and cell.startswith(("=", "+", "-", "@", "\t", "\r"))
    return f"'{cell}" if formula else cell


def _write_parquet(ds: xr.Dataset, path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    frames = _frames(ds)
    first = pa.Table.from_pandas(next(frames), preserve_index=False)
    schema = _with_metadata(first.schema, ds)
    with pq.ParquetWriter(path, schema) as writer:
        writer.write_table(first.cast(schema))
        for frame in frames:
            writer.write_table(pa.Table.from_pandas(frame, schema=schema, preserve_index=False))


def _with_metadata(schema: pa.Schema, ds: xr.Dataset) -> pa.Schema:
    """Return a schema with units and meanings of columns, and the file's global attributes."""
    described = _described(ds).set_index("name")
    for place, field in enumerate(schema):
        row = described.loc[field.name]
        schema = schema.set(place, field.with_metadata(row[["units", "meaning"]].to_dict()))
    fixed = described[described["fixed_value"] != ""]
    about = {name: value for name, value in ds.attrs.items() if isinstance(value, str)}
    # json writes a float with all its digits.
    return schema.with_metadata(about | {"fixed_values": json.dumps(dict(fixed["fixed_value"]))})


def _frames(ds: xr.Dataset) -> Iterator[pd.DataFrame]:
    """Yield the table chunk by chunk, with rows in the order of the points or samples."""
    import pandas as pd

    template = _template(ds)
    dims, columns = list(map(str, template.dims)), _columns(ds)
    chunks = Chunks(template.shape)
    for number in range(len(chunks)):
        part = ds.isel(dict(zip(dims, chunks.box(number), strict=True)))
        shape = dict(zip(dims, chunks.shape(number), strict=True))
        yield pd.DataFrame({name: _values(part[name], shape) for name in columns})


def _template(ds: xr.Dataset) -> xr.DataArray:
    """Return a variable with a value for each row: for each point, and each level of quantiles."""
    template = next(ds[name] for name in _TEMPLATES if name in ds.variables)
    levels = {QUANTILE: ds.sizes[QUANTILE]} if QUANTILE in ds.dims else {}
    return template.expand_dims(levels, axis=-1) if levels else template


def _columns(ds: xr.Dataset) -> list[str]:
    """Return the names of the columns: axes, other coordinates, variables."""
    dims = _template(ds).dims
    along = [str(name) for name in ds.coords if ds[name].ndim and name not in dims]
    names = [*map(str, dims), *along, *map(str, ds.data_vars)]
    return [name for name in names if name in ds.variables and set(ds[name].dims) <= set(dims)]


def _values(variable: xr.DataArray, shape: Mapping[str, int]) -> Any:
    """Return a column (rows,), repeated along the dimensions that the variable lacks."""
    missing = {dim: size for dim, size in shape.items() if dim not in variable.dims}
    whole = variable.variable.set_dims(missing | dict(variable.sizes))  # type: ignore[no-untyped-call]
    values = whole.transpose(*shape).values.ravel()
    if flags := flags_of(variable.attrs):
        return _words(values, flags)
    return _counts(values, str(variable.name)) if values.dtype.kind == "i" else values


def _words(codes: np.ndarray, known: Mapping[int, str]) -> Any:
    """Return the meanings (rows,) of the codes of a flag; those of a masked point are empty."""
    words = [known.get(code, str(code)) for code in codes]
    if codes.dtype.kind != "f":
        return words
    import pandas as pd

    # A column of texts, even if all those of a chunk are empty.
    texts = [None if np.isnan(code) else word for code, word in zip(codes, words, strict=True)]
    return pd.array(texts, dtype="string")


def _counts(values: np.ndarray, name: str) -> Any:
    """Return integers (rows,), empty where missing: a -1 would distort a mean."""
    import pandas as pd

    if name not in RESULTS:
        return values
    return pd.arrays.IntegerArray(values, values == RESULTS[name].missing)


def _unit(variable: xr.DataArray) -> str:
    """Return the unit for people, in a form that UDUNITS may not know."""
    units, known = str(variable.attrs.get("units", "")), PARAMETERS.get(str(variable.name))
    return known.written if known and known.written and known.units == units else units


def _described(ds: xr.Dataset) -> pd.DataFrame:
    """Return the second table: units and meanings of columns, values of fixed parameters."""
    import pandas as pd

    fixed = {str(name): ds[name].item() for name in ds.coords if not ds[name].ndim}
    rows = [
        (name, _unit(ds[name]), ds[name].attrs.get("long_name", ""), fixed.get(name, ""))
        for name in dict.fromkeys([*_columns(ds), *fixed])
    ]
    return pd.DataFrame(rows, columns=_DESCRIPTION)
