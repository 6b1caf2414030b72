"""Euler-Cromer for many points at once, in lanes, a module in the table `options.METHODS`."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from stickslip.kernels.euler_cromer.euler_cromer_trajectory import euler_cromer_trajectory
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.euler_cromer.march import march_kernel
from stickslip.kernels.families import FamilyKernel, families
from stickslip.kernels.fastest_rates import largest_stable_step
from stickslip.kernels.plain_iteration import orbits as plain
from stickslip.kernels.plain_iteration.march import WIDTH, PlainMarch, PlainWalk
from stickslip.options import NO_NOISE, Options
from stickslip.parameters import Parameters

trajectory_kernel = euler_cromer_trajectory


def family_kernels(kinds: np.ndarray, options: Options) -> Iterator[FamilyKernel]:
    """Yield the additional kernels for points of these kinds (n, k), as in `families.KIND`."""
    yield from plain.reference_kernels(kinds, options)
    no_points, nothing = np.empty((0, len(Parameters._fields))), np.empty(0, np.int64)
    tasks = March(no_points, nothing, np.empty((0, WIDTH)), options.physics).tasks
    noisy = options.noise != NO_NOISE
    for measured in (False, True):
        for family, _ in families(options.physics, kinds):
            kernel = march_kernel(family, noisy, measured)
            yield FamilyKernel(kernel, partial(kernel, tasks, nothing, 0))


def largest_step(points: np.ndarray, options: Options) -> np.ndarray:
    """Return the largest stable fixed step [s] of each point (n, parameters)."""
    return largest_stable_step(points, options.friction)


def rounding(options: Options) -> float:
    """Return the tolerance at which a cusp of the law is rounded: 0, as no cusp is."""
    return 0.0


def stochastic_walk(
    points: np.ndarray, starts: np.ndarray, streams: np.ndarray, options: Options
) -> PlainWalk:
    """Return motions with stochastic noise; arguments as in `adaptive.driver.stochastic_walk`."""
    # Imported here since only stochastic films need it.
    from stickslip.kernels.euler_cromer.stochastic import StochasticMarch

    march = PlainMarch(partial(StochasticMarch, streams), points, starts, options)
    return march.walk(np.arange(len(points)))


def orbits(
    points: np.ndarray,
    options: Options,
    starts: np.ndarray,
    results: np.ndarray,
    finals: np.ndarray,
    patience: int = 0,
) -> None:
    """Compute stationary orbits; arrays as in `adaptive.driver.orbits`."""
    plain.write_orbits(March, points, options, starts, results, finals)
