"""The choice of points of a result: the nearest to what texts such as `temperature=228` name."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS, canonical_name
from sweeps.charts.labels import parameters_along, slice_label
from sweeps.config.numbers import number
from sweeps.human import did_you_mean


def slice_at(ds: xr.Dataset, at: Iterable[str]) -> tuple[xr.Dataset, str]:
    """The dataset at the points that are nearest, and a sentence that says where that is.

    `temperature=180,220,300` keeps several points of an axis, and the axis with them.
    """
    ds = with_numbers(ds)
    texts: list[str] = []
    some: dict[str, list[int]] = {}
    for text in at:
        key, _, value = (part.strip() for part in text.partition("="))
        if "," not in value:
            texts.append(text)
            continue
        each = [f"{key}={one}" for one in value.strip("[]").split(",")]
        found = [places_at(ds, [one]) for one in each]
        some |= {dim: list(dict.fromkeys(place[dim] for place in found)) for dim in found[0]}
    ds = ds.isel(some)
    places = places_at(ds, texts)
    return ds.isel(places), f"At {slice_label(ds, places)}." if places else ""


def places_at(ds: xr.Dataset, at: Iterable[str]) -> dict[str, int]:
    """The nearest place along each dimension that texts such as `temperature=228` name.

    Raises ValueError for what is no axis, no value, or far off the axis.
    """
    places: dict[str, int] = {}
    for text in at:
        key, _, value = (part.strip() for part in text.partition("="))
        if not key or not value:
            raise ValueError(f"'{text}' must be KEY=VALUE, for example temperature=228")
        dim, name = axis_named(ds, key)
        if dim in places:
            raise ValueError(
                f"'{text}': {dim} is sliced before already; several points are {key}=180,220,300"
            )
        places[dim] = _nearest(ds[name], value, text)
    return places


def with_numbers(ds: xr.Dataset) -> xr.Dataset:
    """Give numbers to dimensions without a coordinate, as of results that were stacked."""
    bare = {dim: np.arange(n) for dim, n in ds.sizes.items() if dim not in ds.coords}
    return ds.assign_coords(bare) if bare else ds


def slice_in_the_middle(ds: xr.Dataset, dims: Iterable[str]) -> tuple[xr.Dataset, str]:
    """The dataset in the middle of some dimensions, and a sentence that says where that is."""
    places = {dim: ds.sizes[dim] // 2 for dim in dims}
    where = f"In the middle of further axes: {slice_label(ds, places)}." if places else ""
    return ds.isel(places), where


def axis_named(ds: xr.Dataset, name: str) -> tuple[str, str]:
    """The dimension along which a name varies, and the coordinate that it is."""
    full = canonical_name(name) or name
    if full in ds.sizes and ds.sizes[full] > 1:
        return full, full
    if full in ds.coords and ds[full].size > 1:
        return str(ds[full].dims[0]), full
    if full in ds.coords:
        value = ds[full].values.item()
        raise ValueError(f"{full} is {value} in all of this file; {_axes_of(ds)}")
    hint = did_you_mean(name, [*_varying(ds), *PARAMETERS])
    raise ValueError(f"unknown axis '{name}'{hint}; {_axes_of(ds)}")


def _nearest(coordinate: xr.DataArray, text: str, whole: str) -> int:
    values = coordinate.values
    if values.dtype.kind not in "fiu":
        known = [str(value) for value in values]
        if text in known:
            return known.index(text)
        raise ValueError(f"'{whole}': there are {' and '.join(known)}")
    try:
        value = number(text) if "/" in text else float(text)
    except ValueError:
        raise ValueError(f"'{whole}': {text} is no number") from None
    if not math.isfinite(value):
        raise ValueError(f"'{whole}': must be a finite number")
    low, high = float(values.min()), float(values.max())
    # Beyond the ends by the longest step there is: nobody means the last point.
    reach = float(np.diff(np.sort(values)).max(initial=0.0))
    if not low - reach <= value <= high + reach:
        raise ValueError(f"'{whole}': {coordinate.name} goes from {low:g} to {high:g} in this file")
    return int(np.argmin(np.abs(values - value)))


def _varying(ds: xr.Dataset) -> list[str]:
    dims = [str(dim) for dim, size in ds.sizes.items() if size > 1]
    return [name for dim in dims for name in dict.fromkeys([dim, *parameters_along(ds, dim)])]


def _axes_of(ds: xr.Dataset) -> str:
    symbols = {name: f" ({PARAMETERS[name].symbol})" for name in PARAMETERS}
    names = [f"{name}{symbols.get(name, '')}" for name in _varying(ds)]
    return f"its axes are {', '.join(names)}" if names else "it has no axes: it is a single point"
