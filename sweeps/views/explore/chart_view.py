"""The chart of a result with what chooses it: variable, axes, a slider for each further axis."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np
import xarray as xr
from bokeh.events import Tap
from bokeh.layouts import column, row
from bokeh.models import CheckboxGroup, Column, Div, Select, Slider
from bokeh.plotting import figure

from stickslip.orbit import Orbit
from stickslip.symbols import plain
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.charts.at import places_at
from sweeps.charts.axes import MANY
from sweeps.charts.borders import are_over, axes_of, elsewhere_than
from sweeps.charts.chart import (
    Cells,
    Chart,
    Curves,
    Place,
    axes_to_choose,
    chart_of,
    further_axes,
    is_cloud,
)
from sweeps.charts.choice import Choice
from sweeps.charts.colours import is_discrete
from sweeps.charts.labels import slice_label
from sweeps.figure_table import AMPLITUDES
from sweeps.grid import DIRECTION
from sweeps.views.charts.borders import add_borders
from sweeps.views.charts.drawing import draw
from sweeps.views.charts.legends import kinds_html
from sweeps.views.explore.address import value_text
from sweeps.views.explore.beginning import Opened
from sweeps.views.explore.spot import spot_of

_AUTOMATIC = "automatic"
_NARROW = 130  # pixels
_LEGEND = Path(__file__).with_name("page.css").read_text(encoding="utf-8")


class ChartView:
    """The chart of a result, with its borders.

    `clicked` is told the place of a point, `redrawn` that something else is drawn.
    """

    def __init__(
        self,
        result: xr.Dataset,
        clicked: Callable[[Place], None],
        borders: xr.Dataset | None = None,
        redrawn: Callable[[], None] = lambda: None,
    ) -> None:
        self._result, self._clicked, self._borders = result, clicked, borders
        self._redrawn = redrawn
        self._opened: tuple[Opened, Orbit | None] | None = None
        self._drawn: tuple[Chart, str, figure] | None = None
        self._quiet = False
        variables = [name for name in RESULTS if name in result.variables]
        titled = [(name, _titled(name)) for name in variables]
        self.variable = Select(
            title="variable", options=titled, value=_first(result), name="variable",
            sizing_mode="stretch_width",
        )  # fmt: skip
        choices = [
            (_AUTOMATIC, _AUTOMATIC),
            *((n, _titled(n)) for n in axes_to_choose(result)),
        ]
        self.across, self.up = (
            Select(title=title, options=choices, value=_AUTOMATIC, width=_NARROW, name=title)
            for title in ("across", "upward")
        )
        self.log = CheckboxGroup(labels=["logarithmic values"], name="logarithmic")
        self.sliders: dict[str, Slider] = {
            str(dim): self._slider(str(dim)) for dim, size in result.sizes.items() if size > 1
        }
        self._labels = {
            dim: Div(text="", disable_math=True, margin=(4, 5, -4, 5)) for dim in self.sliders
        }
        self.message = Div(text="", styles={"color": "#b03a00"}, name="chart-message")
        self.legend = Div(text="", name="legend", disable_math=True, stylesheets=[_LEGEND])
        self._place = column(sizing_mode="stretch_width")
        for select in (self.variable, self.across, self.up):
            select.on_change("value", self._moved)
        self.log.on_change("active", self._moved)
        self._draw()

    @property
    def column(self) -> Column:
        """The chart below its controls."""
        roles = [self.across, self.up] if len(self.across.options) > 1 else []
        return column(
            self.variable,
            row(*roles, self.log, styles={"align-items": "end"}),
            self.legend,
            self._place,
            *(part for dim, slider in self.sliders.items() for part in (self._labels[dim], slider)),
            self.message,
            name="chart",
            sizing_mode="stretch_width",
        )

    def mark(self, opened: Opened, orbit: Orbit | None) -> None:
        """Mark a point, and cut further axes where it lies."""
        moved = False
        for dim, index in (opened.place or {}).items():
            moved |= self.sliders[dim].visible and self.sliders[dim].value != index
            self._quiet = True
            self.sliders[dim].value = index
            self._quiet = False
        self._opened = opened, orbit
        if moved:
            self._draw()
        else:
            self._ring()

    def step(self, opened: Opened, right: int, up: int) -> None:
        """Open the point next to one, in the chart; it may be marked later, when it is computed."""
        if self._drawn is None:
            return
        chart, variable, _ = self._drawn
        marked, orbit = self._opened or (None, None)
        place = opened.place
        if place is None:  # between the points of the file: from the nearest one
            x, y = spot_of(chart, variable, opened, orbit if marked is opened else None)
            place = None if x is None or y is None else chart.place_at(x, y)
        if place is not None:
            cuts = {dim: int(s.value) for dim, s in self.sliders.items() if s.visible}
            self._clicked(chart.neighbour({**place, **cuts}, right, up))

    def parts(self) -> dict[str, str]:
        """What is chosen, where it is not what the page begins with, and where further axes are."""
        parts = {
            name: str(select.value)
            for name, (select, usual) in self._selects().items()
            if select.value != usual
        }
        if self.log.active:
            parts["logarithmic"] = "yes"
        for dim, slider in self.sliders.items():
            if slider.visible:
                parts[dim] = value_text(self._result, dim, int(slider.value))
        return parts

    def restore(self, parts: Mapping[str, str]) -> None:
        """Choose what `parts` once returned; what is not to be had is as at the beginning."""
        self._quiet = True
        for name, (select, usual) in self._selects().items():
            known = [option[0] for option in select.options]
            select.value = parts[name] if parts.get(name) in known else usual
        self.log.active = [0] if parts.get("logarithmic") == "yes" else []
        for dim, slider in self.sliders.items():
            if dim in parts:
                with suppress(ValueError):
                    slider.value = places_at(self._result, [f"{dim}={parts[dim]}"])[dim]
        self._quiet = False
        self._draw()

    def _selects(self) -> dict[str, tuple[Select, str]]:
        """Return what can be chosen, by its name in an address, with what the page begins with."""
        return {
            "variable": (self.variable, _first(self._result)),
            "across": (self.across, _AUTOMATIC),
            "upward": (self.up, _AUTOMATIC),
        }

    def _ring(self) -> None:
        """Put a ring around the point that is open, dashed where it is none of the file."""
        if self._drawn is None or self._opened is None:
            return
        (chart, variable, drawn), (opened, orbit) = self._drawn, self._opened
        spot = spot_of(chart, variable, opened, orbit)
        known = all(value is not None and np.isfinite(value) for value in spot)
        x, y = ([value] if known else [] for value in spot)
        white, ring = (shape for shape in drawn.renderers if shape.name == "mark")
        white.data_source.data = {"x": x, "y": y}
        ring.glyph.line_dash = [] if opened.place is not None else [3, 2]

    def _tap(self, event: Tap) -> None:
        if self._drawn and event.x is not None and event.y is not None:
            place = self._drawn[0].place_at(float(event.x), float(event.y))
            if place is not None:
                self._clicked(place)

    def _moved(self, _attribute: str, _old: object, _new: object) -> None:
        if not self._quiet:
            self._draw()

    def _draw(self) -> None:
        """Draw what is chosen, or say why it cannot be drawn."""
        choice = self._choice()
        try:
            further = further_axes(self._result, choice)
            places = {dim: int(s.value) for dim, s in self.sliders.items()}
            chart = chart_of(self._result, choice, places)
        except ValueError as error:
            self.message.text = html.escape(f"{error}.")
            return
        self.message.text = ""
        for dim, slider in self.sliders.items():
            slider.visible = dim in further
            self._labels[dim].text = html.escape(
                plain(slice_label(self._result, {dim: int(slider.value)}))
            )
            self._labels[dim].visible = slider.visible
        self.log.visible = not is_discrete(self._result, str(self.variable.value))
        kinds = None if isinstance(chart, Curves) else chart.colours
        self.legend.text = (
            f'<div class="kinds">{kinds_html(kinds)}</div>' if kinds and kinds.codes else ""
        )
        drawn = draw(chart)
        if self._borders is not None:
            self.message.text = html.escape(self._add_borders(drawn, chart, self._borders))
        drawn.on_event(Tap, self._tap)
        self._drawn = chart, str(self.variable.value), drawn
        self._place.children = [drawn]
        self._ring()
        self._redrawn()

    def _add_borders(self, drawn: figure, chart: Chart, borders: xr.Dataset) -> str:
        """Draw the borders where they belong; returns why there are none, in a sentence."""
        if not (isinstance(chart, Cells) and are_over(borders, chart.across, chart.up)):
            return f"The borders lie over {' and '.join(axes_of(borders))}."
        if elsewhere := elsewhere_than(self._result.isel(chart.places), borders):
            return f"No borders: {plain(elsewhere)}."
        add_borders(drawn, chart, borders)
        return ""

    def _choice(self) -> Choice:
        across, up = (
            None if select.value == _AUTOMATIC else str(select.value)
            for select in (self.across, self.up)
        )
        return Choice(str(self.variable.value), across, up, log="z" if self.log.active else "")

    def _slider(self, dim: str) -> Slider:
        size = self._result.sizes[dim]
        slider = Slider(
            start=0, end=size - 1, step=1, value=size // 2, show_value=False, tooltips=False,
            title=None, visible=False, name=f"axis-{dim}", sizing_mode="stretch_width",
            bar_color="#0072B2", html_attributes={"data-label": dim.replace("_", " ")},
        )  # fmt: skip
        slider.on_change("value", self._moved)
        return slider


def _titled(name: str) -> str:
    """Return the name of a variable or an axis in a list: a parameter with its symbol."""
    symbol = f"{plain(f'${PARAMETERS[name].tex}$')} " if name in PARAMETERS else ""
    return symbol + name.replace("_", " ")


def _first(result: xr.Dataset) -> str:
    """Return the initial variable: over one long axis an amplitude, else the kind of motion."""
    long = [dim for dim, size in result.sizes.items() if size > MANY and dim != DIRECTION]
    if "regime" in result and (len(long) > 1 or is_cloud(result, Choice("regime"))):
        return "regime"
    return AMPLITUDES[0]
