"""Passes of many points through the lanes of the adaptive method."""

from __future__ import annotations

import numpy as np

from inside import PHYSICS
from stickslip.kernels.adaptive import passes
from stickslip.kernels.adaptive.march import AdaptiveMarch
from stickslip.kernels.adaptive.passes import work_through
from stickslip.kernels.adaptive.tangents import travelled
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import ATTEMPTED, CYCLE, OUTCOME, Motions, motions_of
from stickslip.kernels.orbits.settling import Search, settle
from stickslip.measure.accumulate import RECORD
from stickslip.options import Options


def end_states(
    points: np.ndarray, periods: int, options: Options
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return SI states (x, v, ln phi) after some periods, (n, 3), attempted steps and statuses."""
    motions = motions_of(points, PHYSICS)
    half_periods(motions)[:] = 2 * periods
    settings = options.settings()
    work_through(motions, passes.TRAVEL, settings.rtol, settings.max_steps, PHYSICS)
    conversion_of(PHYSICS).restore_states(points, motions.states)
    counts = motions.counts
    return motions.states[:, :-1], counts[:, ATTEMPTED], counts[:, OUTCOME]


def searched(points: np.ndarray, options: Options) -> int:
    """Search for the orbits of points, and return the attempted steps of all."""
    motions, settings = motions_of(points, PHYSICS), options.settings()
    march = AdaptiveMarch(points, motions, PHYSICS, settings.max_steps)
    distance, halves = settings.stationary_rtol, 2 * settings.max_periods
    task = Search(settings.rtol, distance, halves, settings.accelerate)
    settle(march, np.arange(len(points)), task)
    return int(motions.counts[:, ATTEMPTED].sum())


def half_periods(motions: Motions) -> np.ndarray:
    """Return half periods after which each orbit closes: a view, to be changed."""
    return motions.counts[:, CYCLE]


def period_records(points: np.ndarray, rtol: float, finals: np.ndarray | None = None) -> np.ndarray:
    """Return SI records (n, RECORD) of a period from the start, or from SI states (n, columns)."""
    motions, records = motions_of(points, PHYSICS), np.empty((len(points), RECORD))
    if finals is not None:
        motions.states[:] = scaled_states(points, finals)
    half_periods(motions)[:] = 2
    work_through(motions, passes.MEASURE, rtol, 10**9, PHYSICS)
    conversion_of(PHYSICS).write_records(points, half_periods(motions), motions.measured, records)
    return records


def scaled_states(points: np.ndarray, finals: np.ndarray) -> np.ndarray:
    """Return SI states (n, columns) in the units of the lanes."""
    states = finals.copy()
    conversion_of(PHYSICS).scale_states(points, states)
    return states


def travelled_states(
    points: np.ndarray, states: np.ndarray, halves: np.ndarray, rtol: float
) -> np.ndarray:
    """Return scaled states (n, 3) after so many half periods of each point."""
    return travelled(motions_of(points, PHYSICS).points, states, halves, rtol, PHYSICS)
