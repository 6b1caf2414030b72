"""The curves of a variable over an axis: one for each fluid or value, and for each way."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from sweeps.charts.axes import Axis
from sweeps.charts.colours import is_discrete
from sweeps.charts.jumps import jumps
from sweeps.charts.labels import DIRECTIONS, Array, legend_label, shown
from sweeps.charts.layout import Layout
from sweeps.charts.missing import trusted, value_range
from sweeps.charts.styles import CurveStyle, Hue, Palette, curve_style, hue_of, way_style
from sweeps.grid import DIRECTION


@dataclass(frozen=True)
class Curve:
    """One curve: values over the axis, where they jump, and its place along the other axes.

    `way` is the direction in which it is followed, if in both; `spread` that of values at random.
    """

    label: str
    hue: Hue
    values: Array
    jumps: Array
    places: dict[str, int]
    way: str = ""
    spread: Array | None = None

    def style(self, palette: Palette) -> CurveStyle:
        """Return how it is drawn."""
        return way_style(curve_style(self.hue, palette), self.way)


def curves_of(ds: xr.Dataset, layout: Layout, axis: Axis, name: str) -> Iterator[Curve]:
    """Yield the curves of a variable: for each value of the hue, and for each way.

    The points of `ds` are in the order of the axis.
    """
    dims = [dim for dim in (layout.hue, DIRECTION if layout.both_ways else None) if dim]
    count, counts = ds.sizes[layout.hue] if layout.hue else 1, is_discrete(ds, name)
    for places in itertools.product(*(range(ds.sizes[dim]) for dim in dims)):
        place = dict(zip(dims, places, strict=True))
        line, hue = ds.isel(place), hue_of(layout.hue, place.get(str(layout.hue), 0), count)
        labels = [legend_label(ds, layout.hue, place[layout.hue])] if layout.hue else []
        way = ""
        if layout.both_ways:
            way = str(line[DIRECTION].values)
            labels.append(DIRECTIONS.get(way, way))
        values = shown(trusted(line, name)).values
        # Nothing lies between two counts.
        breaks = abs(np.diff(values)) > 0 if counts else jumps(line, axis.steps, values)
        yield Curve(", ".join(labels), hue, values, breaks, place, way, _spread(line, name))


def _spread(line: xr.Dataset, name: str) -> Array | None:
    """Return the standard deviation between drive periods, where the value is a mean over them.

    It is none of orbits of several periods, whose value is the largest: it is no band around that.
    """
    own = f"{name}_spread"
    if own not in line or "orbit_periods" not in line:
        return None
    spread = np.where(line["orbit_periods"] == 0, shown(trusted(line, own)).values, 0.0)
    return np.nan_to_num(spread) if np.nansum(spread) else None


def range_with_spread(ds: xr.Dataset, name: str, *, log: bool) -> tuple[float, float]:
    """Return the range of the values, and of what lies a standard deviation above them."""
    low, high = value_range(ds, name, log=log)
    spread = _spread(ds, name)
    if spread is not None:
        high = max(high, float(np.nanmax(shown(trusted(ds, name)).values + spread)))
    return low, high


def axis_limits(
    low: float, high: float, room: float = 1.0, *, log: bool = False
) -> tuple[float, float]:
    """Return limits just below the lowest point, so that a curve at zero shows, and above all."""
    if log:
        span = max(high / low, 1.1)
        return low * span**-0.03, low * (span**1.05) ** room
    span = high - low
    return low - 0.03 * span, low + 1.05 * span * room
