"""Curves of run time against error, and the ratios that follow from them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from peers import NUMBALSODA, PEERS

from curves.series import REFERENCE_RTOL, Series

TARGETS = (1e-4, 1e-6, 1e-8)
TOLERATED = 0.1  # part of an ensemble that may fail before the run is no point of the curve
OURS_SINGLE, OURS_ENSEMBLE = "ours, single trajectory", "ours, ensemble"
OURS_SAMPLE, NUMBALSODA_SAMPLE = "ours, one at a time", f"{NUMBALSODA}, one at a time"


def curve(solver: str, series: Series, ladder: tuple[float, ...], runs: int) -> dict[str, Any]:
    """Measure one solver over a ladder, its own if empty; return points and failures."""
    points: list[dict[str, Any]] = []
    failures: list[dict[str, Any]] = []
    given_up = False
    for rtol in ladder or series.ladder:
        if given_up:
            reason = "not tried: did not finish at a looser tolerance"
            failures.append({"rtol": rtol, "reason": reason})
            continue
        run = series.run(rtol, runs)
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
        if run.steps:
            point["steps_per_period"] = run.steps
        points.append(point)
        _print_point(solver, point)
    return {"solver": solver, "members": series.points, "points": points, "failures": failures}


def _complaint(good: np.ndarray, reason: str) -> str:
    """Return why a run is no point of a curve: too many members are wrong; '' if it is one."""
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


def cross_check(curves: list[dict[str, Any]]) -> dict[str, Any]:
    """Return how far the tightest peer, of another kind and other hands, is from the reference."""
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


def cost_at(
    points: list[dict[str, Any]], error: float, cost: str = "seconds_per_period"
) -> float | None:
    """Return what it costs a solver to reach `error`, log-log between its best points.

    Points that are no better than a cheaper one are left out. A solver that is already better at
    its loosest tolerance gets that one's cost; None where it is never as good.
    """
    best: list[tuple[float, float]] = []
    for point in sorted(points, key=lambda point: point[cost]):
        if not best or point["error"] < best[-1][0]:
            best.append((point["error"], point[cost]))
    if not best or best[-1][0] > error:
        return None
    log_error, log_cost = np.log(np.maximum(np.array(best[::-1]), 1e-300)).T
    return float(np.exp(np.interp(math.log(error), log_error, log_cost)))


def costs(curves: dict[str, Any]) -> list[dict[str, Any]]:
    """Return our steps and seconds a period for an ensemble at equal error, and the ratios."""
    table = []
    for error in TARGETS:
        ensemble = curves[OURS_ENSEMBLE]["points"]
        row = {
            "error": error,
            "steps_per_period": cost_at(ensemble, error, "steps_per_period"),
            "seconds_per_period": cost_at(ensemble, error),
            "ratio": _ratio(curves, NUMBALSODA_SAMPLE, OURS_ENSEMBLE, error),
            "ratio_one_at_a_time": _ratio(curves, NUMBALSODA_SAMPLE, OURS_SAMPLE, error),
        }
        print("  " + "  ".join(f"{k} {v:.3g}" if v else f"{k} not reached" for k, v in row.items()))
        table.append(row)
    return table


def ratios(curves: dict[str, Any], euler_cromer: dict[str, Any]) -> dict[str, Any]:
    """Return how many times faster we are at equal error, None where either never gets there."""
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
        times = [cost_at(curve["points"], error) for curve in others]
        fastest = min((t for t in times if t), default=None)
        ours = cost_at(curves[OURS_SINGLE]["points"], error)
        ratio = fastest / ours if fastest and ours else None
        what = "single trajectory against the fastest peer"
        table.append({"what": what, "error": error, "ratio": ratio})
    for name in (OURS_ENSEMBLE, OURS_SINGLE):
        for error in (1e-6, euler_cromer["error"]):
            ours = cost_at(curves[name]["points"], error) if error else None
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
    theirs = cost_at(curves[other]["points"], error)
    own = cost_at(curves[ours]["points"], error)
    return theirs / own if theirs and own else None
