"""Stationary orbits and their observables, from parameters: the interface to the kernels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from stickslip.compiled.cache import is_kept
from stickslip.kernels.families import FamilyKernel
from stickslip.kernels.parameter_rows import final_columns
from stickslip.measure.results import STATUS
from stickslip.options import (
    DEFAULTS,
    METHODS,
    TYPICAL_PATH,
    NoiseError,
    Options,
    options_for_orbits,
)
from stickslip.parameters import Parameters, given_or_default
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.tables import value_table
from stickslip.variables import RESULT_COLUMNS, RESULTS, OrbitValues

_NOISE = Parameters._fields.index("noise_intensity")
_PERIODS = RESULT_COLUMNS.index("periods_integrated")
_ERROR = RESULT_COLUMNS.index("amplitude_error")

# A point that is not accurate enough is computed again up to three times, each time with a tenth of
# the tolerances.
_REFINEMENTS = 3
_TIGHTEST = 1e-12

_PHI_0 = Parameters._fields.index("initial_order_parameter")


class Orbit(OrbitValues):
    """The observables of one stationary orbit, in SI units.

    `variables.RESULTS` describes them. Without a result, the amplitudes are NaN and the counts
    -1. `state` is (x, v, ln phi), followed by the strain if that relaxes, at the start
    of a drive period on the orbit, or where the search ended. Orbits are equal if all their values
    are; here NaN equals NaN.

    >>> orbit = stationary_orbit()
    >>> orbit.status.name, orbit.melting_count, round(orbit.friction_force_amplitude, 6)
    ('OK', 4, 0.002812)
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Orbit) and _comparable(self) == _comparable(other)

    def __ne__(self, other: object) -> bool:
        return not self == other  # a tuple's own method treats NaN and NaN as different

    def __hash__(self) -> int:
        return hash(_comparable(self))

    def _repr_html_(self) -> str:
        """Return the status in words and the observables, for a notebook."""
        values = {name: getattr(self, name) for name in RESULT_COLUMNS}
        return f"<p>{self.status.sentence}</p>{value_table(values, RESULTS)}"


def _comparable(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return values with None in place of NaN, which does not equal itself."""
    return tuple(
        _comparable(value) if isinstance(value, tuple) else None if value != value else value
        for value in values
    )


def prepared_points(points: np.ndarray, noise: str, starting: int | None = None) -> np.ndarray:
    """Return parameters (n, parameters) as kernels take them under a noise treatment.

    Raises NoiseError if a film starts at phi = 0 and could never solidify. Only the first
    `starting` points, by default all, start at phi_0.
    """
    points = np.array(np.atleast_2d(points), dtype=float)
    if noise == "none":
        points[:, _NOISE] = 0.0
    started = points[:starting]
    if np.any((started[:, _NOISE] == 0.0) & (started[:, _PHI_0] == 0.0)):
        raise NoiseError
    return points


def typical_options(options: Options) -> Options:
    """Return the options with the typical path in place of stochastic noise."""
    return replace(options, noise=TYPICAL_PATH) if options.physics.chance else options


def prepare_kernels(options: Options, kinds: np.ndarray) -> None:
    """Compile or load all that `compute_orbits` needs for points of these kinds (n, k).

    The columns are the parameters in `kernels.families.KIND`.
    """
    _prepare_shared(typical_options(options))
    for own in _family_kernels(options, kinds):
        own.compile()


@cache
def _prepare_shared(options: Options) -> None:
    """Compile or load all kernels that do not belong to a family: a run without points calls them.

    Once for these options, since the run takes as long as half an orbit.
    """
    compute_orbits(np.empty((0, len(Parameters._fields))), options)


def uncompiled(options: Options, kinds: np.ndarray) -> list[int]:
    """Return the numbers of the kernels for points of these kinds (n, k) that are not compiled."""
    kernels = enumerate(_family_kernels(options, kinds))
    return [number for number, own in kernels if not is_kept(own.kernel)]


def compile_one(options: Options, kinds: np.ndarray, number: int) -> None:
    """Compile or load the kernel with a number from `uncompiled`, in any process."""
    _family_kernels(options, kinds)[number].compile()


def _family_kernels(options: Options, kinds: np.ndarray) -> list[FamilyKernel]:
    kernels_of = METHODS[options.method].kernels.family_kernels
    both = dict.fromkeys((typical_options(options), options))
    found = {own.kernel: own for some in both for own in kernels_of(kinds, some)}
    return list(found.values())


def compute_orbits(
    points: np.ndarray,
    options: Options,
    starts: np.ndarray | None = None,
    *,
    patience: int = 0,
    limit: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the stationary orbits of many points.

    Parameters
    ----------
    points
        (n, parameters) in SI units, in the order of `Parameters._fields`.
    options
        Method, tolerances, noise.
    starts
        (n, columns), the states at phase 0 to start from, laid out like `finals`. A row of NaN
        means the start that the parameters give.
    patience
        Drive periods after which the adaptive method leaves a point `pending`; 0 for no limit. With
        a limit, points that need finer tolerances become `pending` as well. Such points are
        computed faster together, with the same results.
    limit
        Drive periods after which the adaptive method gives up a point as `pending`, at each
        tolerance; 0 for no limit.

    Returns
    -------
    results
        (n, columns) in the order of `variables.RESULT_COLUMNS`.
    finals
        (n, columns) in the order of `kernels.parameter_rows.final_columns`.

    Raises
    ------
    NoiseError
        phi_0 = 0 without noise.
    """
    compute = _compute_ensembles if options.physics.chance else _compute_paths
    return compute(points, options, starts, patience, limit)


def _compute_paths(
    points: np.ndarray, options: Options, starts: np.ndarray | None, patience: int, limit: int
) -> tuple[np.ndarray, np.ndarray]:
    """Compute films without random numbers, as `compute_orbits` does."""
    points, method = prepared_points(points, options.noise), METHODS[options.method]
    results = np.tile(failed_row(Status.REFUSED), (len(points), 1))
    finals = np.full((len(points), len(final_columns(options.physics))), np.nan)
    stable = options.dt <= method.kernels.largest_step(points, options)
    starts = np.full_like(finals, np.nan) if starts is None else starts
    results[stable], finals[stable] = _orbits(
        points[stable], options, starts[stable], patience or limit
    )
    if patience and method.refines:
        results[_is_doubtful(results, options)] = failed_row(Status.PENDING)
    for _ in range(_REFINEMENTS if method.refines else 0):
        doubtful = np.flatnonzero(_is_doubtful(results, options))
        if not len(doubtful):
            break
        options = _finer(options)
        better = _orbits(points[doubtful], options, starts[doubtful], limit)
        _replace_by_better(results, finals, doubtful, *better)
    inaccurate = _is_inaccurate(results, options)
    periods = results[inaccurate, _PERIODS]
    results[inaccurate] = failed_row(Status.INACCURATE)
    results[inaccurate, _PERIODS] = periods
    return results, finals


def _compute_ensembles(
    points: np.ndarray, options: Options, starts: np.ndarray | None, patience: int, limit: int
) -> tuple[np.ndarray, np.ndarray]:
    """Compute stochastic films, as `compute_orbits` does; the finals are of the typical paths."""
    from stickslip.kernels.ensembles import write_ensembles  # only stochastic films need it

    results, finals = compute_orbits(
        points, typical_options(options), starts, patience=patience, limit=limit
    )
    write_ensembles(np.atleast_2d(np.asarray(points, dtype=float)), options, results, finals)
    return results, finals


def _orbits(
    points: np.ndarray, options: Options, starts: np.ndarray, patience: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the results and finals (n, columns) of one run over points (n, parameters)."""
    results = np.full((len(points), len(RESULT_COLUMNS)), np.nan)
    finals = np.full((len(points), len(final_columns(options.physics))), np.nan)
    METHODS[options.method].kernels.orbits(points, options, starts, results, finals, patience)
    return results, finals


def _is_inaccurate(results: np.ndarray, options: Options) -> np.ndarray:
    """Return which ok points (n,) exceed the largest error estimate."""
    return (results[:, STATUS] == Status.OK) & (results[:, _ERROR] > options.max_error)


def _is_doubtful(results: np.ndarray, options: Options) -> np.ndarray:
    """Return which points (n,) may need a finer tolerance."""
    violated = results[:, STATUS] == Status.INVARIANT_VIOLATED
    return _is_inaccurate(results, options) | violated


def _finer(options: Options) -> Options:
    """Return the options with a tenth of the tolerances."""
    rtol, stationary = (
        max(0.1 * tolerance, _TIGHTEST) for tolerance in (options.rtol, options.stationary_rtol)
    )
    return replace(options, rtol=rtol, stationary_rtol=stationary)


def _replace_by_better(
    results: np.ndarray,
    finals: np.ndarray,
    rows: np.ndarray,
    new_results: np.ndarray,
    new_finals: np.ndarray,
) -> None:
    """Copy new rows (m, columns) with a result over `rows` (m,) of the old ones; add up periods."""
    before = results[rows, _PERIODS]
    found = np.isin(new_results[:, STATUS], (Status.OK, Status.APERIODIC))
    results[rows[found]], finals[rows[found]] = new_results[found], new_finals[found]
    results[rows, _PERIODS] = before + new_results[:, _PERIODS]


def failed_row(status: Status = Status.FAILED) -> np.ndarray:
    """Return the result row (columns,) of a point that was not computed."""
    row = np.array([RESULTS[name].missing for name in RESULT_COLUMNS], dtype=float)
    row[STATUS] = status
    return row


def stationary_orbit(
    parameters: Parameters | None = None,
    *,
    method: str = DEFAULTS.method,
    rtol: float = DEFAULTS.rtol,
    dt: float = DEFAULTS.dt,
    noise: str = DEFAULTS.noise,
    realizations: int = DEFAULTS.realizations,
    seed: int = DEFAULTS.seed,
    window: int | None = None,
    friction: str = DEFAULTS.friction,
    strain: str = DEFAULTS.strain,
    max_periods: int = DEFAULTS.max_periods,
    max_steps: int | None = DEFAULTS.max_steps,
    max_error: float = DEFAULTS.max_error,
    accelerate: bool = DEFAULTS.accelerate,
    observables: str | Iterable[str] = (),
) -> Orbit:
    """Return the stationary orbit that a motion from the start in `parameters` reaches.

    >>> orbit = stationary_orbit(Parameters(temperature=250))
    >>> orbit.status.name, orbit.regime.name
    ('OK', 'STICK_SLIP_SYMMETRIC')
    >>> round(orbit.friction_force_amplitude, 6)
    0.001322

    Parameters
    ----------
    parameters
        The model's parameters; the paper's Fig. 3 by default.
    method
        'adaptive' (stiff, order 4) or 'euler-cromer' (the paper's explicit scheme, order 1).
    rtol
        Tolerance of the adaptive method and of the stationarity.
    dt
        Step of euler-cromer [s].
    noise
        'typical-path', 'none' for the deterministic equation, or 'stochastic' for the statistics of
        a random ensemble, whose amplitudes are means over single drive periods.
    realizations, seed
        The number of paths of a stochastic film, and the seed of their random numbers.
    window
        Drive periods over which the statistics are taken: 200 by default for an orbit that never
        closes, 32 for each realization.
    friction
        The law of the viscous stress: one of `options.FRICTION_LAWS`, or your own.
    strain
        The elastic strain: 'adiabatic' (Eq. 24) or 'relaxing', an independent variable (Eq. 23).
    max_periods, max_steps
        Budgets of drive periods and of steps.
    max_error
        Largest error estimate of an ok orbit; 1 for any.
    accelerate
        Extrapolate a sequence that clearly contracts instead of iterating it to the end.
    observables
        Groups of result variables, from `variables.OBSERVABLES`. It has no effect: all are
        computed.

    Returns
    -------
    Orbit
        Its `status` says how the search ended; a search that fails raises no exception.

    Raises
    ------
    NoiseError
        phi_0 = 0 without noise.
    OptionError
        An unknown method, treatment, law or observable; a tolerance, step or budget out of range.
    TypeError
        `parameters` is not a `Parameters`.
    """
    options = options_for_orbits(
        method=method,
        rtol=rtol,
        dt=dt,
        max_steps=max_steps,
        max_error=max_error,
        max_periods=max_periods,
        accelerate=accelerate,
        noise=noise,
        realizations=realizations,
        seed=seed,
        window=window,
        friction=friction,
        strain=strain,
        observables=observables,
    )
    results, finals = compute_orbits(np.array(given_or_default(parameters)), options)
    return orbit_of_row(results[0], finals[0])


def orbit_of_row(row: np.ndarray, final: np.ndarray) -> Orbit:
    """Return the Orbit of a result row (columns,) and its final row (columns,)."""
    counts = {name: int for name in RESULT_COLUMNS if RESULTS[name].dtype == "i4"}
    kinds: dict[str, Any] = counts | {
        "status": lambda value: Status(int(value)),
        "regime": lambda value: Regime(int(value)),
    }
    fields = {
        name: kinds.get(name, float)(value)
        for name, value in zip(RESULT_COLUMNS, row.tolist(), strict=True)
    }
    return Orbit(**fields, state=tuple(final[:-1].tolist()))
