"""Run time against error: this package, other solvers, and Euler-Cromer, on the same orbits.

Part one: error of x relative to X_m after three drive periods from the common start, against
seconds per period on one processor, for three fluids and a ladder of tolerances. Part two: the
same on random points of five fluids, against numbalsoda. Benchmarks/README.md says how to read the
numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from common import arguments, finish, random_points
from parts.curves import (
    NUMBALSODA_SAMPLE,
    OURS_ENSEMBLE,
    OURS_SAMPLE,
    OURS_SINGLE,
    costs,
    cross_check,
    curve,
    ratios,
)
from parts.paper_scheme import euler_cromer
from parts.series import PERIODS, by_peer, in_lanes, one_by_one
from peers import NUMBALSODA, PEERS, Worker
from peers.worker import pin

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


def main() -> None:
    quick = arguments(__doc__).quick
    plan = QUICK if quick else FULL
    pin()
    workers = {name: Worker(name) for name in plan.peers if PEERS[name].version()}
    try:
        results = {
            "periods": PERIODS,
            "peers": {name: peer.version() or "not installed" for name, peer in PEERS.items()},
            "regimes": {name: _regime(name, plan, workers) for name in REGIMES},
            "random": {
                "seed": RANDOM_SEED,
                "points": plan.random_points,
                "fluids": {name: _random_fluid(gamma, plan, workers) for name, gamma in FLUIDS},
            },
        }
    finally:
        for worker in workers.values():
            worker.close()
    for name, version in results["peers"].items():
        if version == "not installed":
            print(f"{name}: not installed")
    finish("work_precision", results, quick=quick)


# --- part one: three fluids -----------------------------------------------------------------------


def _regime(name: str, plan: Plan, workers: dict[str, Worker]) -> dict[str, Any]:
    """All curves of one fluid, and the ratios that they give."""
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
    """The scene at so many temperatures, shape (count, parameters)."""
    return np.array([p._replace(temperature=T) for T in np.linspace(*TEMPERATURES, count)])


# --- part two: random points of five fluids -------------------------------------------------------


def _random_fluid(gamma: float, plan: Plan, workers: dict[str, Worker]) -> dict[str, Any]:
    """The curves of random points of a fluid, and how many times faster than numbalsoda."""
    points = random_points(plan.random_points, RANDOM_SEED)
    points[:, Parameters._fields.index("rheological_index")] = gamma
    solvers = {OURS_ENSEMBLE: in_lanes(points), OURS_SAMPLE: one_by_one(points)}
    if NUMBALSODA in workers:
        solvers[NUMBALSODA_SAMPLE] = by_peer(NUMBALSODA, workers[NUMBALSODA], points, plan.limit)
    print(f"\n{len(points)} random points, gamma = {gamma:.2f}")
    curves = {
        name: curve(name, series, plan.ladder, plan.random_runs) for name, series in solvers.items()
    }
    return {"curves": list(curves.values()), "costs": costs(curves)}


if __name__ == "__main__":
    main()
