"""Periods, orbits, errors and time on 200 random points, against plain iteration with numbalsoda.

Part a: periods integrated at default options. Part b: is it the orbit that plain iteration ends
on, at every point? Part c: errors of the amplitudes against a reference, over the tolerances; does
`amplitude_error` bound them, and what does it cost? Part d: time for all points on one core,
against LSODA of numbalsoda with plain iteration at equal error.
"""

from __future__ import annotations

import math
import statistics
from collections import Counter
from typing import Any

import numpy as np
from common import (
    AMPLITUDES,
    amplitude_errors,
    arguments,
    column,
    described,
    finish,
    good,
    median_seconds,
    parameter,
    quantile,
    random_points,
    timed,
)
from peers import NUMBALSODA, PEERS, Failure, StationaryOrbit, Worker
from peers.worker import pin

from stickslip.kernels.adaptive import driver, passes
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters

SEED, POINTS, FEW = 2026, 200, 12
LADDER = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
STATED_AT = (1e-4, 1e-6, 1e-8)
DEFAULT = Options().rtol

REFERENCE = Options(rtol=1e-11, stationary_rtol=1e-10)
QUICK_REFERENCE = Options(rtol=1e-10, stationary_rtol=1e-10)
PLAIN = Options(
    rtol=1e-8, stationary_rtol=1e-8, max_periods=6000, max_steps=10**9, accelerate=False
)
UNSETTLED_REFERENCE = Options(rtol=1e-10, stationary_rtol=1e-10)
SAME = 1e-3  # relative: closer amplitudes are those of the same orbit
FAINT_STRESS = 1.0  # Pa: below it a stress is that of a film that is never solid

PEER_LADDER = (1e-5, 1e-6, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9)
PEER_SAMPLE = 5  # every fifth point, to find the tolerance of equal error
PEER_LIMIT = 30.0  # seconds a point
TOLERATED = 0.1  # part of the points that may fail at a tolerance that is chosen
OWN_LADDER = tuple(float(f"{10 ** (-3 - i / 10):.1e}") for i in range(31))
PEER_PERIODS, PEER_STATIONARY = 5000, 1e-6
RUNS = 5

COUNTS = ("orbit_periods", "melting_count")
PASSES = {(passes.SETTLE, False): "search", (passes.MEASURE, False): "measurement"} | {
    (passes.MEASURE, True): "finer measurement"
}


def main() -> None:
    quick = arguments(__doc__).quick
    pin()
    points = random_points(POINTS, SEED)[: FEW if quick else POINTS]
    compute_orbits(points, Options())  # compiles or loads what is needed
    reference, seconds = timed(lambda: _orbits(points, QUICK_REFERENCE if quick else REFERENCE))
    print(f"{len(points)} points, reference in {seconds:.0f} s")
    default = _orbits(points, Options())
    results: dict[str, Any] = {
        "points": len(points),
        "seed": SEED,
        "reference": {"rtol": REFERENCE.rtol, "stationary_rtol": REFERENCE.stationary_rtol},
        "not_ok": _not_ok(points, default),
        "reference_not_ok": _not_ok(points, reference),
        "periods": _periods(points, default),
        "plain_iteration": _against_plain(points, default, quick=quick),
        "errors": _errors(points, default, reference, LADDER[::3] if quick else LADDER),
        "estimate": _estimates(points, reference, STATED_AT[1:2] if quick else STATED_AT),
        "attempts": _attempts(points),
    }
    results["time"] = _against_peer(points, default, reference, quick=quick)
    finish("random", {"headline": _headline(results)} | results, quick=quick)


def _orbits(points: np.ndarray, options: Options) -> np.ndarray:
    return compute_orbits(points, options)[0]


def _not_ok(points: np.ndarray, results: np.ndarray) -> list[dict[str, Any]]:
    """Points that did not end ok, with their status."""
    return [
        described(points[i], status=int(column(results, "status")[i]))
        for i in np.flatnonzero(~good(results))
    ]


# --- a: periods -----------------------------------------------------------------------------------


def _periods(points: np.ndarray, results: np.ndarray) -> dict[str, Any]:
    """Periods integrated, search and measurement together, of all points and by fluid."""
    periods = column(results, "periods_integrated")
    gammas = parameter(points, "rheological_index")
    table = {"all": _spread(periods)}
    for gamma in np.unique(gammas):
        table[f"gamma={gamma:.3g}"] = _spread(periods[gammas == gamma])
    print("periods integrated:", table["all"])
    return table


def _spread(values: np.ndarray) -> dict[str, float]:
    return {"median": quantile(values, 50), "95": quantile(values, 95), "max": float(values.max())}


# --- b: the same orbit ----------------------------------------------------------------------------


def _against_plain(points: np.ndarray, default: np.ndarray, *, quick: bool) -> dict[str, Any]:
    """Whether each point ends on the orbit of plain iteration; the others, with the differences."""
    options = Options(**(vars(PLAIN) | {"max_periods": 500})) if quick else PLAIN
    plain, seconds = timed(lambda: _orbits(points, options))
    settled = good(plain)
    compared = plain.copy()
    if not settled.all():
        compared[~settled] = _orbits(points[~settled], UNSETTLED_REFERENCE)
    differences = [
        _difference(mine, theirs) for mine, theirs in zip(default, compared, strict=True)
    ]
    periods = column(plain, "periods_integrated")
    result = {
        "rtol": PLAIN.rtol,
        "max_periods": options.max_periods,
        "seconds": seconds,
        "settled": int(settled.sum()),
        "same_orbit": sum(not difference for difference in differences),
        "other_orbit": [
            described(points[i], differs_in=differences[i], plain_settled=bool(settled[i]))
            for i in range(len(points))
            if differences[i]
        ],
        "not_settled": [
            described(
                points[i],
                status=int(column(plain, "status")[i]),
                periods=int(periods[i]),
                same_as_at_1e_10=not differences[i],
            )
            for i in np.flatnonzero(~settled)
        ],
        "periods": _spread(periods[settled]) if settled.any() else {},
    }
    print(f"plain iteration: {result['settled']} settle, {result['same_orbit']} on the same orbit")
    for name in ("other_orbit", "not_settled"):
        for line in result[name]:
            print(f"  {name}: {line}")
    return result


def _difference(mine: np.ndarray, theirs: np.ndarray) -> dict[str, list[float]]:
    """The results in which two orbits differ, as pairs; empty where they are the same orbit."""
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


# --- c: errors ------------------------------------------------------------------------------------


def _same_counts(results: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Points that are ok in both and have the same counts: others end on another orbit."""
    same = good(results) & good(reference)
    for name in COUNTS:
        same &= column(results, name) == column(reference, name)
    return same


def _errors(
    points: np.ndarray, default: np.ndarray, reference: np.ndarray, ladder: tuple[float, ...]
) -> dict[str, Any]:
    """Error of the worse amplitude over the tolerances, and of either at the default."""
    rows = [_error_row(points, rtol, reference) for rtol in ladder]
    same = _same_counts(default, reference)
    both = amplitude_errors(points, default, reference)[same]
    at_default = {
        name: {"median": quantile(both[:, i], 50), "max": float(both[:, i].max())}
        for i, name in enumerate(AMPLITUDES)
    }
    worst = int(np.argmax(both.max(axis=1)))
    result = {
        "at_default": at_default,
        "worst_point": described(points[same][worst], error=float(both[worst].max())),
        "other_counts_at_default": [described(point) for point in points[~same]],
        "ladder": rows,
        "slope_median": _slope(rows, "median"),
        "slope_95": _slope(rows, "95"),
    }
    print(f"slopes: median {result['slope_median']:.2f}, 95 % {result['slope_95']:.2f}")
    return result


def _error_row(points: np.ndarray, rtol: float, reference: np.ndarray) -> dict[str, Any]:
    results = _orbits(points, Options(rtol=rtol, stationary_rtol=rtol))
    same = _same_counts(results, reference)
    errors = amplitude_errors(points, results, reference)[same].max(axis=1)
    row = {
        "rtol": rtol,
        "median": quantile(errors, 50),
        "95": quantile(errors, 95),
        "max": float(errors.max()),
        "not_ok": _not_ok(points, results),
        "other_counts": int((good(results) & ~same).sum()),
    }
    print(
        f"  rtol {rtol:.0e}: error median {row['median']:.1e}, 95 % {row['95']:.1e}, "
        f"max {row['max']:.1e}; {len(row['not_ok'])} not ok, {row['other_counts']} other counts"
    )
    return row


def _slope(rows: list[dict[str, Any]], name: str) -> float:
    """Slope of a straight line through log(error) over log(tolerance)."""
    logs = np.log([[row["rtol"], max(row[name], 1e-16)] for row in rows])
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])


def _estimates(
    points: np.ndarray, reference: np.ndarray, ladder: tuple[float, ...]
) -> list[dict[str, Any]]:
    """How often the stated error bounds the true one, and by how much it is too large.

    Points on another orbit than the reference count as they come: an honest bound covers them.
    """
    rows = []
    for rtol in ladder:
        results = _orbits(points, Options(rtol=rtol, stationary_rtol=rtol))
        ok = good(results) & good(reference)
        true = amplitude_errors(points, results, reference)[ok].max(axis=1)
        stated = column(results, "amplitude_error")[ok]
        missed = np.flatnonzero(stated < true)
        rows.append(
            {
                "rtol": rtol,
                "points": int(ok.sum()),
                "bounded": float(np.mean(stated >= true)),
                "overestimate_median": float(np.median(stated / np.maximum(true, 1e-16))),
                "missed": [
                    described(points[ok][i], stated=float(stated[i]), true=float(true[i]))
                    for i in missed
                ],
            }
        )
        print(
            f"  rtol {rtol:.0e}: bounded {rows[-1]['bounded']:.1%}, "
            f"overestimate {rows[-1]['overestimate_median']:.2g} in the median"
        )
    return rows


def _attempts(points: np.ndarray) -> dict[str, Any]:
    """Attempted steps of all points by what they were for.

    The finer measurement is reported; the one at the tolerance itself is there for the error.
    """
    counted: Counter[str] = Counter()
    original = driver._work_through

    def counting(queue: Any, task: Any) -> None:
        before = queue.counts[:, passes.ATTEMPTED].sum()
        original(queue, task)
        finer = task.mode == passes.MEASURE and task.rtol < DEFAULT
        counted[PASSES[task.mode, finer]] += int(queue.counts[:, passes.ATTEMPTED].sum() - before)

    driver._work_through = counting
    try:
        compute_orbits(points, Options())
    finally:
        driver._work_through = original
    total = sum(counted.values())
    parts = {what: count / total for what, count in counted.items()}
    print("attempts:", {what: f"{part:.1%}" for what, part in parts.items()})
    return {"total": total, "per_point": total / len(points), "parts": parts}


# --- d: time --------------------------------------------------------------------------------------


def _against_peer(
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
        "periods": _spread(np.array([o.periods for o, _ in runs_of_peer if not _is_failure(o)])),
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
    print("ratios of total times:", result["ratios"], "at its error:", result["at_its_error"])
    return result


def _is_failure(orbit: StationaryOrbit | Failure) -> bool:
    return isinstance(orbit, Failure)


def _median_error(points: np.ndarray, results: np.ndarray, reference: np.ndarray) -> float:
    same = _same_counts(results, reference)
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
        results = _orbits(points, options)
        error = _median_error(points, results, reference)
        if error <= peer["error_median"] or rtol == OWN_LADDER[-1]:
            break
    result: dict[str, Any] = {"rtol": rtol, "error_median": error}
    result["not_ok"] = _not_ok(points, results)
    result["seconds"] = {
        what: median_seconds(lambda chosen=part: compute_orbits(points[chosen], options), runs)
        for what, part in parts.items()
    }
    result["ratios"] = {what: peer["seconds"][what] / result["seconds"][what] for what in parts}
    return result


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


def _headline(results: dict[str, Any]) -> dict[str, Any]:
    periods, errors, plain = (
        results["periods"]["all"],
        results["errors"],
        results["plain_iteration"],
    )
    lines: dict[str, Any] = {
        "points (not ok)": f"{results['points']} ({len(results['not_ok'])})",
        "periods integrated: median, 95 %, max": ", ".join(f"{n:g}" for n in periods.values()),
        "same orbit as plain iteration": (
            f"{plain['same_orbit']} of {results['points']} ({plain['settled']} settle plainly)"
        ),
    }
    for name, values in errors["at_default"].items():
        lines[f"error of {name} at default: median, max"] = (
            f"{values['median']:.1e}, {values['max']:.1e}"
        )
    lines["slope of error against tolerance: median, 95 %"] = (
        f"{errors['slope_median']:.2f}, {errors['slope_95']:.2f}"
    )
    for row in results["estimate"]:
        lines[f"amplitude_error at rtol {row['rtol']:.0e}: bounds, overestimates by"] = (
            f"{row['bounded']:.1%}, {row['overestimate_median']:.2g}"
        )
    part = results["attempts"]["parts"].get("measurement", 0.0)
    lines["part of the attempts for the error estimate"] = f"{part:.1%}"
    taken = results["time"]
    lines["all points on one core, ours"] = f"{taken['seconds']['all']:.3g} s"
    if "ratios" in taken:
        peer = taken["numbalsoda"]
        lines["median error, ours and numbalsoda"] = (
            f"{taken['error_median']:.1e}, {peer['error_median']:.1e} (its rtol {peer['rtol']:.0e})"
        )
        lines["numbalsoda with plain iteration: failed points, left out on both sides"] = peer[
            "failed"
        ]
        lines["times faster at default: in total, gamma < 0"] = _pair(taken["ratios"])
        loose = taken["at_its_error"]
        lines[f"times faster at its error (our rtol {loose['rtol']:.0e}): in total, gamma < 0"] = (
            _pair(loose["ratios"])
        )
    return lines


def _pair(ratios: dict[str, float]) -> str:
    return f"{ratios['all']:.3g}, {ratios['gamma<0']:.3g}"


if __name__ == "__main__":
    main()
