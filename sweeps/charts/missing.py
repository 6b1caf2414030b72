"""Points without a value: charts leave them out, and notes count them."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import xarray as xr

from stickslip.status import Status
from stickslip.variables import RESULTS
from sweeps.charts.labels import shown
from sweeps.figure_table import AMPLITUDES
from sweeps.human import counted

RESULT_STATUSES = [int(status) for status in Status if status.is_result]


def trusted(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return a variable at the points with a result, and NaN elsewhere, whatever the file holds."""
    if name == "status":
        return ds[name].astype(float)
    values = ds[name]
    # Variables, not arrays: the slow alignment of coordinates is not needed within one dataset.
    present = values.variable != (RESULTS[name].missing if name in RESULTS else np.nan)
    if "status" in ds:
        status = ds["status"].variable
        present = present & status.copy(data=np.isin(status.values, RESULT_STATUSES))
    kept = values.variable.where(present)  # type: ignore[no-untyped-call] # by xarray
    return xr.DataArray(kept, values.coords, name=values.name)


def with_result(ds: xr.Dataset) -> xr.DataArray:
    """Return True at the points with a result; raises ValueError if the dataset has no status."""
    if "status" not in ds:
        raise ValueError("this is not the result of a sweep: it lacks a status")
    return ds["status"].isin(RESULT_STATUSES)


def value_range(
    ds: xr.Dataset, name: str, *, log: bool = False, with_zero: bool = True
) -> tuple[float, float]:
    """Return the range of a variable's trusted values, in the unit in which they are shown.

    The range includes 0 unless the scale is logarithmic. Without `with_zero` it includes 0 only if
    all values are equal.
    """
    values = shown(trusted(ds, name)).values
    values = values[np.isfinite(values) & (values > 0 if log else True)]
    if values.size == 0:
        return (0.1, 1.0) if log else (0.0, 1.0)
    if log:
        return float(values.min()), float(values.max())
    low, high = float(values.min()), float(values.max())
    if with_zero or low == high:
        low, high = min(low, 0.0), max(high, 0.0)
    return (low, high) if low < high else (0.0, 1.0)


def missing_points(ds: xr.Dataset, names: Sequence[str] = AMPLITUDES) -> xr.DataArray:
    """Return True where a point has no result, or lacks an amplitude, which every result has."""
    missing = xr.zeros_like(ds[names[0]], dtype=bool)
    for name in names:
        values = trusted(ds, name)
        lacking = values.isnull()
        if name not in AMPLITUDES and "status" in ds:
            lacking = lacking & ~ds["status"].isin(RESULT_STATUSES)
        missing = missing | lacking
    return missing


def missing_notes(
    ds: xr.Dataset, names: Sequence[str], mark: str, *, log: Collection[str] = ()
) -> list[str]:
    """Return sentences that count the points left out, by reason; none if all are drawn.

    `log` names the variables drawn on a logarithmic scale.
    """
    missing = missing_points(ds, names)
    notes = []
    if missing.any():
        reasons = ["no status in the file"]
        if "status" in ds:
            codes, counts = np.unique(ds["status"].values[missing.values], return_counts=True)
            reasons = [f"{n} {_reason(code)}" for code, n in zip(codes, counts, strict=True)]
        count = f"{int(missing.sum())} of {missing.size}"
        notes = [f"{mark}{count} points missing ({', '.join(reasons)})"]
    for name in names:
        values = trusted(ds, name)
        undefined = int((values.isnull() & ~missing).sum())
        if undefined:
            notes.append(
                f"{shown(ds[name]).symbol} is not defined at {counted(undefined, 'point')}."
            )
        if name in log and (below := int((values <= 0).sum())):
            at = counted(below, "point")
            notes.append(f"{shown(ds[name]).symbol} is not above 0 at {at}: not drawn.")
    return notes


def _reason(code: float) -> str:
    if np.isnan(code):
        return "without a status"  # masked, for example by `StickslipAccessor.ok`
    if code in RESULT_STATUSES:
        return "without a value"  # the file contradicts itself, and the note must not hide that
    if code not in list(Status):
        return f"with the unknown status {code:g}"
    return Status(int(code)).name.lower().replace("_", " ")
