"""What a command of the command line gives back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

FOUR_POINTS = """\
title: Four points
sweep:
  temperature: [200, 250]
  rheological_index: [-2/3, 0]
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4}
simulation: {periods: 1, samples_per_period: 50}
"""


class Result(NamedTuple):
    """The exit code of a command and what it printed."""

    code: int
    out: str
    err: str


Command = Callable[..., Result]


def entries(folder: Path | str = ".") -> list[str]:
    """The names in a folder, in order."""
    return sorted(path.name for path in Path(folder).iterdir())
