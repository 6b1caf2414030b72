"""Which of many similar cases the suite takes, and which are left to `make stress` or `faults`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest


def one_then(mark: str, values: Sequence[Any]) -> list[Any]:
    """Cases of a parametrized test: the first belongs to the suite, the others bear the mark."""
    others = (pytest.param(value, marks=getattr(pytest.mark, mark)) for value in values[1:])
    return [values[0], *others]
