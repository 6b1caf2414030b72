"""Orbits that close late or never, watched one drive period at a time, for all methods.

A motion in which the search found no cycle is watched over a window of periods. If neighbouring
motions nevertheless approach each other, the motion is on its way to a cycle after all, and the
search goes on. Otherwise it is aperiodic and is measured as such.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from stickslip.compiled.decorators import kernel_making_arrays
from stickslip.kernels.parameter_rows import parameters_of, write_results
from stickslip.measure.accumulate import FORCE_MAX, INTEGRALS, RECORD, STRESS_MAX
from stickslip.measure.results import APERIODIC, OK, Measured, relative_difference
from stickslip.measure.window import Window, amplitudes_of, mean_in_order, statistics_of
from stickslip.variables import RESULT_COLUMNS

# Tangents point in the direction of fastest growth after the first number of periods, and their
# growth is averaged up to the second. If it is above the third per period, no cycle is near.
_ALIGNING = 16
_JUDGED = 128
LEAST_GROWTH = -0.01

RTOL = 1e-8
"""Tolerance of the adaptive method when it integrates tangents for motions of another method."""


class Walk(Protocol):
    """Motions that advance one drive period at a time."""

    def states(self) -> np.ndarray:
        """Return stroboscopic states (n, columns) as in finals, in SI units, with the next step."""

    def next_period(self) -> np.ndarray:
        """Advance by a period; return its records (n, RECORD) as a stretch, in SI units."""

    def outcomes(self) -> np.ndarray:
        """Return the Status (n,) of each motion, OK while it goes on."""


class DivisibleWalk(Walk, Protocol):
    """Motions that can be split, so that some may end before others."""

    def part(self, which: np.ndarray) -> DivisibleWalk:
        """Return the walk of some of the motions, from their present states."""


class TangentWalk(Walk, Protocol):
    """Motions with tangent vectors, each of which may end separately."""

    def growth(self) -> np.ndarray:
        """Return the logarithms (n,) of the growth of tangent vectors over the last period."""

    def stop(self, which: np.ndarray) -> None:
        """Stop these motions (n,) where they are, with the outcome PENDING."""


class Watched(NamedTuple):
    """The results of watching n motions, with amplitudes of stress [Pa] and force [N].

    `records` (n, RECORD) are of the window. The `uncertainties` (n, RECORD) of their INTEGRALS
    refer to means over such windows, and are 0 if a motion is not aperiodic. `lengths` (n,) of the
    window are in drive periods. `begins` and `ends` (n, columns) are the states before and after
    it, as finals. `means`, `errors` and `spreads` (n, 2) belong to the amplitudes of single
    periods. `exponents` (n,) are the growth of tangent vectors per period. `aperiodic` (n,) is a
    flag; where it is false, the statistics are NaN. `periods` (n,) are the periods watched.
    """

    records: np.ndarray
    uncertainties: np.ndarray
    lengths: np.ndarray
    begins: np.ndarray
    ends: np.ndarray
    means: np.ndarray
    errors: np.ndarray
    spreads: np.ndarray
    exponents: np.ndarray
    aperiodic: np.ndarray
    periods: np.ndarray

    def part(self, which: np.ndarray) -> Watched:
        """Return the results of some of the motions."""
        return Watched(*(column[which] for column in self))


def watch(walk: TangentWalk, length: int, *, decisive: bool = False) -> Watched:
    """Watch motions over a window of `length` drive periods, each until its kind is known.

    The watch of a motion whose neighbours approach it ends early. The motion then counts as
    aperiodic only if the watch is `decisive`, after a second search without a cycle. The watch of a
    motion that fails ends at once.
    """
    begins, after, total = walk.states(), walk.states(), max(length, _JUDGED)
    window, periods, grown = Window(len(begins)), np.zeros(len(begins), np.int64), []
    for period in range(total):
        if period == total - length:
            begins, window = after, Window(len(begins))
        going_on = walk.outcomes() == OK
        if period > _ALIGNING and not going_on.any():
            break
        periods += going_on
        window.add(walk.next_period())
        after = walk.states()
        grown.append(walk.growth())
        if period + 1 == _JUDGED and not decisive:
            walk.stop(~_grows(grown))
    whole = (walk.outcomes() == OK) & (decisive | (periods == total) & _grows(grown))
    means, errors, spreads = (np.full((len(begins), 2), np.nan) for _ in range(3))
    singles = window.amplitudes.transpose(1, 2, 0)
    means[whole], errors[whole], spreads[whole] = statistics_of(singles[whole])
    integrals = window.integrals.transpose(1, 2, 0)[whole]
    uncertainties = np.zeros_like(window.record)
    uncertainties[np.ix_(whole, INTEGRALS)] = length * statistics_of(integrals)[1]
    return Watched(
        records=window.record,
        uncertainties=uncertainties,
        lengths=np.full(len(begins), length),
        begins=begins,
        ends=after,
        means=means,
        errors=errors,
        spreads=spreads,
        exponents=mean_in_order(grown[_ALIGNING:]),
        aperiodic=whole,
        periods=periods,
    )


def _grows(grown: list[np.ndarray]) -> np.ndarray:
    return mean_in_order(grown[_ALIGNING:_JUDGED]) > LEAST_GROWTH


def spreads_of(walk: DivisibleWalk, periods: np.ndarray) -> np.ndarray:
    """Return the standard deviations (n, 2) of stress and force amplitudes over an orbit's periods.

    The orbits close after `periods` (n,); the result is 0 for one period.
    """
    longest, rows = int(periods.max(initial=0)), np.arange(len(periods))
    singles = np.zeros((longest, len(periods), 2))
    for period in range(longest):
        on = periods[rows] > period
        if not on.all():
            walk, rows = walk.part(on), rows[on]
        singles[period, rows] = amplitudes_of(walk.next_period())
    whole = [statistics_of(singles[:n, i].T[None])[2][0] for i, n in enumerate(periods)]
    return np.array(whole).reshape(-1, 2)


@kernel_making_arrays
def write_relative_errors(
    points: np.ndarray, means: np.ndarray, errors: np.ndarray, relative: np.ndarray
) -> None:
    """Write the relative errors (n,) of mean amplitudes (n, 2) of stress and force.

    Each is the larger of the two errors that follow from the absolute `errors` (n, 2), as for an
    orbit with these amplitudes and an error in one extremum.
    """
    exact, blurred = np.zeros(RECORD), np.zeros(RECORD)
    for i in range(points.shape[0]):
        for column, slot in ((0, STRESS_MAX), (1, FORCE_MAX)):
            exact[slot], exact[slot + 1] = means[i, column], -means[i, column]
            blurred[slot] = exact[slot] + errors[i, column]
            blurred[slot + 1] = exact[slot + 1]
        relative[i] = relative_difference(parameters_of(points[i]), blurred, exact)


def aperiodic_rows(points: np.ndarray, watched: Watched, periods: np.ndarray) -> np.ndarray:
    """Return the result rows (n, columns) of aperiodic motions of points (n, parameters).

    `periods` (n,) are the drive periods integrated for each.
    """
    n, errors = len(points), np.empty(len(points))
    results = np.empty((n, len(RESULT_COLUMNS)))
    write_relative_errors(points, watched.means, watched.errors, errors)
    measured = Measured(
        records=watched.records,
        uncertainties=watched.uncertainties,
        cycles=2 * watched.lengths,
        begins=watched.begins,
        ends=watched.ends,
        symmetric=np.zeros(n, dtype=bool),
        amplitudes=watched.means,
        errors=errors,
        spreads=watched.spreads,
        multipliers=np.full(n, np.nan),
        exponents=watched.exponents,
        periods=periods,
        statuses=np.full(n, APERIODIC),
    )
    write_results(points, measured, results)
    return results
