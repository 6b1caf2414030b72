"""Each thing that is skipped because a scene does not need it: time with and without, and numbers.

All on one core. "On" is what the package does, "off" the same without the skip; the change is the
largest relative difference of an amplitude unless it says otherwise.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from common import arguments, column, finish, good, medians_in_turn, parameter
from peers.worker import pin

from stickslip import kernels, simulate
from stickslip.ensemble import end_states
from stickslip.kernels.adaptive import driver, passes
from stickslip.kernels.rows import Settings
from stickslip.model.film import melting_temperature
from stickslip.model.scaling import with_gamma
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters, ParameterValues

FLUIDS = (-2 / 3, 0.0, 2 / 3)
TEMPERATURES = 150.0, 290.0
LIQUID_TEMPERATURES = 299.0, 330.0
FIXED_PERIODS = 100
TWIN_PERIODS = 10
SAMPLES = 2000  # a period, where a trajectory is stored
FAINT_STRESS = 1.0  # Pa
RUNS = 5

Row = dict[str, Any]


def main() -> None:
    quick = arguments(__doc__).quick
    pin()
    runs, count = (1, 4) if quick else (RUNS, 64)
    options = Options()
    points = _points(count, TEMPERATURES)
    compute_orbits(points, options)
    rows = [
        _half_period(points, options, runs),
        *_special_kernels(points, options, runs),
        *_stopping(points, options, runs),
        _no_trajectory(points[:: 1 if quick else 8], options, runs),
        *_no_noise(FLUIDS[1:2] if quick else FLUIDS, count, options, runs),
        *_lanes_for_twins(points, options, runs),
        *_liquid_film(count, options, runs),
    ]
    headline = {}
    for row in rows:
        print(_told(row))
        headline[row["skip"]] = f"{row['times_faster']:.3g} times faster; {_change(row)}"
    results = {"headline": headline, "points": len(points), "runs": runs, "rows": rows}
    finish("skips", results, quick=quick)


def _points(count: int, temperatures: tuple[float, float], **others: float) -> np.ndarray:
    """Rows of parameters: so many temperatures of each of the paper's fluids."""
    return np.array(
        [
            Parameters(temperature=T, rheological_index=gamma, **others)
            for gamma in FLUIDS
            for T in np.linspace(*temperatures, count)
        ]
    )


def _row(skip: str, on: float, off: float, change: float, **more: Any) -> Row:
    """A line of the results: seconds with the skip and without, and the change of numbers."""
    row: Row = {"skip": skip, "seconds_on": on, "seconds_off": off, "times_faster": off / on}
    return row | {"change": change} | more


def _told(row: Row) -> str:
    return (
        f"{row['skip']:64}{1e3 * row['seconds_on']:10.2f} ms on {1e3 * row['seconds_off']:10.2f} "
        f"ms off {row['times_faster']:8.2f} times  {_change(row)}"
    )


def _change(row: Row) -> str:
    return f"changes {row.get('change_of', 'the amplitudes')} by {row['change']:.1e}"


def _largest_change(results: np.ndarray, others: np.ndarray) -> float:
    """Largest relative difference of an amplitude of points that are ok."""
    ok = good(results) & good(others)
    return _relative_change(results[ok, :2], others[ok, :2])


def _relative_change(one: np.ndarray, other: np.ndarray) -> float:
    """Largest relative difference; stresses, in the first column, below 1 Pa are as good as 0."""
    return float((np.abs(one - other) / np.maximum(np.abs(other), [FAINT_STRESS, 1e-300])).max())


# --- half a period --------------------------------------------------------------------------------


def _half_period(points: np.ndarray, options: Options, runs: int) -> Row:
    """Symmetric orbits measured over half a period, and over the whole."""
    queue, task = _settled(points, options)
    symmetric = np.flatnonzero((queue.counts[:, passes.CYCLE] % 2 == 1) & _ok(queue))
    halves = _part(queue, symmetric)
    wholes = _part(queue, symmetric)
    wholes.counts[:, passes.CYCLE] *= 2
    task = task._replace(mode=passes.MEASURE)
    measures = [partial(_amplitudes, halves, task), partial(_amplitudes, wholes, task)]
    on, off = medians_in_turn(measures, runs)
    unit = parameter(points, "angular_frequency") / parameter(points, "kinetic_coefficient")
    units = np.column_stack([unit, np.ones(len(points))])[symmetric]
    one, other = (measure() * units for measure in measures)
    change = _relative_change(one, other)
    return _row(
        "symmetric orbit measured over half a period", on, off, change, points=len(symmetric)
    )


def _settled(points: np.ndarray, options: Options) -> tuple[passes.Queue, passes.Pass]:
    """A queue after the search for the orbits, and what the search was."""
    settings = options.settings()
    queue = driver._queue(points)
    task = _search(settings)
    driver._work_through(queue, task)
    return queue, task


def _search(settings: Settings) -> passes.Pass:
    return passes.Pass(
        passes.SETTLE,
        settings.rtol,
        settings.stationary_rtol,
        2 * settings.max_periods,
        settings.max_steps,
        settings.accelerate,
    )


def _ok(queue: passes.Queue) -> np.ndarray:
    return queue.counts[:, passes.OUTCOME] == 0


def _part(queue: passes.Queue, rows: np.ndarray) -> passes.Queue:
    return passes.Queue(*(array[rows] for array in queue))


def _amplitudes(queue: passes.Queue, task: passes.Pass) -> np.ndarray:
    """Amplitudes of stress and force, in the points' units, by one measurement."""
    fresh = passes.Queue(*(array.copy() for array in queue))
    driver._work_through(fresh, task)
    high, low = fresh.measured[:, 0:4:2], fresh.measured[:, 1:4:2]
    odd = fresh.counts[:, passes.CYCLE] % 2 == 1
    return np.where(odd[:, None], np.maximum(high, low), 0.5 * (high + low))


# --- no general power -----------------------------------------------------------------------------


def _special_kernels(points: np.ndarray, options: Options, runs: int) -> Iterator[Row]:
    """The kernels without a power for the paper's fluids, and the general one on these points."""
    for gamma in FLUIDS:
        part = points[parameter(points, "rheological_index") == gamma]
        yield _compared(
            f"no power for gamma = {gamma:.3g}",
            partial(compute_orbits, part, options),
            partial(_by_general_kernel, part, options),
            runs,
        )


def _by_general_kernel(points: np.ndarray, options: Options) -> tuple[np.ndarray, np.ndarray]:
    with _replaced(passes, "SPECIAL_PASSES", {}):
        return compute_orbits(points, options)


def _compared(skip: str, on: Callable[[], Any], off: Callable[[], Any], runs: int) -> Row:
    """A line from two ways to compute the same orbits; the first calls compile."""
    change = _largest_change(on()[0], off()[0])
    return _row(skip, *medians_in_turn([on, off], runs), change)


@contextmanager
def _replaced(module: Any, name: str, value: Any) -> Iterator[None]:
    """A name of a module bound to something else for a while."""
    kept = getattr(module, name)
    setattr(module, name, value)
    try:
        yield
    finally:
        setattr(module, name, kept)


# --- stop when stationary -------------------------------------------------------------------------


def _stopping(points: np.ndarray, options: Options, runs: int) -> Iterator[Row]:
    """The search for the orbit, against a fixed number of periods.

    The states are compared. Where the motion settles slowly (gamma >= 0) it is the fixed number
    of periods that is not enough: then the difference is what it still misses.
    """
    for gamma in FLUIDS:
        part = points[parameter(points, "rheological_index") == gamma]
        search = partial(_settled, part, options)
        travel = partial(end_states, part, FIXED_PERIODS, options)
        on, off = medians_in_turn([search, travel], runs)
        settled = compute_orbits(part, options)[1][:, :2]
        travelled, _, statuses = travel()
        X_m = np.abs(parameter(part, "drive_amplitude"))
        scale = np.column_stack([X_m, X_m * parameter(part, "angular_frequency")])
        distances = (np.abs(settled - travelled[:, :2]) / scale).max(axis=1)[statuses == 0]
        yield _row(
            f"stop when stationary, not after {FIXED_PERIODS} periods, gamma = {gamma:.3g}",
            on,
            off,
            float(np.median(distances)),
            change_of="(x, v) in the median",
            change_max=float(distances.max()),
            points=len(part),
        )


# --- no trajectory --------------------------------------------------------------------------------


def _no_trajectory(points: np.ndarray, options: Options, runs: int) -> Row:
    """Amplitudes alone, all points at once, and stored trajectories of as many periods.

    The amplitudes are compared with those of the samples of a trajectory on the orbit.
    """
    compute = partial(compute_orbits, points, options)
    results = compute()[0]
    periods = column(results, "periods_integrated").astype(int)
    store = partial(_stored, points, periods, options)
    change = 0.0
    for row, result in zip(points, results, strict=True):
        length = int(column(result[None], "orbit_periods")[0])
        ds = _trajectory(row, length, options, start="stationary")
        for i, name in enumerate(("elastic_stress", "friction_force")):
            values = ds[name].values
            change = max(change, abs(0.5 * (values.max() - values.min()) / result[i] - 1.0))
    on, off = medians_in_turn([compute, store], runs)
    return _row("no trajectory stored", on, off, float(change), points=len(points))


def _stored(points: np.ndarray, periods: np.ndarray, options: Options) -> None:
    for row, length in zip(points, periods, strict=True):
        _trajectory(row, int(length), options)


def _trajectory(row: np.ndarray, periods: int, options: Options, **start: Any) -> Any:
    return simulate(
        Parameters(*row), periods=periods, samples_per_period=SAMPLES, rtol=options.rtol, **start
    )


# --- no noise -------------------------------------------------------------------------------------


def _no_noise(fluids: tuple[float, ...], count: int, options: Options, runs: int) -> Iterator[Row]:
    """Films without noise by a kernel without the closure, and by the package's own.

    Here "on" is the kernel without: the package itself has none, and this is what it would save.
    Trajectories and not orbits, because without noise a film that melts may never become
    stationary.
    """
    for gamma in fluids:
        points = _points(count, TEMPERATURES, noise_intensity=0.0, initial_order_parameter=0.1)
        points = points[parameter(points, "rheological_index") == gamma]
        with _replaced(passes, "with_gamma", _without_noise):
            kernel = passes._make_pass(gamma)
            without = partial(_ends_by_kernel, kernel, gamma, points, options)
            x = without()  # compiles, with what was replaced
        package = partial(_ends, points, options)
        on, off = medians_in_turn([without, package], runs)
        yield _row(
            f"noise closure left out, gamma = {gamma:.3g} (not in the package)",
            on,
            off,
            float(np.abs(x - package()).max()),
            change_of=f"x/X_m after {TWIN_PERIODS} periods",
        )


def _ends(points: np.ndarray, options: Options) -> np.ndarray:
    """x/X_m after TWIN_PERIODS periods, in lanes."""
    states = end_states(points, TWIN_PERIODS, options)[0]
    return states[:, 0] / np.abs(parameter(points, "drive_amplitude"))


@passes.inline
def _without_noise(q: passes.Reduced, gamma: float) -> ParameterValues:
    """As `with_gamma`, with a literal D = 0."""
    p = with_gamma(q, gamma)
    return ParameterValues(
        p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9],
        p[10], p[11], p[12], p[13], p[14], p[15], p[16], p[17], p[18], 0.0,
    )  # fmt: skip


def _ends_by_kernel(kernel: Any, gamma: float, points: np.ndarray, options: Options) -> np.ndarray:
    with _replaced(passes, "SPECIAL_PASSES", passes.SPECIAL_PASSES | {gamma: kernel}):
        return _ends(points, options)


# --- lanes ----------------------------------------------------------------------------------------


def _lanes_for_twins(points: np.ndarray, options: Options, runs: int) -> Iterator[Row]:
    """Trajectories side by side in lanes, and one by one by the scalar twin."""
    for gamma in FLUIDS:
        part = points[parameter(points, "rheological_index") == gamma]
        together, one_by_one = partial(_ends, part, options), partial(_scalar_ends, part, options)
        change = float(np.abs(together() - one_by_one()).max())
        on, off = medians_in_turn([together, one_by_one], runs)
        yield _row(
            f"lanes for the scalar twin, gamma = {gamma:.3g}",
            on,
            off,
            change,
            change_of=f"x/X_m after {TWIN_PERIODS} periods",
        )


def _scalar_ends(points: np.ndarray, options: Options) -> np.ndarray:
    settings, samples = options.settings(), np.empty((TWIN_PERIODS + 1, 3))
    start, ends = np.empty(3), np.empty(len(points))
    for i, row in enumerate(points):
        kernels.starting_log_state(row, start)
        kernels.adaptive_trajectory(row, settings, start, 1, samples)
        ends[i] = samples[-1, 0]
    return ends / np.abs(parameter(points, "drive_amplitude"))


# --- a film that is never solid -------------------------------------------------------------------


def _liquid_film(count: int, options: Options, runs: int) -> Iterator[Row]:
    """Points above the melting temperature, where phi does nothing, against those below.

    The package integrates phi there as everywhere. "Change" is the largest stress in Pa, which
    two equations instead of three would make 0.
    """
    for gamma in FLUIDS:
        parts = [
            points[parameter(points, "rheological_index") == gamma]
            for points in (_points(count, LIQUID_TEMPERATURES), _points(count, TEMPERATURES))
        ]
        p = Parameters()
        melts = melting_temperature.py_func(
            0.0, p.thermal_coefficient, p.critical_temperature, p.elastic_coefficient,
            p.cubic_coefficient, p.quartic_coefficient,
        )  # fmt: skip
        assert LIQUID_TEMPERATURES[0] > melts > TEMPERATURES[1]
        on, off = medians_in_turn([partial(compute_orbits, part, options) for part in parts], runs)
        results = [compute_orbits(part, options)[0] for part in parts]
        stress = float(column(results[0], "elastic_stress_amplitude").max())
        attempts = [
            int(np.sum(_settled(part, options)[0].counts[:, passes.ATTEMPTED])) for part in parts
        ]
        yield _row(
            f"film never solid, gamma = {gamma:.3g}, against solid",
            on,
            off,
            stress,
            change_of="a stress of 0 Pa",
            attempts_of_the_search=attempts,
            periods_median=[
                statistics.median(column(result, "periods_integrated")) for result in results
            ],
        )


if __name__ == "__main__":
    main()
