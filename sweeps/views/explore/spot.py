"""The place in a chart of the point that is open."""

from __future__ import annotations

from stickslip.orbit import Orbit
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.charts.axes import Axis
from sweeps.charts.chart import Chart, Cloud, Curves
from sweeps.charts.labels import shown_number
from sweeps.views.explore.beginning import Opened


def spot_of(
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
