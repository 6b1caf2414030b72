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
    amplitude_errors,
    column,
    description,
    error_bars,
    good,
    orbits,
    parameter,
    quantile,
    random_points,
    same_counts,
    spread,
    statuses,
    worse_errors,
)
from shared.timing import median_seconds, pin, timed

from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters

SEED, POINTS, FEW = 2026, 200, 12
STATED_AT = (1e-4, 1e-6, 1e-8)
RESOLVED = 1e-16  # nothing is granted to the stated errors
PLAIN = Options(
    rtol=1e-8, stationary_rtol=1e-8, max_periods=6000, max_steps=10**9, accelerate=False
)
UNSETTLED_REFERENCE = Options(rtol=1e-10, stationary_rtol=1e-10)
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


def _drawn(quick: bool) -> tuple[np.ndarray, np.ndarray]:
    """Draw the points, and compute their results at a tight tolerance."""
    points = random_points(POINTS, SEED)[: FEW if quick else POINTS]
    options = Options(rtol=1e-10 if quick else 1e-11, stationary_rtol=1e-10)
    return points, orbits(points, options)


# --- the same orbit, and its errors ---------------------------------------------------------------


def accuracy(quick: bool) -> dict[str, Any]:
    """Measure periods, orbits, errors, and how the stated errors bound them."""
    points, reference = _drawn(quick)
    default = orbits(points, Options())
    same = same_counts(default, reference)
    errors = amplitude_errors(points, default, reference)[same]
    return {
        "points": len(points),
        "statuses": statuses(default),
        "periods": spread(column(default, "periods_integrated")),
        "plain_iteration": _against_plain(points, default, quick=quick),
        "errors": {
            name: {"median": quantile(errors[:, i], 50), "max": float(errors[:, i].max())}
            for i, name in enumerate(AMPLITUDES)
        },
        "stated": [_stated(points, rtol, reference) for rtol in STATED_AT],
    }


def _stated(points: np.ndarray, rtol: float, reference: np.ndarray) -> dict[str, Any]:
    """Return how the stated errors bound the true ones, points on another orbit as they come."""
    results = orbits(points, Options(rtol=rtol, stationary_rtol=rtol))
    both = good(results) & good(reference)
    row = {"rtol": rtol} | error_bars(points, results, reference, both, RESOLVED)
    print(row)
    return row


def _against_plain(points: np.ndarray, default: np.ndarray, *, quick: bool) -> dict[str, Any]:
    """Count the points on the orbit of plain iteration; list the others with the differences.

    Where that does not settle, the comparison is with an accelerated run at rtol 1e-10.
    """
    options = Options(**(vars(PLAIN) | {"max_periods": 500})) if quick else PLAIN
    plain = orbits(points, options)
    settled = good(plain)
    compared = plain.copy()
    if not settled.all():
        compared[~settled] = orbits(points[~settled], UNSETTLED_REFERENCE)
    differences = [_difference(*pair) for pair in zip(default, compared, strict=True)]
    result = {
        "max_periods": options.max_periods,
        "settled": int(settled.sum()),
        "same_orbit": sum(not difference for difference in differences),
        "other_orbit": [
            description(points[i], differs_in=differences[i], plain_settled=bool(settled[i]))
            for i in range(len(points))
            if differences[i]
        ],
        "periods": spread(column(plain, "periods_integrated")[settled]) if settled.any() else {},
    }
    print("plain iteration:", result)
    return result


def _difference(mine: np.ndarray, theirs: np.ndarray) -> dict[str, list[float]]:
    """Return the results in which two orbits differ, as pairs, none for the same orbit."""
    own, other = mine[None], theirs[None]
    differences = {}
    for name in ("status", *COUNTS):
        pair = float(column(own, name)[0]), float(column(other, name)[0])
        if pair[0] != pair[1]:
            differences[name] = list(pair)
    for kind in ("elastic_stress", "friction_force"):
        scale = max(abs(float(column(other, f"{kind}_amplitude")[0])), 1e-300)
        for name in (f"{kind}_amplitude", f"{kind}_max", f"{kind}_min"):
            pair = float(column(own, name)[0]), float(column(other, name)[0])
            faint = kind == "elastic_stress" and max(map(abs, pair)) < FAINT_STRESS
            if not (faint or abs(pair[0] - pair[1]) <= SAME * scale):
                differences[name] = list(pair)
    return differences


# --- time -----------------------------------------------------------------------------------------


def time(quick: bool) -> dict[str, Any]:
    """Time all points on one core, and numbalsoda at the error nearest to ours."""
    pin()
    points, reference = _drawn(quick)
    default, runs = orbits(points, Options()), 1 if quick else RUNS
    result: dict[str, Any] = {
        "seconds": median_seconds(lambda: compute_orbits(points, Options()), runs),
        "error_median": _median_error(points, default, reference),
    }
    print("ours:", result)
    if not PEERS[NUMBALSODA].version():
        print("numbalsoda: not installed")
        return result
    with Worker(NUMBALSODA) as worker:
        few = slice(None, None, PEER_SAMPLE)
        pilot = [
            _peer_row(worker, points[few], reference[few], rtol)[0]
            for rtol in (PEER_LADDER[1:2] if quick else PEER_LADDER)
        ]
        target = _median_error(points[few], default[few], reference[few])
        peer, ends = _peer_row(worker, points, reference, _nearest(pilot, target))
    solved = np.array([isinstance(orbit, StationaryOrbit) for orbit, _ in ends])
    thinning = solved & (parameter(points, "rheological_index") < 0)
    peer["seconds"] = _peer_seconds(ends, solved)
    result |= {"numbalsoda": peer, "pilot": pilot}
    result["ratios"] = {
        what: _peer_seconds(ends, part)
        / median_seconds(lambda own=points[part]: compute_orbits(own, Options()), runs)
        for what, part in {"all": solved, "gamma<0": thinning}.items()
    }
    result["in_company"] = _in_company(peer["seconds"] / int(solved.sum()), quick=quick)
    print(result)
    return result


def _median_error(points: np.ndarray, results: np.ndarray, reference: np.ndarray) -> float:
    same = same_counts(results, reference)
    return quantile(worse_errors(points, results, reference)[same], 50)


def _nearest(pilot: list[dict[str, Any]], error: float) -> float:
    """Return the tolerance whose median error is nearest, of those at which few points fail."""
    usable = [row for row in pilot if row["failed"] <= TOLERATED * row["points"]] or pilot
    return min(usable, key=lambda row: abs(math.log(row["error_median"] / error)))["rtol"]


def _in_company(its_seconds: float, *, quick: bool) -> dict[str, Any]:
    """Time a point among thousands that end ok, beside the peer's time of a point."""
    points = random_points(COMPANY // 16 if quick else COMPANY, COMPANY_SEED)
    ended = points[good(orbits(points, Options()))]
    seconds = median_seconds(lambda: compute_orbits(ended, Options()), 1 if quick else RUNS)
    own = seconds / len(ended)
    row = {"points": len(points), "ok": len(ended), "seconds": own}
    return row | {"its_seconds": its_seconds, "ratio": its_seconds / own}


Ended = tuple[StationaryOrbit | Failure, float]


def _peer_seconds(ends: list[Ended], part: np.ndarray) -> float:
    return math.fsum(seconds for (_, seconds), chosen in zip(ends, part, strict=True) if chosen)


def _peer_row(
    worker: Worker, points: np.ndarray, reference: np.ndarray, rtol: float
) -> tuple[dict[str, Any], list[Ended]]:
    """Return errors of numbalsoda with plain iteration, and what became of each point."""
    ends = [_peer_run(worker, Parameters(*row), rtol) for row in points]
    missing = (math.nan, math.nan)
    amplitudes = [o[:2] if isinstance(o, StationaryOrbit) else missing for o, _ in ends]
    errors = worse_errors(points, np.array(amplitudes), reference)
    known = errors[np.isfinite(errors)]
    row = {
        "rtol": rtol,
        "points": len(points),
        "failed": sum(isinstance(orbit, Failure) for orbit, _ in ends),
        "error_median": quantile(known, 50),
        "other_orbits": int((known > SAME).sum()),
    }
    print("  numbalsoda:", row)
    return row, ends


def _peer_run(worker: Worker, p: Parameters, rtol: float) -> Ended:
    """Return an orbit, or why there is none, and its seconds, or those until it failed."""
    orbit, seconds = timed(
        lambda: worker.stationary(p, rtol, PEER_PERIODS, PEER_STATIONARY, limit=PEER_LIMIT)
    )
    return orbit, orbit.seconds if isinstance(orbit, StationaryOrbit) else seconds


if __name__ == "__main__":
    measure("orbits", __doc__, {"accuracy": accuracy, "time": time})
