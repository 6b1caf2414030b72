"""Insets of phase portraits: an enlarged section where small loops cannot be told apart."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes

from sweeps.charts.labels import Array
from sweeps.charts.styles import CurveStyle
from sweeps.figures.style import SMALL, line_of

# As parts of the extent of a portrait: features closer than the first are lost in the width of the
# line; loops that stay within the second are hard to see; and the side of an inset.
_STEP, _SMALL_LOOP, _SIDE = 0.002, 0.03, 0.3

_PLACES = np.linspace(0.04, 0.96 - _SIDE, 40)
_MARGIN = 0.03  # between an inset and the nearest curve


def put_inset(axes: Axes, x: Array, y: Array, style: CurveStyle, name: str) -> None:
    """Enlarge the section of a curve with its smallest loops, in an empty place of its panel.

    Nothing is drawn where the curve has no loop too small to be seen, or leaves no place.
    """
    section = _hidden_loops(*_normalised(x, y))
    place = _empty_place(axes, x, y) if section is not None else None
    if section is None or place is None:
        return
    inset = axes.inset_axes((*place, _SIDE, _SIDE))
    inset.plot(x, y, **line_of(style))
    inset.set_xlim(x.min() + np.ptp(x) * section[0])
    inset.set_ylim(y.min() + np.ptp(y) * section[1])
    inset.tick_params(labelsize=SMALL, direction="in", length=2.0)
    inset.ticklabel_format(useOffset=False)
    inset.locator_params(nbins=2)
    inset.set_title(name, fontsize=SMALL, pad=2.0)
    axes.indicate_inset_zoom(inset, edgecolor="0.4")


def _normalised(x: Array, y: Array) -> tuple[Array, Array]:
    """A curve in a unit square, thinned to steps that can be seen."""
    points = np.column_stack([(v - v.min()) / (np.ptp(v) or 1.0) for v in (x, y)])
    kept = [0]
    for number, point in enumerate(points):
        if math.dist(point, points[kept[-1]]) >= _STEP:
            kept.append(number)
    return points[kept, 0], points[kept, 1]


def _hidden_loops(x: Array, y: Array) -> Array | None:
    """The section ((x, x), (y, y)) where a curve turns most without going far; None if it does not.

    A full turn within `_SMALL_LOOP` of where it began is a loop.
    """
    turned = np.append(0.0, np.cumsum(np.abs(np.diff(_directions(x, y)))))
    most, section = 2.0 * math.pi, None
    for first in range(len(turned)):
        away = np.hypot(x[first:-1] - x[first], y[first:-1] - y[first]) > _SMALL_LOOP
        stretch = int(np.argmax(away)) if away.any() else len(away)
        if stretch < 2:
            continue
        last = first + stretch - 1
        if turned[last] - turned[first] > most:
            most = turned[last] - turned[first]
            section = np.array([_around(v[first : last + 1]) for v in (x, y)])
    return section


def _directions(x: Array, y: Array) -> Array:
    return np.asarray(np.unwrap(np.arctan2(np.diff(y), np.diff(x))))


def _around(values: Array) -> tuple[float, float]:
    """Limits with a margin on both sides."""
    low, high = float(values.min()), float(values.max())
    margin = 0.3 * (high - low)
    return low - margin, high + margin


def _empty_place(axes: Axes, x: Array, y: Array) -> tuple[float, float] | None:
    """The lower left corner, in parts of the panel, of the place farthest from the curve."""
    limits = (axes.get_xlim(), axes.get_ylim())  # asking for them settles them
    points = np.column_stack(
        [(v - low) / (high - low) for v, (low, high) in zip((x, y), limits, strict=True)]
    )
    best, found = _MARGIN, None
    for left in _PLACES:
        for bottom in _PLACES:
            beyond = np.abs(points - [left + _SIDE / 2, bottom + _SIDE / 2]) - _SIDE / 2
            distance = float(beyond.max(axis=1).min())
            if distance > best:
                best, found = distance, (float(left), float(bottom))
    return found
