"""Boxes of parameters, and the points that estimates over a box need."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import ParameterError
from stickslip.variables import PARAMETERS, full_names


class BoxError(ValueError):
    """A box that is none, or that gives no indices; the message says why, and what would help."""


class Range(NamedTuple):
    """The values between which a parameter varies, evenly or evenly in its logarithm."""

    low: float
    high: float
    logarithmic: bool = False

    def __str__(self) -> str:
        return f"{'log ' if self.logarithmic else ''}[{self.low:.17g}, {self.high:.17g}]"

    def values(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the values at numbers in [0, 1)."""
        if self.logarithmic:
            return self.low * (self.high / self.low) ** unit
        return self.low + (self.high - self.low) * unit


class Design(NamedTuple):
    """The points of an estimate: n base points in each of the matrices A and B, and their mixtures.

    In the i-th mixture AB a base point of A has its parameter i from B. `columns` (d + 2, n) of
    each of the d parameters: A, B, then the mixtures.
    """

    box: Mapping[str, Range]
    columns: dict[str, NDArray[np.float64]]

    @classmethod
    def of(cls, box: Mapping[str, Range], base_points: int, seed: int) -> Design:
        """Draw a scrambled Sobol sequence of so many base points, a power of 2."""
        from scipy.stats import qmc

        if base_points < 2 or base_points & (base_points - 1):
            nearest = 2 ** max(round(math.log2(max(base_points, 2))), 1)
            raise BoxError(
                f"base points must be a power of 2, as a Sobol sequence wants: {nearest}, "
                f"not {base_points}"
            )
        drawn = qmc.Sobol(2 * len(box), bits=64, rng=np.random.default_rng(seed))
        unit = drawn.random(base_points).T.reshape(2, len(box), base_points)
        columns = {}
        for i, (name, limits) in enumerate(box.items()):
            mixtures = np.tile(unit[0, i], (len(box), 1))
            mixtures[i] = unit[1, i]
            columns[name] = limits.values(np.vstack([unit[:, i], mixtures]))
        return cls(box, columns)

    def points(self) -> dict[str, NDArray[np.float64]]:
        """Return the values ((d + 2) n,) of each parameter, in the order of result rows."""
        return {name: column.ravel() for name, column in self.columns.items()}


def box_of(box: Mapping[str, Any]) -> tuple[dict[str, Range], dict[str, float]]:
    """Return the ranges of the varied parameters, and the values of the others."""
    ranges, fixed = {}, {}
    for name, written in full_names(box).items():
        if np.ndim(written) == 0 and not isinstance(written, (Mapping, Range)):
            fixed[name] = written
        else:
            ranges[name] = _range_of(name, written)
    if not ranges:
        raise BoxError("no parameter varies; give a range, such as {'temperature': (200, 280)}")
    return ranges, fixed


def _range_of(name: str, written: Any) -> Range:
    """Return a range, as the caller wrote it."""
    if isinstance(written, Range):
        ends, logarithmic = written[:2], written.logarithmic
    else:
        logarithmic = isinstance(written, Mapping)
        ends = written.get("log") if logarithmic else written
    try:
        low, high = map(float, ends)
    except (TypeError, ValueError):
        raise BoxError(
            f"{name}: a range is (low, high) or {{'log': (low, high)}}, not {written!r}"
        ) from None
    for end in (low, high):
        if complaint := PARAMETERS[name].complaint(end):
            raise ParameterError(f"{name} {complaint}")
    if not low < high or (logarithmic and low <= 0.0):
        rule = "rise from low to high" + (", both above 0" if logarithmic else "")
        raise BoxError(f"{name}: a range must {rule}, not from {low:g} to {high:g}")
    return Range(low, high, logarithmic)
