"""The pictures of a motion: the phase portrait of the orbit, and its courses in time.

A motion that is kept for comparison lies beneath, in red.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from bokeh.models import ColumnDataSource, Legend, LegendItem, Span
from bokeh.plotting import figure

from stickslip.symbols import plain
from sweeps.charts.courses import ALONE, LOWER, UPPER, Trace
from sweeps.charts.labels import Array, shown
from sweeps.charts.styles import VERMILLION, CurveStyle
from sweeps.page.scales import line_style, new_figure

COURSES = (
    (Trace("lower_displacement", style=LOWER), Trace("upper_displacement", style=UPPER)),
    (Trace("elastic_stress"),),
    (Trace("friction_force"),),
)
TIME, X, V = "elapsed_time", "lower_displacement", "lower_velocity"
ORDER = "order_parameter"
DRAWN = (TIME, V, *(trace.name for traces in COURSES for trace in traces), ORDER)
"""What is drawn of a motion, first the time; the order parameter is seen in the film."""
KEPT = CurveStyle(VERMILLION, 0.9)

NOTHING = {name: np.zeros(2) for name in DRAWN}
"""The courses of no motion: of no extent, but a browser wants a range."""

_HEIGHT = 140  # pixels
_LEAST_STRESS = 2e-6  # MPa: what is less is the noise floor of a liquid film
_AXIS = 24  # pixels below the lowest panel for the label of its axis


def columns_of(courses: xr.Dataset, names: Sequence[str] = DRAWN) -> dict[str, Array]:
    """Return the time courses of a motion as they are drawn."""
    return {name: shown(courses[name]).values for name in names}


class MotionPictures:
    """The figures of one motion, filled from `source`; `portrait` is the height of the portrait."""

    def __init__(self, portrait: int = 290) -> None:
        self.source = ColumnDataSource(NOTHING, name="motion")
        self.kept = ColumnDataSource(NOTHING, name="kept motion")
        self._labels = {name: plain(shown(xr.DataArray(0.0, name=name)).label) for name in DRAWN}
        self.portrait = self._portrait(portrait)
        self.courses = [self._panel(traces) for traces in COURSES]
        for panel in self.courses[1:]:
            panel.x_range = self.courses[0].x_range
        for panel in self.courses[:-1]:
            panel.xaxis.major_label_text_font_size = "0pt"
        lowest = self.courses[-1]
        lowest.height = _HEIGHT + _AXIS
        lowest.xaxis.axis_label = self._labels[TIME]
        self.courses[0].yaxis.axis_label = f"X, {self._labels[X]}"
        self.courses[0].x_range.range_padding = 0.0
        self.courses[1].y_range.min_interval = _LEAST_STRESS

    def _portrait(self, height: int) -> figure:
        portrait = new_figure(height=height, name="portrait")
        for dimension in ("width", "height"):
            origin = Span(location=0.0, dimension=dimension, line_color="#cccccc", line_width=1)
            portrait.add_layout(origin)
        portrait.line(X, V, source=self.source, **line_style(ALONE))
        self._add_kept(portrait, X, V)
        portrait.xaxis.ticker.desired_num_ticks = 4  # a narrow picture has no room for more
        portrait.xaxis.axis_label = f"displacement {self._labels[X]}"
        portrait.yaxis.axis_label = f"velocity {self._labels[V]}"
        return portrait

    def _add_kept(self, drawn: figure, x: str, y: str) -> None:
        drawn.line(x, y, source=self.kept, level="underlay", **line_style(KEPT))

    def _panel(self, traces: tuple[Trace, ...]) -> figure:
        panel = new_figure(height=_HEIGHT, name=traces[0].name)
        lines = [
            panel.line(TIME, trace.name, source=self.source, **line_style(trace.style))
            for trace in traces
        ]
        self._add_kept(panel, TIME, traces[0].name)
        panel.yaxis.axis_label = self._labels[traces[0].name]
        if len(traces) > 1:
            names = ("lower block x", "upper block X")
            items = [
                LegendItem(label=label, renderers=[line])
                for label, line in zip(names, lines, strict=True)
            ]
            legend = Legend(items=items, orientation="horizontal", location="right")
            legend.update(label_text_font_size="11px", border_line_alpha=0, margin=0, padding=0)
            legend.spacing = 16
            panel.add_layout(legend, "above")
            panel.height = _HEIGHT + _AXIS
        return panel
