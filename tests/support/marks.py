"""The choice between the suite and `make stress` or `make faults` for many similar cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest


def one_then(mark: str, values: Sequence[Any]) -> list[Any]:
    """Return cases of a parametrized test; all but the first have the mark."""
    return [values[0], *marked(mark, values[1:])]


def marked(mark: str, values: Sequence[Any]) -> list[Any]:
    """Return cases with the mark; a tuple is a case of several values."""
    cases = [value if type(value) is tuple else (value,) for value in values]
    return [pytest.param(*case, marks=getattr(pytest.mark, mark)) for case in cases]
