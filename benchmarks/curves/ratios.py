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
        else:
            run = series.run(rtol, runs)
            given_up, errors = run.out_of_time, np.abs(run.x - series.reference)
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
        points.append(point | ({"steps_per_period": run.steps} if run.steps else {}))
        print(f"  {solver:34}{rtol:8.0e}  {points[-1]}", flush=True)
    return {
        "solver": solver,
        "members": len(series.reference),
        "points": points,
        "failures": failures,
    }


def _complaint(good: np.ndarray, reason: str) -> str:
    """Return why a run is no point of a curve: too many members are wrong; '' if it is one."""
    bad = int((~good).sum())
    if bad <= TOLERATED * len(good):
        return ""
    reason = reason or "error larger than 1"
    return reason if len(good) == 1 else f"fails on {bad} of {len(good)} points: {reason}"


def cross_check(curves: list[dict[str, Any]]) -> dict[str, Any]:
    """Return how far the tightest peer, of another kind and other hands, is from the reference."""
    runs = [
        (point["rtol"], point["error"], curve["solver"])
        for curve in curves
        if curve["solver"] in PEERS
        for point in curve["points"]
    ]
    result: dict[str, Any] = {"solver": "ours, single trajectory", "rtol": REFERENCE_RTOL}
    if not runs:
        return result
    rtol, error, solver = min(runs)
    return result | {"tightest_peer": solver, "its_rtol": rtol, "disagreement": error}


def _cost(
    curves: dict[str, Any], solver: str, error: float | None, of: str = "seconds_per_period"
) -> float | None:
    """Return what it costs a solver to reach `error`, log-log between its best points.

    Points that are no better than a cheaper one are left out. A solver that is already better at
    its loosest tolerance gets that one's cost; None where it is never as good.
    """
    best: list[tuple[float, float]] = []
    points = curves[solver]["points"] if solver in curves else []
    for point in sorted(points, key=lambda point: point[of]):
        if not best or point["error"] < best[-1][0]:
            best.append((point["error"], point[of]))
    if not (best and error) or best[-1][0] > error:
        return None
    log_error, log_cost = np.log(np.maximum(np.array(best[::-1]), 1e-300)).T
    return float(np.exp(np.interp(math.log(error), log_error, log_cost)))


def _ratio(theirs: float | None, ours: float | None) -> float | None:
    return theirs / ours if theirs and ours else None


def costs(curves: dict[str, Any]) -> list[dict[str, Any]]:
    """Return our steps and seconds a period for an ensemble at equal error, and the ratios."""
    table = []
    for error in TARGETS:
        steps = _cost(curves, OURS_ENSEMBLE, error, "steps_per_period")
        seconds = _cost(curves, OURS_ENSEMBLE, error)
        ratio = _ratio(_cost(curves, NUMBALSODA_SAMPLE, error), seconds)
        row = {"error": error, "steps_per_period": steps, "seconds_per_period": seconds}
        table.append(row | {"ratio": ratio})
    return table


def ratios(curves: dict[str, Any], euler_cromer: dict[str, Any]) -> dict[str, Any]:
    """Return how many times faster we are at equal error, None where either never gets there."""
    table = []

    def compare(what: str, theirs: float | None, ours: str, error: float | None) -> None:
        ratio = _ratio(theirs, _cost(curves, ours, error))
        table.append({"what": what, "error": error, "ratio": ratio})

    pairs = {
        "ensemble": (NUMBALSODA_SAMPLE, OURS_ENSEMBLE),
        "one at a time": (NUMBALSODA_SAMPLE, OURS_SAMPLE),
        "single trajectory": (NUMBALSODA, OURS_SINGLE),
    }
    for what, (theirs, ours) in pairs.items():
        for error in TARGETS:
            compare(f"{what} against numbalsoda", _cost(curves, theirs, error), ours, error)
    for error in TARGETS:
        times = [_cost(curves, name, error) for name in curves if name in PEERS]
        fastest = min((t for t in times if t), default=None)
        compare("single trajectory against the fastest peer", fastest, OURS_SINGLE, error)
    for what, ours in (("ensemble", OURS_ENSEMBLE), ("single trajectory", OURS_SINGLE)):
        for error in (1e-6, euler_cromer["error"]):
            what_else = f"{what} against Euler-Cromer (extrapolated)"
            compare(what_else, euler_cromer["seconds_per_period"], ours, error)
    return {"times_faster": table}
