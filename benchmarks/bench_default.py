"""Accuracy per cost at the default: what a looser tolerance would save, and what it would cost.

Random points of all fluids, at tolerances around the default and with `max_error` as a target that
decides which points are computed again; errors are those against orbits at a tight tolerance.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from common import (
    COUNTS,
    amplitude_errors,
    amplitudes,
    arguments,
    column,
    finish,
    good,
    medians_in_turn,
    random_points,
)
from peers.worker import pin

from stickslip.options import Options
from stickslip.orbit import compute_orbits

COUNT, RUNS, SEED = 2000, 3, 11
REFERENCE = 1e-10
TARGET = 1e-5
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)


def main() -> None:
    quick = arguments(__doc__).quick
    pin()
    points = random_points(40 if quick else COUNT, SEED)
    tight = Options(rtol=REFERENCE, stationary_rtol=REFERENCE, max_error=1.0)
    exact = compute_orbits(points, tight)[0]
    choices = {f"rtol {rtol:.0e}": _options(rtol) for rtol in TOLERANCES}
    choices |= {
        f"rtol {rtol:.0e}, max_error {TARGET:.0e}": _options(rtol, max_error=TARGET)
        for rtol in TOLERANCES[:2]
    }
    calls = [partial(compute_orbits, points, options) for options in choices.values()]
    seconds = medians_in_turn(calls, 1 if quick else RUNS)
    rows = [
        _row(name, points, call()[0], exact, spent)
        for (name, call, spent) in zip(choices, calls, seconds, strict=True)
    ]
    finish("default", {"points": len(points), "seed": SEED, "rows": rows}, quick=quick)


def _options(rtol: float, **others: float) -> Options:
    return Options(rtol=rtol, stationary_rtol=rtol, **others)  # type: ignore[arg-type]


def _row(
    name: str, points: np.ndarray, results: np.ndarray, exact: np.ndarray, seconds: float
) -> dict[str, Any]:
    """Cost, errors and honesty of one choice, over the points that it and the reference settle."""
    both = good(results) & good(exact)
    same = np.all([column(results, n) == column(exact, n) for n in COUNTS], axis=0)
    errors = amplitude_errors(points, amplitudes(results), amplitudes(exact)).max(axis=1)
    stated = column(results, "amplitude_error")
    row = {
        "choice": name,
        "microseconds": 1e6 * seconds / len(points),
        "not_ok": int((~good(results) & good(exact)).sum()),
        "other_orbit": int((both & ~same).sum()),
        "median": float(np.median(errors[both])),
        "95": float(np.quantile(errors[both], 0.95)),
        "largest": float(errors[both].max()),
        "held": float(np.mean(errors[both] <= stated[both])),
    }
    print(row)
    return row


if __name__ == "__main__":
    main()
