"""Which of many similar cases the suite takes, and which are left to `make stress` or `faults`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest


def one_then(mark: str, values: Sequence[Any]) -> list[Any]:
    """Cases of a parametrized test: the first belongs to the suite, the others bear the mark."""
    return [values[0], *marked(mark, values[1:])]


def marked(mark: str, values: Sequence[Any]) -> list[Any]:
    """Cases, each of several values where it is a tuple, with the mark."""
    cases = [value if type(value) is tuple else (value,) for value in values]
    return [pytest.param(*case, marks=getattr(pytest.mark, mark)) for case in cases]
