"""The colours of charts as matplotlib takes them, their legends and colour bars."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sweeps.charts.colours import Colours
from sweeps.charts.styles import GREY
from sweeps.figures.style import SMALL, name_ticks


class Shades(NamedTuple):
    """Colours as the arguments of what is drawn; all that shares a scale has the same norm."""

    cmap: Colormap
    norm: Normalize

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `pcolormesh` and `scatter`."""
        return self._asdict()


def shades_of(colours: Colours) -> Shades:
    """Return the colours of a variable, in the settings of matplotlib."""
    return Shades(_cmap(colours), _norm(colours))


def _cmap(colours: Colours) -> Colormap:
    """Return the colours of codes in order, or those of a scale of values."""
    cmap = colormaps[mpl.rcParams["image.cmap"]]
    if not colours.codes:
        return cmap.with_extremes(bad=GREY)
    count = len(colours.codes)
    return ListedColormap(
        colours.kinds if colours.is_named else list(cmap(np.linspace(0.0, 1.0, count)))
    )


def _norm(colours: Colours) -> Normalize:
    """Return where each value lies on the scale."""
    if colours.codes:
        count = len(colours.codes)
        return BoundaryNorm(np.arange(count + 1) - 0.5, count)
    return (LogNorm if colours.log else Normalize)(colours.low, colours.high)


def legend_of(colours: Colours) -> list[Line2D]:
    """Return a square and a name for each kind; nothing for numbers, which have a scale."""
    if not colours.is_named:
        return []
    squares = zip(colours.kinds, colours.names, strict=True)
    return [
        Line2D([], [], linestyle="none", marker="s", color=colour, label=label, markersize=6.0)
        for colour, label in squares
    ]


def draw_scale(colours: Colours, shades: Shades, figure: Figure, beside: Sequence[Axes]) -> None:
    """Draw a colour bar beside some panels, where the colours are numbers."""
    if colours.is_named:
        return
    bar = figure.colorbar(
        ScalarMappable(shades.norm, shades.cmap), ax=list(beside), pad=0.02, aspect=25
    )
    bar.set_label(colours.label)
    if colours.log:
        name_ticks(bar.ax.yaxis)
    bar.ax.tick_params(direction="in", which="both")
    bar.ax.yaxis.get_offset_text().set_fontsize(SMALL)
    if colours.codes:
        bar.set_ticks(list(range(len(colours.codes))), labels=colours.names)
        bar.ax.tick_params(which="both", length=0)
