"""Datasets written to files as commands write them."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from sweeps.files.atomic import replacing, storage_errors
from sweeps.files.netcdf import write_checked


def write_dataset(ds: xr.Dataset, path: Path) -> None:
    """Write `ds` to `path`, replacing an older file completely or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with storage_errors(f"cannot write {path}", path.parent), replacing(path) as temporary:
        write_checked(ds, temporary)
