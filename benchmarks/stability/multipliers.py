"""Floquet multipliers against central differences of the map of an orbit at 1e-10, on two boxes.

The reference takes copies on both sides, displaced by four sizes in turn; the two that agree best
give it, and tell how far to trust it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from inside.lanes import scaled_states, travelled_states
from shared.points import Log, Orbits, at, box, descriptions, orbits, quantile

from stability.stated import wide

_EXACT = 1e-10
_TOLERANCES = (1e-4, 1e-6, 1e-8)

# Displacements of copies, in units of the motion, and those of ln(phi) as multiples of them.
_SIZES = (1e-3, 1e-4, 1e-5, 1e-6)
_FILM = 100.0

# References whose two best sizes differ by more are none; errors up to these, over the distance of
# the multiplier from 1 or by themselves, are allowed.
_DOUBTFUL = 1e-3
_ALLOWED_ROOTS, _ALLOWED = 3.0, 0.01

# An orbit whose amplitudes are farther off than this is another one.
_ELSEWHERE = 0.01


_paper = box(
    4901, T=(150, 330), k=Log(1e4, 3e5), K=Log(500, 1e4), omega=(5, 60), gamma=(-2 / 3, 2 / 3)
)
"""Films from all over the range of the paper's claims."""

BOXES = {"paper": _paper, "wide": wide}


def run(quick: bool) -> dict[str, Any]:
    """Measure the errors of multipliers in each box, at each tolerance."""
    return {name: _answer(points(10 if quick else 200)) for name, points in BOXES.items()}


def _answer(points: np.ndarray) -> dict[str, Any]:
    exact = orbits(points, max_error=1.0, **at(_EXACT))
    reference, doubt = _central_multipliers(exact)
    known = exact.ok & (doubt <= _DOUBTFUL)
    return {"known": int(known.sum())} | {
        str(rtol): _compared(rtol, exact, np.where(known, reference, np.nan))
        for rtol in _TOLERANCES
    }


def _central_multipliers(exact: Orbits) -> tuple[np.ndarray, np.ndarray]:
    """Return multipliers (n,) from central differences, and their doubts; NaN for no orbit."""
    halves = 2 * np.nan_to_num(exact.orbit_periods).astype(np.int64)
    rows = np.flatnonzero(exact.ok)
    found = np.full((len(_SIZES), len(exact)), np.nan)
    for size, radii in zip(_SIZES, found, strict=True):
        maps = _central_map(exact[rows], halves[rows], size)
        radii[rows] = [np.abs(np.linalg.eigvals(m)).max() for m in np.nan_to_num(maps, nan=1e9)]
    apart = np.abs(np.diff(found, axis=0))
    best = np.argmin(np.where(np.isnan(apart), np.inf, apart), axis=0)
    each = np.arange(len(exact))
    return found[best + 1, each], apart[best, each]


def _central_map(exact: Orbits, halves: np.ndarray, size: float) -> np.ndarray:
    """Return the maps (n, 3, 3) of small displacements over so many half periods."""
    states, columns = scaled_states(exact.points, exact.finals), []
    for component, own in enumerate((size, size, size * _FILM)):
        ends = []
        for displacement in (own, -own):
            displaced = states.copy()
            displaced[:, component] += displacement
            ends.append(travelled_states(exact.points, displaced, halves, _EXACT))
        columns.append((ends[0] - ends[1]) / (2.0 * own))
    return np.stack(columns, axis=2)


def _compared(rtol: float, exact: Orbits, reference: np.ndarray) -> dict[str, Any]:
    found = orbits(exact.points, max_error=1.0, **at(rtol))
    same = found.same_counts(exact) & ~np.isnan(reference)
    same &= found.errors(exact) <= _ELSEWHERE
    found, true = found[same], reference[same]
    errors = np.abs(found.floquet_multiplier - true)
    errors[np.isnan(errors)] = 1.0
    allowed = np.maximum(_ALLOWED_ROOTS * np.sqrt(rtol) / np.maximum(1.0 - true, 1e-6), _ALLOWED)
    return {
        "compared": len(found),
        "held": float(np.mean(errors <= allowed)) if len(found) else float("nan"),
        "error_median": quantile(errors, 50),
        "error_95": quantile(errors, 95),
        "error_99": quantile(errors, 99),
        "error_max": float(errors.max(initial=0.0)),
        "missed": descriptions(
            found.points, errors > allowed, true=true, found=found.floquet_multiplier
        ),
    }
