"""Quantiles of results over the cases of a sample: how uncertain parameters spread a curve."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

import numpy as np
import xarray as xr

from stickslip.status import Status
from stickslip.variables import RESULTS
from sweeps.charts.axes import MANY, is_scattered
from sweeps.charts.choice import ROLES, Choice, axis_named, refuse_empty
from sweeps.charts.labels import Array, parameters_along, shown
from sweeps.charts.missing import trusted, with_result
from sweeps.grid import CASE, QUANTILE
from sweeps.human import counted

# The median, and the ends of intervals that hold 68 % and 95 % of the cases.
_LEVELS = (0.025, 0.16, 0.5, 0.84, 0.975)
_SIDES = ("lower", "upper")  # ends of a band
_USED = "cases_with_result"
_KEPT = ("title", "Conventions", "sample")


def quantiles_of(ds: xr.Dataset, levels: Sequence[float] | None = None) -> xr.Dataset:
    """Return the quantiles of all measured variables over the cases that have a result.

    `cases_with_result` counts these cases; if there are none, the quantiles are NaN. Raises
    ValueError for a result without cases, points or statuses, and for levels outside [0, 1].
    """
    refuse_empty(ds)
    if ds.sizes.get(CASE, 1) == 1:
        raise ValueError("quantiles are taken over the cases of a sample, and this result has none")
    at = np.unique(np.asarray(_LEVELS if levels is None else levels, dtype=float))
    if not at.size or not (at[0] >= 0.0 and at[-1] <= 1.0):
        raise ValueError(f"quantile levels must be between 0 and 1, not {at.tolist()}")
    there = with_result(ds)
    found = {}
    for name, variable in ds.data_vars.items():
        if not _is_measured(variable) or CASE not in variable.dims:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of points without any value
            found[name] = trusted(ds, str(name)).quantile(at, dim=CASE, keep_attrs=True)
    count = there.sum(CASE).astype(np.int32)
    count.attrs = {"long_name": "number of cases with a result", "units": "1"}
    first = ds["status"].isel({CASE: 0}, drop=True)
    status = first.where(count == 0, Status.OK).astype(first.dtype)
    kept = ds.drop_vars([name for name in parameters_along(ds, CASE) if name in ds.coords])
    kept = kept.drop_dims(CASE)
    attrs = {name: ds.attrs[name] for name in _KEPT if name in ds.attrs} | {"cases": ds.sizes[CASE]}
    made = kept.assign(found | {"status": status, _USED: count})
    made[QUANTILE].attrs = {"long_name": "level of the quantile", "units": "1"}
    made.attrs = attrs  # the others describe the file and its numbers
    return made


def _is_measured(variable: xr.DataArray) -> bool:
    """Return False for kinds and counts, which have no quantiles; masked ones are floats."""
    known = RESULTS.get(str(variable.name))
    return variable.dtype.kind == "f" and (known is None or known.dtype.startswith("f"))


def asks_for_bands(ds: xr.Dataset, choice: Choice, variables: Sequence[str]) -> bool:
    """Return True if the choice wants medians and bands over an axis of many cases in no order.

    Without any choice, a long axis beside the cases is enough. Counts have no quantiles.
    """
    if choice.y or ds.sizes.get(CASE, 1) <= MANY or not is_scattered(ds, CASE):
        return False
    if not all(_is_measured(ds[name]) for name in variables):
        return False
    names = [getattr(choice, role) for role in ROLES if getattr(choice, role)]
    if not names:
        return any(size > MANY for dim, size in ds.sizes.items() if dim != CASE)
    return choice.x is not None and all(axis_named(ds, name)[0] != CASE for name in names)


def medians_of(ds: xr.Dataset) -> tuple[xr.Dataset, list[str]]:
    """Return quantiles as curves (the medians and the ends of bands), and notes that explain them.

    Raises ValueError if the quantiles have no axis, or if the median is not among them.
    """
    if ds.sizes.keys() <= {QUANTILE}:
        raise ValueError(
            "quantiles are drawn as curves, and these have no axis: they are numbers of a single "
            "point; draw the result itself to see its cases"
        )
    levels = ds[QUANTILE].values
    if not np.isclose(levels, 0.5).any():
        raise ValueError("the curve drawn is the median, so 0.5 must be one of the levels")
    pairs, curves = _pairs(levels), {}
    for name in [str(name) for name, each in ds.data_vars.items() if QUANTILE in each.dims]:
        at = {float(level): ds[name].isel({QUANTILE: i}) for i, level in enumerate(levels)}
        curves[name] = ds[name].isel({QUANTILE: int(np.argmin(np.abs(levels - 0.5)))})
        for number, ends in enumerate(pairs):
            for side, level in zip(_SIDES, ends, strict=True):
                curves[_band(name, number, side)] = at[level].rename(name)
    made = ds.drop_dims(QUANTILE).assign(
        {name: curve.drop_vars(QUANTILE) for name, curve in curves.items()}
    )
    holds = " and ".join(f"{100 * (high - low):.3g} %" for low, high in pairs)
    # A part of the quantiles, or what was computed from them, may not say how many cases there are.
    cases = f" of {counted(int(ds.attrs['cases']), 'case')}" if "cases" in ds.attrs else ""
    notes = [f"Medians{f'; bands hold {holds}' if holds else ''}{cases}."]
    lost = (
        int(ds.attrs["cases"]) * ds[_USED].size - int(ds[_USED].sum())
        if cases and _USED in ds
        else 0
    )
    if lost:
        notes.append(f"Left out: {counted(lost, 'point')} without a result.")
    return made, notes


def bands_of(line: xr.Dataset, name: str) -> list[tuple[Array, Array]]:
    """Return the ends of the bands about a median, in shown units, the widest first."""
    bands: list[tuple[Array, Array]] = []
    while (lower := _band(name, len(bands), "lower")) in line:
        upper = _band(name, len(bands), "upper")
        below, above = (shown(line[end].rename(name)).values for end in (lower, upper))
        bands.append((below, above))
    return bands


def _band(name: str, number: int, side: str) -> str:
    return f"{name}_band_{number}_{side}"


def _pairs(levels: Array) -> list[tuple[float, float]]:
    """Return the levels that lie symmetrically about the median, the widest first."""
    below, above = levels[levels < 0.5], levels[levels > 0.5]
    pairs = ((float(low), float(high)) for low in below for high in above)
    return [(low, high) for low, high in pairs if math.isclose(low + high, 1.0)]
