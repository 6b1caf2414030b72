"""Time for random points on one core: ours, and numbalsoda with plain iteration, at equal error."""

from __future__ import annotations

import math
import statistics
from typing import Any

import numpy as np
from common import (
    amplitude_errors,
    described,
    good,
    median_seconds,
    not_ok,
    orbits,
    parameter,
    quantile,
    random_points,
    same_counts,
    spread,
    timed,
)
from peers import NUMBALSODA, PEERS, Failure, StationaryOrbit, Worker

from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters

SAME = 1e-3
"""Relative: closer amplitudes are those of the same orbit."""

PEER_LADDER = (1e-5, 1e-6, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9)
PEER_SAMPLE = 5  # every fifth point, to find the tolerance of equal error
PEER_LIMIT = 30.0  # seconds a point
TOLERATED = 0.1  # part of the points that may fail at a tolerance that is chosen
OWN_LADDER = tuple(float(f"{10 ** (-3 - i / 10):.1e}") for i in range(31))
PEER_PERIODS, PEER_STATIONARY = 5000, 1e-6
RUNS = 5
COMPANY, COMPANY_SEED = 4000, 2027
"""As many other random points fill the lanes to the last, as those of a sweep do."""


def against_peer(
    points: np.ndarray, default: np.ndarray, reference: np.ndarray, *, quick: bool
) -> dict[str, Any]:
    """Seconds for all points on one core, and those of numbalsoda at equal error."""
    runs = 1 if quick else RUNS
    shear_thinning = parameter(points, "rheological_index") < 0
    ours = {
        "all": median_seconds(lambda: compute_orbits(points, Options()), runs),
        "gamma<0": median_seconds(lambda: compute_orbits(points[shear_thinning], Options()), runs),
    }
    error = _median_error(points, default, reference)
    print(f"ours: {ours['all']:.3f} s for all points, median error {error:.1e}")
    result: dict[str, Any] = {"seconds": ours, "error_median": error, "runs": runs}
    if not PEERS[NUMBALSODA].version():
        print("numbalsoda: not installed")
        return result | {"numbalsoda": "not installed"}
    with Worker(NUMBALSODA) as worker:
        ladder = PEER_LADDER[1:2] if quick else PEER_LADDER
        few = slice(None, None, PEER_SAMPLE)
        pilot = [_peer_row(worker, points[few], reference[few], rtol)[0] for rtol in ladder]
        target = _median_error(points[few], default[few], reference[few])
        row, runs_of_peer = _peer_row(worker, points, reference, _nearest(pilot, target))
    took = np.array([seconds for _, seconds in runs_of_peer])
    failed = np.array([isinstance(orbit, Failure) for orbit, _ in runs_of_peer])
    parts = {"all": ~failed, "gamma<0": shear_thinning & ~failed}  # what both have solved
    row |= {
        "seconds": {what: float(took[part].sum()) for what, part in parts.items()},
        "seconds_in_failures": {
            "all": float(took[failed].sum()),
            "gamma<0": float(took[failed & shear_thinning].sum()),
        },
        "periods": spread(np.array([o.periods for o, _ in runs_of_peer if not _is_failure(o)])),
        "failures": [
            described(point, reason=orbit.reason, seconds=seconds)
            for point, (orbit, seconds) in zip(points, runs_of_peer, strict=True)
            if isinstance(orbit, Failure)
        ],
        "pilot": pilot,
    }
    solved = {
        what: median_seconds(lambda chosen=part: compute_orbits(points[chosen], Options()), runs)
        for what, part in parts.items()
    }
    result |= {"numbalsoda": row, "ratios": {w: row["seconds"][w] / solved[w] for w in solved}}
    result["at_its_error"] = _at_error(points, reference, row, parts, runs)
    result["in_company"] = _in_company(row, result, int(np.sum(~failed)), quick=quick)
    print("ratios of total times:", result["ratios"], "at its error:", result["at_its_error"])
    return result


def _is_failure(orbit: StationaryOrbit | Failure) -> bool:
    return isinstance(orbit, Failure)


def _median_error(points: np.ndarray, results: np.ndarray, reference: np.ndarray) -> float:
    same = same_counts(results, reference)
    return quantile(amplitude_errors(points, results, reference)[same].max(axis=1), 50)


def _nearest(pilot: list[dict[str, Any]], error: float) -> float:
    """The tolerance whose median error is nearest, of those at which few points fail."""
    usable = [row for row in pilot if row["failed"] <= TOLERATED * row["points"]] or pilot
    return min(usable, key=lambda row: abs(math.log(row["error_median"] / error)))["rtol"]


def _at_error(
    points: np.ndarray,
    reference: np.ndarray,
    peer: dict[str, Any],
    parts: dict[str, np.ndarray],
    runs: int,
) -> dict[str, Any]:
    """Our time at the loosest tolerance whose median error is not larger than the peer's."""
    for rtol in OWN_LADDER:
        options = Options(rtol=rtol)
        results = orbits(points, options)
        error = _median_error(points, results, reference)
        if error <= peer["error_median"] or rtol == OWN_LADDER[-1]:
            break
    result: dict[str, Any] = {"rtol": rtol, "error_median": error}
    result["not_ok"] = not_ok(points, results)
    result["seconds"] = {
        what: median_seconds(lambda chosen=part: compute_orbits(points[chosen], options), runs)
        for what, part in parts.items()
    }
    result["ratios"] = {what: peer["seconds"][what] / result["seconds"][what] for what in parts}
    return result


def _in_company(
    peer: dict[str, Any], alone: dict[str, Any], solved: int, *, quick: bool
) -> dict[str, Any]:
    """Our time of a point among thousands against the peer's of a point.

    So many of its points are `solved`; what those took that failed is left out on both sides, ours
    being any that did not end ok. `alone` has our times for few points.
    """
    points = random_points(COMPANY // 16 if quick else COMPANY, COMPANY_SEED)
    its = peer["seconds"]["all"] / solved
    rows: dict[str, Any] = {"points": len(points), "seed": COMPANY_SEED, "its_seconds": its}
    tolerances = {"default": Options().rtol, "at_its_error": alone["at_its_error"]["rtol"]}
    for what, rtol in tolerances.items():
        options = Options(rtol=rtol)
        results, whole = timed(lambda chosen=options: orbits(points, chosen))
        ended = points[good(results)]
        seconds = median_seconds(
            lambda chosen=options, own=ended: compute_orbits(own, chosen), 1 if quick else RUNS
        )
        row = {"rtol": rtol, "ok": len(ended), "seconds": seconds / len(ended)}
        row |= {"ratio": its / row["seconds"], "failed": len(points) - len(ended)}
        rows[what] = row | {"seconds_with_failures": whole / len(points)}
    print("in company:", rows)
    return rows


def _peer_row(
    worker: Worker, points: np.ndarray, reference: np.ndarray, rtol: float
) -> tuple[dict[str, Any], list[tuple[StationaryOrbit | Failure, float]]]:
    """Errors of numbalsoda with plain iteration at a tolerance, and what became of each point.

    The seconds of a point that fails are those until it failed.
    """
    runs = [_peer_run(worker, Parameters(*row), rtol) for row in points]
    orbits = [orbit for orbit, _ in runs]
    missing = (math.nan, math.nan)
    amplitudes = [o[:2] if isinstance(o, StationaryOrbit) else missing for o in orbits]
    errors = amplitude_errors(points, np.array(amplitudes), reference).max(axis=1)
    known = errors[np.isfinite(errors)]
    row = {
        "rtol": rtol,
        "points": len(points),
        "failed": sum(map(_is_failure, orbits)),
        "error_median": quantile(known, 50),
        "error_95": quantile(known, 95),
        "other_orbits": int((known > SAME).sum()),
        "seconds_mean": statistics.fmean(seconds for _, seconds in runs),
    }
    print("  numbalsoda:", {k: f"{v:.2g}" if isinstance(v, float) else v for k, v in row.items()})
    return row, runs


def _peer_run(
    worker: Worker, p: Parameters, rtol: float
) -> tuple[StationaryOrbit | Failure, float]:
    orbit, seconds = timed(
        lambda: worker.stationary(p, rtol, PEER_PERIODS, PEER_STATIONARY, limit=PEER_LIMIT)
    )
    return orbit, orbit.seconds if isinstance(orbit, StationaryOrbit) else seconds
