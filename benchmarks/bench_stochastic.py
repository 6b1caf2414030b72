"""The stochastic film: its ensembles beside plain Euler-Maruyama and beside the typical path.

At omega = 15 rad/s, where the film may freeze sooner or later and single drive periods differ, the
largest elastic stress of a period is compared with that of an independent computation
(`euler_maruyama.py`). Over omega the typical path is compared with the ensembles.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np
from common import AMPLITUDES, arguments, column, finish, medians_in_turn, timed
from euler_maruyama import single_periods

from stickslip.kernels.adaptive import driver
from stickslip.kernels.streams import streams_of
from stickslip.measure.accumulate import STRESS_MAX
from stickslip.options import STOCHASTIC, Options, default_window
from stickslip.orbit import compute_orbits, typical_options
from stickslip.parameters import Parameters

STEP = 2e-9  # s
PATHS, PERIODS, DROPPED = 4, 30, 5
FREQUENCIES = np.arange(5.0, 45.01, 0.5)
FLUIDS = (-2 / 3, 0.0, 2 / 3)
RUNS = 5

Row = dict[str, Any]


def main() -> None:
    quick = arguments(__doc__).quick
    paths, periods, step = (1, 7, 1e-8) if quick else (PATHS, PERIODS, STEP)
    frequencies = FREQUENCIES[20:22] if quick else FREQUENCIES
    realizations = 8 if quick else Options().realizations
    chance = Options(noise=STOCHASTIC, realizations=realizations, window=default_window(STOCHASTIC))
    results = {
        "options": asdict(chance),
        "euler_maruyama": _euler_maruyama(paths, periods, step),
        "ensemble": _largest_stresses(Parameters(angular_frequency=15.0), chance),
        "steady": _steady(chance),
        "closure": _over_frequencies(frequencies, chance),
        "prices": [_price(gamma, chance) for gamma in FLUIDS[: 1 if quick else None]],
    }
    finish("stochastic", results, quick=quick)


def _euler_maruyama(paths: int, periods: int, step: float) -> Row:
    """Largest stresses of single periods of paths from the settled typical path at omega = 15."""
    p = Parameters(angular_frequency=15.0)
    _, finals = compute_orbits(np.array([p]), Options())
    start = np.array([finals[0, 0], finals[0, 1], math.exp(finals[0, 2])])

    def path(number: int) -> np.ndarray:
        kicks = np.random.default_rng(number)
        return single_periods(np.array(p), step, start, kicks, periods)[DROPPED:, 0]

    single_periods(np.array(p), 1e-4, start, np.random.default_rng(0), 1)  # compiled
    with ThreadPoolExecutor(2) as pool:
        singles, seconds = timed(lambda: np.concatenate([*pool.map(path, range(paths))]))
    return {"step": step, "seconds": seconds} | _told("Euler-Maruyama", singles)


def _largest_stresses(p: Parameters, options: Options) -> Row:
    """The same by the ensemble."""
    point = np.array([p])
    results, finals = compute_orbits(point, typical_options(options))
    paths = options.realizations
    walk = driver.stochastic_walk(
        np.repeat(point, paths, axis=0),
        np.repeat(finals, paths, axis=0),
        streams_of(point, options),
        options,
    )
    records = [walk.next_period()[:, STRESS_MAX] for _ in range(DROPPED + options.window)]
    told = _told("ensemble", np.concatenate(records[DROPPED:]))
    return told | {"typical_path": float(column(results, "elastic_stress_max")[0])}


def _told(what: str, singles: np.ndarray) -> Row:
    mean, spread = float(singles.mean()), float(singles.std(ddof=1))
    error = spread / math.sqrt(len(singles))
    print(f"{what}: {mean:.6g} +- {error:.2g} Pa, spread {spread:.3g} Pa, {len(singles)} periods")
    return {"mean": mean, "standard_error": error, "spread": spread, "periods": len(singles)}


def _steady(options: Options) -> Row:
    """Spread and change at omega = 10, where the film freezes at each stop."""
    point = np.array([Parameters()])
    chance, _ = compute_orbits(point, options)
    typical, _ = compute_orbits(point, typical_options(options))
    stress = column(typical, AMPLITUDES[0])[0]
    return {
        "spread": float(column(chance, f"{AMPLITUDES[0]}_spread")[0] / stress),
        "change": float(column(chance, AMPLITUDES[0])[0] / stress - 1.0),
    }


def _over_frequencies(frequencies: np.ndarray, options: Options) -> list[Row]:
    """Amplitudes of the typical path and of the ensembles over the frequency of the drive."""
    points = np.array([Parameters(angular_frequency=omega) for omega in frequencies])
    (chance, _), seconds = timed(lambda: compute_orbits(points, options))
    typical, _ = compute_orbits(points, typical_options(options))
    print(f"{len(points)} ensembles in {seconds:.1f} s")
    names = [*AMPLITUDES, *(f"{name}_spread" for name in AMPLITUDES), "amplitude_error", "status"]
    return [
        {"omega": float(omega)}
        | {name: float(column(chance, name)[i]) for name in names}
        | {f"typical_{name}": float(column(typical, name)[i]) for name in (*AMPLITUDES, "status")}
        for i, omega in enumerate(frequencies)
    ]


def _price(gamma: float, options: Options) -> Row:
    """Microseconds of a drive period of a realization, and of one of the search's measurement."""
    point = np.array([Parameters(angular_frequency=15.0, rheological_index=gamma)])
    few = replace(options, realizations=max(options.realizations // 4, 1))
    calls = [partial(compute_orbits, point, some) for some in (options, few)]
    for call in calls:
        call()
    whole, part = medians_in_turn(calls, RUNS)
    periods = (options.realizations - few.realizations) * (DROPPED + options.window)
    price = 1e6 * (whole - part) / periods
    _, alone = timed(lambda: compute_orbits(point, typical_options(options)))
    print(
        f"gamma {gamma:6.3f}: {price:.1f} us a period, {whole:.3f} s a point, {alone:.4f} s typical"
    )
    return {"gamma": gamma, "microseconds": price, "seconds": whole, "typical_seconds": alone}


if __name__ == "__main__":
    main()
