"""Stationary orbits by plain iteration: settle, measure, compare with the adaptive method.

For every march, tangents and reference orbits are computed by the adaptive method.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.kernels.adaptive import driver as adaptive
from stickslip.kernels.families import FamilyKernel
from stickslip.kernels.orbits.finding import find_orbits
from stickslip.kernels.orbits.motions import CYCLE, OUTCOME
from stickslip.kernels.orbits.settling import Search
from stickslip.kernels.orbits.watching import aperiodic_rows, spreads_of
from stickslip.kernels.plain_iteration.comparison import settle_from, write_errors
from stickslip.kernels.plain_iteration.march import MakeMarch, PlainMarch
from stickslip.kernels.plain_iteration.starts import finals_of
from stickslip.kernels.points import write_results
from stickslip.measure.accumulate import INTEGRALS
from stickslip.measure.results import Measured
from stickslip.measure.window import amplitudes_of
from stickslip.numerics.adaptive import OK
from stickslip.options import Options


def reference_kernels(kinds: np.ndarray, options: Options) -> Iterator[FamilyKernel]:
    """Yield the kernels of the reference orbits of points of these kinds (n, k).

    There are none if the noise is stochastic.
    """
    if not options.physics.chance:
        yield from adaptive.family_kernels(kinds, options)


def write_orbits(
    make_march: MakeMarch,
    points: np.ndarray,
    options: Options,
    starts: np.ndarray,
    results: np.ndarray,
    finals: np.ndarray,
) -> None:
    """Compute stationary orbits by a march; arrays as in `adaptive.driver.orbits`.

    The error estimate compares with the orbit on which the adaptive method settles from there.
    """
    settings, march = options.settings(), PlainMarch(make_march, points, starts, options)
    task = Search(0.0, settings.stationary_rtol, 2 * settings.max_periods, False, per_period=1)
    aperiodic = find_orbits(march, task, settings.window)
    statuses, cycles = march.motions.counts[:, OUTCOME], march.motions.counts[:, CYCLE]
    begins = march.own.states()
    _measure(march, cycles)
    ends, records = march.own.states(), march.own.records()
    finals[:] = finals_of(points, begins)
    known = settle_from(points, finals, statuses, options)
    records[statuses != OK] = 0.0  # what a march left there that did not come to its end
    errors, uncertainties = np.empty(len(points)), np.zeros_like(records)
    write_errors(points, records, known.records, errors)
    integrals = list(INTEGRALS)
    known_integrals = known.integrals * (2 * cycles)[:, None]
    uncertainties[:, integrals] = np.abs(records[:, integrals] - known_integrals)
    measured = Measured(
        records=records,
        uncertainties=uncertainties,
        cycles=2 * cycles,
        begins=begins,
        ends=ends,
        symmetric=known.symmetric,
        amplitudes=amplitudes_of(records),
        errors=errors,
        spreads=_spreads(march, statuses, cycles),
        multipliers=known.multipliers,
        exponents=np.full(len(points), np.nan),
        periods=march.periods,
        statuses=statuses,
    )
    write_results(points, measured, results)
    for rows, watched in aperiodic:
        results[rows] = aperiodic_rows(points[rows], watched, march.periods[rows])
        finals[rows] = watched.ends


def _measure(march: PlainMarch, cycles: np.ndarray) -> None:
    """Take the settled motions once over their orbits of so many periods (n,)."""
    pending, done = np.flatnonzero(march.motions.counts[:, OUTCOME] == OK), 0
    march.own.clear_records(pending)
    while len(pending := pending[cycles[pending] > done]):
        pending, done = march.next_period(pending, measured=True), done + 1


def _spreads(march: PlainMarch, statuses: np.ndarray, cycles: np.ndarray) -> np.ndarray:
    """Return the standard deviations (n, 2) of amplitudes of single drive periods, SI units."""
    spreads = np.zeros((len(statuses), 2))
    rows = np.flatnonzero((statuses == OK) & (cycles > 1))
    if len(rows):  # once more over the orbit
        spreads[rows] = spreads_of(march.walk(rows), cycles[rows])
    return spreads
