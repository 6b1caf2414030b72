"""Borders between kinds of motion on the maps of the pages."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import xarray as xr
from bokeh.models import ColumnDataSource, HoverTool, Legend, LegendItem
from bokeh.plotting import figure

from sweeps.figures.borders import lines_of
from sweeps.figures.colours import code_name
from sweeps.figures.style import BLACK
from sweeps.views.boundaries.table import Type
from sweeps.views.charts.kinds import Cells
from sweeps.views.charts.scales import put_above

_DASHES = {"grazing": "solid", "fold": "dashed"}
_WIDTH = 1.5  # pixels
_COUNTS = ("orbit_periods", "melting_count")


def add_borders(drawn: figure, chart: Cells, borders: xr.Dataset) -> None:
    """Draw borders on the figure of a map over their axes.

    A click on the legend hides them; the pointer on a line shows what it parts.
    """
    parts = list(_parts(borders, chart.across.dim, chart.up.dim))
    items, shapes = [], []
    for name, dashes in _DASHES.items():
        own = [(places, words) for places, words, type_ in parts if type_ == name]
        if not own:
            continue
        data = {
            "x": [places[:, 0].tolist() for places, _ in own],
            "y": [places[:, 1].tolist() for places, _ in own],
            "between": [words for _, words in own],
            "type": [name] * len(own),
        }
        look = {"line_color": BLACK, "line_width": _WIDTH, "line_dash": dashes, "line_cap": "round"}
        source = ColumnDataSource(data)
        shapes.append(drawn.multi_line("x", "y", source=source, name=f"borders {name}", **look))
        items.append(LegendItem(label=f"border: {name}", renderers=shapes[-1:]))
    if shapes:
        tips = [("between", "@between"), ("border", "@type")]
        drawn.add_tools(HoverTool(renderers=shapes, tooltips=tips, line_policy="interp"))
        put_above(drawn, Legend(items=items, click_policy="hide"), columns=len(items))


def _parts(borders: xr.Dataset, across: str, up: str) -> Iterator[tuple[np.ndarray, str, str]]:
    """Yield parts of lines that are of one type: places (n, 2), the kinds on both sides, type."""
    for places, points in lines_of(borders, across, up):
        first = borders.isel({borders["line"].dims[0]: points[0]})
        words = " | ".join(_side(first, side) for side in ("left", "right"))
        is_grazing = borders["type"].values[points] == Type.GRAZING
        # A piece that ends where lines meet is what its other end is.
        pieces = is_grazing[:-1] | is_grazing[1:]
        ends = [0, *(np.flatnonzero(np.diff(pieces)) + 1).tolist(), len(pieces)]
        for start, stop in itertools.pairwise(ends):
            kind = Type.GRAZING if pieces[start] else Type.FOLD
            yield places[start : stop + 1], words, kind.name.lower()


def _side(point: xr.Dataset, side: str) -> str:
    """Return the kind of motion on one side, with its counts where the borders are of these."""
    words = [code_name("regime", int(point[f"kind_{side}"]))]
    for count in _COUNTS:
        if f"{count}_{side}" in point:
            name = code_name(count, int(point[f"{count}_{side}"]))
            words.append(f"{count.replace('_', ' ')} {name}")
    return ", ".join(words)
