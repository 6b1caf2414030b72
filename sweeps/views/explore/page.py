"""The page of one tab: what is moved on it, what is computed for it, what it shows."""

from __future__ import annotations

import html
from pathlib import Path

from bokeh.core.templates import get_env
from bokeh.document import Document
from bokeh.layouts import column
from bokeh.models import Button, Div
from bokeh.resources import Resources

from stickslip.parameters import Parameters
from sweeps.config.load import Config
from sweeps.exits import ExpectedError
from sweeps.human import clock
from sweeps.views.charts.kinds import Place
from sweeps.views.charts.orbit_figures import MotionPictures, columns_of
from sweeps.views.explore.beginning import Beginning, Opened, lone, open_point, with_parameters
from sweeps.views.explore.chart_view import ChartView
from sweeps.views.explore.controls import GROUPS, Controls
from sweeps.views.explore.copies import Copies
from sweeps.views.explore.latest import Latest
from sweeps.views.explore.motion import Motion, compute
from sweeps.views.explore.settings import Settings
from sweeps.views.explore.summary import summary_html
from sweeps.views.points import periods_of

_LOOK = 200  # milliseconds between looks at whether something is still awaited
_MOMENT = 0.4  # seconds: what takes no longer is not announced
_LOADING = 2.0  # seconds: what is compiled already is loaded in less
_TEMPLATE = Path(__file__).with_name("page.html")
_STYLE = Path(__file__).with_name("page.css").read_text(encoding="utf-8")


class Page:
    """One tab; `open_in` puts it into a document."""

    def __init__(self, beginning: Beginning) -> None:
        self._beginning, self._opened, self._doing = beginning, beginning.first, ""
        self._controls = Controls(
            beginning.scales, self._opened.point.parameters, self._vary, self._refuse
        )
        self._settings = Settings(self._opened.config, self._set)
        self._pictures, self._copies = MotionPictures(), Copies()
        self._texts = {
            name: Div(text="", name=name, stylesheets=[_STYLE], disable_math=True)
            for name in ("where", "state", "refusals", "summary")
        }
        self._texts["refusals"].visible = False
        result = beginning.result
        self._chart = None if result is None else ChartView(result, self._open, beginning.borders)

    def open_in(self, document: Document) -> None:
        """Fill the document of a tab, and begin to compute."""
        self._latest = Latest(self._work, self._hand_over)
        self._document = document
        reset = Button(label="Reset", name="reset", width=90)
        reset.on_click(lambda: self._show(self._beginning.first))
        courses = column(*self._pictures.courses, name="courses", sizing_mode="stretch_width")
        groups = [self._controls.column(group) for group in GROUPS]
        roots = [reset, courses, self._pictures.portrait, self._settings.column, *groups]
        roots += [self._copies.column, *self._texts.values()]
        for root in [*roots, *([self._chart.column] if self._chart else [])]:
            document.add_root(root)
        document.title = " - ".join(filter(None, ["stickslip explore", self._beginning.name]))
        _use_template(document, with_chart=self._chart is not None)
        document.add_periodic_callback(self._look, _LOOK)
        document.on_session_destroyed(lambda _: self._latest.close())
        self._ask(self._opened)

    # --- what is moved ---

    def _vary(self, parameters: Parameters) -> None:
        """Other parameters."""
        self._take(with_parameters(self._opened.config, parameters))

    def _set(self) -> None:
        """Other settings."""
        self._take(self._settings.applied(self._opened.config))

    def _take(self, config: Config) -> None:
        self._ask(lone(config))

    def _open(self, place: Place) -> None:
        """A point of the file."""
        assert self._beginning.result is not None
        try:
            self._show(open_point(self._beginning.result, place))
        except ExpectedError as error:
            self._refuse([str(error)])

    def _show(self, opened: Opened) -> None:
        """A point that was not made by the controls: they follow."""
        self._controls.show(opened.point.parameters)
        self._settings.show(opened.config)
        self._ask(opened)

    def _refuse(self, complaints: list[str]) -> None:
        lines = [f'<p class="trouble">{html.escape(line)}</p>' for line in complaints]
        self._texts["refusals"].update(text="".join(lines), visible=bool(lines))

    # --- what is computed, in threads ---

    def _ask(self, opened: Opened) -> None:
        self._opened = opened
        name = f"<b>{html.escape(self._beginning.name)}</b> " if self._beginning.name else ""
        notes = "".join(f'<p class="note">{html.escape(n)}</p>' for n in self._beginning.notes)
        self._texts["where"].text = name + html.escape(opened.label) + notes
        self._latest.submit(opened)

    def _work(self, opened: Opened) -> Motion:
        return compute(opened, self._tell)

    def _tell(self, doing: str) -> None:
        self._doing = doing

    def _hand_over(self, motion: Motion) -> None:
        self._document.add_next_tick_callback(lambda: self._draw(motion))

    # --- what is shown ---

    def _draw(self, motion: Motion) -> None:
        self._pictures.show(None if motion.courses is None else columns_of(motion.courses))
        self._texts["summary"].text = summary_html(motion)
        orbit = motion.orbit
        found = orbit is not None and orbit.status.is_result
        self._copies.show(motion.opened, periods_of(orbit) if found and orbit else 1)
        if self._chart:
            self._chart.mark(motion.opened, orbit)
        self._look()

    def _look(self) -> None:
        """Say what is awaited, where it takes longer than a moment."""
        text, waiting = "", self._latest.waiting
        if waiting is not None and waiting > _MOMENT:
            text = f"computing … {clock(waiting)}"
            if self._doing == "compiling" and waiting > _LOADING:
                text = (
                    "compiling for this processor: about a minute, and kept for later runs "
                    f"({clock(waiting)})"
                )
            text = f'<span class="busy">{text}</span>'
        if self._texts["state"].text != text:
            self._texts["state"].text = text


def _use_template(document: Document, *, with_chart: bool) -> None:
    """Lay the document out in the page's own template, with all scripts inside it."""
    context = document.session_context
    host = context.request.headers.get("Host", "") if context and context.request else ""
    scripts = Resources(mode="inline", components=["bokeh", "bokeh-widgets"]).render()
    document.template = get_env().from_string(_TEMPLATE.read_text(encoding="utf-8"))
    document.template_variables.update(with_chart=with_chart, bokeh_scripts=scripts, host=host)
