"""Words in a picture that are never cut: wrapped by their measured width, above and below."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.text import Text

from sweeps.figures.style import SMALL, TEXT

_BETWEEN_WORDS = re.compile(r" (?=(?:[^$]*\$[^$]*\$)*[^$]*$)")  # a space outside of mathtext
_MARGIN = 0.1  # inches, left and right of small print
_LINE = 1.35  # font sizes: the distance of two lines
_HANDLE, _PAD, _GAP = 2.6, 0.8, 1.2  # of a legend, in font sizes


def wrapped(figure: Figure, text: str, inches: float, size: str = TEXT) -> str:
    """A text in lines of at most so many inches, broken between words."""
    lines = [""]
    for word in _BETWEEN_WORDS.split(text):
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and width_in_inches(figure, longer, size) > inches:
            lines.append(word)
        else:
            lines[-1] = longer
    return "\n".join(lines)


def width_in_inches(figure: Figure, text: str, size: str = TEXT) -> float:
    """How wide one line of text is."""
    drawn = Text(text=text, fontsize=size, figure=figure)
    return float(drawn.get_window_extent().width) / figure.dpi


def put_legend(figure: Figure, handles: Sequence[Line2D]) -> None:
    """A legend above the panels, where it cannot hide a curve; the figure grows by its height."""
    labels = [str(handle.get_label()) for handle in handles]
    length = _HANDLE if any(handle.get_linestyle() != "None" for handle in handles) else 0.8
    beside = (length + _PAD + _GAP) * _inches(TEXT)
    widest = max(width_in_inches(figure, label) for label in labels) + beside
    columns = max(1, min(len(labels), int(figure.get_figwidth() / widest)))
    _grow(figure, math.ceil(len(labels) / columns), TEXT)
    figure.legend(
        handles=list(handles),
        loc="outside upper center",
        ncols=columns,
        handlelength=length,
        handletextpad=_PAD,
        columnspacing=_GAP,
        borderaxespad=0.2,
    )


def put_note(figure: Figure, sentences: Sequence[str]) -> None:
    """Small print below the panels, under what is there already; the figure grows by its height."""
    inches = figure.get_figwidth() - 2 * _MARGIN
    lines = [wrapped(figure, sentence, inches, SMALL) for sentence in sentences if sentence]
    if lines:
        there = figure.get_supxlabel()
        _grow(figure, sum(line.count("\n") + 1 for line in lines), SMALL)
        figure.supxlabel("\n".join([there, *lines] if there else lines), fontsize=SMALL)


def _grow(figure: Figure, lines: int, size: str) -> None:
    figure.set_figheight(figure.get_figheight() + lines * _LINE * _inches(size))


def _inches(size: str) -> float:
    """The font size in inches."""
    return float(FontProperties(size=size).get_size_in_points()) / 72.0
