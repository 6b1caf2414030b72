"""The tolerance ladder: true and stated errors of random points."""

from __future__ import annotations

from typing import Any

from shared.points import at, orbits, random_points

TOLERANCES = tuple(float(f"1e-{i}") for i in range(2, 11))
_EXACT = 1e-12
_RESOLVED = 1e-11  # by a comparison with the reference


def run(quick: bool) -> dict[str, Any]:
    """Measure errors at each tolerance, and keep every pair of a stated and a true one."""
    points = random_points(20 if quick else 200, 7)
    exact = orbits(points, max_error=1.0, **at(_EXACT))
    steps, pairs = [], []
    for rtol in TOLERANCES:
        found = orbits(points, max_error=1.0, **at(rtol))
        both = found.ok & exact.ok
        steps.append({"rtol": rtol} | found.error_bars(exact, both, _RESOLVED))
        errors = zip(found.amplitude_error[both], found.errors(exact)[both], strict=True)
        pairs += [[rtol, float(stated), float(true)] for stated, true in errors]
    return {"points": len(points), "steps": steps, "pairs": pairs}
