"""Periods, orbits, errors and time on 200 random points, against plain iteration with numbalsoda.

Part a: periods integrated at default options. Part b: is it the orbit that plain iteration ends
on, at every point? Part c: errors of the amplitudes against a reference, over the tolerances; does
`amplitude_error` bound them, and what does it cost? Part d: time for all points on one core,
against LSODA of numbalsoda with plain iteration at equal error.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from common import (
    AMPLITUDES,
    COUNTS,
    amplitude_errors,
    arguments,
    column,
    described,
    finish,
    good,
    not_ok,
    orbits,
    parameter,
    quantile,
    random_points,
    same_counts,
    spread,
    timed,
)
from inside import attempts_of
from parts.random_against_peer import SAME, against_peer
from peers.worker import pin

from stickslip.options import Options
from stickslip.orbit import compute_orbits

SEED, POINTS, FEW = 2026, 200, 12
LADDER = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
STATED_AT = (1e-4, 1e-6, 1e-8)

REFERENCE = Options(rtol=1e-11, stationary_rtol=1e-10)
QUICK_REFERENCE = Options(rtol=1e-10, stationary_rtol=1e-10)
PLAIN = Options(
    rtol=1e-8, stationary_rtol=1e-8, max_periods=6000, max_steps=10**9, accelerate=False
)
UNSETTLED_REFERENCE = Options(rtol=1e-10, stationary_rtol=1e-10)
FAINT_STRESS = 1.0  # Pa: below it a stress is that of a film that is never solid


def main() -> None:
    quick = arguments(__doc__).quick
    pin()
    points = random_points(POINTS, SEED)[: FEW if quick else POINTS]
    compute_orbits(points, Options())  # compiles or loads what is needed
    reference, seconds = timed(lambda: orbits(points, QUICK_REFERENCE if quick else REFERENCE))
    print(f"{len(points)} points, reference in {seconds:.0f} s")
    default = orbits(points, Options())
    results: dict[str, Any] = {
        "points": len(points),
        "seed": SEED,
        "reference": {"rtol": REFERENCE.rtol, "stationary_rtol": REFERENCE.stationary_rtol},
        "not_ok": not_ok(points, default),
        "reference_not_ok": not_ok(points, reference),
        "periods": _periods(points, default),
        "plain_iteration": _against_plain(points, default, quick=quick),
        "errors": _errors(points, default, reference, LADDER[::3] if quick else LADDER),
        "estimate": _estimates(points, reference, STATED_AT[1:2] if quick else STATED_AT),
        "attempts": _attempts(points),
    }
    results["time"] = against_peer(points, default, reference, quick=quick)
    finish("random", results, quick=quick)


# --- a: periods -----------------------------------------------------------------------------------


def _periods(points: np.ndarray, results: np.ndarray) -> dict[str, Any]:
    """Periods integrated, search and measurement together, of all points and by fluid."""
    periods = column(results, "periods_integrated")
    gammas = parameter(points, "rheological_index")
    table = {"all": spread(periods)}
    for gamma in np.unique(gammas):
        table[f"gamma={gamma:.3g}"] = spread(periods[gammas == gamma])
    print("periods integrated:", table["all"])
    return table


# --- b: the same orbit ----------------------------------------------------------------------------


def _against_plain(points: np.ndarray, default: np.ndarray, *, quick: bool) -> dict[str, Any]:
    """Whether each point ends on the orbit of plain iteration; the others, with the differences."""
    options = Options(**(vars(PLAIN) | {"max_periods": 500})) if quick else PLAIN
    plain, seconds = timed(lambda: orbits(points, options))
    settled = good(plain)
    compared = plain.copy()
    if not settled.all():
        compared[~settled] = orbits(points[~settled], UNSETTLED_REFERENCE)
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
        "periods": spread(periods[settled]) if settled.any() else {},
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


def _errors(
    points: np.ndarray, default: np.ndarray, reference: np.ndarray, ladder: tuple[float, ...]
) -> dict[str, Any]:
    """Error of the worse amplitude over the tolerances, and of either at the default."""
    rows = [_error_row(points, rtol, reference) for rtol in ladder]
    same = same_counts(default, reference)
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
    results = orbits(points, Options(rtol=rtol, stationary_rtol=rtol))
    same = same_counts(results, reference)
    errors = amplitude_errors(points, results, reference)[same].max(axis=1)
    row = {
        "rtol": rtol,
        "median": quantile(errors, 50),
        "95": quantile(errors, 95),
        "max": float(errors.max()),
        "not_ok": not_ok(points, results),
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
        results = orbits(points, Options(rtol=rtol, stationary_rtol=rtol))
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
    """Attempted steps of all points by what they were for."""
    counted = attempts_of(points, Options())
    total = sum(counted)
    parts = {what: count / total for what, count in counted._asdict().items()}
    print("attempts:", {what: f"{part:.1%}" for what, part in parts.items()})
    return {"total": total, "per_point": total / len(points), "parts": parts}


if __name__ == "__main__":
    main()
