"""The common style of all pictures: settings, colours, lines, empty panels, legends, notes.

The object-oriented API with the Agg canvas needs no pyplot. The settings of matplotlib are global,
so `styled` changes them to the house style and a style file for a time, in one thread.
"""

from __future__ import annotations

import contextlib
import math
import re
import threading
from collections.abc import Iterator, Sequence
from contextvars import ContextVar
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib import style as mpl_style
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import LogFormatterSciNotation

from sweeps.charts.colours import BLACK, CURVES, CurveStyle, Hue, Palette, curve_style
from sweeps.figures.look import Look
from sweeps.human import did_you_mean

COLUMN = 3.4  # inches: one column of a journal
PAGE = 7.0  # inches: its two columns
TEXT, SMALL = "medium", "small"  # relative to the font size, which a style file may change

HOUSE: dict[str, Any] = {
    "font.size": 8.0,
    "axes.titlesize": TEXT,
    "axes.labelsize": TEXT,
    "axes.linewidth": 0.6,
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.use_mathtext": True,
    "axes.prop_cycle": cycler(color=[style.colour for style in CURVES]),
    "xtick.labelsize": TEXT,
    "ytick.labelsize": TEXT,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "legend.fontsize": TEXT,
    "legend.frameon": False,
    "savefig.dpi": 200,
}
# A style file does not change these: journals reject Type 3 fonts, words in an SVG stay words, and
# the names inside an SVG are the same in every run.
OUTPUT: dict[str, Any] = {
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "stickslip",
}

# Windows, toolbars and the like, about which matplotlib warns if a style sets them.
_NO_STYLE = (
    *("backend", "webagg", "interactive", "toolbar", "timezone", "docstring", "date.epoch", "tk."),
    *("figure.raise_window", "figure.max_open_warning", "savefig.directory"),
)

# A space outside mathtext that is not between a number and its unit.
_BETWEEN_WORDS = re.compile(r"(?<!\$) (?=(?:[^$]*\$[^$]*\$)*[^$]*$)")
_MARGIN = 0.1  # inches, left and right of small print
_LINE = 1.35  # font sizes: from one line to the next
_HANDLE, _PAD, _GAP = 2.6, 0.8, 1.2  # of a legend, in font sizes
_SHORT_HANDLE, _SHORT_PAD, _SHORT_GAP = 1.7, 0.4, 0.9  # for a legend with little room
_MOST_LEGEND = 0.16  # of the height of a picture of fixed size
_ABOVE = "above"  # the mark of a legend above given axes

_settings = threading.RLock()


_USUAL = Look()
_look: ContextVar[Look] = ContextVar("look", default=_USUAL)


@contextlib.contextmanager
def styled(look: Look | None = None) -> Iterator[None]:
    """Draw with the look: the house style and the style file set matplotlib for a time.

    Given axes keep the settings that they were made with. Raises ValueError if matplotlib does not
    understand the style file.
    """
    look = look or _USUAL
    own = {} if look.style is None else _style_settings(look.style)
    if look.size is None and "figure.figsize" in own:
        look = replace(look, size=tuple(own["figure.figsize"]))
    settings = [OUTPUT] if look.axes else [HOUSE, own, OUTPUT]
    with _settings, mpl_style.context(settings, after_reset=look.axes is None):
        before = _look.set(look)
        try:
            yield
        finally:
            _look.reset(before)


def _style_settings(file: Path) -> dict[str, Any]:
    """Return the settings of a style file or, if there is no such file, of a style by name."""
    remedy = "such a file has lines like `font.size: 9`"
    try:
        _require_settings(file)
        found = mpl.rc_params_from_file(file, fail_on_error=True, use_default_template=False)
    except FileNotFoundError:
        if str(file) not in mpl_style.library:
            hint = did_you_mean(str(file), mpl_style.library)
            raise ValueError(
                f"the style file {file} does not exist, nor is it a style of matplotlib{hint}"
            ) from None
        found = mpl_style.library[str(file)]
    except (OSError, ValueError) as error:
        raise ValueError(f"{file} is not a matplotlib style file: {error}; {remedy}") from None
    return {name: found[name] for name in found if not name.startswith(_NO_STYLE)}


def _require_settings(file: Path) -> None:
    """Raise ValueError for a line that sets nothing, about which matplotlib would only warn."""
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
        name, colon, _ = line.partition("#")[0].partition(":")
        if name.strip() and (not colon or name.strip() not in mpl.rcParams):
            hint = did_you_mean(name.strip(), mpl.rcParams)
            raise ValueError(f"line {number} does not name a matplotlib setting{hint}")


def line_of(style: CurveStyle) -> dict[str, Any]:
    """Return the arguments of `Axes.plot`, with thinner lines above thicker ones."""
    return {
        "color": style.colour,
        "linewidth": style.width,
        "linestyle": style.dashes,
        "zorder": 3.0 - 0.1 * style.width,
        "markersize": style.width + 1.4,
        "solid_capstyle": "butt",  # projecting caps would narrow the gap at a missing point
    }


def palette() -> Palette:
    """Return the colours of curves in the present settings, which a style file may change."""
    colours = mpl.rcParams["axes.prop_cycle"].by_key().get("color", [BLACK])
    cmap = mpl.colormaps[mpl.rcParams["image.cmap"]]
    return Palette(colours, lambda place: to_hex(cmap(place)))


def line_at(hue: Hue) -> CurveStyle:
    """Return the style of a curve in the colours of the present settings."""
    return curve_style(hue, palette())


def new_figure(size: tuple[float, float], layout: str | None = None) -> Figure:
    """Return an empty figure with its canvas, of `size` inches unless the user chose a size."""
    look = _look.get()
    if look.axes is not None:
        raise ValueError("this picture needs a whole figure; leave ax out")
    figure = Figure(figsize=look.size or size, layout=layout)  # type: ignore[arg-type]
    FigureCanvasAgg(figure)
    return figure


def new_panels(
    rows: int, columns: int, size: tuple[float, float], **share: Any
) -> tuple[Figure, np.ndarray[Any, np.dtype[Any]]]:
    """Return an empty figure of `size` inches and its panels as an array (rows, columns).

    Raises ValueError if the user gave axes and one panel is not enough.
    """
    axes = _look.get().axes
    if axes is not None and rows * columns == 1:
        return axes.figure, np.array([[axes]])  # type: ignore[return-value] # or a part of a figure
    if axes is not None:
        raise ValueError(
            f"ax takes a picture with one panel, but this one has {rows * columns}; choose one "
            "variable, and fix the other axes with at"
        )
    figure = new_figure(size, layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, **share)
    for axes in panels.flat:
        for axis in (axes.xaxis, axes.yaxis):
            axis.get_offset_text().set_fontsize(SMALL)
    return figure, panels


def width_of(columns: int) -> float:
    """Return the width in inches of a figure with this number of columns."""
    return COLUMN if columns == 1 else min(PAGE, 1.0 + 2.0 * columns)


class _LogFormatter(LogFormatterSciNotation):
    """Plain numbers on an axis of less than two decades of usual numbers: 200, not 2 x 10^2."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the text of a tick; empty if matplotlib would omit it."""
        text = super().__call__(x, pos)
        low, high = sorted(self.axis.get_view_interval())  # type: ignore[union-attr] # it has one
        usual = low >= 1e-3 and high < min(1e5, 100.0 * low)
        return f"{x:g}" if text and usual else str(text)


def make_logarithmic(axes: Axes, directions: Sequence[str]) -> None:
    """Make axes logarithmic in the `directions` x and y."""
    for direction in directions:
        axes.set(**{f"{direction}scale": "log"})
        name_ticks(axes.xaxis if direction == "x" else axes.yaxis)


def name_ticks(axis: Axis) -> None:
    """Write plain numbers at the ticks of a logarithmic axis, if it is short."""
    axis.set_major_formatter(_LogFormatter())
    axis.set_minor_formatter(_LogFormatter(labelOnlyBase=False))
    axis.set_tick_params(which="minor", labelsize=SMALL)


def wrapped(figure: Figure, text: str, inches: float, size: str = TEXT) -> str:
    """Return a text broken between words into lines no wider than this number of inches."""
    lines = [""]
    for word in _BETWEEN_WORDS.split(text):
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and width_in_inches(figure, longer, size) > inches:
            lines.append(word)
        else:
            lines[-1] = longer
    return "\n".join(lines)


def width_in_inches(figure: Figure, text: str, size: str = TEXT) -> float:
    """Return the width of a line of text."""
    drawn = Text(text=text, fontsize=size, figure=figure)
    return float(drawn.get_window_extent().width) / figure.dpi


def put_legend(
    figure: Figure,
    handles: Sequence[Line2D],
    *,
    above: bool = False,
    short: Sequence[Line2D] = (),
) -> None:
    """Put a legend above the panels, where it cannot hide a curve; the figure grows by its height.

    A figure of fixed size cannot grow. If the legend would fill much of it, the legend has small
    print and the `short` handles, which say the same in fewer words. Given axes have the legend
    inside, or `above` them, because maps and oscillations leave no room inside.
    """
    axes = _look.get().axes
    if axes is not None and not above:
        axes.legend(handles=list(handles))
    elif axes is not None:
        inches = float(axes.get_window_extent().width) / figure.dpi
        place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
        in_columns = _in_columns(figure, handles, inches)
        axes.legend(**place, **in_columns, frameon=False).set_gid(_ABOVE)
    else:
        in_columns = _in_columns(figure, handles, figure.get_figwidth())
        lines = math.ceil(len(handles) / in_columns["ncols"])
        too_high = lines * _LINE * _inches(TEXT) > _MOST_LEGEND * figure.get_figheight()
        if _look.get().size is not None and too_high:
            few = [*short] or handles
            in_columns = _in_columns(figure, few, figure.get_figwidth(), short=True)
        _grow(figure, lines, TEXT)
        figure.legend(loc="outside upper center", **in_columns)


def _in_columns(
    figure: Figure, handles: Sequence[Line2D], inches: float, *, short: bool = False
) -> dict[str, Any]:
    """Return the arguments of a legend in as many columns as fit."""
    labels = [str(handle.get_label()) for handle in handles]
    length = _SHORT_HANDLE if short else _HANDLE
    pad, gap, size = (_SHORT_PAD, _SHORT_GAP, SMALL) if short else (_PAD, _GAP, TEXT)
    if all(handle.get_linestyle() == "None" for handle in handles):
        length = 0.8
    beside = (length + pad + gap) * _inches(size)
    widths = [width_in_inches(figure, label, size) + beside for label in labels]
    fitting = [
        columns
        for columns in range(1, len(labels) + 1)
        if sum(column.max() for column in np.array_split(widths, columns)) <= inches
    ]
    return {
        "handles": list(handles),
        "ncols": max(fitting, default=1),
        "handlelength": length,
        "handletextpad": pad,
        "columnspacing": gap,
        "borderaxespad": 0.2,
    } | ({"fontsize": size, "labelspacing": 0.2} if short else {})


def put_title(figure: Figure, title: str) -> None:
    """Put a title above the panels and their legend; the figure grows by its height.

    Control characters, which no font has, become spaces.
    """
    title = "".join(c if c.isprintable() or c == "\n" else " " for c in title)
    if (axes := _look.get().axes) is not None:
        legend = axes.get_legend()
        if legend is not None and legend.get_gid() == _ABOVE:
            _entitle(legend, title, mpl.rcParams["axes.titlesize"])
        else:
            axes.set_title(title)
        return
    text = wrapped(figure, title, figure.get_figwidth() - 2 * _MARGIN)
    _grow(figure, text.count("\n") + 1, TEXT)
    if figure.legends:  # over which the layout would print a title of the figure
        _entitle(figure.legends[0], text, TEXT)
    else:
        figure.suptitle(text, fontsize=TEXT)


def _entitle(legend: Legend, title: str, size: Any) -> None:
    legend.set_title(title, FontProperties(size=size))
    legend.get_title().set_multialignment("center")


def has_small_print() -> bool:
    """Return True if notes are shown; given axes have no room for them."""
    return _look.get().axes is None


def put_note(figure: Figure, sentences: Sequence[str]) -> None:
    """Add small print below the panels and any earlier small print; the figure grows by its height.

    Given axes have no small print, nor do figures whose user does not want it.
    """
    if _look.get().axes is not None or not _look.get().note:
        return
    inches = figure.get_figwidth() - 2 * _MARGIN
    lines = [wrapped(figure, sentence, inches, SMALL) for sentence in sentences if sentence]
    if lines:
        above = figure.get_supxlabel()
        _grow(figure, sum(line.count("\n") + 1 for line in lines), SMALL)
        figure.supxlabel("\n".join([above, *lines] if above else lines), fontsize=SMALL)


def _grow(figure: Figure, lines: int, size: str) -> None:
    if _look.get().size is not None:
        return
    figure.set_figheight(figure.get_figheight() + lines * _LINE * _inches(size))


def _inches(size: str) -> float:
    """Return the font size in inches."""
    return float(FontProperties(size=size).get_size_in_points()) / 72.0
