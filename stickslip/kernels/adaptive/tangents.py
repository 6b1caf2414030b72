"""Separation of neighbouring motions: Floquet multipliers and growth, from displaced copies.

A copy is integrated like the motion itself, with the same tolerance and the same first step, so
that most integration errors are common to both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.kernels.adaptive.passes import (
    CYCLE,
    MEASURE,
    OUTCOME,
    TRAVEL,
    Pass,
    Queue,
    new_queue,
)
from stickslip.kernels.adaptive.queues import part_of, work_through
from stickslip.measure.accumulate import SENSITIVE
from stickslip.model.models import model_of
from stickslip.model.state import Component
from stickslip.numerics.adaptive import OK
from stickslip.numerics.spectrum import spectral_radii
from stickslip.options import Physics

# A copy is displaced farther in components with a small weight, but not so far that the film melts
# or freezes: as if the weight were at least this.
_LEAST_WEIGHT = 0.01

# Budget of steps of a copy: beyond it the multiplier stays unknown.
_MAX_STEPS = 20_000_000

# Half periods over which the tolerance of the points does not blur a multiplier; and the tolerances
# for longer cycles, and in turn for results above 1, which no attracting orbit has.
_SHORT = 2
_TIGHT = (1e-8, 1e-10)

# A symmetric orbit comes at least this close to its mirror image.
_MIRROR_IMAGE = 1e-4


Components = tuple[Component, ...]


def _weights(components: Components) -> np.ndarray:
    return np.array([component.weight for component in components])


def _displacements(rtol: float, components: Components) -> np.ndarray:
    """Displacements (width,) of copies, in units of the point: a compromise of curvature and noise.

    That of the film is the largest, because ln(phi), which swings by hundreds, is the noisiest.
    """
    return np.sqrt(rtol) / np.maximum(_weights(components), _LEAST_WEIGHT)


def floored(states: np.ndarray, components: Components) -> np.ndarray:
    """Return the components (n, width) of states, raised to their floors for comparison."""
    floors = np.array([component.floor for component in components])
    return np.asarray(np.maximum(states[:, : len(components)], floors))


def weighted(differences: np.ndarray, components: Components) -> np.ndarray:
    """Return differences (n, width) of states, weighted as in the test of repetition."""
    return np.asarray(_weights(components) * differences)


def travelled(
    points: np.ndarray, states: np.ndarray, cycles: np.ndarray, rtol: float, physics: Physics
) -> np.ndarray:
    """Return motions after so many half periods, (n, width); NaN for those that failed.

    `points` (n, reduced parameters), `states` (n, width + 1), `cycles` (n,); mirrored as in lanes.
    """
    queue = _run(points, states, cycles, TRAVEL, rtol, physics)
    return _images(queue, model_of(physics).components)


def _run(
    points: np.ndarray,
    states: np.ndarray,
    cycles: np.ndarray,
    mode: int,
    rtol: float,
    physics: Physics,
) -> Queue:
    queue = new_queue(points, states.copy())
    queue.counts[:, CYCLE] = cycles
    work_through(queue, Pass(mode, rtol, rtol, 0, _MAX_STEPS, False), physics)
    return queue


def _images(queue: Queue, components: Components) -> np.ndarray:
    """The states of a queue, (n, width); NaN for those that failed."""
    ends = floored(queue.states, components)
    ends[queue.counts[:, OUTCOME] != OK] = np.nan
    return ends


class Neighbours(NamedTuple):
    """Results from displaced copies of n settled orbits, in the points' own units; NaN if unknown.

    Moduli of the largest Floquet `multipliers` (n,); the `maps` (n, width, width) of small
    displacements over the cycle, mirrored as in the lanes; the `slopes` (n, SENSITIVE, width) of
    the extrema and integrals measured on it.
    """

    multipliers: np.ndarray
    maps: np.ndarray
    slopes: np.ndarray


def neighbours_of(
    queue: Queue, begins: np.ndarray, ends: Queue, rtol: float, physics: Physics
) -> Neighbours:
    """Return the results of copies displaced from states `begins` (n, width + 1) on settled orbits.

    `queue` holds their cycles; `ends` is the queue after a measurement from there at the tolerance
    `rtol`. A cycle of an odd number of half periods is half an orbit.
    """
    n, width = len(begins), begins.shape[1] - 1
    settled, cycles = queue.counts[:, OUTCOME] == OK, queue.counts[:, CYCLE]
    # Infinite until measured: longer cycles are measured only by the tight tolerances below.
    largest, maps = np.where(settled, np.inf, np.nan), np.full((n, width, width), np.nan)
    slopes = np.full((n, len(SENSITIVE), width), np.nan)

    def compare(rows: np.ndarray, measured: Queue, tolerance: float) -> None:
        maps[rows], slopes[rows] = _linear_maps(measured, begins[rows], tolerance, physics)
        largest[rows] = spectral_radii(maps[rows])

    short = np.flatnonzero(settled & (cycles <= _SHORT))
    compare(short, part_of(ends, short), rtol)
    for tight in _TIGHT:
        rows, tolerance = np.flatnonzero(largest > 1.0), min(rtol, tight)
        if len(rows):
            points, halves = queue.points[rows], cycles[rows]
            again = _run(points, begins[rows], halves, MEASURE, tolerance, physics)
            compare(rows, again, tolerance)
    return Neighbours(np.where(cycles % 2 == 1, largest**2, largest), maps, slopes)


def _linear_maps(
    measured: Queue, begins: np.ndarray, rtol: float, physics: Physics
) -> tuple[np.ndarray, np.ndarray]:
    """Return the maps (n, width, width) of small displacements, and `Neighbours.slopes`.

    `measured` is the queue of the same cycles, tolerance and states `begins` (n, width + 1).
    """
    components = model_of(physics).components
    n, width = len(begins), len(components)
    sizes = _displacements(rtol, components)
    displaced, cycles = np.tile(begins, (width, 1)), np.tile(measured.counts[:, CYCLE], width)
    for component in range(width):
        displaced[component * n : (component + 1) * n, component] += sizes[component]
    points = np.tile(measured.points, (width, 1))
    copies = _run(points, displaced, cycles, MEASURE, rtol, physics)
    moved = _images(copies, components).reshape(width, n, width) - _images(measured, components)
    slots = list(SENSITIVE)
    higher = copies.measured[:, slots].reshape(width, n, len(slots))
    higher = higher - measured.measured[:, slots]
    # Copied, since those of a single point are contiguous already: a second signature of kernels.
    maps, slopes = (
        np.ascontiguousarray((change / sizes[:, None, None]).transpose(1, 2, 0))
        for change in (moved, higher)
    )
    return maps, slopes


def symmetric(
    queue: Queue, begins: np.ndarray, stationary_rtol: float, rtol: float, physics: Physics
) -> np.ndarray:
    """Tell which of the settled orbits (n,) are their own mirror images half a drive period later.

    `queue` holds their cycles; `begins` (n, width + 1) are states on them.
    """
    cycles = queue.counts[:, CYCLE]
    rows = np.flatnonzero((queue.counts[:, OUTCOME] == OK) & (cycles == 2))
    images = travelled(
        queue.points[rows], begins[rows], np.ones(len(rows), np.int64), rtol, physics
    )
    components = model_of(physics).components
    apart = weighted(images - floored(begins[rows], components), components)
    moved = np.abs(apart).max(axis=1, initial=0.0)
    found = cycles == 1
    found[rows] = moved <= max(_MIRROR_IMAGE, 10.0 * stationary_rtol)
    return np.asarray(found)


class Tangents:
    """Tangent vectors of n motions, carried along by slightly displaced copies.

    `rtol` is the tolerance of the integration, `components` are those of the states.
    """

    def __init__(self, count: int, rtol: float, components: Components) -> None:
        width = len(components)
        self._components, self._sizes = components, _displacements(rtol, components)
        self._directions = np.full((count, width), width**-0.5)

    def displaced(self, states: np.ndarray) -> np.ndarray:
        """Return displaced copies (n, width + 1) of motions in these states."""
        copies = states.copy()
        copies[:, :-1] += self._sizes * self._directions
        return copies

    def carried(self, states: np.ndarray, copies: np.ndarray) -> np.ndarray:
        """Return the logarithms (n,) of the growth up to these states of motions and copies."""
        apart = floored(copies, self._components) - floored(states, self._components)
        moved = apart / self._sizes
        # The same order of summation for any number of motions, unlike `np.linalg.norm`.
        growth = np.sqrt(np.cumsum(np.square(moved), axis=1)[:, -1])
        self._directions = moved / np.where(growth > 0.0, growth, 1.0)[:, None]
        return np.asarray(np.log(np.maximum(growth, np.finfo(float).tiny)))
