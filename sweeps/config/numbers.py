"""Numbers, texts and names of parameters as people write them, and messages about mistakes."""

from __future__ import annotations

import math
import re
from numbers import Real
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator

from stickslip.variables import (
    BY_SYMBOL,
    PARAMETERS,
    RESULTS,
    canonical_name,
    canonical_result,
)
from sweeps.config.written_config import quoted
from sweeps.human import did_you_mean

# More digits are beyond a float, and would make int() and the division slow.
_RATIONAL = re.compile(r"\s*([+-]?\d{1,300})\s*/\s*(\d{1,300})\s*")
RATIONAL_PATTERN = r"^\s*[+-]?\d+\s*/\s*\d+\s*$"
"""The pattern, in JSON Schema, of a text allowed in place of a number."""

_NUMBER = r"[-+]?(\.\d+|\d+(\.\d*)?)([eE][-+]?\d+)?"
_REMEDIES = (
    (_NUMBER, "write the number without quotes"),
    (r"[\u2012-\u2015\u2212].*", "write the minus as `-`, the character on the keyboard"),
    (r"[-+]?\d{1,3}(,\d{3})+(\.\d*)?", "write it without thousands separators"),
    (r"[-+]?\d+,\d+", "write it with a decimal point"),
    (r"[-+]?\d+(_\d+)+.*", "write it without underscores"),
    (r"\d+(:\d+)+", "a colon has no meaning in a number"),
    (rf"{_NUMBER}\s*[^\d\s.,*/+^()-].*", "write the number alone, in SI units"),
    (r"[\d\s.eE*/+^()-]+", "only fractions of integers are evaluated, such as -2/3"),
)


def number(value: object) -> float:
    """Return a number, or a fraction of integers such as the text `-2/3`, as a float.

    NaN and infinities pass. -0 becomes 0, so that equal numbers have one spelling. Raises
    ValueError with a remedy for anything else, including booleans and quoted numbers.
    """
    if isinstance(value, str):
        return _rational(value)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"must be a number, not {quoted(value)}")
    try:
        return float(value) + 0.0
    except OverflowError:
        return math.inf


def finite(value: object) -> float:
    """Return `value` as a finite float; raises ValueError as `number` does, and for NaN and inf."""
    real = number(value)
    if not math.isfinite(real):
        raise ValueError(f"must be a finite number, not {quoted(value)}")
    return real


def whole(value: object) -> int:
    """Return `value` as an int, such as 1000 for 1e3; raises ValueError if it is no integer."""
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    real = number(value)
    if isinstance(value, str) or not real.is_integer():
        raise ValueError(f"must be a whole number, not {quoted(value)}")
    return int(real)


def text(value: object) -> str:
    """Return `value` if it is a text without control characters; raises ValueError otherwise."""
    if not isinstance(value, str):
        hint = "; put it in quotes" if isinstance(value, (bool, int, float)) else ""
        raise ValueError(f"must be text, not {quoted(value)}{hint}")
    if re.search(r"[\x00-\x08\x0b-\x1f\x7f\ud800-\udfff]", value):
        raise ValueError("must not contain control characters")
    return value


def full_name(key: str, *other_keys: str) -> str:
    """Return the full name of a parameter for its name or symbol.

    Raises ValueError for another key, with the closest parameter or one of `other_keys` as a hint.
    """
    name = canonical_name(key)
    if name is None:
        hint = did_you_mean(key, [*PARAMETERS, *BY_SYMBOL, *other_keys])
        hint = "; was it meant as part of 3,000? write 3000" if key.isdigit() else hint
        raise ValueError(f"unknown parameter{hint}")
    return name


Finite = Annotated[float, BeforeValidator(finite)]
Text = Annotated[str, BeforeValidator(text)]
ParameterName = Annotated[str, AfterValidator(full_name)]


def result_name(name: str) -> str:
    """Return the full name of a result variable for its name or symbol; raises ValueError."""
    known = canonical_result(name)
    if known is None:
        hint = did_you_mean(name, RESULTS) or f"; the names are {', '.join(RESULTS)}"
        raise ValueError(f"unknown result variable {name!r}{hint}")
    return known


ResultName = Annotated[str, AfterValidator(result_name)]


def _rational(value: str) -> float:
    match = _RATIONAL.fullmatch(value)
    if not match:
        raise ValueError(f"must be a number, not {quoted(value)}{_remedy(value)}")
    numerator, denominator = map(int, match.groups())
    if denominator == 0:
        raise ValueError(f"must be a number, but {quoted(value)} divides by zero")
    try:
        return numerator / denominator + 0.0
    except OverflowError:
        return math.copysign(math.inf, numerator)


def _remedy(value: str) -> str:
    # Nobody writes a longer number, and the limit keeps the patterns quick.
    beginning = value.strip()[:80]
    for pattern, remedy in _REMEDIES:
        if re.fullmatch(pattern, beginning):
            return f"; {remedy}"
    return ""
