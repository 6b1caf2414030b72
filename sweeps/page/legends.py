"""What the colours of a chart are, as HTML beside it: it wraps where a page is narrow."""

from __future__ import annotations

from html import escape

from sweeps.charts.colours import Colours, code_name, code_sentence
from sweeps.charts.styles import GREY
from sweeps.page.scales import palette_of


def kinds_html(colours: Colours) -> str:
    """Return the kinds or counts of a variable, each with its colour and its meaning."""
    squares = [
        _square(colour, code_name(colours.name, code), code_sentence(colours.name, code))
        for colour, code in zip(palette_of(colours), colours.codes, strict=True)
    ]
    return "".join(squares)


def missing_html() -> str:
    """Return the colour of points without a value."""
    return _square(GREY, "no value", "No result, or not defined at these points.")


def _square(colour: str, text: str, meaning: str) -> str:
    square = f'<i style="background:{colour}"></i>'
    return f'<span title="{escape(meaning)}">{square}{escape(text)}</span>'
