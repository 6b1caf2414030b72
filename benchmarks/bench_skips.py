"""Each thing that is skipped because a scene does not need it: time with and without, and numbers.

All on one core. "On" is what the package does, "off" the same without the skip; the change is the
largest relative difference of an amplitude unless it says otherwise.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import inside
import numpy as np
from common import arguments, column, finish, good, medians_in_turn, parameter
from peers.worker import pin

from stickslip import simulate
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters

FLUIDS = (-2 / 3, 0.0, 2 / 3)
TEMPERATURES = 150.0, 290.0
LIQUID_TEMPERATURES = 299.0, 330.0  # a film at rest melts at 298.2 K
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
    finish("skips", {"points": len(points), "runs": runs, "rows": rows}, quick=quick)


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
    print(f"{skip:66}{1e3 * on:10.2f} ms on {1e3 * off:10.2f} ms off, change {change:.1e}")
    return row | {"change": change} | more


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
    queue = inside.search(points, options)
    symmetric = np.flatnonzero((inside.half_periods(queue) % 2 == 1) & inside.succeeded(queue))
    halves, wholes = inside.chosen(queue, symmetric), inside.chosen(queue, symmetric)
    inside.half_periods(wholes)[:] *= 2
    measures = [
        partial(inside.measured, each, points[symmetric], options) for each in (halves, wholes)
    ]
    change = _relative_change(*(measure()[0] for measure in measures))  # the first calls compile
    on, off = medians_in_turn(measures, runs)
    return _row(
        "symmetric orbit measured over half a period", on, off, change, points=len(symmetric)
    )


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
    with inside.general_kernels():
        return compute_orbits(points, options)


def _compared(skip: str, on: Callable[[], Any], off: Callable[[], Any], runs: int) -> Row:
    """A line from two ways to compute the same orbits; the first calls compile."""
    change = _largest_change(on()[0], off()[0])
    return _row(skip, *medians_in_turn([on, off], runs), change)


# --- stop when stationary -------------------------------------------------------------------------


def _stopping(points: np.ndarray, options: Options, runs: int) -> Iterator[Row]:
    """The search for the orbit, against a fixed number of periods.

    The states are compared. Where the motion settles slowly (gamma >= 0) it is the fixed number
    of periods that is not enough: then the difference is what it still misses.
    """
    for gamma in FLUIDS:
        part = points[parameter(points, "rheological_index") == gamma]
        search = partial(inside.search, part, options)
        travel = partial(inside.end_states, part, FIXED_PERIODS, options)
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
        kernel = inside.kernel_without_noise(gamma)
        without = partial(_ends_by_kernel, kernel, points, options)
        package = partial(_ends, points, options)
        change = float(np.abs(without() - package()).max())
        on, off = medians_in_turn([without, package], runs)
        yield _row(
            f"noise closure left out, gamma = {gamma:.3g} (not in the package)",
            on,
            off,
            change,
            change_of=f"x/X_m after {TWIN_PERIODS} periods",
        )


def _ends(points: np.ndarray, options: Options) -> np.ndarray:
    """x/X_m after TWIN_PERIODS periods, in lanes."""
    states = inside.end_states(points, TWIN_PERIODS, options)[0]
    return states[:, 0] / np.abs(parameter(points, "drive_amplitude"))


def _ends_by_kernel(kernel: Any, points: np.ndarray, options: Options) -> np.ndarray:
    with inside.replaced_kernel(kernel):
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
    ends = np.array([inside.scalar_end(row, options, TWIN_PERIODS)[0] for row in points])
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
        on, off = medians_in_turn([partial(compute_orbits, part, options) for part in parts], runs)
        results = [compute_orbits(part, options)[0] for part in parts]
        stress = float(column(results[0], "elastic_stress_amplitude").max())
        attempts = [inside.attempted(inside.search(part, options)) for part in parts]
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
