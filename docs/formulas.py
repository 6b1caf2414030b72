"""Formulas as SVG, drawn when the site is built: reading it needs no scripts, fonts or network.

An extension of Sphinx; ziamath draws, with the STIX fonts that it brings.
"""

from __future__ import annotations

import re
from functools import cache
from html import escape
from typing import Any

import ziamath
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import logging

_SIZE = 20  # units of the drawing; a formula is scaled to the text by `em`
_EM = 1.15 / _SIZE  # STIX is smaller than the fonts of the page
_TAG = re.compile(r"\\tag\{(\d+)\}")
_UNKNOWN = re.compile(r"\\[a-zA-Z]+")

log = logging.getLogger(__name__)


class FormulaError(ValueError):
    """Something in a formula that cannot be drawn."""


@cache
def drawn(tex: str, *, inline: bool) -> str:
    """Return the SVG of a formula, in the colour and on the base line of the text.

    Raises FormulaError.
    """
    ziamath.config.math.color = "currentColor"
    ziamath.config.precision = 1
    ziamath.config.svg2 = False  # no names of glyphs, which several formulas of a page would share
    try:
        formula = ziamath.Latex(tex, size=_SIZE, inline=inline)
        picture = formula.svg()
    except Exception as error:
        raise FormulaError(f"{tex}: {error!r}") from error
    if unknown := _UNKNOWN.findall(formula.mathmlstr()):
        raise FormulaError(f"{tex}: {unknown[0]} is not known")
    x, y, width, height = map(float, re.findall(r'viewBox="(.*?)"', picture)[0].split())
    head = (
        f'<svg role="img" aria-label="{escape(tex)}" viewBox="{x} {y} {width} {height}"'
        f' width="{width * _EM:.3f}em" height="{height * _EM:.3f}em"'
        f' style="vertical-align: {-(y + height) * _EM:.3f}em">'
    )
    return re.sub(r"<svg [^>]*>", lambda _: head, picture, count=1)


def _of_text(visitor: Any, node: nodes.Element) -> None:
    _append(visitor, node, '<span class="formula">{}</span>', node.astext(), inline=True)


def _of_paragraph(visitor: Any, node: nodes.Element) -> None:
    tex = node.astext()
    number = "".join(f'<span class="number">({n})</span>' for n in _TAG.findall(tex))
    frame = f'<div class="formula"><span class="drawn">{{}}</span>{number}</div>'
    _append(visitor, node, frame, _TAG.sub("", tex).strip(), inline=False)


def _append(visitor: Any, node: nodes.Element, frame: str, tex: str, *, inline: bool) -> None:
    try:
        visitor.body.append(frame.format(drawn(tex, inline=inline)))
    except FormulaError as error:
        log.warning("%s", error, location=node)
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_html_math_renderer("drawn", (_of_text, None), (_of_paragraph, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
