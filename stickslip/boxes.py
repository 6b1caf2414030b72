"""Boxes of parameters, and the points at which a box is sampled."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.distributions import (
    Distribution,
    DistributionError,
    Normal,
    Range,
    distribution_of,
)
from stickslip.variables import full_names


class BoxError(ValueError):
    """An invalid box, or one without indices; the message gives the cause and the remedy."""


class Design(NamedTuple):
    """The points of an estimate: matrices A and B of n base points each, and their mixtures.

    The i-th mixture is A with the i-th parameter taken from B. `columns` has an array (d + 2, n)
    for each of the d parameters: its values in A, in B and in the mixtures.
    """

    box: Mapping[str, Distribution]
    columns: dict[str, NDArray[np.float64]]

    @classmethod
    def of(cls, box: Mapping[str, Distribution], base_points: int, seed: int) -> Design:
        """Draw base points, a power of 2, from a scrambled Sobol sequence; raises BoxError."""
        from scipy.stats import qmc

        try:
            base_points = operator.index(base_points)
        except TypeError:
            raise BoxError(f"base points must be a whole number, not {base_points!r}") from None
        if base_points < 2 or base_points & (base_points - 1):
            nearest = 2 ** max(round(math.log2(max(base_points, 2))), 1)
            raise BoxError(
                f"base points must be a power of 2 for the Sobol sequence, such as {nearest}, "
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
        """Return the values ((d + 2) n,) of each parameter, in the order of the result rows."""
        return {name: column.ravel() for name, column in self.columns.items()}


def box_of(box: Mapping[str, Any]) -> tuple[dict[str, Distribution], dict[str, float]]:
    """Return the distributions of the varied parameters and the values of the fixed ones."""
    varied, fixed = {}, {}
    for name, written in full_names(box).items():
        if np.ndim(written) == 0 and not isinstance(written, (Mapping, Range, Normal)):
            fixed[name] = written
            continue
        try:
            varied[name] = distribution_of(name, written)
        except DistributionError as error:
            raise BoxError(f"{name}: {error}") from None
    if not varied:
        raise BoxError("no parameter varies; give a range, such as {'temperature': (200, 280)}")
    return varied, fixed
