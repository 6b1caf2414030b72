"""Points without a value: never drawn, never silent."""

from __future__ import annotations

import numpy as np
import xarray as xr

from stickslip.status import Status
from sweeps.figure_table import AMPLITUDES
from sweeps.figures.labels import shown

_RESULTS = [int(status) for status in Status if status.is_result]


def trusted(ds: xr.Dataset, name: str) -> xr.DataArray:
    """An amplitude where the point has a result, NaN elsewhere whatever the file holds there."""
    return ds[name].where(ds["status"].isin(_RESULTS)) if "status" in ds else ds[name]


def highest(ds: xr.Dataset, name: str) -> float:
    """The highest of an amplitude's trusted values as they are shown; 1 where none is above 0."""
    values = shown(trusted(ds, name)).values
    return float(values.max(initial=0.0, where=np.isfinite(values))) or 1.0


def missing_points(ds: xr.Dataset) -> xr.DataArray:
    """True where a point lacks a trusted amplitude."""
    first, second = (trusted(ds, name).isnull() for name in AMPLITUDES)
    return first | second


def missing_note(ds: xr.Dataset, mark: str) -> str:
    """A sentence that counts the missing points by reason; empty where there are none."""
    missing = missing_points(ds).values
    if not missing.any():
        return ""
    if "status" in ds:
        codes, counts = np.unique(ds["status"].values[missing], return_counts=True)
        reasons = [f"{n} {_reason(code)}" for code, n in zip(codes, counts, strict=True)]
    else:
        reasons = ["no status in the file"]
    count = int(missing.sum())
    return f"{mark}{count} of {missing.size} points missing ({', '.join(reasons)})"


def _reason(code: int) -> str:
    if code in _RESULTS:
        return "without a value"  # the file contradicts itself; say so rather than hide the gap
    if code not in list(Status):
        return f"with the unknown status {code}"
    return Status(code).name.lower().replace("_", " ")
