"""Run time against error: this package, other solvers, and Euler-Cromer, on the same orbits.

Error of x relative to X_m after three drive periods from the common start, against seconds a period
on one processor, over a ladder of tolerances: for three fluids, and for random points of five.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from curves.ratios import (
    NUMBALSODA_SAMPLE,
    OURS_ENSEMBLE,
    OURS_SAMPLE,
    OURS_SINGLE,
    costs,
    cross_check,
    curve,
    ratios,
)  # fmt: skip
from curves.series import PERIODS, by_peer, in_lanes, one_by_one, reference
from inside.scalar import scalar_end
from peers import NUMBALSODA, PEERS, Worker
from shared.measuring import measure
from shared.points import parameter, random_points
from shared.timing import pin, timed

from stickslip.options import Options
from stickslip.parameters import Parameters

REGIMES = {"gamma=-2/3": -2 / 3, "gamma=0": 0.0, "gamma=2/3": 2 / 3}
FLUIDS = [(f"gamma={gamma:.2f}", gamma) for gamma in (-2 / 3, -1 / 3, 0.0, 1 / 3, 2 / 3)]
TEMPERATURES = 155.0, 280.0
RANDOM_SEED = 58
PAPER_DT = 1e-10


class Plan(NamedTuple):
    """How much is measured; an empty ladder is each solver's own."""

    ladder: tuple[float, ...] = ()
    peers: tuple[str, ...] = tuple(PEERS)
    ensemble: int = 256
    sample: int = 16
    runs: int = 5
    limit: float = 8.0
    random_points: int = 128
    random_runs: int = 2
    euler_cromer_dt: tuple[tuple[float, ...], ...] = ((8e-9, 4e-9), (4e-8, 2e-8), (4e-8, 2e-8))
    euler_cromer_steps: int = 5_000_000


FULL = Plan()
QUICK = Plan(
    ladder=(1e-4, 1e-6),
    peers=tuple(name for name, peer in PEERS.items() if not peer.slow),
    ensemble=16,
    sample=4,
    runs=2,
    limit=3.0,
    random_points=6,
    random_runs=1,
    euler_cromer_dt=((), (1.6e-6, 8e-7), (1.6e-6, 8e-7)),
    euler_cromer_steps=200_000,
)


# --- three fluids ---------------------------------------------------------------------------------


def fluids(quick: bool) -> dict[str, Any]:
    """Measure curves and ratios of three fluids: one trajectory, an ensemble, every peer."""
    pin()
    plan = QUICK if quick else FULL
    workers = {name: Worker(name) for name in plan.peers if PEERS[name].version()}
    try:
        regimes = {
            name: _regime(name, plan, steps, workers)
            for name, steps in zip(REGIMES, plan.euler_cromer_dt, strict=True)
        }
    finally:
        for worker in workers.values():
            worker.close()
    versions = {name: peer.version() or "not installed" for name, peer in PEERS.items()}
    print(*(f"{name}: not installed" for name, v in versions.items() if v == "not installed"))
    return {"periods": PERIODS, "peers": versions, "regimes": regimes}


def _regime(
    name: str, plan: Plan, steps: tuple[float, ...], workers: dict[str, Worker]
) -> dict[str, Any]:
    """Return all curves of one fluid, and the ratios that they give."""
    p = Parameters(rheological_index=REGIMES[name])
    scene, points = np.array([p]), np.tile(p, (plan.ensemble, 1))
    parameter(points, "temperature")[:] = np.linspace(*TEMPERATURES, plan.ensemble)
    sample = points[:: max(plan.ensemble // plan.sample, 1)]
    print(f"\n{name}")
    solvers = {
        OURS_SINGLE: one_by_one(scene),
        OURS_ENSEMBLE: in_lanes(points),
        OURS_SAMPLE: one_by_one(sample),
    }
    for peer, worker in workers.items():
        solvers[peer] = by_peer(peer, worker, scene, plan.limit)
        if peer == NUMBALSODA:
            solvers[NUMBALSODA_SAMPLE] = by_peer(peer, worker, sample, plan.limit)
    curves = {name: curve(name, series, plan.ladder, plan.runs) for name, series in solvers.items()}
    scheme = _euler_cromer(p, steps, plan.euler_cromer_steps)
    return {
        "curves": list(curves.values()),
        "reference": cross_check(list(curves.values())),
        "euler_cromer": scheme,
        "ratios": ratios(curves, scheme),
    }


def _euler_cromer(p: Parameters, ladder: tuple[float, ...], steps: int) -> dict[str, Any]:
    """Return the paper's scheme at larger steps, extrapolated to the paper's, too slow to run."""
    points = [_euler_cromer_run(p, dt) for dt in ladder]
    _euler_cromer_end(p, PAPER_DT, 1000)
    runs = [timed(lambda: _euler_cromer_end(p, PAPER_DT, steps))[1] for _ in range(5)]
    per_step, in_a_period = min(runs) / steps, 2 * math.pi / p.angular_frequency / PAPER_DT
    result = {
        "points": points,
        "dt": PAPER_DT,
        "extrapolated": True,
        "ns_per_step": 1e9 * per_step,
        "timed_part_of_a_period": steps / in_a_period,
        "seconds_per_period": per_step * in_a_period,
        "error": points[-1]["error"] * PAPER_DT / points[-1]["dt"] if points else None,
        "error_ratios_at_half_the_step": [a["error"] / b["error"] for a, b in pairwise(points)],
    }
    print("  Euler-Cromer, extrapolated:", result, flush=True)
    return result


def _euler_cromer_run(p: Parameters, dt: float) -> dict[str, Any]:
    """Return error and time of one run over all periods at `dt`."""
    x, seconds = timed(lambda: _euler_cromer_end(p, dt, None))
    return {
        "dt": dt,
        "error": float(abs(x / abs(p.drive_amplitude) - reference(np.array(p).tobytes())[0])),
        "seconds_per_period": seconds / PERIODS,
        "ns_per_step": 1e9 * seconds / PERIODS / (2 * math.pi / p.angular_frequency / dt),
    }


def _euler_cromer_end(p: Parameters, dt: float, max_steps: int | None) -> float:
    """Return x after all periods, or anything where the steps did not suffice."""
    options = Options(method="euler-cromer", dt=dt, max_steps=max_steps)
    return scalar_end(np.array(p), options, PERIODS)[0]


# --- random points --------------------------------------------------------------------------------


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
    parameter(points, "rheological_index")[:] = gamma
    solvers = {OURS_ENSEMBLE: in_lanes(points)}
    if PEERS[NUMBALSODA].version():
        solvers[NUMBALSODA_SAMPLE] = by_peer(NUMBALSODA, worker, points, plan.limit)
    print(f"\n{len(points)} random points, gamma = {gamma:.2f}")
    curves = {
        name: curve(name, series, plan.ladder, plan.random_runs) for name, series in solvers.items()
    }
    return {"curves": list(curves.values()), "costs": costs(curves)}


if __name__ == "__main__":
    measure("work_precision", __doc__, {"fluids": fluids, "random": random})
