"""Borders between kinds of motion on the maps of the pages."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from bokeh.models import ColumnDataSource, HoverTool, Legend, LegendItem
from bokeh.plotting import figure

from sweeps.charts.borders import STYLES, parts_of
from sweeps.charts.chart import Cells
from sweeps.charts.colours import code_name
from sweeps.charts.styles import BLACK
from sweeps.page.scales import put_above

_WIDTH, _APART = 1.5, 24  # pixels: of a line, between the types in the legend
_COUNTS = ("orbit_periods", "melting_count")


def add_borders(drawn: figure, chart: Cells, borders: xr.Dataset) -> None:
    """Draw borders on the figure of a map over their axes.

    A click on the legend hides them; the pointer on a line shows what it parts.
    """
    parts = list(_parts(borders, chart.across.dim, chart.up.dim))
    items, shapes = [], []
    for name, dashes in STYLES.items():
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
        put_above(drawn, Legend(items=items, click_policy="hide"), len(items), _APART)


def _parts(borders: xr.Dataset, across: str, up: str) -> Iterator[tuple[np.ndarray, str, str]]:
    """Yield parts of lines that are of one type: places (n, 2), the kinds on both sides, type."""
    for places, points, type_ in parts_of(borders, across, up):
        first = borders.isel({borders["line"].dims[0]: points[0]})
        yield places, " | ".join(_side(first, side) for side in ("left", "right")), type_


def _side(point: xr.Dataset, side: str) -> str:
    """Return the kind of motion on one side, with its counts where the borders are of these."""
    words = [code_name("regime", int(point[f"kind_{side}"]))]
    for count in _COUNTS:
        if f"{count}_{side}" in point:
            name = code_name(count, int(point[f"{count}_{side}"]))
            words.append(f"{count.replace('_', ' ')} {name}")
    return ", ".join(words)
