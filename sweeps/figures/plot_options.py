"""The options of a picture: what is chosen of a sweep, what lies over it, and how it is to look."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import xarray as xr

from sweeps.charts.choice import Choice
from sweeps.figures.look import Look

if TYPE_CHECKING:
    from sweeps.measurements import Measurements


@dataclass(frozen=True)
class PlotOptions(Choice):
    """A choice, `boundaries` to draw on a map, and `data` (measurements) to draw over curves.

    The `look` changes nothing of that.
    """

    boundaries: xr.Dataset | None = None
    data: Measurements | None = None
    look: Look = field(default_factory=Look)

    @property
    def asks(self) -> bool:
        """True if anything is chosen of what is to be drawn."""
        return bool(self.variable) or bool(self.at) or self.asks_for_axes

    @property
    def asks_for_axes(self) -> bool:
        """True if any option is chosen that only a picture of a sweep has."""
        over = self.boundaries is not None or self.data is not None
        return super().asks_for_axes or over
