"""Boxes of parameters, and the points that estimates over a box need."""

from __future__ import annotations

import math
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
    """A box that is none, or that gives no indices; the message says why, and what would help."""


class Design(NamedTuple):
    """The points of an estimate: n base points in each of the matrices A and B, and their mixtures.

    In the i-th mixture AB a base point of A has its parameter i from B. `columns` (d + 2, n) of
    each of the d parameters: A, B, then the mixtures.
    """

    box: Mapping[str, Distribution]
    columns: dict[str, NDArray[np.float64]]

    @classmethod
    def of(cls, box: Mapping[str, Distribution], base_points: int, seed: int) -> Design:
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


def box_of(box: Mapping[str, Any]) -> tuple[dict[str, Distribution], dict[str, float]]:
    """Return the distributions of the varied parameters, and the values of the others."""
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
