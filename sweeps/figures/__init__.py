"""Pictures of result and trajectory files. They draw what a Dataset holds and compute nothing.

`draw` chooses the picture, and `save` writes it. `sweeps.figure_table` lists the figures. Only the
scale table of `sweeps.charts.labels` converts units, such as Pa to MPa or m to µm.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from string import ascii_lowercase
from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LogNorm
from matplotlib.figure import Figure

from sweeps.charts.choice import data_of, default_figure, obstacle, refuse_empty, slice_at
from sweeps.charts.labels import changed_parameters
from sweeps.figure_table import FIGURES
from sweeps.figures.amplitudes import draw_results
from sweeps.figures.look import Look, PlotOptions, Range
from sweeps.figures.save import ENDINGS, save
from sweeps.figures.style import put_note, put_title, styled
from sweeps.figures.traces import draw_variables
from sweeps.human import counted

__all__ = ["ENDINGS", "Look", "PlotOptions", "default_figure", "draw", "obstacle", "save"]


def draw(ds: xr.Dataset, figure: str | None = None, options: PlotOptions | None = None) -> Figure:
    """Return a picture of a dataset; `save` writes it.

    `ds` is a sweep result, or a trajectory along `elapsed_time` or along (axis, sample) with a 2-D
    `elapsed_time`. `figure` is a key of `FIGURES`, by default `default_figure(ds)`. `options` set
    the style and, instead of a figure by name, may choose variables and axes of a sweep or
    variables of a trajectory.

    Raises ValueError for an unknown name, and if the dataset is empty or lacks the data of the
    figure.
    """
    options = options or PlotOptions()
    look = options.look
    ds = _in_order(ds)
    if figure is not None and options.asks:
        raise ValueError("figure draws a whole picture; leave out figure, or variables and axes")
    with styled(look):
        if options.asks:
            picture = _chosen(ds, options)
        else:
            name = figure or default_figure(ds)
            if refused := obstacle(ds, name):
                raise ValueError(refused)
            refuse_empty(ds)
            module, _, function = FIGURES[name].function.rpartition(".")
            picture = getattr(importlib.import_module(f"{__name__}.{module}"), function)(ds)
        if picture.axes:  # the table of a single point has all parameters, and no axes
            put_note(picture, [changed_parameters(ds)])
        _finish(picture, look)
    if look.axes is None:
        picture.set_label(str(ds.attrs.get("title", "")))
    return picture


def _in_order(ds: xr.Dataset) -> xr.Dataset:
    """Return a dataset, which may be transposed, with the dimensions that figures count on."""
    first = [dim for dim in ("temperature",) if data_of(ds) == "phases" and dim in ds.dims]
    last = [dim for dim in ("ramped_strain", "sample", "bound") if dim in ds.dims]
    return ds.transpose(*first, ..., *last) if first or last else ds


def _chosen(ds: xr.Dataset, options: PlotOptions) -> Figure:
    data = data_of(ds)
    if data == "trajectory" and options.variable is not None and not options.asks_for_axes:
        chosen, at = slice_at(ds, options.at)
        if chosen["elapsed_time"].dims[-1:] != ds["elapsed_time"].dims[-1:]:
            raise ValueError("a trajectory is drawn over all its time; to show a part, use xlim")
        courses = draw_variables(chosen, options.variables)
        put_note(courses, [at])
        return courses
    if data == "fit" and options.data is not None:
        raise ValueError(
            "the picture of a fit shows the fitted data; leave out data "
            "(`stickslip plot FILE --figure fit` draws the fit)"
        )
    if data != "sweep":
        names = ", ".join(f"'{name}'" for name in FIGURES if not obstacle(ds, name))
        here = "a variable or a figure" if data == "trajectory" else "a figure"
        raise ValueError(
            f"this file holds {FIGURES[default_figure(ds)].drawn}, and only a sweep has variables "
            f"over axes; choose {here} by name: {names}"
        )
    is_of_borders = "boundary_point" in ds.dims
    if (options.variable is None or is_of_borders) and (refused := obstacle(ds, "amplitudes")):
        raise ValueError(refused)
    return draw_results(ds, options)


def _finish(figure: Figure, look: Look) -> None:
    """Set the limits, letters and title of a picture.

    Raises ValueError for limits that are impossible on a logarithmic scale, in the wrong order, or
    without effect on the picture, and for more panels than there are letters.
    """
    panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    panels = [look.axes] if look.axes else panels
    coloured = False
    for axes in panels:
        _require_positive("xlim", look.xlim, logarithmic=axes.get_xscale() == "log")
        _require_positive("ylim", look.ylim, logarithmic=axes.get_yscale() == "log")
        _require_rising("xlim", look.xlim, axes.get_xlim())
        _require_rising("ylim", look.ylim, axes.get_ylim())
        axes.set_xlim(*look.xlim)
        axes.set_ylim(*look.ylim)
        for drawn in axes.collections:  # the colours of kinds have no limits
            if drawn.get_array() is not None and not isinstance(drawn.norm, BoundaryNorm):
                _require_positive("clim", look.clim, logarithmic=isinstance(drawn.norm, LogNorm))
                _require_rising("clim", look.clim, drawn.get_clim())
                drawn.set_clim(*look.clim)
                coloured = True
    _require_effect(look, panels, coloured=coloured)
    if look.letters:
        first = 0 if look.letters is True else ascii_lowercase.index(look.letters)
        if first + len(panels) > len(ascii_lowercase):
            raise ValueError(
                f"letters run out at z: too few for {counted(len(panels), 'panel')} starting at "
                f"{ascii_lowercase[first]}"
            )
        # To the left of the upper corner of the panel, where there is no curve.
        corner: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
        corner |= {"xytext": (-2.0, 2.0), "ha": "right", "va": "bottom"}
        for letter, axes in zip(ascii_lowercase[first:], panels, strict=False):
            axes.annotate(f"({letter})", (0.0, 1.0), **corner)
    if look.title:
        put_title(figure, look.title)


def _require_effect(look: Look, panels: Sequence[Axes], *, coloured: bool) -> None:
    """Raise ValueError for limits of something that the picture does not have."""
    limits = {"xlim": panels, "ylim": panels, "clim": coloured}
    for name, present in limits.items():
        if getattr(look, name) != (None, None) and not present:
            what = "colour scale" if name == "clim" else "axes"
            raise ValueError(f"{name} does not apply: this picture has no {what}")


def _require_rising(name: str, limits: Range, ends: Range) -> None:
    """Raise ValueError if a single given limit lies beyond the present end on the other side."""
    (low, high), (lowest, highest) = limits, ends
    if low is not None and high is None and highest is not None and low >= highest:
        raise ValueError(f"{name} begins at {low:g}, beyond the other end at {highest:.4g}")
    if high is not None and low is None and lowest is not None and high <= lowest:
        raise ValueError(f"{name} ends at {high:g}, before the other end at {lowest:.4g}")


def _require_positive(name: str, limits: Range, *, logarithmic: bool) -> None:
    """Raise ValueError for limits of a logarithmic scale that are not positive."""
    for end in limits:
        if logarithmic and end is not None and end <= 0.0:
            raise ValueError(f"{name} on a logarithmic scale must be greater than 0, not {end:g}")
