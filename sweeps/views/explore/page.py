"""The page of one tab: what is moved on it, what is computed for it, what it shows."""

from __future__ import annotations

import html
from pathlib import Path

from bokeh.core.templates import get_env
from bokeh.document import Document
from bokeh.layouts import column
from bokeh.models import Button, Div

from stickslip.parameters import Parameters
from sweeps.charts.chart import Place
from sweeps.config.load import Config
from sweeps.exits import ExpectedError
from sweeps.human import clock
from sweeps.points import periods_of
from sweeps.views.charts.library import library
from sweeps.views.charts.orbit_figures import DRAWN, columns_of
from sweeps.views.explore import address
from sweeps.views.explore.beginning import Beginning, Opened, lone, open_point, with_parameters
from sweeps.views.explore.chart_view import ChartView
from sweeps.views.explore.controls import GROUPS, Controls
from sweeps.views.explore.copies import Copies
from sweeps.views.explore.latest import Latest
from sweeps.views.explore.motion import Motion, compute
from sweeps.views.explore.pictures import OrbitPictures
from sweeps.views.explore.settings import Settings
from sweeps.views.explore.state import PageState
from sweeps.views.explore.summary import kept_html, summary_html

_LOOK = 200  # milliseconds between looks at whether something is still awaited
_MOMENT = 0.4  # seconds: what takes no longer is not announced
_LOADING = 2.0  # seconds: what is compiled already is loaded in less
_TEMPLATE = Path(__file__).with_name("page.html")
_SCRIPT = Path(__file__).with_name("page.js")
_KEEP, _DROP = "Keep this orbit", "Drop the kept orbit"
_COLUMNS = (*DRAWN, "order_parameter")
_STYLE = Path(__file__).with_name("page.css").read_text(encoding="utf-8")


class Page:
    """One tab; `open_in` puts it into a document."""

    def __init__(self, beginning: Beginning) -> None:
        self._beginning, self._opened, self._doing = beginning, beginning.first, ""
        self._controls = Controls(
            beginning.scales, self._opened.point.parameters, self._vary, self._refuse
        )
        self._settings = Settings(self._opened.config, self._set)
        self._pictures, self._copies = OrbitPictures(), Copies()
        self._state = PageState(name="state")
        self._state.on_asked(self._follow)
        self._shown: Motion | None = None
        self._kept: Motion | None = None
        # A point to keep that an address names is computed first, and after it the one to show.
        self._to_keep: Opened | None = None
        self._keep = Button(label=_KEEP, name="keep", width=150)
        self._keep.on_click(self._keep_or_drop)
        self._texts = {
            name: Div(text="", name=name, stylesheets=[_STYLE], disable_math=True)
            for name in ("where", "state", "refusals", "summary", "kept")
        }
        self._texts["refusals"].visible = self._texts["kept"].visible = False
        result = beginning.result
        self._chart: ChartView | None = None
        if result is not None:
            self._chart = ChartView(result, self._open, beginning.borders, self._write_address)
            self._state.on_step(self._step)

    def open_in(self, document: Document) -> None:
        """Fill the document of a tab, and begin to compute."""
        self._latest = Latest(self._work, self._hand_over)
        self._document = document
        reset = Button(label="Reset", name="reset", width=90)
        reset.on_click(self._reset)
        reset.tags = [self._state]  # it comes along with a root
        courses = column(*self._pictures.courses, name="courses", sizing_mode="stretch_width")
        groups = [self._controls.column(group) for group in GROUPS]
        roots = [
            reset,
            self._keep,
            courses,
            self._pictures.portrait,
            self._settings.column,
            *groups,
        ]
        roots += [self._copies.column, *self._texts.values()]
        for root in [*roots, *([self._chart.column] if self._chart else [])]:
            document.add_root(root)
        document.title = " - ".join(filter(None, ["stickslip explore", self._beginning.name]))
        _use_template(document, with_chart=self._chart is not None)
        document.js_on_event("document_ready", self._state.beginning(self._pictures))
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

    def _step(self, right: int, up: int) -> None:
        """The point of the file next to the one that was asked for last."""
        assert self._chart is not None
        self._chart.step(self._opened, right, up)

    def _show(self, opened: Opened) -> None:
        """A point that was not made by the controls: they follow."""
        self._controls.show(opened.point.parameters)
        self._settings.show(opened.config)
        self._ask(opened)

    def _reset(self) -> None:
        """Return to what the page began with."""
        self._let_go()
        self._show(self._beginning.first)

    def _follow(self, end: str) -> None:
        """What an end of the address asks for; what cannot be shown is refused in a sentence."""
        parts, result = address.read(end), self._beginning.result
        kept = address.within(parts, address.KEPT)
        try:
            opened = address.opened_by(parts, result) if parts else self._beginning.first
            beneath = address.opened_by(kept, result) if kept else None
        except ExpectedError as error:
            self._refuse([f"The address asks for what this page does not have: {error}."])
            return
        if self._chart:
            self._chart.restore(address.within(parts, address.CHART))
        self._let_go()
        self._show(opened)
        if beneath:
            self._to_keep = beneath
            self._latest.submit(beneath)

    def _write_address(self) -> None:
        """Put what is shown into the address of the page."""
        result = self._beginning.result
        parts = address.parts_of(self._opened, result)
        if self._kept:
            parts |= address.under(address.KEPT, address.parts_of(self._kept.opened, result))
        if self._chart:
            parts |= address.under(address.CHART, self._chart.parts())
        self._state.address = address.written(parts)

    def _refuse(self, complaints: list[str]) -> None:
        lines = [f'<p class="trouble">{html.escape(line)}</p>' for line in complaints]
        self._texts["refusals"].update(text="".join(lines), visible=bool(lines))

    # --- what is computed, in threads ---

    def _ask(self, opened: Opened) -> None:
        self._opened, self._to_keep = opened, None
        name = f"<b>{html.escape(self._beginning.name)}</b> " if self._beginning.name else ""
        notes = "".join(f'<p class="note">{html.escape(n)}</p>' for n in self._beginning.notes)
        self._texts["where"].text = name + html.escape(opened.label) + notes
        self._write_address()
        self._latest.submit(opened)

    def _work(self, opened: Opened) -> Motion:
        return compute(opened, self._tell)

    def _tell(self, doing: str) -> None:
        self._doing = doing

    def _hand_over(self, motion: Motion) -> None:
        self._document.add_next_tick_callback(lambda: self._draw(motion))

    # --- what is shown ---

    def _keep_or_drop(self) -> None:
        if self._kept:
            self._let_go()
        elif self._shown:
            self._keep_beneath(self._shown)
        self._write_address()

    def _keep_beneath(self, motion: Motion) -> None:
        """Leave a motion in the pictures, beneath those that follow."""
        self._kept, self._keep.label = motion, _DROP
        self._pictures.keep(None if motion.courses is None else columns_of(motion.courses))
        self._texts["kept"].update(text=kept_html(motion), visible=True)

    def _let_go(self) -> None:
        self._kept, self._keep.label = None, _KEEP
        self._pictures.keep(None)
        self._texts["kept"].visible = False

    def _draw(self, motion: Motion) -> None:
        if motion.opened is self._to_keep:
            self._keep_beneath(motion)
            self._ask(self._opened)
            return
        self._shown = motion
        courses = motion.courses
        self._state.periods = motion.drive_periods
        self._pictures.show(None if courses is None else columns_of(courses, _COLUMNS))
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
                    "compiling for this processor: up to a minute, and kept for later runs "
                    f"({clock(waiting)})"
                )
            text = f'<span class="busy">{text}</span>'
        if self._texts["state"].text != text:
            self._texts["state"].text = text


def _use_template(document: Document, *, with_chart: bool) -> None:
    """Lay the document out in the page's own template, with all scripts inside it."""
    context = document.session_context
    host = context.request.headers.get("Host", "") if context and context.request else ""
    document.template = get_env().from_string(_TEMPLATE.read_text(encoding="utf-8"))
    document.template_variables.update(
        with_chart=with_chart,
        library=library("bokeh", "bokeh-widgets"),
        page_script=_SCRIPT.read_text(encoding="utf-8"),
        host=host,
    )
