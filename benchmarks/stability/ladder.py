"""The tolerance ladder: true error, stated error and slope on random points."""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import column, error_bars, good, orbits, random_points, worse_errors

from stickslip.options import Options

TOLERANCES = tuple(float(f"1e-{i}") for i in range(2, 11))
_EXACT = 1e-12
_SEED = 7
# What a comparison with the reference can resolve.
_RESOLVED = 1e-11


def run(quick: bool) -> dict[str, Any]:
    """Measure errors at each tolerance, and keep every pair of a stated and a true one."""
    points = random_points(20 if quick else 200, _SEED)
    exact = orbits(points, Options(rtol=_EXACT, stationary_rtol=_EXACT, max_error=1.0))
    steps, pairs = [], []
    for rtol in TOLERANCES:
        found = orbits(points, Options(rtol=rtol, stationary_rtol=rtol, max_error=1.0))
        both = good(found) & good(exact)
        steps.append({"rtol": rtol} | error_bars(points, found, exact, both, _RESOLVED))
        true = worse_errors(points, found, exact)[both]
        stated = column(found, "amplitude_error")[both]
        pairs += [[rtol, float(s), float(t)] for s, t in zip(stated, true, strict=True)]
    inner = [step for step in steps if 1e-9 < step["rtol"] < 1e-2]
    slope = np.polyfit(
        np.log10([s["rtol"] for s in inner]), np.log10([s["error_median"] for s in inner]), 1
    )[0]
    return {"points": len(points), "steps": steps, "slope": float(slope), "pairs": pairs}
