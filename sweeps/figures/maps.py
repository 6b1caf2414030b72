"""Amplitudes over two axes: a map of the stress above, of the force below, each with a scale."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from sweeps.figure_table import AMPLITUDES
from sweeps.figures.labels import Array, shown
from sweeps.figures.layout import MOST_FACETS, Axis, Layout, axis_of, selections
from sweeps.figures.missing import highest, missing_note, trusted
from sweeps.figures.style import (
    GREY,
    SMALL,
    STACKED,
    TEXT,
    name_columns,
    new_panels,
    put_note,
    set_scale,
    width_of,
)


def draw_maps(ds: xr.Dataset, layout: Layout) -> Figure:
    """Two maps on the same axes, a column of them for each facet, with one scale a row.

    A missing point is grey.
    """
    across, up = (axis_of(ds, dim) for dim in layout.axes)
    ds = ds.isel({across.dim: across.order, up.dim: up.order})
    facets, note = selections(ds, layout.facets, MOST_FACETS)
    size = (width_of(len(facets)), STACKED)
    figure, panels = new_panels(2, len(facets), size, sharex=True, sharey=True)
    for row, name in zip(panels, AMPLITUDES, strict=True):
        top = highest(ds, name)
        for axes, facet in zip(row, facets, strict=True):
            mesh = _draw_map(axes, facet.dataset, name, across, up, top)
        _draw_scale(figure, mesh, list(row), shown(ds[name]).label)
    name_columns(panels, [facet.label for facet in facets], across.label)
    _label(panels, across, up)
    put_note(figure, [missing_note(ds, "Grey: "), note])
    return figure


def _draw_map(
    axes: Axes, ds: xr.Dataset, name: str, across: Axis, up: Axis, top: float
) -> QuadMesh:
    values = shown(trusted(ds, name).transpose(up.dim, across.dim)).values
    return axes.pcolormesh(
        cell_edges(across),
        cell_edges(up),
        np.ma.masked_invalid(values),
        cmap=colormaps["viridis"].with_extremes(bad=GREY),
        vmin=0.0,
        vmax=top,
        rasterized=True,  # thousands of cells as vectors make a slow file with hairlines
    )


def cell_edges(axis: Axis) -> Array:
    """The borders between the points of an axis, halfway on its own scale."""
    values = np.log(axis.quantity.values) if axis.geometric else axis.quantity.values
    middles = (values[1:] + values[:-1]) / 2
    first, last = 2 * values[0] - middles[0], 2 * values[-1] - middles[-1]
    edges = np.concatenate([[first], middles, [last]])
    return np.exp(edges) if axis.geometric else edges


def _draw_scale(figure: Figure, mesh: QuadMesh, row: list[Axes], label: str) -> None:
    bar = figure.colorbar(mesh, ax=row, pad=0.02, aspect=25)
    bar.set_label(label, fontsize=TEXT)
    bar.ax.tick_params(labelsize=TEXT, direction="in")
    bar.ax.yaxis.get_offset_text().set_fontsize(SMALL)


def _label(panels: Array, across: Axis, up: Axis) -> None:
    for axes in panels[:, 0]:
        axes.set_ylabel(up.label, fontsize=TEXT)
    for axes in panels.flat:
        axes.tick_params(direction="out", which="both", top=False, right=False)
        set_scale(axes, "x", across.geometric)
        set_scale(axes, "y", up.geometric)
