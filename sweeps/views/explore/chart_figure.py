"""The figure of the chart that is shown, and the mark on it that says which point is open."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from bokeh.events import Tap

from stickslip.orbit import Orbit
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.figures.labels import shown_number
from sweeps.figures.layout import Axis
from sweeps.views.charts.drawing import draw
from sweeps.views.charts.kinds import Chart, Cloud, Curves, Place
from sweeps.views.explore.beginning import Opened


class ChartFigure:
    """A figure of one chart; `clicked` is called with the place of a point."""

    def __init__(self, chart: Chart, variable: str, clicked: Callable[[Place], None]) -> None:
        self.chart, self._variable = chart, variable
        self.figure = draw(chart)

        def tap(event: Tap) -> None:
            if event.x is not None and event.y is not None:
                place = chart.place_at(float(event.x), float(event.y))
                if place is not None:
                    clicked(place)

        self.figure.on_event(Tap, tap)

    def mark(self, opened: Opened, orbit: Orbit | None) -> None:
        """Mark the place of a point, dashed where it is none of the file."""
        spot = _spot(self.chart, self._variable, opened, orbit)
        known = all(value is not None and np.isfinite(value) for value in spot)
        x, y = ([value] if known else [] for value in spot)
        white, ring = (shape for shape in self.figure.renderers if shape.name == "mark")
        white.data_source.data = {"x": x, "y": y}
        ring.glyph.line_dash = [] if opened.place is not None else [3, 2]


def _spot(
    chart: Chart, variable: str, opened: Opened, orbit: Orbit | None
) -> tuple[float | None, float | None]:
    """Return where a point lies in a chart; None for what the chart does not say."""
    if isinstance(chart, Cloud):
        across, up = (_value(name, opened, orbit) for name in chart.names)
        return across, up
    x = _coordinate(chart.across, opened)
    if isinstance(chart, Curves):
        return x, _value(variable, opened, orbit)
    return x, _coordinate(chart.up, opened)


def _value(name: str, opened: Opened, orbit: Orbit | None) -> float | None:
    """Return a parameter or a result of the point that is open, as it is shown."""
    if name in RESULTS:
        return None if orbit is None else _shown(name, getattr(orbit, name))
    return _shown(name, opened.point.parameters._asdict()[name])


def _coordinate(axis: Axis, opened: Opened) -> float | None:
    if axis.dim in PARAMETERS and not axis.names:
        return _shown(axis.dim, opened.point.parameters._asdict()[axis.dim])
    if axis.dim not in (opened.place or {}):
        return 0.0 if axis.quantity.values.size == 1 else None
    index = axis.order.tolist().index((opened.place or {})[axis.dim])
    return float(axis.quantity.values[index])


def _shown(name: str, value: float) -> float:
    return float(shown_number(name, value).values)
