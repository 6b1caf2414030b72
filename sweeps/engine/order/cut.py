"""The blocks in which the missing points of a grid are computed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sweeps.engine.order.follow import Lines
from sweeps.engine.order.product import Blocks
from sweeps.grid import Grid


def blocks_of(
    grid: Grid,
    done: NDArray[np.bool_],
    slots: int,
    *,
    seconds: float = 1.0,
    block_points: int | None = None,
    pilot: int = 0,
) -> Blocks | Lines:
    """Blocks of points, or of whole lines where an axis is followed; arguments as of `Blocks`."""
    if grid.followed:
        return Lines(grid, done, slots)
    return Blocks(done, slots, seconds=seconds, block_points=block_points, pilot=pilot)
