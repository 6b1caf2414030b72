"""How neighbouring motions separate: Floquet multipliers and growth, from displaced copies.

A copy is integrated like the motion itself, with the same tolerance and the same first step, so
that most of what the integrator adds to either is the same.
"""

from __future__ import annotations

import numpy as np

from stickslip.kernels.adaptive.passes import CYCLE, OUTCOME, TRAVEL, Pass, Queue, new_queue
from stickslip.kernels.adaptive.queues import part_of, work_through
from stickslip.model.state import components_of
from stickslip.numerics.adaptive import OK
from stickslip.numerics.spectrum import spectral_radii
from stickslip.options import RELAXING, Physics

_WEIGHTS = np.array([component.weight for component in components_of(RELAXING)])
_FLOORS = np.array([component.floor for component in components_of(RELAXING)])

# ... but not so much that the film melts or freezes.
_LEAST_WEIGHT = 0.01

# Budget of steps of a copy: beyond it the multiplier stays unknown.
_MAX_STEPS = 20_000_000

# Half periods over which the tolerance of the points does not blur a multiplier, and tolerances for
# longer ways; what attracts has none above 1: there the tightest.
_SHORT = 2
_TIGHT = (1e-8, 1e-10)

# A symmetric orbit returns to its mirror image at least as closely.
_MIRROR_IMAGE = 1e-4


def _displacements(rtol: float, width: int) -> np.ndarray:
    """Displacements (width,) of copies, in units of the point: between bending and noise.

    The film's is the largest: the tolerance leaves the most to ln(phi), which swings by hundreds.
    """
    return np.sqrt(rtol) / np.maximum(_WEIGHTS[:width], _LEAST_WEIGHT)


def _floored(states: np.ndarray, width: int) -> np.ndarray:
    """The first columns (n, width) of states as they are compared: not below their floors."""
    return np.asarray(np.maximum(states[:, :width], _FLOORS[:width]))


def travelled(
    points: np.ndarray, states: np.ndarray, cycles: np.ndarray, rtol: float, physics: Physics
) -> np.ndarray:
    """Where motions are after so many half periods, (n, width); NaN where that failed.

    `points` (n, reduced parameters), `states` (n, width + 1), `cycles` (n,); mirrored as in lanes.
    """
    queue = new_queue(points, states.copy())
    queue.counts[:, CYCLE] = cycles
    work_through(queue, Pass(TRAVEL, rtol, rtol, 0, _MAX_STEPS, False), physics)
    ends = _floored(queue.states, states.shape[1] - 1)
    ends[queue.counts[:, OUTCOME] != OK] = np.nan
    return ends


def multipliers_of(
    queue: Queue, begins: np.ndarray, ends: np.ndarray, rtol: float, physics: Physics
) -> np.ndarray:
    """Moduli (n,) of the largest Floquet multipliers of settled orbits; NaN where unknown.

    The `queue` with their cycles; a measurement at the tolerance `rtol` went from the states
    `begins` to `ends`, (n, width + 1). A cycle of an odd number of half periods is half an orbit.
    """
    settled, cycles = queue.counts[:, OUTCOME] == OK, queue.counts[:, CYCLE]
    largest, rows = np.where(settled, np.inf, np.nan), np.flatnonzero(settled & (cycles <= _SHORT))
    part = part_of(queue, rows)
    largest[rows] = _largest(
        part, begins[rows], _floored(ends[rows], begins.shape[1] - 1), rtol, physics
    )
    for tight in _TIGHT:
        rows, tolerance = np.flatnonzero(largest > 1.0), min(rtol, tight)
        if not len(rows):
            break
        part = part_of(queue, rows)
        images = travelled(part.points, begins[rows], cycles[rows], tolerance, physics)
        largest[rows] = _largest(part, begins[rows], images, tolerance, physics)
    return np.where(cycles % 2 == 1, largest**2, largest)


def _largest(
    queue: Queue, begins: np.ndarray, images: np.ndarray, rtol: float, physics: Physics
) -> np.ndarray:
    """Moduli (n,) of the largest eigenvalues of the maps over the cycles; NaN where unknown.

    `images` (n, width) of the states `begins` (n, width + 1) under the maps, at the same tolerance.
    """
    return np.asarray(spectral_radii(_linear_maps(queue, begins, images, rtol, physics)))


def _linear_maps(
    queue: Queue, begins: np.ndarray, ends: np.ndarray, rtol: float, physics: Physics
) -> np.ndarray:
    """The maps (n, width, width) of small displacements over the cycles, as in lanes."""
    n, width = len(begins), begins.shape[1] - 1
    sizes = _displacements(rtol, width)
    displaced, cycles = np.tile(begins, (width, 1)), np.tile(queue.counts[:, CYCLE], width)
    for component in range(width):
        displaced[component * n : (component + 1) * n, component] += sizes[component]
    images = travelled(np.tile(queue.points, (width, 1)), displaced, cycles, rtol, physics)
    moved = images.reshape(width, n, width) - ends
    maps = (moved / sizes[:, None, None]).transpose(1, 2, 0)
    return np.ascontiguousarray(maps)  # of one point they are so as it is: a second signature


def symmetric(
    queue: Queue, begins: np.ndarray, stationary_rtol: float, rtol: float, physics: Physics
) -> np.ndarray:
    """Which of the settled orbits (n,) are their own mirror images half a drive period later.

    The `queue` with their cycles; `begins` (n, width + 1) states on them.
    """
    cycles = queue.counts[:, CYCLE]
    rows = np.flatnonzero((queue.counts[:, OUTCOME] == OK) & (cycles == 2))
    images = travelled(
        queue.points[rows], begins[rows], np.ones(len(rows), np.int64), rtol, physics
    )
    moved = np.abs(
        _WEIGHTS[: images.shape[1]] * (images - _floored(begins[rows], images.shape[1]))
    ).max(axis=1, initial=0.0)
    found = cycles == 1
    found[rows] = moved <= max(_MIRROR_IMAGE, 10.0 * stationary_rtol)
    return np.asarray(found)


class Tangents:
    """Tangent vectors of n motions, carried along by copies displaced a little.

    `rtol` is the tolerance of the integration, `width` the number of state variables.
    """

    def __init__(self, count: int, rtol: float, width: int) -> None:
        self._sizes = _displacements(rtol, width)
        self._directions = np.full((count, width), width**-0.5)

    def displaced(self, states: np.ndarray) -> np.ndarray:
        """The copies (n, width + 1) of the motions in these states."""
        copies = states.copy()
        copies[:, :-1] += self._sizes * self._directions
        return copies

    def carried(self, states: np.ndarray, copies: np.ndarray) -> np.ndarray:
        """Logarithms (n,) of the growth up to these states of the motions and their copies."""
        width = len(self._sizes)
        moved = (_floored(copies, width) - _floored(states, width)) / self._sizes
        # In this order for any number of motions, which `np.linalg.norm` does not promise.
        growth = np.sqrt(np.cumsum(np.square(moved), axis=1)[:, -1])
        self._directions = moved / np.where(growth > 0.0, growth, 1.0)[:, None]
        return np.asarray(np.log(np.maximum(growth, np.finfo(float).tiny)))
