"""The colours of maps and points: named kinds, counts, or a scale of values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import RESULTS
from sweeps.figures.labels import Array, shown
from sweeps.figures.missing import trusted, value_range
from sweeps.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    SMALL,
    VERMILLION,
    YELLOW,
    name_ticks,
)

KINDS = ("regime", "status")
_MOST_COUNTS = 12  # different numbers that colours still tell apart

# One colour each, in every picture. A print without colours tells them apart as well: a liquid is
# light, and the farther a motion is from a simple one, the darker it is.
_REGIMES = {
    Regime.LIQUID: "#9AD3F4",
    Regime.LOCKED: BLUE,
    Regime.STICK_SLIP_SYMMETRIC: ORANGE,
    Regime.STICK_SLIP_ASYMMETRIC: VERMILLION,
    Regime.SUBHARMONIC: "#00684C",
    Regime.APERIODIC: "#5A1A50",
    Regime.UNKNOWN: GREY,
}
_STATUSES: dict[int, str] = {
    Status.OK: SKY,
    Status.NOT_STATIONARY: ORANGE,
    Status.STEP_LIMIT: YELLOW,
    Status.DIVERGED: VERMILLION,
    Status.REFUSED: "0.45",
    Status.FAILED: BLACK,
    Status.INVARIANT_VIOLATED: PURPLE,
    Status.APERIODIC: BLUE,
    Status.INACCURATE: GREEN,
    Status.INTERPOLATED: "#BBDDF6",
    Status.PENDING: GREY,
}


@dataclass(frozen=True)
class Colours:
    """Colours for the values of one variable: `codes` in order where they are kinds or counts."""

    name: str
    label: str
    cmap: Colormap
    norm: Normalize
    codes: tuple[int, ...] = ()

    def placed(self, ds: xr.Dataset) -> Array:
        """The trusted values as colours take them: those of codes are their places in the order."""
        values = shown(trusted(ds, self.name)).values
        if self.codes:
            places = np.searchsorted(self.codes, np.nan_to_num(values, nan=self.codes[0]))
            values = np.where(np.isnan(values), np.nan, places)
        return np.ma.masked_invalid(values)

    @property
    def legend(self) -> list[Line2D]:
        """A square and a name for each kind; empty for numbers, which have a scale."""
        if self.name not in KINDS:
            return []
        return [_square(self.cmap(i), code_name(self.name, c)) for i, c in enumerate(self.codes)]

    def draw_scale(self, figure: Figure, beside: Sequence[Axes]) -> None:
        """A colour bar beside some panels, where the colours are numbers."""
        if self.name in KINDS:
            return
        mappable = ScalarMappable(self.norm, self.cmap)
        bar = figure.colorbar(mappable, ax=list(beside), pad=0.02, aspect=25)
        bar.set_label(self.label)
        if isinstance(self.norm, LogNorm):
            name_ticks(bar.ax.yaxis)
        bar.ax.tick_params(direction="in", which="both")
        bar.ax.yaxis.get_offset_text().set_fontsize(SMALL)
        if self.codes:
            names = [code_name(self.name, code) for code in self.codes]
            bar.set_ticks(list(range(len(names))), labels=names)
            bar.ax.tick_params(which="both", length=0)


def is_discrete(ds: xr.Dataset, name: str) -> bool:
    """Tell whether a variable has few enough kinds or counts for a colour each."""
    return name in KINDS or kinds_in(ds, name) is not None


def kinds_in(ds: xr.Dataset, name: str) -> tuple[int, ...] | None:
    """Return the trusted kinds or counts of a variable, in order; None if it has other values."""
    if name not in RESULTS or not RESULTS[name].dtype.startswith("i"):
        return None
    values = trusted(ds, name).values
    codes = tuple(int(code) for code in np.unique(values[np.isfinite(values)]))
    return codes if name in KINDS or len(codes) <= _MOST_COUNTS else None


def colours_of(ds: xr.Dataset, name: str, *, log: bool = False) -> Colours:
    """The colours of a variable, the same for every slice of `ds`."""
    label = shown(ds[name]).label
    if codes := kinds_in(ds, name):
        norm = BoundaryNorm(np.arange(len(codes) + 1) - 0.5, len(codes))
        return Colours(name, label, ListedColormap(_palette(name, codes)), norm, codes)
    cmap = colormaps[mpl.rcParams["image.cmap"]].with_extremes(bad=GREY)
    scale = LogNorm if log else Normalize
    return Colours(name, label, cmap, scale(*value_range(ds, name, log=log, with_zero=False)))


def code_name(name: str, code: int) -> str:
    """Return the name of a code of a variable; that of a count is its number."""
    if name == "regime" and code in list(Regime):
        words = Regime(code).name.lower().replace("stick_slip_", "stick-slip, ")
    elif name == "status" and code in list(Status):
        words = Status(code).name.lower()
    elif name == "orbit_periods" and code == 0:
        words = "aperiodic"
    else:
        words = f"{name} {code}" if name in KINDS else str(code)
    return words.replace("_", " ")


def code_sentence(name: str, code: int) -> str:
    """Return what a code of a variable means; nothing for a count."""
    if name not in KINDS:
        return ""
    kinds: type[Regime] | type[Status] = Regime if name == "regime" else Status
    return kinds(code).sentence if code in list(kinds) else "A code of another version."


def kind_colour(name: str, code: int) -> str:
    """The colour of a kind, the same in every picture."""
    fixed: dict[int, str] = {"regime": _REGIMES, "status": _STATUSES}[name]  # type: ignore[assignment]
    return fixed.get(code, "0.6")


def _palette(name: str, codes: Sequence[int]) -> list[Any]:
    if name in KINDS:
        return [kind_colour(name, code) for code in codes]
    return list(colormaps[mpl.rcParams["image.cmap"]](np.linspace(0.0, 1.0, len(codes))))


def _square(colour: Any, label: str) -> Line2D:
    return Line2D([], [], linestyle="none", marker="s", color=colour, label=label, markersize=6.0)
