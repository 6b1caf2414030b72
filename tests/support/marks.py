"""Which of many similar cases the suite takes, and which are left to `make stress`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest


def one_then_stress(values: Sequence[Any]) -> list[Any]:
    """Cases of a parametrized test: the first belongs to the suite, the others to `make stress`."""
    return [values[0], *(pytest.param(value, marks=pytest.mark.stress) for value in values[1:])]
