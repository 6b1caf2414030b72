"""The pictures of the page: of the motion that is shown, and of one that is kept beneath it."""

from __future__ import annotations

from collections.abc import Mapping

from bokeh.models import ColumnDataSource
from bokeh.plotting import figure

from sweeps.charts.labels import Array
from sweeps.charts.styles import VERMILLION, CurveStyle
from sweeps.views.charts.orbit_figures import COURSES, NOTHING, TIME, MotionPictures, V, X
from sweeps.views.charts.scales import line_style

KEPT = CurveStyle(VERMILLION, 0.9)


class OrbitPictures(MotionPictures):
    """Pictures of two motions."""

    def __init__(self) -> None:
        super().__init__()
        self.kept = ColumnDataSource(NOTHING)
        self._add_kept(self.portrait, X, V)
        for panel, traces in zip(self.courses, COURSES, strict=True):
            self._add_kept(panel, TIME, traces[0].name)

    def keep(self, columns: Mapping[str, Array] | None) -> None:
        """Draw the courses of a motion beneath those of all others; none draws no such motion."""
        self.kept.data = dict(columns or NOTHING)

    def _add_kept(self, drawn: figure, x: str, y: str) -> None:
        drawn.line(x, y, source=self.kept, level="underlay", **line_style(KEPT))
