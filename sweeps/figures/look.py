"""The options of a picture: its look, the choice of what it shows, and what is drawn over it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from string import ascii_lowercase
from typing import TYPE_CHECKING

import xarray as xr
from matplotlib.axes import Axes

from sweeps.charts.choice import Choice

if TYPE_CHECKING:
    from sweeps.measurements import Measurements


Range = tuple[float | None, float | None]


@dataclass(frozen=True)
class Look:
    """Choices for a picture that do not change its content.

    `size` is the size of the whole picture in inches. `xlim`, `ylim` and `clim` (of the colours)
    are in shown units; None leaves an end as it is. `letters` names the panels (a), (b), ..., or
    from another letter on. `note` keeps the small print, and `style` is a style file. A picture of
    one panel can be drawn into given `axes`, which keep their settings of matplotlib.

    Raises ValueError for a size that is not positive, for limits that are not finite or do not
    rise, and for `letters` that are not a letter.
    """

    size: tuple[float, float] | None = None
    xlim: Range = (None, None)
    ylim: Range = (None, None)
    clim: Range = (None, None)
    letters: bool | str = False
    note: bool = True
    title: str | None = None
    style: Path | None = None
    axes: Axes | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible size, limit or letter."""
        for name in ("size", "xlim", "ylim", "clim"):
            pair = getattr(self, name)
            if pair is not None and (not isinstance(pair, Sequence) or len(pair) != 2):
                raise ValueError(f"{name} must be two numbers, not {pair!r}")
        if self.size is not None and not all(0.0 < inches < 100.0 for inches in self.size):
            raise ValueError(f"a size is a width and a height of 0 to 100 inches, not {self.size}")
        if not isinstance(self.letters, bool) and self.letters not in set(ascii_lowercase):
            raise ValueError(f"letters must start at one of a to z, not {self.letters!r}")
        for name in ("xlim", "ylim", "clim"):
            low, high = getattr(self, name)
            if not all(end is None or math.isfinite(end) for end in (low, high)):
                raise ValueError(f"each end of {name} must be a finite number or left open")
            if low is not None and high is not None and not low < high:
                raise ValueError(f"{name} must rise, not go from {low!r} to {high!r}")


def size_of(text: str) -> tuple[float, float]:
    """Return the size written as a text such as `3.37x2.5`; raises ValueError for other texts."""
    try:
        width, height = (float(part) for part in text.lower().split("x"))
    except ValueError:
        raise ValueError(
            f"a size is WIDTHxHEIGHT in inches, as in 3.37x2.5, not {text!r}"
        ) from None
    return width, height


def range_of(text: str) -> Range:
    """Return the limits written as `0:3`, `:3` or `0:`; raises ValueError for other texts."""
    try:
        low, high = (float(part) if part.strip() else None for part in text.split(":"))
    except ValueError:
        raise ValueError(f"limits are LOW:HIGH, as in 0:3, 0: or :3, not {text!r}") from None
    return low, high


@dataclass(frozen=True)
class PlotOptions(Choice):
    """A choice, `boundaries` to draw on a map, and measured `data` to draw over curves.

    The `look` does not change what is drawn.
    """

    boundaries: xr.Dataset | None = None
    data: Measurements | None = None
    look: Look = field(default_factory=Look)

    @property
    def asks(self) -> bool:
        """True if the user chose what is drawn."""
        return bool(self.variable) or bool(self.at) or self.asks_for_axes

    @property
    def asks_for_axes(self) -> bool:
        """True if the user set an option that only pictures of sweeps have."""
        over = self.boundaries is not None or self.data is not None
        return super().asks_for_axes or over
