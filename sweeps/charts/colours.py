"""Colours and lines that distinguish curves, and the colours of maps: kinds, counts or a scale."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.charts.labels import Array, shown
from sweeps.charts.missing import trusted, value_range

# Okabe & Ito: people with any common colour blindness can distinguish them.
BLACK, VERMILLION, SKY = "#000000", "#D55E00", "#56B4E9"
ORANGE, BLUE, GREEN = "#E69F00", "#0072B2", "#009E73"
PURPLE, YELLOW = "#CC79A7", "#F0E442"
GREY = "#D1D1D1"  # points without a value in a map


class CurveStyle(NamedTuple):
    """Colour, width in points and dash pattern of one curve."""

    colour: str
    width: float
    dashes: str | tuple[float, tuple[float, ...]] = "solid"


# All widths differ: if curves coincide, the thick ones show beside the thin ones, and dashed ones
# lie on top. The grey levels differ too, for a print without colours.
CURVES = (
    CurveStyle(VERMILLION, 1.6),
    CurveStyle(SKY, 3.4),
    CurveStyle(BLACK, 0.9, (0, (5.0, 3.0))),
    CurveStyle(ORANGE, 2.6),
    CurveStyle(BLUE, 1.4, (0, (7.0, 2.0, 1.5, 2.0))),
    CurveStyle(GREEN, 2.0, (0, (1.2, 1.2))),
    CurveStyle(PURPLE, 1.2, (0, (9.0, 3.0))),
    CurveStyle(YELLOW, 4.4),
)
SINGLE = CurveStyle(BLACK, 1.2)

# For curves of ordered values. The last tenth of the map is too light for a line on white.
_ORDERED_WIDTH, _LIGHTEST = 1.4, 0.9
_DOWNWARD = (0, (3.0, 2.0))  # dashes


class Palette(NamedTuple):
    """The colours of curves: a cycle, and a shade for each ordered value from 0 to 1."""

    cycle: Sequence[str]
    shade: Callable[[float], str]


@dataclass(frozen=True)
class Hue:
    """Which of several curves this is, and whether they have an order, as temperatures do."""

    index: int = 0
    count: int = 1
    ordered: bool = False


def hue_of(dim: str | None, index: int, count: int) -> Hue:
    """Return the hue of a curve by its place along a dimension; fluids and cases have no order."""
    return Hue(index, count, dim in PARAMETERS and dim != "rheological_index")


def curve_style(hue: Hue, palette: Palette) -> CurveStyle:
    """Return the style of a curve; curves of ordered values differ only in colour."""
    if hue.count == 1:
        return SINGLE
    if hue.ordered:
        place = _LIGHTEST * hue.index / (hue.count - 1)
        return CurveStyle(palette.shade(place), _ORDERED_WIDTH)
    colour = palette.cycle[hue.index % len(palette.cycle)]
    return CURVES[hue.index % len(CURVES)]._replace(colour=colour)


def way_style(style: CurveStyle, way: str) -> CurveStyle:
    """Return the style of a curve followed upward, or followed downward: dashed and thinner.

    A single curve gets a colour for each direction instead.
    """
    if not way:
        return style
    if style == SINGLE:
        colour, width = (VERMILLION, 2.6) if way == "up" else (BLUE, 1.2)
        return style._replace(colour=colour, width=width)  # both show where they coincide
    if way == "up":
        return style._replace(dashes="solid")
    return style._replace(dashes=_DOWNWARD, width=0.6 * style.width)


# --- the colours of maps and points ---------------------------------------------------------------

KINDS = ("regime", "status")

_MOST_COUNTS = 12  # different numbers that colours can still distinguish
_OTHER = "#999999"

# Each keeps its colour in every picture. They also differ in a print without colours: a liquid is
# light, and the more complicated a motion, the darker it is.
_REGIMES: dict[int, str] = {
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
    Status.REFUSED: "#737373",
    Status.FAILED: BLACK,
    Status.INVARIANT_VIOLATED: PURPLE,
    Status.APERIODIC: BLUE,
    Status.INACCURATE: GREEN,
    Status.INTERPOLATED: "#BBDDF6",
    Status.UNSTABLE: "#8C2D04",
    Status.PENDING: GREY,
}


@dataclass(frozen=True)
class Colours:
    """Colours for the values of one variable; kinds and counts have their `codes` in order.

    `low` and `high` are the ends of the scale in shown units or, for codes, the outer edges of
    their places in the order.
    """

    name: str
    label: str
    low: float
    high: float
    log: bool = False
    codes: tuple[int, ...] = ()

    def placed(self, ds: xr.Dataset) -> Array:
        """Return the trusted values to colour; codes become their places in the order."""
        values = shown(trusted(ds, self.name)).values
        if self.codes:
            places = np.searchsorted(self.codes, np.nan_to_num(values, nan=self.codes[0]))
            values = np.where(np.isnan(values), np.nan, places)
        return np.ma.masked_invalid(values)

    @property
    def is_named(self) -> bool:
        """True for kinds, which have fixed names and colours, unlike counts and values."""
        return self.name in KINDS

    @property
    def names(self) -> list[str]:
        """The names of the codes, in order."""
        return [code_name(self.name, code) for code in self.codes]

    @property
    def kinds(self) -> list[str]:
        """The colours of kinds, in order."""
        return [kind_colour(self.name, code) for code in self.codes]


def is_discrete(ds: xr.Dataset, name: str) -> bool:
    """Return True if a variable has so few kinds or counts that each gets a colour."""
    return name in KINDS or kinds_in(ds, name) is not None


def kinds_in(ds: xr.Dataset, name: str) -> tuple[int, ...] | None:
    """Return the trusted kinds or counts of a variable, in order; None for any other variable."""
    if name not in RESULTS or not RESULTS[name].dtype.startswith("i"):
        return None
    values = trusted(ds, name).values
    codes = tuple(int(code) for code in np.unique(values[np.isfinite(values)]))
    return codes if name in KINDS or len(codes) <= _MOST_COUNTS else None


def colours_of(ds: xr.Dataset, name: str, *, log: bool = False) -> Colours:
    """Return the colours of a variable, which are the same in every slice of `ds`."""
    label = shown(ds[name]).label
    if codes := kinds_in(ds, name):
        return Colours(name, label, -0.5, len(codes) - 0.5, codes=codes)
    return Colours(name, label, *value_range(ds, name, log=log, with_zero=False), log)


def code_name(name: str, code: int) -> str:
    """Return the name of a code; the name of a count is its number."""
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
    """Return the meaning of a code; empty for a count."""
    if name not in KINDS:
        return ""
    kinds: type[Regime] | type[Status] = Regime if name == "regime" else Status
    return kinds(code).sentence if code in list(kinds) else "A code from another version."


def kind_colour(name: str, code: int) -> str:
    """Return the colour of a kind, which is the same in every picture."""
    return {"regime": _REGIMES, "status": _STATUSES}[name].get(code, _OTHER)
