"""What optional physics costs a point, and how much it changes.

Terms of sixth order and a strain that relaxes (Eq. 23 against Eq. 24); stochastic noise, whose
ensembles are compared with plain Euler-Maruyama (`shared/euler_maruyama.py`) and with the typical
path.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from shared.euler_maruyama import single_periods
from shared.measuring import measure
from shared.points import AMPLITUDES, column, good
from shared.timing import medians_in_turn, pin, timed

from stickslip.kernels.adaptive import driver
from stickslip.kernels.streams import streams_of
from stickslip.measure.accumulate import STRESS_MAX
from stickslip.options import ADIABATIC, RELAXING, STOCHASTIC, Options, default_window
from stickslip.orbit import compute_orbits, stationary_orbit, typical_options
from stickslip.parameters import Parameters

FLUIDS = (-2 / 3, 0.0, 2 / 3)
COUNT, RUNS = 400, 7
TIMES = tuple(10.0**power for power in range(-8, 0))
TIGHT = 1e-12

STEP = 2e-9  # s, of Euler-Maruyama
PATHS, PERIODS, DROPPED = 4, 30, 5
FREQUENCIES = np.arange(5.0, 45.01, 0.5)
ENSEMBLE_RUNS = 5

Row = dict[str, Any]


# --- sixth order, a strain that relaxes -----------------------------------------------------------


def prices(quick: bool) -> dict[str, Any]:
    """Time a point of each fluid and model on one core, the models in turn."""
    pin()
    fluids, count, runs = (FLUIDS[:1], 16, 1) if quick else (FLUIDS, COUNT, RUNS)
    return {"points": count, "fluids": [_prices(gamma, count, runs) for gamma in fluids]}


def _prices(gamma: float, count: int, runs: int) -> Row:
    """Time the models; terms of sixth order are so small that the orbits are the same."""
    rng = np.random.default_rng(7)
    films = [
        Parameters(
            temperature=rng.uniform(150.0, 310.0),
            viscosity_coefficient=10.0 ** rng.uniform(4.0, 5.3),
            spring_stiffness=10.0 ** rng.uniform(2.7, 4.0),
            angular_frequency=10.0 ** rng.uniform(0.7, 1.7),
            rheological_index=gamma,
        )
        for _ in range(count)
    ]
    points = np.array(films)
    sextic = np.array([film._replace(sextic_coefficient=1e-9) for film in films])
    models = {
        "default": (points, Options()),
        "sixth order": (sextic, Options()),
        "relaxing strain": (points, Options(strain=RELAXING)),
    }
    settled = {name: int(good(compute_orbits(*model)[0]).sum()) for name, model in models.items()}
    seconds = medians_in_turn([partial(compute_orbits, *model) for model in models.values()], runs)
    microseconds = {name: 1e6 * s / count for name, s in zip(models, seconds, strict=True)}
    print(f"gamma {gamma:.3f}", microseconds, settled)
    return {"gamma": gamma, "microseconds": microseconds, "settled": settled}


def relaxation(quick: bool) -> dict[str, Any]:
    """Compute the changes of the amplitudes from Eq. 24 to Eq. 23 over the relaxation time."""
    return {"rows": [_difference(tau) for tau in (TIMES[:2] if quick else TIMES)]}


def _difference(tau: float) -> Row:
    """Return relative changes, the thickness in proportion to tau, viscous stress the same."""
    h, p = 0.1 * tau, Parameters()
    k = p.viscosity_coefficient * (h / p.film_thickness) ** (p.rheological_index + 1.0)
    film = p._replace(film_thickness=h, strain_relaxation_time=tau, viscosity_coefficient=k)
    before, after = (
        stationary_orbit(film, strain=strain, rtol=TIGHT) for strain in (ADIABATIC, RELAXING)
    )
    changes = {name: getattr(after, name) / getattr(before, name) - 1.0 for name in AMPLITUDES}
    print(f"tau {tau:.0e} s", changes, after.status.name)
    return {"tau": tau, "status": after.status.name} | changes


# --- stochastic noise -----------------------------------------------------------------------------


def ensembles(quick: bool) -> dict[str, Any]:
    """Compare ensembles with Euler-Maruyama and the typical path, and time them."""
    paths, periods, step = (1, 7, 1e-8) if quick else (PATHS, PERIODS, STEP)
    frequencies, fluids = (FREQUENCIES[20:22], FLUIDS[:1]) if quick else (FREQUENCIES, FLUIDS)
    realizations = 8 if quick else Options().realizations
    noisy = Options(noise=STOCHASTIC, realizations=realizations, window=default_window(STOCHASTIC))
    return {
        "euler_maruyama": _euler_maruyama(paths, periods, step),
        "ensemble": _largest_stresses(Parameters(angular_frequency=15.0), noisy),
        "closure": _over_frequencies(frequencies, noisy),
        "prices": [_price(gamma, noisy) for gamma in fluids],
    }


def _euler_maruyama(paths: int, periods: int, step: float) -> Row:
    """Return largest stresses of single periods from the settled typical path at omega = 15.

    There the film may freeze sooner or later, and single drive periods differ.
    """
    p = Parameters(angular_frequency=15.0)
    _, finals = compute_orbits(np.array([p]), Options())
    start = np.array([finals[0, 0], finals[0, 1], math.exp(finals[0, 2])])

    def path(number: int) -> np.ndarray:
        kicks = np.random.default_rng(number)
        return single_periods(np.array(p), step, start, kicks, periods)[DROPPED:, 0]

    single_periods(np.array(p), 1e-4, start, np.random.default_rng(0), 1)  # compiled
    with ThreadPoolExecutor(2) as pool:
        singles = np.concatenate([*pool.map(path, range(paths))])
    return {"step": step} | _statistics("Euler-Maruyama", singles)


def _largest_stresses(p: Parameters, options: Options) -> Row:
    """Return the same by the ensemble."""
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
    row = _statistics("ensemble", np.concatenate(records[DROPPED:]))
    return row | {"typical_path": float(column(results, "elastic_stress_max")[0])}


def _statistics(what: str, singles: np.ndarray) -> Row:
    mean, spread = float(singles.mean()), float(singles.std(ddof=1))
    error = spread / math.sqrt(len(singles))
    print(f"{what}: {mean:.6g} +- {error:.2g} Pa, spread {spread:.3g} Pa, {len(singles)} periods")
    return {"mean": mean, "standard_error": error, "spread": spread, "periods": len(singles)}


def _over_frequencies(frequencies: np.ndarray, options: Options) -> list[Row]:
    """Return amplitudes of typical path and ensembles over the frequency of the drive."""
    points = np.array([Parameters(angular_frequency=omega) for omega in frequencies])
    noisy, _ = compute_orbits(points, options)
    typical, _ = compute_orbits(points, typical_options(options))
    names = [*AMPLITUDES, *(f"{name}_spread" for name in AMPLITUDES), "amplitude_error", "status"]
    return [
        {"omega": float(omega)}
        | {name: float(column(noisy, name)[i]) for name in names}
        | {f"typical_{name}": float(column(typical, name)[i]) for name in (*AMPLITUDES, "status")}
        for i, omega in enumerate(frequencies)
    ]


def _price(gamma: float, options: Options) -> Row:
    """Return microseconds of a drive period of a realization, and seconds of a point."""
    point = np.array([Parameters(angular_frequency=15.0, rheological_index=gamma)])
    few = replace(options, realizations=max(options.realizations // 4, 1))
    calls = [partial(compute_orbits, point, some) for some in (options, few)]
    for call in calls:
        call()
    whole, part = medians_in_turn(calls, ENSEMBLE_RUNS)
    periods = (options.realizations - few.realizations) * (DROPPED + options.window)
    _, alone = timed(lambda: compute_orbits(point, typical_options(options)))
    row = {"gamma": gamma, "microseconds": 1e6 * (whole - part) / periods}
    row |= {"seconds": whole, "typical_seconds": alone}
    print(row)
    return row


if __name__ == "__main__":
    parts = (prices, relaxation, ensembles)
    measure("physics", __doc__, {part.__name__: part for part in parts})
