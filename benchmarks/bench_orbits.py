"""Orbits of 200 random points: whether they are the right ones, how accurate, and how fast.

`accuracy` compares with plain iteration, point by point, and with a reference at rtol 1e-11.
`time` is that of all points on one core, beside LSODA of numbalsoda with plain iteration.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from peers import NUMBALSODA, PEERS, Failure, StationaryOrbit, Worker
from shared.measuring import measure
from shared.points import (
    AMPLITUDES,
    COUNTS,
    Orbits,
    amplitude_errors,
    at,
    description,
    orbits,
    parameter,
    quantile,
    random_points,
    spread,
)  # fmt: skip
from shared.timing import median_seconds, pin

from stickslip.parameters import Parameters

SEED, POINTS, FEW = 2026, 200, 12
STATED_AT = (1e-4, 1e-6, 1e-8)
RESOLVED = 1e-16  # nothing is granted to the stated errors
PLAIN_PERIODS = 6000
FAINT_STRESS = 1.0  # Pa: below it a stress is that of a film that is never solid
SAME = 1e-3
"""Relative: closer amplitudes are those of the same orbit."""

PEER_LADDER = (1e-5, 1e-6, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9)
PEER_SAMPLE = 5  # every fifth point, to find the tolerance of equal error
PEER_LIMIT = 30.0  # seconds a point
TOLERATED = 0.1  # part of the points that may fail at a tolerance that is chosen
PEER_PERIODS, PEER_STATIONARY = 5000, 1e-6
RUNS = 5
COMPANY, COMPANY_SEED = 4000, 2027
"""As many other random points fill the lanes to the last, as those of a sweep do."""


def _exact(quick: bool) -> Orbits:
    """Return the orbits of the points at a tight tolerance."""
    points = random_points(POINTS, SEED)[: FEW if quick else POINTS]
    return orbits(points, rtol=1e-10 if quick else 1e-11, stationary_rtol=1e-10)


# --- the same orbit, and its errors ---------------------------------------------------------------


def accuracy(quick: bool) -> dict[str, Any]:
    """Measure periods, orbits, errors, and how the stated errors bound them."""
    exact = _exact(quick)
    found = orbits(exact.points)
    errors = amplitude_errors(exact.points, found.amplitudes, exact.amplitudes)
    errors = errors[found.same_counts(exact)]
    return {
        "points": len(found),
        "statuses": found.statuses(),
        "periods": spread(found.periods_integrated),
        "plain_iteration": _against_plain(found, 500 if quick else PLAIN_PERIODS),
        "errors": {
            name: {"median": quantile(own, 50), "max": float(own.max())}
            for name, own in zip(AMPLITUDES, errors.T, strict=True)
        },
        "stated": [_stated(exact, rtol) for rtol in STATED_AT],
    }


def _stated(exact: Orbits, rtol: float) -> dict[str, Any]:
    """Return how the stated errors bound the true ones, points on another orbit as they come."""
    found = orbits(exact.points, **at(rtol))
    return {"rtol": rtol} | found.error_bars(exact, found.ok & exact.ok, RESOLVED)


def _against_plain(found: Orbits, periods: int) -> dict[str, Any]:
    """Count the points on the orbit of plain iteration; list the others with the differences.

    Where that does not settle, the comparison is with an accelerated run at rtol 1e-10.
    """
    points = found.points
    plain = orbits(points, accelerate=False, max_periods=periods, max_steps=10**9, **at(1e-8))
    settled, compared = plain.ok, plain[:]
    if not settled.all():
        compared.rows[~settled] = orbits(points[~settled], **at(1e-10)).rows
    differ = _differences(found, compared)
    same = ~np.any(list(differ.values()), axis=0)
    return {
        "max_periods": periods,
        "settled": int(settled.sum()),
        "same_orbit": int(same.sum()),
        "other_orbit": [
            description(
                points[i],
                differs_in={
                    name: [float(getattr(each, name)[i]) for each in (found, compared)]
                    for name, where in differ.items()
                    if where[i]
                },
                plain_settled=bool(settled[i]),
            )
            for i in np.flatnonzero(~same)
        ],
        "periods": spread(plain.periods_integrated[settled]) if settled.any() else {},
    }


def _differences(own: Orbits, other: Orbits) -> dict[str, np.ndarray]:
    """Return for each result which orbits (n,) differ in it."""
    differ = {name: getattr(own, name) != getattr(other, name) for name in ("status", *COUNTS)}
    for kind in ("elastic_stress", "friction_force"):
        scale = np.abs(getattr(other, f"{kind}_amplitude"))
        for name in (f"{kind}_amplitude", f"{kind}_max", f"{kind}_min"):
            mine, theirs = getattr(own, name), getattr(other, name)
            largest = np.maximum(np.abs(mine), np.abs(theirs))
            faint = (largest < FAINT_STRESS) & (kind == "elastic_stress")
            differ[name] = ~(faint | (np.abs(mine - theirs) <= SAME * scale))
    return differ


# --- time -----------------------------------------------------------------------------------------


def time(quick: bool) -> dict[str, Any]:
    """Time all points on one core, and numbalsoda at the error nearest to ours."""
    pin()
    exact, runs = _exact(quick), 1 if quick else RUNS
    found = orbits(exact.points)
    error = _median_error(found, exact)
    result: dict[str, Any] = {"seconds": _seconds(exact.points, runs), "error_median": error}
    if not PEERS[NUMBALSODA].version():
        print("numbalsoda: not installed")
        return result
    few, ladder = slice(None, None, PEER_SAMPLE), PEER_LADDER[1:2] if quick else PEER_LADDER
    with Worker(NUMBALSODA) as worker:
        pilot = [_peer_row(worker, exact[few], rtol)[0] for rtol in ladder]
        target = _median_error(found[few], exact[few])
        peer, ends = _peer_row(worker, exact, _nearest(pilot, target))
    solved = np.array([isinstance(end, StationaryOrbit) for end in ends])
    thinning = solved & (parameter(exact.points, "rheological_index") < 0)
    its_seconds = np.array([end.seconds for end in ends])
    peer["seconds"] = float(its_seconds[solved].sum())
    ratios = {
        what: float(its_seconds[part].sum()) / _seconds(exact.points[part], runs)
        for what, part in {"all": solved, "gamma<0": thinning}.items()
    }
    company = _in_company(peer["seconds"] / int(solved.sum()), quick=quick)
    return result | {"numbalsoda": peer, "pilot": pilot, "ratios": ratios, "in_company": company}


def _seconds(points: np.ndarray, runs: int) -> float:
    return median_seconds(lambda: orbits(points), runs)


def _median_error(found: Orbits, exact: Orbits) -> float:
    return quantile(found.errors(exact)[found.same_counts(exact)], 50)


def _nearest(pilot: list[dict[str, Any]], error: float) -> float:
    """Return the tolerance whose median error is nearest, of those at which few points fail."""
    usable = [row for row in pilot if row["failed"] <= TOLERATED * row["points"]] or pilot
    return min(usable, key=lambda row: abs(math.log(row["error_median"] / error)))["rtol"]


def _in_company(its_seconds: float, *, quick: bool) -> dict[str, Any]:
    """Time a point among thousands that end ok, beside the peer's time of a point."""
    found = orbits(random_points(COMPANY // 16 if quick else COMPANY, COMPANY_SEED))
    ok = found.points[found.ok]
    own = _seconds(ok, 1 if quick else RUNS) / len(ok)
    row = {"points": len(found), "ok": len(ok), "seconds": own}
    return row | {"its_seconds": its_seconds, "ratio": its_seconds / own}


def _peer_row(
    worker: Worker, exact: Orbits, rtol: float
) -> tuple[dict[str, Any], list[StationaryOrbit | Failure]]:
    """Return errors of numbalsoda with plain iteration, and what became of each point."""
    ends = [
        worker.stationary(Parameters(*row), rtol, PEER_PERIODS, PEER_STATIONARY, limit=PEER_LIMIT)
        for row in exact.points
    ]
    failed, missing = [isinstance(end, Failure) for end in ends], (math.nan, math.nan)
    amplitudes = [missing if bad else end[:2] for end, bad in zip(ends, failed, strict=True)]
    errors = amplitude_errors(exact.points, np.array(amplitudes), exact.amplitudes).max(axis=1)
    known = errors[np.isfinite(errors)]
    row = {
        "rtol": rtol,
        "points": len(ends),
        "failed": sum(failed),
        "error_median": quantile(known, 50),
        "other_orbits": int((known > SAME).sum()),
    }
    print("  numbalsoda:", row)
    return row, ends


if __name__ == "__main__":
    measure("orbits", __doc__, {"accuracy": accuracy, "time": time})
