"""The separation of neighbouring motions: Floquet multipliers of orbits, and growth.

The map of small displacements over a cycle comes from the variational equations, which a measuring
pass solves as well (`variations.py`). Growth over many periods comes from a displaced copy with the
same tolerance and first step, so that most errors are common to both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.kernels.adaptive.passes import TRAVEL, VARY, work_through
from stickslip.kernels.adaptive.variations import LEAST_WEIGHT
from stickslip.kernels.orbits.motions import CYCLE, OUTCOME, Motions, new_motions
from stickslip.measure.accumulate import SENSITIVE
from stickslip.model.models import model_of
from stickslip.model.state import Component
from stickslip.numerics.adaptive import OK
from stickslip.numerics.spectrum import spectral_radii
from stickslip.options import Physics

# Budget of steps of a motion, beyond which the multiplier stays unknown.
_MAX_STEPS = 20_000_000

# Half periods over which the tolerance of the points does not blur a multiplier. The tolerances are
# for longer cycles, and then for results above 1, which no attracting orbit has.
_SHORT = 2
_TIGHT = (1e-8, 1e-10)

Components = tuple[Component, ...]


def _weights(components: Components) -> np.ndarray:
    return np.array([component.weight for component in components])


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
    """Return the states (n, width) of motions after `cycles` (n,) half periods; NaN if they failed.

    `points` (n, reduced parameters), `states` (n, width + 1); mirrored as in lanes.
    """
    motions = _run(points, states, cycles, TRAVEL, rtol, physics)
    ends = floored(motions.states, model_of(physics).components)
    ends[motions.counts[:, OUTCOME] != OK] = np.nan
    return ends


def _run(
    points: np.ndarray,
    states: np.ndarray,
    cycles: np.ndarray,
    mode: int,
    rtol: float,
    physics: Physics,
) -> Motions:
    motions = new_motions(points, states.copy())
    motions.counts[:, CYCLE] = cycles
    work_through(motions, mode, rtol, _MAX_STEPS, physics)
    return motions


class Neighbours(NamedTuple):
    """Results from neighbours of n settled orbits, in the points' own units; NaN if unknown.

    `multipliers` (n,) are the moduli of the largest Floquet multipliers. `maps` (n, width, width)
    describe small displacements over the cycle, mirrored as in the lanes. `slopes` (n, SENSITIVE,
    width) belong to the extrema and integrals of the cycle.
    """

    multipliers: np.ndarray
    maps: np.ndarray
    slopes: np.ndarray


def neighbours_of(
    motions: Motions, begins: np.ndarray, rtol: float, physics: Physics
) -> Neighbours:
    """Return the results of a VARY pass from states `begins` (n, width + 1) on settled orbits.

    `motions` are in the state after the pass, with the tolerance `rtol`. A cycle of an odd number
    of half periods is half an orbit.
    """
    cycles, components = motions.counts[:, CYCLE], model_of(physics).components
    maps, slopes = _linear_maps(motions, components)
    largest = spectral_radii(maps)
    largest[cycles > _SHORT] = np.inf  # until it is measured at a tight tolerance
    largest[np.isnan(maps[:, 0, 0])] = np.nan
    for tight in _TIGHT:
        rows, tolerance = np.flatnonzero(largest > 1.0), min(rtol, tight)
        if len(rows):
            again = _run(motions.points[rows], begins[rows], cycles[rows], VARY, tolerance, physics)
            maps[rows], slopes[rows] = _linear_maps(again, components)
            largest[rows] = spectral_radii(np.ascontiguousarray(maps[rows]))
    return Neighbours(np.where(cycles % 2 == 1, largest**2, largest), maps, slopes)


def _linear_maps(motions: Motions, components: Components) -> tuple[np.ndarray, np.ndarray]:
    """Return the maps (n, width, width) of small displacements, and `Neighbours.slopes`.

    `motions` are in the state after a VARY pass; the result is NaN if a motion failed.
    """
    n, width = len(motions.states), len(components)
    maps = motions.varied[:, : width * width].reshape(n, width, width).transpose(0, 2, 1).copy()
    slopes = motions.varied[:, width * width :].reshape(n, len(SENSITIVE), width).copy()
    # All values below the floor of a component count as equal.
    floors = np.array([component.floor for component in components])
    maps[motions.states[:, :width] <= floors] = 0.0
    failed = motions.counts[:, OUTCOME] != OK
    maps[failed], slopes[failed] = np.nan, np.nan
    return maps, slopes


class Tangents:
    """Tangent vectors of n motions, as slightly displaced copies.

    `rtol` is the tolerance of the integration; states have these `components`.
    """

    def __init__(self, count: int, rtol: float, components: Components) -> None:
        width, self._components = len(components), components
        # The size, in units of the point, is a compromise between curvature and noise. The copy of
        # the film is displaced most, because ln(phi), which swings by hundreds, is the noisiest.
        self._sizes = np.sqrt(rtol) / np.maximum(_weights(components), LEAST_WEIGHT)
        self._directions = np.full((count, width), width**-0.5)

    def displaced(self, states: np.ndarray) -> np.ndarray:
        """Return displaced copies (n, width + 1) of these states of the motions."""
        copies = states.copy()
        copies[:, :-1] += self._sizes * self._directions
        return copies

    def carried(self, states: np.ndarray, copies: np.ndarray) -> np.ndarray:
        """Return the logarithms (n,) of the growth, from the new states of motions and copies."""
        apart = floored(copies, self._components) - floored(states, self._components)
        moved = apart / self._sizes
        # Unlike `np.linalg.norm` this has the same order of summation for any number of motions.
        growth = np.sqrt(np.cumsum(np.square(moved), axis=1)[:, -1])
        self._directions = moved / np.where(growth > 0.0, growth, 1.0)[:, None]
        return np.asarray(np.log(np.maximum(growth, np.finfo(float).tiny)))
