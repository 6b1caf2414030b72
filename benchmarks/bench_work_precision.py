"""Run time against error: this package, other solvers, and Euler-Cromer, on the same orbits.

Error of x relative to X_m after three drive periods from the common start, against seconds a period
on one processor, over a ladder of tolerances: for three fluids, and for random points of five.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from curves.paper_scheme import euler_cromer
from curves.ratios import (
    NUMBALSODA_SAMPLE,
    OURS_ENSEMBLE,
    OURS_SAMPLE,
    OURS_SINGLE,
    costs,
    cross_check,
    curve,
    ratios,
)
from curves.series import PERIODS, by_peer, in_lanes, one_by_one
from peers import NUMBALSODA, PEERS, Worker
from shared.measuring import measure
from shared.points import random_points
from shared.timing import pin

from stickslip.parameters import Parameters

REGIMES = {"gamma=-2/3": -2 / 3, "gamma=0": 0.0, "gamma=2/3": 2 / 3}
FLUIDS = [(f"gamma={gamma:.2f}", gamma) for gamma in (-2 / 3, -1 / 3, 0.0, 1 / 3, 2 / 3)]
TEMPERATURES = 155.0, 280.0
RANDOM_SEED = 58


class Plan(NamedTuple):
    """How much is measured; an empty ladder is each solver's own."""

    ladder: tuple[float, ...]
    peers: list[str]
    ensemble: int
    sample: int
    runs: int
    limit: float
    random_points: int
    random_runs: int
    euler_cromer_dt: dict[str, tuple[float, ...]]
    euler_cromer_steps: int


FULL = Plan(
    ladder=(),
    peers=list(PEERS),
    ensemble=256,
    sample=16,
    runs=5,
    limit=8.0,
    random_points=128,
    random_runs=2,
    euler_cromer_dt={
        "gamma=-2/3": (8e-9, 4e-9),
        "gamma=0": (4e-8, 2e-8),
        "gamma=2/3": (4e-8, 2e-8),
    },
    euler_cromer_steps=5_000_000,
)
QUICK = Plan(
    ladder=(1e-4, 1e-6),
    peers=[name for name, peer in PEERS.items() if not peer.slow],
    ensemble=16,
    sample=4,
    runs=2,
    limit=3.0,
    random_points=6,
    random_runs=1,
    euler_cromer_dt={"gamma=-2/3": (), "gamma=0": (1.6e-6, 8e-7), "gamma=2/3": (1.6e-6, 8e-7)},
    euler_cromer_steps=200_000,
)


def fluids(quick: bool) -> dict[str, Any]:
    """Measure curves and ratios of three fluids: one trajectory, an ensemble, every peer."""
    pin()
    plan = QUICK if quick else FULL
    workers = {name: Worker(name) for name in plan.peers if PEERS[name].version()}
    try:
        regimes = {name: _regime(name, plan, workers) for name in REGIMES}
    finally:
        for worker in workers.values():
            worker.close()
    versions = {name: peer.version() or "not installed" for name, peer in PEERS.items()}
    print(*(f"{name}: not installed" for name, v in versions.items() if v == "not installed"))
    return {"periods": PERIODS, "peers": versions, "regimes": regimes}


def _regime(name: str, plan: Plan, workers: dict[str, Worker]) -> dict[str, Any]:
    """Return all curves of one fluid, and the ratios that they give."""
    p = Parameters(rheological_index=REGIMES[name])
    points = _ensemble(p, plan.ensemble)
    sample = points[:: max(plan.ensemble // plan.sample, 1)]
    print(f"\n{name}")
    solvers = {
        OURS_SINGLE: one_by_one(np.array([p])),
        OURS_ENSEMBLE: in_lanes(points),
        OURS_SAMPLE: one_by_one(sample),
    }
    for peer, worker in workers.items():
        solvers[peer] = by_peer(peer, worker, np.array([p]), plan.limit)
        if peer == NUMBALSODA:
            solvers[NUMBALSODA_SAMPLE] = by_peer(peer, worker, sample, plan.limit)
    curves = {name: curve(name, series, plan.ladder, plan.runs) for name, series in solvers.items()}
    scheme = euler_cromer(p, plan.euler_cromer_dt[name], plan.euler_cromer_steps)
    return {
        "curves": list(curves.values()),
        "reference": cross_check(list(curves.values())),
        "euler_cromer": scheme,
        "ratios": ratios(curves, scheme),
    }


def _ensemble(p: Parameters, count: int) -> np.ndarray:
    """Return the scene at so many temperatures, shape (count, parameters)."""
    return np.array([p._replace(temperature=T) for T in np.linspace(*TEMPERATURES, count)])


def random(quick: bool) -> dict[str, Any]:
    """Measure curves of random points of five fluids, against numbalsoda."""
    pin()
    plan = QUICK if quick else FULL
    with Worker(NUMBALSODA) as worker:
        found = {name: _random_fluid(gamma, plan, worker) for name, gamma in FLUIDS}
    return {"seed": RANDOM_SEED, "points": plan.random_points, "fluids": found}


def _random_fluid(gamma: float, plan: Plan, worker: Worker) -> dict[str, Any]:
    """Return the curves of random points of a fluid, and how many times faster than numbalsoda."""
    points = random_points(plan.random_points, RANDOM_SEED)
    points[:, Parameters._fields.index("rheological_index")] = gamma
    solvers = {OURS_ENSEMBLE: in_lanes(points), OURS_SAMPLE: one_by_one(points)}
    if PEERS[NUMBALSODA].version():
        solvers[NUMBALSODA_SAMPLE] = by_peer(NUMBALSODA, worker, points, plan.limit)
    print(f"\n{len(points)} random points, gamma = {gamma:.2f}")
    curves = {
        name: curve(name, series, plan.ladder, plan.random_runs) for name, series in solvers.items()
    }
    return {"curves": list(curves.values()), "costs": costs(curves)}


if __name__ == "__main__":
    measure("work_precision", __doc__, {"fluids": fluids, "random": random})
