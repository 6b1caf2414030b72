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
from stickslip.kernels.orbits.motions import (
    CYCLE,
    OUTCOME,
    RESOLUTION,
    Motions,
    new_motions,
)
from stickslip.measure.accumulate import SENSITIVE
from stickslip.model.models import model_of
from stickslip.model.state import Component
from stickslip.numerics.adaptive import OK
from stickslip.numerics.spectrum import spectral_radii
from stickslip.numerics.variational import DAMPING as DAMPING_OF_A_STEP
from stickslip.options import Physics

# Budget of steps of a motion, beyond which the multiplier stays unknown.
_MAX_STEPS = 20_000_000

# Half periods over which the tolerance of the points does not blur a multiplier. Multipliers
# of longer cycles, and those above 1, which no attracting orbit has, are measured again at the
# first of these tolerances, and those still above 1 at the second.
_SHORT = 2
_TIGHT = (1e-8, 1e-10)

# The method damps free oscillations of the block if its steps, which follow the film and the drive,
# do not resolve them. If the logarithm of this spurious damping over a cycle is above the first
# number, the multiplier is measured again with steps that are short enough for the second one,
# unless there would be more than `_MOST_STEPS`. If it is then above `_GROWS`, but not above what
# the damping makes up for, the motion came to an unstable orbit because it was damped.
_DAMPS, _LITTLE_DAMPING, _MOST_STEPS, _GROWS = 1e-2, 3e-4, 2_000_000, 1.001

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
    longest: np.ndarray | float = np.inf,
) -> Motions:
    motions = new_motions(points, states.copy())
    motions.counts[:, CYCLE], motions.longest[:] = cycles, longest
    motions.states[:, -1] = np.minimum(motions.states[:, -1], longest)
    work_through(motions, mode, rtol, _MAX_STEPS, physics)
    return motions


class Neighbours(NamedTuple):
    """Results from neighbours of n settled orbits, in the points' own units; NaN if unknown.

    `multipliers` (n,) are the moduli of the largest Floquet multipliers, and `unstable` (n,) says
    about which orbits free oscillations of the block grow. `maps` (n, width, width) describe small
    displacements over the cycle as the method carries them, mirrored as in the lanes. `slopes` (n,
    SENSITIVE, width) belong to the extrema and integrals of the cycle.
    """

    multipliers: np.ndarray
    unstable: np.ndarray
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
    damping, longest = _unresolved(motions)
    damped = longest < np.inf
    largest[damped] = np.inf
    largest[np.isnan(maps[:, 0, 0]) | (np.pi * cycles > _MOST_STEPS * longest)] = np.nan
    for tight in _TIGHT:
        rows, tolerance = np.flatnonzero(largest > 1.0), min(rtol, tight)
        if len(rows):
            again = _run(
                motions.points[rows], begins[rows], cycles[rows], VARY, tolerance, physics,
                longest[rows],
            )  # fmt: skip
            finer, finer_slopes = _linear_maps(again, components)
            largest[rows] = spectral_radii(np.ascontiguousarray(finer))
            kept = ~damped[rows]
            maps[rows[kept]], slopes[rows[kept]] = finer[kept], finer_slopes[kept]
    # An orbit whose disturbances grow faster than the method damps them was left by the search.
    hidden = np.log(np.maximum(largest, 1.0)) < damping
    unstable = damped & (largest > _GROWS) & hidden
    return Neighbours(np.where(cycles % 2 == 1, largest**2, largest), unstable, maps, slopes)


def _unresolved(motions: Motions) -> tuple[np.ndarray, np.ndarray]:
    """Return the spurious damping (n,) of free oscillations, and the steps (n,) that resolve them.

    `motions` are in the state after a VARY pass; the steps are infinite if it resolved them.
    """
    damping, fastest = motions.varied[:, -RESOLUTION:].T
    rows, longest = np.flatnonzero(damping > _DAMPS), np.full(len(damping), np.inf)
    lengths, rates = np.pi * motions.counts[rows, CYCLE], fastest[rows]
    # Over a length L, equal steps h damp an oscillation of rate w by DAMPING_OF_A_STEP w^4 h^3 L.
    longest[rows] = np.cbrt(_LITTLE_DAMPING / (DAMPING_OF_A_STEP * rates * lengths)) / rates
    return damping, longest


def _linear_maps(motions: Motions, components: Components) -> tuple[np.ndarray, np.ndarray]:
    """Return the maps (n, width, width) of small displacements, and `Neighbours.slopes`.

    `motions` are in the state after a VARY pass; the result is NaN if a motion failed.
    """
    n, width = len(motions.states), len(components)
    maps = motions.varied[:, : width * width].reshape(n, width, width).transpose(0, 2, 1).copy()
    slopes = motions.varied[:, width * width : -RESOLUTION]
    slopes = slopes.reshape(n, len(SENSITIVE), width).copy()
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
