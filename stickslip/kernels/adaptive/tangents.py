"""How neighbouring motions separate: Floquet multipliers and growth, from displaced copies.

A copy is integrated like the motion itself, with the same tolerance and the same first step, so
that most of what the integrator adds to either is the same.
"""

from __future__ import annotations

import numpy as np

from stickslip.kernels.adaptive.passes import CYCLE, OUTCOME, TRAVEL, Pass, Queue, new_queue
from stickslip.kernels.adaptive.queues import part_of, work_through
from stickslip.model.state import STATE, WIDTH
from stickslip.numerics.adaptive import OK
from stickslip.numerics.spectrum import spectral_radii

_WEIGHTS = np.array([component.weight for component in STATE])
_FLOORS = np.array([component.floor for component in STATE])

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


def _displacements(rtol: float) -> np.ndarray:
    """Displacements (WIDTH,) of copies, in units of the point: between bending and noise.

    The film's is the largest: the tolerance leaves the most to ln(phi), which swings by hundreds.
    """
    return np.sqrt(rtol) / np.maximum(_WEIGHTS, _LEAST_WEIGHT)


def _floored(states: np.ndarray) -> np.ndarray:
    """States (n, WIDTH) as they are compared: not below the floor of a component."""
    return np.asarray(np.maximum(states[:, :WIDTH], _FLOORS))


def travelled(
    points: np.ndarray, states: np.ndarray, cycles: np.ndarray, rtol: float, law: str
) -> np.ndarray:
    """Where motions are after so many half periods, (n, WIDTH); NaN where that failed.

    `points` (n, reduced parameters), `states` (n, WIDTH + 1), `cycles` (n,); mirrored as in lanes.
    """
    queue = new_queue(points, states.copy())
    queue.counts[:, CYCLE] = cycles
    work_through(queue, Pass(TRAVEL, rtol, rtol, 0, _MAX_STEPS, False), law)
    ends = _floored(queue.states)
    ends[queue.counts[:, OUTCOME] != OK] = np.nan
    return ends


def multipliers_of(
    queue: Queue, begins: np.ndarray, ends: np.ndarray, rtol: float, law: str
) -> np.ndarray:
    """Moduli (n,) of the largest Floquet multipliers of settled orbits; NaN where unknown.

    The `queue` with their cycles; a measurement at the tolerance `rtol` went from the states
    `begins` to `ends`, (n, WIDTH + 1). A cycle of an odd number of half periods is half an orbit.
    """
    settled, cycles = queue.counts[:, OUTCOME] == OK, queue.counts[:, CYCLE]
    largest, rows = np.where(settled, np.inf, np.nan), np.flatnonzero(settled & (cycles <= _SHORT))
    part = part_of(queue, rows)
    largest[rows] = _largest(part, begins[rows], _floored(ends[rows]), rtol, law)
    for tight in _TIGHT:
        rows, tolerance = np.flatnonzero(largest > 1.0), min(rtol, tight)
        if not len(rows):
            break
        part = part_of(queue, rows)
        images = travelled(part.points, begins[rows], cycles[rows], tolerance, law)
        largest[rows] = _largest(part, begins[rows], images, tolerance, law)
    return np.where(cycles % 2 == 1, largest**2, largest)


def _largest(
    queue: Queue, begins: np.ndarray, images: np.ndarray, rtol: float, law: str
) -> np.ndarray:
    """Moduli (n,) of the largest eigenvalues of the maps over the cycles; NaN where unknown.

    `images` (n, WIDTH) of the states `begins` (n, WIDTH + 1) under the maps, at the same tolerance.
    """
    return np.asarray(spectral_radii(_linear_maps(queue, begins, images, rtol, law)))


def _linear_maps(
    queue: Queue, begins: np.ndarray, ends: np.ndarray, rtol: float, law: str
) -> np.ndarray:
    """The maps (n, WIDTH, WIDTH) of small displacements over the cycles, as in lanes."""
    n, sizes = len(begins), _displacements(rtol)
    displaced, cycles = np.tile(begins, (WIDTH, 1)), np.tile(queue.counts[:, CYCLE], WIDTH)
    for component in range(WIDTH):
        displaced[component * n : (component + 1) * n, component] += sizes[component]
    images = travelled(np.tile(queue.points, (WIDTH, 1)), displaced, cycles, rtol, law)
    moved = images.reshape(WIDTH, n, WIDTH) - ends
    return np.asarray((moved / sizes[:, None, None]).transpose(1, 2, 0))


def symmetric(
    queue: Queue, begins: np.ndarray, stationary_rtol: float, rtol: float, law: str
) -> np.ndarray:
    """Which of the settled orbits (n,) are their own mirror images half a drive period later.

    The `queue` with their cycles; `begins` (n, WIDTH + 1) states on them.
    """
    cycles = queue.counts[:, CYCLE]
    rows = np.flatnonzero((queue.counts[:, OUTCOME] == OK) & (cycles == 2))
    images = travelled(queue.points[rows], begins[rows], np.ones(len(rows), np.int64), rtol, law)
    moved = np.abs(_WEIGHTS * (images - _floored(begins[rows]))).max(axis=1, initial=0.0)
    found = cycles == 1
    found[rows] = moved <= max(_MIRROR_IMAGE, 10.0 * stationary_rtol)
    return np.asarray(found)


class Tangents:
    """Tangent vectors of n motions, carried along by copies displaced a little.

    `rtol` is the tolerance of the integration.
    """

    def __init__(self, count: int, rtol: float) -> None:
        self._sizes = _displacements(rtol)
        self._directions = np.full((count, WIDTH), WIDTH**-0.5)

    def displaced(self, states: np.ndarray) -> np.ndarray:
        """The copies (n, WIDTH + 1) of the motions in these states."""
        copies = states.copy()
        copies[:, :WIDTH] += self._sizes * self._directions
        return copies

    def carried(self, states: np.ndarray, copies: np.ndarray) -> np.ndarray:
        """Logarithms (n,) of the growth up to these states of the motions and their copies."""
        moved = (_floored(copies) - _floored(states)) / self._sizes
        growth = np.linalg.norm(moved, axis=1)
        self._directions = moved / np.where(growth > 0.0, growth, 1.0)[:, None]
        return np.asarray(np.log(np.maximum(growth, np.finfo(float).tiny)))
