"""What optional physics costs a point: sixth order, a strain that relaxes, stochastic noise."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from shared.measuring import measure
from shared.points import drawn, orbits, parameter
from shared.timing import medians_in_turn, pin, timed

from stickslip.options import RELAXING, STOCHASTIC, Options, default_window
from stickslip.orbit import compute_orbits, typical_options
from stickslip.parameters import Parameters

FLUIDS = (-2 / 3, 0.0, 2 / 3)
COUNT, RUNS = 400, 7
ENSEMBLE_RUNS = 5
DROPPED = 5
"""Periods of an ensemble before those that count."""

Row = dict[str, Any]


def prices(quick: bool) -> dict[str, Any]:
    """Time a point of each fluid and model on one core, the models in turn."""
    pin()
    fluids, count, runs = (FLUIDS[:1], 16, 1) if quick else (FLUIDS, COUNT, RUNS)
    return {"points": count, "fluids": [_prices(gamma, count, runs) for gamma in fluids]}


def _prices(gamma: float, count: int, runs: int) -> Row:
    """Time the models; terms of sixth order are so small that the orbits are the same."""
    points = drawn(count, 7, partial(_film, gamma))
    sextic = points.copy()
    parameter(sextic, "sextic_coefficient")[:] = 1e-9
    models = {
        "default": partial(orbits, points),
        "sixth order": partial(orbits, sextic),
        "relaxing strain": partial(orbits, points, strain=RELAXING),
    }
    settled = {name: int(compute().ok.sum()) for name, compute in models.items()}
    seconds = medians_in_turn(list(models.values()), runs)
    microseconds = {name: 1e6 * s / count for name, s in zip(models, seconds, strict=True)}
    return {"gamma": gamma, "microseconds": microseconds, "settled": settled}


def _film(gamma: float, rng: np.random.Generator, _: int) -> Parameters:
    return Parameters(
        temperature=rng.uniform(150.0, 310.0),
        viscosity_coefficient=10.0 ** rng.uniform(4.0, 5.3),
        spring_stiffness=10.0 ** rng.uniform(2.7, 4.0),
        angular_frequency=10.0 ** rng.uniform(0.7, 1.7),
        rheological_index=gamma,
    )


def ensembles(quick: bool) -> Row:
    """Time ensembles of stochastic films."""
    realizations = 8 if quick else Options().realizations
    noisy = Options(noise=STOCHASTIC, realizations=realizations, window=default_window(STOCHASTIC))
    return {"prices": [_price(gamma, noisy) for gamma in (FLUIDS[:1] if quick else FLUIDS)]}


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
    microseconds = 1e6 * (whole - part) / periods
    times = {"microseconds": microseconds, "seconds": whole, "typical_seconds": alone}
    return {"gamma": gamma} | times


if __name__ == "__main__":
    measure("physics", __doc__, {"prices": prices, "ensembles": ensembles})
