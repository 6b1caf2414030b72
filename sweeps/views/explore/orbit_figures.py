"""The pictures of a motion: the phase portrait of the orbit, and what goes on over its time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bokeh.models import BasicTickFormatter, ColumnDataSource, DataRange1d, Legend, LegendItem, Span
from bokeh.plotting import figure

from sweeps.figures.labels import shown
from sweeps.figures.motion.traces import ALONE, LOWER, UPPER, Trace
from sweeps.figures.style import CurveStyle
from sweeps.views.symbols import plain

if TYPE_CHECKING:
    import xarray as xr

_DASHES = [5, 3]
_COURSES = (
    (Trace("lower_displacement", style=LOWER), Trace("upper_displacement", style=UPPER)),
    (Trace("elastic_stress"),),
    (Trace("friction_force"),),
)
_TIME, _X, _V = "elapsed_time", "lower_displacement", "lower_velocity"
_DRAWN = (_TIME, _X, _V, *(trace.name for traces in _COURSES for trace in traces))
_HEIGHT, _PORTRAIT = 140, 290  # pixels
_LEAST_STRESS = 2e-6  # MPa: what is less is the noise floor of a liquid film
_AXIS = 24  # pixels below the lowest panel for the label of its axis


class MotionPictures:
    """The figures of one motion; `show` puts another one in its place."""

    def __init__(self) -> None:
        self._data = ColumnDataSource({name: [] for name in dict.fromkeys(_DRAWN)})
        self.portrait = self._portrait()
        self.courses = [self._panel(traces) for traces in _COURSES]
        for panel in self.courses[1:]:
            panel.x_range = self.courses[0].x_range
        for panel in self.courses[:-1]:
            panel.xaxis.major_label_text_font_size = "0pt"
        lowest = self.courses[-1]
        lowest.height = _HEIGHT + _AXIS
        self.courses[0].x_range.range_padding = 0.0
        self.courses[1].y_range.min_interval = _LEAST_STRESS

    def show(self, courses: xr.Dataset | None) -> None:
        """Draw other time courses; none leaves the pictures empty."""
        if courses is None:
            self._data.data = {name: [] for name in self._data.data}
            return
        quantities = {name: shown(courses[name]) for name in self._data.data}
        self._data.data = {name: quantity.values for name, quantity in quantities.items()}
        labels = {name: plain(quantity.label) for name, quantity in quantities.items()}
        self.portrait.xaxis.axis_label = f"displacement {labels[_X]}"
        self.portrait.yaxis.axis_label = f"velocity {labels[_V]}"
        self.courses[0].yaxis.axis_label = f"X, {labels[_X]}"
        for panel, (trace,) in zip(self.courses[1:], _COURSES[1:], strict=True):
            panel.yaxis.axis_label = labels[trace.name]
        self.courses[-1].xaxis.axis_label = labels[_TIME]

    def _portrait(self) -> figure:
        portrait = new_figure(height=_PORTRAIT, name="portrait")
        for dimension in ("width", "height"):
            origin = Span(location=0.0, dimension=dimension, line_color="#cccccc", line_width=1)
            portrait.add_layout(origin)
        portrait.line(_X, _V, source=self._data, **_style(ALONE))
        return portrait

    def _panel(self, traces: tuple[Trace, ...]) -> figure:
        panel = new_figure(height=_HEIGHT, name=traces[0].name)
        lines = [
            panel.line(_TIME, trace.name, source=self._data, **_style(trace.style))
            for trace in traces
        ]
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


def new_figure(**settings: Any) -> figure:
    """An empty figure in the style of the page, as wide as its place."""
    empty = figure(
        sizing_mode="stretch_width",
        tools="pan,box_zoom,wheel_zoom,reset,save",
        toolbar_location="right",
        output_backend="canvas",
        min_border_left=60,  # panels above one another begin together
        **settings,
    )
    empty.toolbar.update(logo=None, autohide=True)
    empty.grid.grid_line_alpha = 0.4
    for axis in empty.axis:
        axis.update(axis_label_text_font_style="normal", axis_label_text_font_size="12px")
        axis.update(major_label_text_font_size="11px", axis_label_standoff=4)
        axis.update(minor_tick_line_color=None)
        axis.formatter = BasicTickFormatter(power_limit_low=-4, power_limit_high=7)
    for ends in (empty.x_range, empty.y_range):
        if isinstance(ends, DataRange1d):
            ends.only_visible = True
    return empty


def _style(style: CurveStyle) -> dict[str, Any]:
    dashes = [] if style.dashes == "solid" else _DASHES
    return {"line_color": style.colour, "line_width": 1.6 * style.width, "line_dash": dashes}
