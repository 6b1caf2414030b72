"""Ensembles, the statistics of stochastic films, for all methods.

The realizations of a point start on its settled typical path. A few drive periods, in which they
become independent of it, are dropped. The realizations are then measured over a window, one drive
period at a time.
"""

from __future__ import annotations

import numpy as np

from stickslip.kernels.orbits.watching import Walk, Watched, aperiodic_rows, write_relative_errors
from stickslip.kernels.streams import streams_of
from stickslip.measure.accumulate import INTEGRALS
from stickslip.measure.results import STATUS
from stickslip.measure.window import Window, error_of_mean
from stickslip.options import METHODS, Options
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS

OK, APERIODIC = int(Status.OK), int(Status.APERIODIC)

# Drive periods after which a realization no longer depends on the typical path.
_DROPPED = 5

# The number of paths in one computation.
PATHS_AT_A_TIME = 4096

_COLUMN = {name: place for place, name in enumerate(RESULT_COLUMNS)}
_AMPLITUDES = ("elastic_stress_amplitude", "friction_force_amplitude")
_HIGHEST = ("elastic_stress_max", "friction_force_max", "power_balance_error")
_LOWEST = ("elastic_stress_min", "friction_force_min")
_SUMS = ("melting_count", "solid_transition_count")
_ERRORS = (
    "dissipated_energy_error", "friction_force_in_phase_error", "friction_force_out_of_phase_error",
)  # fmt: skip
_MEANS = (
    "solid_fraction", "asymmetry", "dissipated_energy",
    "friction_force_in_phase", "friction_force_out_of_phase", "friction_force_mean_abs",
)  # fmt: skip
_RMS = ("friction_force_rms",)

_ERROR_COLUMNS = [_COLUMN[name] for name in _ERRORS]


def write_ensembles(
    points: np.ndarray, options: Options, results: np.ndarray, finals: np.ndarray
) -> None:
    """Replace the typical paths of points by the statistics of their realizations.

    `points` (n, parameters) are in SI units; `results` (n, columns) and `finals` (n, columns)
    belong to their typical paths. The properties of the whole orbit (regime, multiplier, exponent,
    state) still describe the typical path. Points without one are left unchanged.
    """
    rows = np.flatnonzero(np.isin(results[:, STATUS], (OK, APERIODIC)))
    size = max(1, PATHS_AT_A_TIME // int(options.realizations))
    for first in range(0, len(rows), size):
        batch = rows[first : first + size]
        results[batch] = _statistics(points[batch], options, results[batch], finals[batch])


def _statistics(
    points: np.ndarray, options: Options, typical: np.ndarray, finals: np.ndarray
) -> np.ndarray:
    """Return the result rows (n, columns) of points (n, parameters) with these typical paths."""
    paths, window = int(options.realizations), int(options.window)
    own = np.repeat(points, paths, axis=0)
    walk = METHODS[options.method].kernels.stochastic_walk(
        own, np.repeat(finals, paths, axis=0), streams_of(points, options), options
    )
    for _ in range(_DROPPED):
        walk.next_period()
    rows, singles = _measured(own, walk, window, paths)
    results, shape = typical.copy(), (len(points), paths, -1)
    errors = np.empty((len(points), len(_AMPLITUDES)))
    for i, (own_rows, amplitudes) in enumerate(
        zip(rows.reshape(shape), singles.reshape(*shape, window), strict=True)
    ):
        errors[i] = [error_of_mean(each) for each in amplitudes.swapaxes(0, 1)]
        _combine(own_rows, amplitudes, results[i])
    means = results[:, [_COLUMN[name] for name in _AMPLITUDES]]
    relative = np.empty(len(points))
    write_relative_errors(points, means, errors, relative)
    results[:, _COLUMN["amplitude_error"]] += relative
    results[:, _ERROR_COLUMNS] += typical[:, _ERROR_COLUMNS]
    results[:, _COLUMN["periods_integrated"]] += paths * (_DROPPED + window)
    return results


def _measured(
    points: np.ndarray, walk: Walk, length: int, paths: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows (m, columns) of paths over a window, and the amplitudes of single periods.

    The amplitudes (m, 2, length) are of stress [Pa] and force [N]. The errors of integrals refer to
    the mean over the `paths` of each point.
    """
    begins, window, count = walk.states(), Window(len(points)), len(points)
    for _ in range(length):
        window.add(walk.next_period())
    singles = np.ascontiguousarray(window.amplitudes.transpose(1, 2, 0))
    integrals = window.integrals.transpose(1, 2, 0).reshape(-1, paths, len(INTEGRALS), length)
    errors = [[error_of_mean(each) for each in one.swapaxes(0, 1)] for one in integrals]
    zeros, uncertainties = np.zeros((count, 2)), np.zeros_like(window.record)
    uncertainties[:, list(INTEGRALS)] = length * np.repeat(errors, paths, axis=0)
    watched = Watched(
        records=window.record,
        uncertainties=uncertainties,
        lengths=np.full(count, length),
        begins=begins,
        ends=walk.states(),
        means=singles.mean(axis=2),
        errors=zeros,
        spreads=zeros,
        exponents=np.full(count, np.nan),
        aperiodic=np.ones(count, dtype=bool),
        periods=np.full(count, _DROPPED + length),
    )
    rows = aperiodic_rows(points, watched, watched.periods)
    outcomes = walk.outcomes()
    rows[outcomes != OK, STATUS] = outcomes[outcomes != OK]
    return rows, singles


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values * values)))


def _combine(rows: np.ndarray, singles: np.ndarray, result: np.ndarray) -> None:
    """Combine the rows (paths, columns) of realizations into the result row of their point.

    `singles` (paths, 2, periods) are the amplitudes of single periods. If one realization failed,
    the whole point fails.
    """
    failed = rows[:, STATUS] != APERIODIC
    if failed.any():
        result[:] = [RESULTS[name].missing for name in RESULT_COLUMNS]
        result[STATUS] = rows[failed, STATUS][0]
        return
    for place, name in enumerate(_AMPLITUDES):
        values = np.ascontiguousarray(singles[:, place]).ravel()
        result[_COLUMN[name]], result[_COLUMN[f"{name}_spread"]] = values.mean(), values.std()
    for names, combine in (
        (_HIGHEST, np.max), (_LOWEST, np.min), (_SUMS, np.sum), (_MEANS, np.mean),
        (_RMS, _root_mean_square), (_ERRORS, np.max),
    ):  # fmt: skip
        for name in names:
            result[_COLUMN[name]] = combine(np.ascontiguousarray(rows[:, _COLUMN[name]]))
    result[_COLUMN["orbit_periods"]] = 0.0  # the motion never closes
