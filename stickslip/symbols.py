"""Conversion of mathtext labels to plain text and HTML, for pages without typeset formulas."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterator

# The commands that occur in the registry, in units and in numbers.
_COMMANDS = {
    "gamma": "γ",
    "omega": "ω",
    "varphi": "φ",
    "tau": "τ",
    "varepsilon": "ε",
    "delta": "δ",
    "alpha": "α",
    "sigma": "σ",
    "mu": "μ",
    "lambda": "λ",
    "cdot": "·",
    "times": "×",
    "max": "max ",
    "min": "min ",
    "mathrm": "",
    ",": " ",
    " ": " ",
}
_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[_^{}]|.")

# Unicode has no subscripts of b, c, d, f, g, q, w, y, z and most Greek letters.
LOWERED = dict(zip("0123456789aehijklmnoprstuvx", "₀₁₂₃₄₅₆₇₈₉ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ", strict=True))
"""The characters with a subscript form, and that form."""

_LOWERED = str.maketrans(LOWERED)
_RAISED = str.maketrans("0123456789+−γ", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ᵞ")

_Script = Callable[[str, str], str]


def plain(label: str) -> str:
    """Return a mathtext label such as `$T_c$ (K)` as plain text, such as `T_c (K)`.

    Powers become superscripts and indices subscripts if Unicode has all the characters.
    """
    return "".join(_converted(label, str, _plain_script))


def as_html(label: str) -> str:
    """Return a mathtext label as HTML; text outside the formulas is escaped."""
    return "".join(_converted(label, html.escape, _html_script))


def _converted(label: str, escape: Callable[[str], str], script: _Script) -> Iterator[str]:
    for number, part in enumerate(label.split("$")):
        if number % 2:
            yield re.sub(" +", " ", _math(iter(_TOKEN.findall(part)), escape, script))
        else:
            yield escape(part)


def _math(tokens: Iterator[str], escape: Callable[[str], str], script: _Script) -> str:
    """Convert tokens up to the closing brace, or to the end."""
    parts = []
    for token in tokens:
        if token == "}":
            break
        if token in ("_", "^"):
            parts.append(script(token, _group(tokens, escape, script)))
        elif token == "{":
            parts.append(_math(tokens, escape, script))
        else:
            parts.append(escape(_symbol(token)))
    return "".join(parts)


def _group(tokens: Iterator[str], escape: Callable[[str], str], script: _Script) -> str:
    """Convert the argument of `_` or `^`: the text in braces, or a single symbol."""
    token = next(tokens, "")
    if token == "\\mathrm":
        token = next(tokens, "")
    return _math(tokens, escape, script) if token == "{" else escape(_symbol(token))


def _symbol(token: str) -> str:
    if token.startswith("\\"):
        return _COMMANDS.get(token[1:], token[1:])
    return "−" if token == "-" else token


def _plain_script(kind: str, text: str) -> str:
    moved = text.translate(_LOWERED if kind == "_" else _RAISED)
    if not set(moved) & set(text) - {","}:
        return moved
    return f"_{text}" if kind == "_" else f"^({text})"


def _html_script(kind: str, text: str) -> str:
    tag = "sub" if kind == "_" else "sup"
    return f"<{tag}>{text}</{tag}>"
