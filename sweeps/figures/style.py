"""What all pictures share: sizes, colours, line styles, and an empty figure to draw in.

The object-oriented API with the Agg canvas keeps no global state: no pyplot, no rcParams.
"""

from __future__ import annotations

import re
import textwrap
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

COLUMN = 3.4  # inches: one column of a journal
PAGE = 7.0  # inches: its two columns
STACKED = 4.8  # inches: the height of two panels
TEXT = 8.0  # points
SMALL = 6.5  # points: notes and labels inside a panel

# Okabe & Ito: told apart with every common colour blindness.
BLACK, VERMILLION, SKY = "#000000", "#D55E00", "#56B4E9"
ORANGE, BLUE, GREEN = "#E69F00", "#0072B2", "#009E73"
PURPLE, YELLOW = "#CC79A7", "#F0E442"
GREY = "0.82"  # points without a value in a map


class CurveStyle(NamedTuple):
    """Colour, width in points and dash pattern of one curve."""

    colour: str
    width: float
    dashes: str | tuple[float, tuple[float, ...]] = "solid"

    def line(self) -> dict[str, Any]:
        """The arguments of `Axes.plot`; a thinner line lies over a thicker one."""
        return {
            "color": self.colour,
            "linewidth": self.width,
            "linestyle": self.dashes,
            "zorder": 3.0 - 0.1 * self.width,
            "markersize": self.width + 1.4,
            "solid_capstyle": "butt",  # projecting caps would narrow the gap of a missing point
        }


# No two widths are equal: of curves that coincide the thick ones show beside the thin ones, and
# the dashed ones lie on top. The grey levels differ too, for a print without colours.
CURVES = (
    CurveStyle(VERMILLION, 1.6),
    CurveStyle(SKY, 3.4),
    CurveStyle(BLACK, 0.9, (0, (5.0, 3.0))),
    CurveStyle(ORANGE, 2.6),
    CurveStyle(BLUE, 1.4, (0, (7.0, 2.0, 1.5, 2.0))),
    CurveStyle(GREEN, 2.0, (0, (1.2, 1.2))),
    CurveStyle(PURPLE, 1.2, (0, (9.0, 3.0))),
    CurveStyle(YELLOW, 4.4),
)
SINGLE = CurveStyle(BLACK, 1.2)


def curve_style(index: int, count: int) -> CurveStyle:
    """The style of curve `index` out of `count`."""
    return SINGLE if count == 1 else CURVES[index % len(CURVES)]


def new_figure(size: tuple[float, float], layout: str | None = None) -> Figure:
    """An empty figure of `size` inches with a canvas of its own."""
    figure = Figure(figsize=size, layout=layout)  # type: ignore[arg-type]
    FigureCanvasAgg(figure)
    return figure


def new_panels(
    rows: int, columns: int, size: tuple[float, float], **share: Any
) -> tuple[Figure, np.ndarray[Any, np.dtype[Any]]]:
    """An empty figure of `size` inches and its panels as an array (rows, columns)."""
    figure = new_figure(size, layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, **share)
    for axes in panels.flat:
        _dress(axes)
    return figure, panels


def width_of(columns: int) -> float:
    """The width in inches of a figure with so many columns of panels."""
    return COLUMN if columns == 1 else min(PAGE, 1.0 + 2.0 * columns)


def _dress(axes: Axes) -> None:
    axes.tick_params(which="both", direction="in", top=True, right=True, labelsize=TEXT)
    axes.ticklabel_format(scilimits=(-3, 5), useMathText=True)
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_offset_text().set_fontsize(SMALL)
    axes.spines[:].set_linewidth(0.6)


def name_columns(panels: np.ndarray[Any, np.dtype[Any]], titles: list[str], label: str) -> None:
    """A title above each column of panels, and what its x axes have in common below."""
    for column, title in zip(panels.T, titles, strict=True):
        column[0].set_title(title, fontsize=TEXT)
        column[-1].set_xlabel(label, fontsize=TEXT)


def set_scale(axes: Axes, direction: Literal["x", "y"], geometric: bool) -> None:
    """A logarithmic axis where its points are spaced geometrically."""
    if geometric:
        axes.set(**{f"{direction}scale": "log"})
        axes.tick_params(axis=direction, which="minor", labelsize=SMALL)


def put_legend(figure: Figure, lines: list[Line2D]) -> None:
    """A legend above the panels, where it cannot hide a curve."""
    figure.legend(
        handles=lines,
        loc="outside upper center",
        ncols=_legend_columns(figure, [str(line.get_label()) for line in lines]),
        fontsize=TEXT,
        frameon=False,
        handlelength=2.6,
        columnspacing=1.2,
        borderaxespad=0.2,
    )


def _legend_columns(figure: Figure, labels: list[str]) -> int:
    letters = max(len(re.sub(r"[${}_^]|(?<=\\)[a-z]+", "", label)) for label in labels)
    inches = 0.55 + 0.065 * letters  # handle and gap, then a letter of TEXT size
    return max(1, min(len(labels), int(figure.get_figwidth() / inches)))


def put_note(figure: Figure, sentences: list[str]) -> None:
    """Small print below the panels, wrapped to the width of the figure."""
    letters = int(figure.get_figwidth() / 0.055)  # of SMALL size
    lines = [line for sentence in sentences for line in textwrap.wrap(sentence, letters)]
    if lines:
        figure.supxlabel("\n".join(lines), fontsize=SMALL)
