"""Which orbits are their own mirror images half a drive period later."""

from __future__ import annotations

import numpy as np

from stickslip.kernels.adaptive.tangents import floored, travelled, weighted
from stickslip.kernels.orbits.motions import CYCLE, OUTCOME, Motions
from stickslip.model.models import model_of
from stickslip.numerics.adaptive import OK
from stickslip.options import Physics

# A symmetric orbit comes at least this close to its mirror image.
_MIRROR_IMAGE = 1e-4


def symmetric(
    motions: Motions, begins: np.ndarray, stationary_rtol: float, rtol: float, physics: Physics
) -> np.ndarray:
    """Return which settled orbits (n,) equal their mirror images half a drive period later.

    `motions` hold their cycles, and `begins` (n, width + 1) are states on them.
    """
    cycles = motions.counts[:, CYCLE]
    rows = np.flatnonzero((motions.counts[:, OUTCOME] == OK) & (cycles == 2))
    images = travelled(
        motions.points[rows], begins[rows], np.ones(len(rows), np.int64), rtol, physics
    )
    components = model_of(physics).components
    apart = weighted(images - floored(begins[rows], components), components)
    moved = np.abs(apart).max(axis=1, initial=0.0)
    found = cycles == 1
    found[rows] = moved <= max(_MIRROR_IMAGE, 10.0 * stationary_rtol)
    return np.asarray(found)
