"""The colours of curves, and how they are told apart, on paper and on a screen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from stickslip.variables import PARAMETERS

# Okabe & Ito: told apart with every common colour blindness.
BLACK, VERMILLION, SKY = "#000000", "#D55E00", "#56B4E9"
ORANGE, BLUE, GREEN = "#E69F00", "#0072B2", "#009E73"
PURPLE, YELLOW = "#CC79A7", "#F0E442"
GREY = "#D1D1D1"  # points without a value in a map


class CurveStyle(NamedTuple):
    """Colour, width in points and dash pattern of one curve."""

    colour: str
    width: float
    dashes: str | tuple[float, tuple[float, ...]] = "solid"


# No two widths are equal: of curves that coincide the thick ones show beside the thin ones, and
# the dashed ones lie on top. The grey levels differ too, for a print without colours.
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

# Curves of ordered values; the last tenth of the map is too light for a line on white.
_ORDERED_WIDTH, _LIGHTEST = 1.4, 0.9
_DOWNWARD = (0, (3.0, 2.0))  # dashes


class Palette(NamedTuple):
    """The colours that a painter has for curves: in no order, and of ordered values from 0 to 1."""

    cycle: Sequence[str]
    shade: Callable[[float], str]


@dataclass(frozen=True)
class Hue:
    """Which of several curves one is, and whether their values are ordered, as temperatures are."""

    index: int = 0
    count: int = 1
    ordered: bool = False


def hue_of(dim: str | None, index: int, count: int) -> Hue:
    """Return the hue of the curve at a place along a dimension: fluids and cases have no order."""
    return Hue(index, count, dim in PARAMETERS and dim != "rheological_index")


def curve_style(hue: Hue, palette: Palette) -> CurveStyle:
    """Return the style of a curve; those of ordered values are alike but for their colour."""
    if hue.count == 1:
        return SINGLE
    if hue.ordered:
        place = _LIGHTEST * hue.index / (hue.count - 1)
        return CurveStyle(palette.shade(place), _ORDERED_WIDTH)
    colour = palette.cycle[hue.index % len(palette.cycle)]
    return CURVES[hue.index % len(CURVES)]._replace(colour=colour)


def way_style(style: CurveStyle, way: str) -> CurveStyle:
    """Return the style of a curve that is followed upward, or downward: dashed and thinner.

    A single curve has a colour for each way instead.
    """
    if not way:
        return style
    if style == SINGLE:
        colour, width = (VERMILLION, 2.6) if way == "up" else (BLUE, 1.2)
        return style._replace(colour=colour, width=width)  # where they coincide both show
    if way == "up":
        return style._replace(dashes="solid")
    return style._replace(dashes=_DOWNWARD, width=0.6 * style.width)
