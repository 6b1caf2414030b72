"""Stationary orbits by plain iteration, which are compared with the adaptive method.

For every march the adaptive method computes tangents and reference orbits. A finite step changes
not only the measurement of a cycle but also the cycle. If the orbit attracts slowly, a small error
of the map is a large offset of its fixed point. So the comparison is with the orbit on which the
adaptive method settles from the same state, and not with its path along the fixed-step orbit.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from stickslip.compiled.decorators import kernel
from stickslip.kernels.adaptive import driver as adaptive
from stickslip.kernels.adaptive import tangents
from stickslip.kernels.adaptive.march import AdaptiveMarch
from stickslip.kernels.adaptive.mirror_images import symmetric
from stickslip.kernels.adaptive.passes import VARY, work_through
from stickslip.kernels.families import FamilyKernel
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.finding import find_orbits
from stickslip.kernels.orbits.motions import CYCLE, OUTCOME, motions_of
from stickslip.kernels.orbits.settling import APERIODIC, Search, settle
from stickslip.kernels.orbits.watching import aperiodic_rows, spreads_of
from stickslip.kernels.parameter_rows import parameters_of, write_results
from stickslip.kernels.plain_iteration.march import MakeMarch, PlainMarch, finals_of
from stickslip.measure.accumulate import INTEGRALS, RECORD
from stickslip.measure.results import Measured, relative_difference
from stickslip.measure.window import amplitudes_of
from stickslip.numerics.adaptive import OK
from stickslip.options import Options
from stickslip.status import Status

INACCURATE = int(Status.INACCURATE)

# The error of the reference at the paper's step is 1e-9.
_RTOL = 1e-9
_MAX_STEPS = 20_000_000

# The difference of two records adds those of both extrema; an amplitude is half of max - min.
_AMPLITUDE_PART = 0.5


def reference_kernels(kinds: np.ndarray, options: Options) -> Iterator[FamilyKernel]:
    """Yield the kernels of the reference orbits of points of these kinds (n, k).

    There are none with stochastic noise.
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

    The error estimate compares each orbit with the one on which the adaptive method settles from
    there.
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
    records[statuses != OK] = 0.0  # an unfinished march leaves numbers there
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
    """Take the settled motions once over their orbits of `cycles` (n,) periods."""
    pending, done = np.flatnonzero(march.motions.counts[:, OUTCOME] == OK), 0
    march.own.clear_records(pending)
    while len(pending := pending[cycles[pending] > done]):
        pending, done = march.next_period(pending, measured=True), done + 1


def _spreads(march: PlainMarch, statuses: np.ndarray, cycles: np.ndarray) -> np.ndarray:
    """Return standard deviations (n, 2) of the amplitudes of single drive periods, in SI units."""
    spreads = np.zeros((len(statuses), 2))
    rows = np.flatnonzero((statuses == OK) & (cycles > 1))
    if len(rows):  # this goes over the orbit once more
        spreads[rows] = spreads_of(march.walk(rows), cycles[rows])
    return spreads


# --- reference orbits -----------------------------------------------------------------------------


class Known(NamedTuple):
    """Reference values of n orbits.

    `records` (n, RECORD) are in SI units, their `integrals` (n, INTEGRALS) per half period;
    `symmetric` (n,); Floquet `multipliers` (n,).
    """

    records: np.ndarray
    integrals: np.ndarray
    symmetric: np.ndarray
    multipliers: np.ndarray


def settle_from(
    points: np.ndarray, finals: np.ndarray, statuses: np.ndarray, options: Options
) -> Known:
    """Return the orbits on which the adaptive method settles from stroboscopic states.

    `points` (n, parameters); `finals` (n, columns). If it finds none, `statuses` (n,) gets the
    reason.
    """
    physics, halves = options.physics, 2 * options.max_periods
    conversion = conversion_of(physics)
    motions = motions_of(points, physics)
    motions.states[:] = finals
    conversion.scale_states(points, motions.states)
    motions.counts[:, OUTCOME] = statuses
    march = AdaptiveMarch(points, motions, physics, _MAX_STEPS)
    settle(march, np.flatnonzero(statuses == OK), Search(_RTOL, _RTOL, halves, accelerate=True))
    begins = motions.states.copy()
    work_through(motions, VARY, _RTOL, _MAX_STEPS, physics)
    wandered = (statuses == OK) & (motions.counts[:, OUTCOME] == APERIODIC)
    statuses[:] = np.where(wandered, INACCURATE, motions.counts[:, OUTCOME])
    records, cycles = np.empty((len(points), RECORD)), motions.counts[:, CYCLE]
    conversion.write_records(points, cycles, motions.measured, records)
    whole = np.where(cycles % 2 == 1, 2 * cycles, np.maximum(cycles, 1))  # 0 where none was found
    return Known(
        records,
        records[:, list(INTEGRALS)] / whole[:, None],
        symmetric(motions, begins, options.stationary_rtol, _RTOL, physics),
        tangents.neighbours_of(motions, begins, _RTOL, physics).multipliers,
    )


@kernel
def write_errors(
    points: np.ndarray, records: np.ndarray, references: np.ndarray, errors: np.ndarray
) -> None:
    """Write the errors (n,) of amplitudes, from `records` and `references` (n, RECORD)."""
    for i in range(points.shape[0]):
        difference = relative_difference(parameters_of(points[i]), records[i], references[i])
        errors[i] = _AMPLITUDE_PART * difference
