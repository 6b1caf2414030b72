"""Stroboscopic maps with known orbits, and a search for these orbits without a drive.

A map stands for half a drive period with reversed signs or, with `per_period` 1, for a whole one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stickslip.numerics.periodic import search

TOL = 1e-6
State = tuple[float, float, float]
Map = Callable[[State, float], State]

START: State = (0.9, -0.3, 0.02)
LIMIT = np.array([0.3, -0.2, 0.005])


def new_memory(
    z: State = START,
    per_period: int = 2,
    *,
    accelerate: bool = True,
    refinable: bool = True,
    late: bool = False,
    filled_with: int = 0,
) -> Any:
    """Return the record of a search that starts from `z`, whatever the record held before."""
    record = np.frombuffer(
        bytes([filled_with]) * search.memory_of(3).itemsize, search.memory_of(3)
    ).copy()
    search.start(record[0], z, per_period, accelerate, refinable, late)
    return record[0]


class Search(NamedTuple):
    """The end of a search, with the last correction in `z` and without it in `raw`."""

    z: np.ndarray
    verdict: int
    cycle: int
    ratio: float
    applications: int
    verdicts: list[int]
    raw: State

    def count(self, verdict: int) -> int:
        return self.verdicts.count(verdict)


def find(
    S: Map,
    z: State = START,
    accelerate: bool = True,
    rtol: float = 1e-6,
    budget: int = 20_000,
    per_period: int = 2,
    refinable: bool = True,
    late: bool = False,
) -> Search:
    """Return the orbit on which the map settles from `z`."""
    memory = new_memory(z, per_period, accelerate=accelerate, refinable=refinable, late=late)
    noise, verdicts = rtol, []
    while True:
        z = S(z, noise)
        verdict, dx, dv = search.judge(memory, z, TOL, noise, budget)
        verdicts.append(verdict)
        z = z[0] + dx, z[1] + dv, z[2]
        if verdict == search.FINER:
            noise *= 0.1
        elif verdict == search.RESTORE:
            z, noise = tuple(memory["stored"].tolist()), rtol
        elif verdict in (search.EXHAUSTED, search.WANDERING):
            return Search(np.array(z), verdict, 0, math.nan, len(verdicts), verdicts, z)
        elif verdict == search.SETTLED:
            (cycle, ratio), (dx, dv) = search.found(memory), search.last_correction(memory)
            end = np.array([z[0] + dx, z[1] + dv, z[2]])
            return Search(end, verdict, cycle, ratio, len(verdicts), verdicts, z)


def linear(slow: float, fast: float = 0.05, film: float = 0.1) -> Map:
    """Return a map to LIMIT, slow along (1, 0.4) and fast across it, with a separate film."""

    def S(z: State, noise: float) -> State:
        x, v, w = np.array(z) - LIMIT
        along, across = slow * x, fast * (v - 0.4 * x)
        return LIMIT[0] + along, LIMIT[1] + 0.4 * along + across, LIMIT[2] + film * w

    return S


def cyclic(length: int, ratio: float, seed: int | None = None) -> tuple[Map, np.ndarray]:
    """Return a map and its attracting cycle (length, 3) of distant points, shuffled by a seed."""
    angles = 2 * np.pi * np.arange(length) / length
    if seed is not None:
        angles = np.random.default_rng(seed).permutation(angles)
    points = 0.5 * np.array([np.cos(angles), np.sin(angles), 0.1 * np.cos(angles)]).T

    def S(z: State, noise: float) -> State:
        nearest = int(np.argmin(np.linalg.norm(points[:, :2] - np.array(z[:2]), axis=1)))
        x, v, w = points[(nearest + 1) % length] + ratio * (np.array(z) - points[nearest])
        return float(x), float(v), float(w)

    return S, points


def pitchfork(growth: float) -> Map:
    """Return a map whose orbit x = 0 repels by -growth, but seems to be the limit from outside."""

    def S(z: State, noise: float) -> State:
        x, v, _ = z
        return -x * (growth - x * x), -0.5 * x + 0.02 * (v + 0.5 * x), 1e-4 * x * x

    return S


def noisy(S: Map, level: float, seed: int) -> Map:
    """Return the map with noise in x and v, `level` times the tolerance of the integrator."""
    rng = np.random.default_rng(seed)

    def with_noise(z: State, noise: float) -> State:
        x, v, w = S(z, noise)
        dx, dv = level * noise * rng.uniform(-1.0, 1.0, 2)
        return x + dx, v + dv, w

    return with_noise
