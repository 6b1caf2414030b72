"""Run time against error: this package, other solvers, and Euler-Cromer, on the same orbits.

Part one: error of x relative to X_m after three drive periods from the common start, against
seconds per period on one processor, for three fluids and a ladder of tolerances. Part two: the
same on random points. Benchmarks/README.md says how to read the numbers.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from functools import cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from common import random_points
from environment import write_results
from peers import LADDER, NUMBALSODA, PEERS, Failure, State, Worker
from peers.worker import pin

from stickslip import kernels
from stickslip.ensemble import end_states
from stickslip.options import Options
from stickslip.parameters import Parameters

PERIODS = 3
REFERENCE_RTOL = 1e-12
REGIMES = {"gamma=-2/3": -2 / 3, "gamma=0": 0.0, "gamma=2/3": 2 / 3}
TARGETS = (1e-4, 1e-6, 1e-8)
TOLERATED = 0.1  # part of an ensemble that may fail before the run is no point of the curve
TEMPERATURES = 155.0, 280.0
OURS_SINGLE, OURS_ENSEMBLE = "ours, single trajectory", "ours, ensemble"
OURS_SAMPLE, NUMBALSODA_SAMPLE = "ours, one at a time", f"{NUMBALSODA}, one at a time"

# Ours reaches an error of 1e-4 at tolerances that are looser than those of the peers.
OWN_LADDER = (1e-2, 3e-3, *LADDER)

PAPER_DT = 1e-10
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
    random_ladder: tuple[float, ...]
    euler_cromer_dt: dict[str, tuple[float, ...]]
    euler_cromer_steps: int


FULL = Plan(
    ladder=(),
    peers=list(PEERS),
    ensemble=256,
    sample=16,
    runs=5,
    limit=8.0,
    random_points=50,
    random_ladder=(1e-4, 1e-6, 1e-8),
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
    random_ladder=(1e-6,),
    euler_cromer_dt={"gamma=-2/3": (), "gamma=0": (1.6e-6, 8e-7), "gamma=2/3": (1.6e-6, 8e-7)},
    euler_cromer_steps=200_000,
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer tolerances, no slow peers")
    quick = parser.parse_args().quick
    plan = QUICK if quick else FULL
    pin()
    workers = {name: Worker(name) for name in plan.peers if PEERS[name].version()}
    try:
        results = {
            "quick": quick,
            "periods": PERIODS,
            "peers": {name: peer.version() or "not installed" for name, peer in PEERS.items()},
            "regimes": {name: _regime(name, plan, workers) for name in REGIMES},
            "random": _random_points(plan, workers),
        }
    finally:
        for worker in workers.values():
            worker.close()
    for name, version in results["peers"].items():
        if version == "not installed":
            print(f"{name}: not installed")
    print(write_results("quick/work_precision" if quick else "work_precision", results))


# --- part one: three fluids -----------------------------------------------------------------------


def _regime(name: str, plan: Plan, workers: dict[str, Worker]) -> dict[str, Any]:
    """All curves of one fluid, and the ratios that they give."""
    p = Parameters(rheological_index=REGIMES[name])
    points = _ensemble(p, plan.ensemble)
    sample = points[:: max(plan.ensemble // plan.sample, 1)]
    print(f"\n{name}")
    curves = [
        _curve(OURS_SINGLE, _one_by_one(np.array([p])), plan),
        _curve(OURS_ENSEMBLE, _in_lanes(points), plan),
        _curve(OURS_SAMPLE, _one_by_one(sample), plan),
    ]
    for peer, worker in workers.items():
        curves.append(_curve(peer, _by_peer(peer, worker, np.array([p]), plan), plan))
        if peer == NUMBALSODA:
            curves.append(_curve(NUMBALSODA_SAMPLE, _by_peer(peer, worker, sample, plan), plan))
    curve_of = {curve["solver"]: curve for curve in curves}
    euler_cromer = _euler_cromer(p, plan.euler_cromer_dt[name], plan.euler_cromer_steps)
    return {
        "curves": curves,
        "reference": _cross_check(curves),
        "euler_cromer": euler_cromer,
        "ratios": _ratios(curve_of, euler_cromer),
    }


def _ensemble(p: Parameters, count: int) -> np.ndarray:
    """The scene at so many temperatures, shape (count, 20)."""
    return np.array([p._replace(temperature=T) for T in np.linspace(*TEMPERATURES, count)])


class Run(NamedTuple):
    """End positions (n,) in X_m, NaN where a point failed; seconds per period; timings; why."""

    x: np.ndarray
    seconds: np.ndarray
    runs: int
    reason: str = ""
    out_of_time: bool = False


class Series(NamedTuple):
    """A solver bound to its points: their number, reference, the run at a tolerance, tolerances."""

    points: int
    reference: np.ndarray
    run: Callable[[float, int], Run]
    ladder: tuple[float, ...] = OWN_LADDER


def _curve(solver: str, series: Series, plan: Plan) -> dict[str, Any]:
    """The measured points of one solver over the ladder, and what failed."""
    points: list[dict[str, Any]] = []
    failures: list[dict[str, Any]] = []
    given_up = False
    for rtol in plan.ladder or series.ladder:
        if given_up:
            reason = "not tried: did not finish at a looser tolerance"
            failures.append({"rtol": rtol, "reason": reason})
            continue
        run = series.run(rtol, plan.runs)
        given_up = run.out_of_time
        errors = np.abs(run.x - series.reference)
        good = errors <= 1.0
        reason = _complaint(good, run.reason)
        if reason:
            failures.append({"rtol": rtol, "reason": reason})
            print(f"  {solver:34}{rtol:8.0e}  {reason}", flush=True)
            continue
        point = {
            "rtol": rtol,
            "error": float(np.median(np.where(good, errors, np.inf))),
            "error_95": float(np.percentile(errors[good], 95)),
            "seconds_per_period": float(np.nanmean(run.seconds)),
            "runs": run.runs,
            "failed": int((~good).sum()),
        }
        points.append(point)
        _print_point(solver, point)
    return {"solver": solver, "members": series.points, "points": points, "failures": failures}


def _complaint(good: np.ndarray, reason: str) -> str:
    """Why a run is no point of a curve: too many members failed or are wrong; '' if it is one."""
    bad = int((~good).sum())
    if bad <= TOLERATED * len(good):
        return ""
    reason = reason or "error larger than 1"
    return reason if len(good) == 1 else f"fails on {bad} of {len(good)} points: {reason}"


def _print_point(solver: str, point: dict[str, Any]) -> None:
    milliseconds = 1e3 * point["seconds_per_period"]
    failed = f", {point['failed']} failed" if point["failed"] else ""
    print(
        f"  {solver:34}{point['rtol']:8.0e}{milliseconds:12.4f} ms per period"
        f"   error {point['error']:.1e} (95 %: {point['error_95']:.1e}){failed}",
        flush=True,
    )


# --- the solvers ----------------------------------------------------------------------------------


def _one_by_one(points: np.ndarray) -> Series:
    """The scalar code of this package, one call a point."""

    def run(rtol: float, runs: int) -> Run:
        settings = Options(rtol=rtol).settings()
        x = [_end(row, settings) for row in points]
        timed = [_shortest(partial(_end, row, settings), runs) for row in points]
        seconds = np.array([seconds for seconds, _ in timed]) / PERIODS
        return Run(_scaled(points, x), seconds, min(n for _, n in timed), "status not ok")

    return Series(len(points), _reference(points.tobytes()), run)


@cache
def _reference(rows: bytes) -> np.ndarray:
    """End positions in X_m by the scalar code at the reference's tolerance."""
    points = np.frombuffer(rows).reshape(-1, len(Parameters._fields))
    settings = Options(rtol=REFERENCE_RTOL).settings()
    return _scaled(points, [_end(row, settings) for row in points])


def _end(row: np.ndarray, settings: kernels.Settings) -> float:
    """x after all periods by the scalar code; NaN where it fails."""
    samples = np.empty((PERIODS + 1, 3))
    status = kernels.adaptive_trajectory(row, settings, np.array(_start(row)), 1, samples)
    return float(samples[-1, 0]) if status == 0 else math.nan


def _in_lanes(points: np.ndarray) -> Series:
    """The ensemble code of this package, on one processor."""

    def end(rtol: float) -> np.ndarray:
        states, _, statuses = end_states(points, PERIODS, Options(rtol=rtol))
        return np.where(statuses == 0, states[:, 0], np.nan)

    def run(rtol: float, runs: int) -> Run:
        x = end(rtol)
        seconds, done = _shortest(lambda: end(rtol), runs)
        each = np.array([seconds / (len(points) * PERIODS)])
        return Run(_scaled(points, x), each, done, "status not ok")

    return Series(len(points), _reference(points.tobytes()), run)


def _by_peer(name: str, worker: Worker, points: np.ndarray, plan: Plan) -> Series:
    """A peer, one call a point."""

    def run(rtol: float, runs: int) -> Run:
        x, seconds, done, last = [], [], runs, Failure("")
        for row in points:
            p = Parameters(*row)
            answer = worker.measure(p, _start(row), PERIODS, rtol, limit=plan.limit, runs=runs)
            if isinstance(answer, Failure):
                last = answer
                x.append(math.nan)
                seconds.append(math.nan)
            else:
                x.append(answer.state[0])
                seconds.append(answer.seconds / PERIODS)
                done = min(done, answer.runs)
        return Run(_scaled(points, x), np.array(seconds), done, *last)

    return Series(len(points), _reference(points.tobytes()), run, PEERS[name].ladder)


def _start(row: np.ndarray) -> State:
    state = np.empty(3)
    kernels.starting_log_state(row, state)
    return float(state[0]), float(state[1]), float(state[2])


def _scaled(points: np.ndarray, x: Any) -> np.ndarray:
    return np.asarray(x) / np.abs(points[:, Parameters._fields.index("drive_amplitude")])


def _shortest(call: Callable[[], Any], runs: int) -> tuple[float, int]:
    """The shortest of up to `runs` timings [s], and how many fitted into two seconds."""
    shortest, done = math.inf, 0
    while done < runs and (done == 0 or done * shortest < 2.0):
        begun = time.perf_counter()
        call()
        shortest, done = min(shortest, time.perf_counter() - begun), done + 1
    return shortest, done


# --- Euler-Cromer ---------------------------------------------------------------------------------


def _euler_cromer(p: Parameters, ladder: tuple[float, ...], steps: int) -> dict[str, Any]:
    """The paper's scheme: measured at larger steps, extrapolated to the paper's."""
    reference = _reference(np.array(p).tobytes())[0]
    points = [_fixed_run(p, dt, reference) for dt in ladder]
    _fixed_seconds(p, PAPER_DT, 1000)
    per_step = min(_fixed_seconds(p, PAPER_DT, steps) for _ in range(5)) / steps
    steps_a_period = 2 * math.pi / p.angular_frequency / PAPER_DT
    result: dict[str, Any] = {
        "points": points,
        "dt": PAPER_DT,
        "extrapolated": True,
        "ns_per_step": 1e9 * per_step,
        "timed_part_of_a_period": steps / steps_a_period,
        "seconds_per_period": per_step * steps_a_period,
        "error": None,
    }
    if points:
        finest = points[-1]
        result["error"] = finest["error"] * PAPER_DT / finest["dt"]
        ratios = [a["error"] / b["error"] for a, b in pairwise(points)]
        result["error_ratios_at_half_the_step"] = ratios
    error = "not measured" if result["error"] is None else f"{result['error']:.1e}"
    print(
        f"  Euler-Cromer at dt {PAPER_DT:g} s, extrapolated: {result['seconds_per_period']:.0f} s "
        f"per period ({result['ns_per_step']:.1f} ns a step), error {error}",
        flush=True,
    )
    return result


def _fixed_run(p: Parameters, dt: float, reference: float) -> dict[str, Any]:
    """One run over all periods at `dt`, which is also the timing."""
    begun = time.perf_counter()
    x = _fixed_end(p, dt, None)
    seconds = (time.perf_counter() - begun) / PERIODS
    error = float(abs(x / abs(p.drive_amplitude) - reference))
    steps = 2 * math.pi / p.angular_frequency / dt
    return {
        "dt": dt,
        "error": error,
        "seconds_per_period": seconds,
        "ns_per_step": 1e9 * seconds / steps,
    }


def _fixed_seconds(p: Parameters, dt: float, steps: int) -> float:
    begun = time.perf_counter()
    _fixed_end(p, dt, steps)
    return time.perf_counter() - begun


def _fixed_end(p: Parameters, dt: float, max_steps: int | None) -> float:
    """x after all periods; anything where the steps did not suffice."""
    settings = Options(method="euler-cromer", dt=dt, max_steps=max_steps).settings()
    samples = np.empty((PERIODS + 1, 3))
    row = np.array(p)
    kernels.fixed_trajectory(row, settings, np.array(_start(row)), 1, samples)
    return float(samples[-1, 0])


# --- what follows from the curves -----------------------------------------------------------------


def _cross_check(curves: list[dict[str, Any]]) -> dict[str, Any]:
    """How far the tightest peer, of another kind and other hands, is from the reference."""
    runs = [
        (point["rtol"], point["error"], curve["solver"])
        for curve in curves
        if curve["solver"] in PEERS
        for point in curve["points"]
    ]
    result: dict[str, Any] = {"solver": "ours, single trajectory", "rtol": REFERENCE_RTOL}
    if runs:
        rtol, error, solver = min(runs)
        result |= {"tightest_peer": solver, "its_rtol": rtol, "disagreement": error}
        print(f"  reference against {solver} at {rtol:g}: {error:.1e}")
    return result


def seconds_at(points: list[dict[str, Any]], error: float) -> float | None:
    """Seconds per period at which a solver reaches `error`, log-log between its best points.

    Points that are no better than a cheaper one are left out. A solver that is already better at
    its loosest tolerance gets that one's time; None where it is never as good.
    """
    best: list[tuple[float, float]] = []
    for point in sorted(points, key=lambda point: point["seconds_per_period"]):
        if not best or point["error"] < best[-1][0]:
            best.append((point["error"], point["seconds_per_period"]))
    if not best or best[-1][0] > error:
        return None
    log_error, log_seconds = np.log(np.maximum(np.array(best[::-1]), 1e-300)).T
    return float(np.exp(np.interp(math.log(error), log_error, log_seconds)))


def _ratios(curves: dict[str, Any], euler_cromer: dict[str, Any]) -> dict[str, Any]:
    """How many times faster this package is at equal error; None where either never gets there."""
    pairs = {
        "ensemble against numbalsoda": (NUMBALSODA_SAMPLE, OURS_ENSEMBLE),
        "one at a time against numbalsoda": (NUMBALSODA_SAMPLE, OURS_SAMPLE),
        "single trajectory against numbalsoda": (NUMBALSODA, OURS_SINGLE),
    }
    table = [
        {"what": what, "error": error, "ratio": _ratio(curves, *pair, error)}
        for what, pair in pairs.items()
        for error in TARGETS
    ]
    others = [curve for name, curve in curves.items() if name in PEERS]
    for error in TARGETS:
        times = [seconds_at(curve["points"], error) for curve in others]
        fastest = min((t for t in times if t), default=None)
        ours = seconds_at(curves[OURS_SINGLE]["points"], error)
        ratio = fastest / ours if fastest and ours else None
        what = "single trajectory against the fastest peer"
        table.append({"what": what, "error": error, "ratio": ratio})
    for name in (OURS_ENSEMBLE, OURS_SINGLE):
        for error in (1e-6, euler_cromer["error"]):
            ours = seconds_at(curves[name]["points"], error) if error else None
            ratio = euler_cromer["seconds_per_period"] / ours if ours else None
            what = f"{name.removeprefix('ours, ')} against Euler-Cromer (extrapolated)"
            table.append({"what": what, "error": error, "ratio": ratio})
    for row in table:
        error = "its own" if row["error"] is None else f"{row['error']:.0e}"
        ratio = "not reached" if row["ratio"] is None else f"{row['ratio']:.3g} times faster"
        print(f"  {row['what']:58} at error {error:8} {ratio}")
    return {"times_faster": table}


def _ratio(curves: dict[str, Any], other: str, ours: str, error: float) -> float | None:
    if other not in curves:
        return None
    theirs = seconds_at(curves[other]["points"], error)
    own = seconds_at(curves[ours]["points"], error)
    return theirs / own if theirs and own else None


# --- part two: random points ----------------------------------------------------------------------


def _random_points(plan: Plan, workers: dict[str, Worker]) -> dict[str, Any]:
    """Errors and times on points all over the range of parameters."""
    points = random_points(plan.random_points, RANDOM_SEED)
    solvers = {OURS_ENSEMBLE: _in_lanes(points), OURS_SAMPLE: _one_by_one(points)}
    if NUMBALSODA in workers:
        solvers[NUMBALSODA_SAMPLE] = _by_peer(NUMBALSODA, workers[NUMBALSODA], points, plan)
    print(f"\n{len(points)} random points")
    rows = [
        _random_row(solver, rtol, series, plan.runs)
        for solver, series in solvers.items()
        for rtol in plan.random_ladder
    ]
    return {"seed": RANDOM_SEED, "points": len(points), "rows": rows}


def _random_row(solver: str, rtol: float, series: Series, runs: int) -> dict[str, Any]:
    """Median and 95th percentile over the points that did not fail."""
    run = series.run(rtol, runs)
    errors = np.abs(run.x - series.reference)
    good = errors <= 1.0
    timed = run.seconds[good] if len(run.seconds) == len(good) else run.seconds
    row: dict[str, Any] = {
        "solver": solver,
        "rtol": rtol,
        "failed": int((~good).sum()),
        "reason": run.reason if not good.all() else "",
        "runs": run.runs,
    }
    if good.any():
        row |= {
            "error_median": float(np.median(errors[good])),
            "error_95": float(np.percentile(errors[good], 95)),
            "seconds_per_period_mean": float(np.mean(timed)),
        }
    if good.any() and len(timed) > 1:  # an ensemble is timed as a whole
        row["seconds_per_period_median"] = float(np.median(timed))
        row["seconds_per_period_95"] = float(np.percentile(timed, 95))
    print(
        "  " + "  ".join(f"{k} {v:.2g}" if isinstance(v, float) else f"{v}" for k, v in row.items())
    )
    return row


if __name__ == "__main__":
    main()
