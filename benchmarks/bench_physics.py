"""What optional physics cost a point, and how much they change: Eq. 23 against Eq. 24.

Times are those of `compute_orbits` on one core, the models in turn; the films with terms of sixth
order are those of the paper with coefficients so small that they change nothing visible, so that
the same orbits are computed.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from common import AMPLITUDES, arguments, finish, good, medians_in_turn
from peers.worker import pin

from stickslip.options import ADIABATIC, RELAXING, Options
from stickslip.orbit import compute_orbits, stationary_orbit
from stickslip.parameters import Parameters

FLUIDS = (-2 / 3, 0.0, 2 / 3)
COUNT, RUNS = 400, 7
TIMES = tuple(10.0**power for power in range(-8, 0))
TIGHT = 1e-12

Row = dict[str, Any]


def main() -> None:
    quick = arguments(__doc__).quick
    pin()
    count, runs = (16, 1) if quick else (COUNT, RUNS)
    fluids, times = (FLUIDS[:1], TIMES[:2]) if quick else (FLUIDS, TIMES)
    results = {
        "points": count,
        "runs": runs,
        "prices": [_prices(gamma, count, runs) for gamma in fluids],
        "relaxation": [_differences(tau) for tau in times],
    }
    finish("physics", results, quick=quick)


def _prices(gamma: float, count: int, runs: int) -> Row:
    """Microseconds a point of a fluid with each model, and which points all of them settle."""
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
    plain = Options()
    models = {
        "default": (points, plain),
        "sixth order": (sextic, plain),
        "relaxing strain": (points, replace(plain, strain=RELAXING)),
    }
    settled = {name: int(good(compute_orbits(*model)[0]).sum()) for name, model in models.items()}
    seconds = medians_in_turn([partial(compute_orbits, *model) for model in models.values()], runs)
    prices = {name: 1e6 * value / count for name, value in zip(models, seconds, strict=True)}
    print(f"gamma {gamma:6.3f}", {name: round(price, 1) for name, price in prices.items()}, settled)
    return {"gamma": gamma, "microseconds": prices, "settled": settled}


def _differences(tau: float) -> Row:
    """Relative changes of the amplitudes from Eq. 24 to Eq. 23, thickness in proportion to tau.

    The viscous stress stays as it is.
    """
    h, p = 0.1 * tau, Parameters()
    k = p.viscosity_coefficient * (h / p.film_thickness) ** (p.rheological_index + 1.0)
    film = p._replace(film_thickness=h, strain_relaxation_time=tau, viscosity_coefficient=k)
    before, after = (
        stationary_orbit(film, strain=strain, rtol=TIGHT) for strain in (ADIABATIC, RELAXING)
    )
    changes = {name: getattr(after, name) / getattr(before, name) - 1.0 for name in AMPLITUDES}
    print(f"tau {tau:.0e} s", changes, after.status.name)
    return {"tau": tau, "status": after.status.name} | changes


if __name__ == "__main__":
    main()
