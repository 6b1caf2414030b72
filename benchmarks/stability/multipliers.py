"""Floquet multipliers against central differences of the map of an orbit at 1e-10, on two boxes.

The reference takes copies on both sides, displaced by four sizes in turn; the two that agree best
give it, and tell how far to trust it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from shared.points import (
    box_points,
    column,
    description,
    good,
    quantile,
    same_counts,
    worse_errors,
)

from stability.stated import wide
from stickslip.kernels.adaptive.tangents import travelled
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import motions_of
from stickslip.model.models import model_of
from stickslip.options import Options
from stickslip.orbit import compute_orbits

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


def paper(count: int) -> np.ndarray:
    """Return films (count, parameters) from all over the range of the paper's claims."""
    return box_points(
        count,
        4901,
        temperature=("linear", 150, 330),
        viscosity_coefficient=("log", 1e4, 3e5),
        spring_stiffness=("log", 500, 1e4),
        angular_frequency=("linear", 5, 60),
        rheological_index=("linear", -2 / 3, 2 / 3),
    )


BOXES: dict[str, Callable[[int], np.ndarray]] = {"paper": paper, "wide": wide}


def run(quick: bool) -> dict[str, Any]:
    """Measure the errors of multipliers in each box, at each tolerance."""
    return {name: _answer(points(10 if quick else 200)) for name, points in BOXES.items()}


def _answer(points: np.ndarray) -> dict[str, Any]:
    exact, finals = compute_orbits(points, _options(_EXACT))
    reference, doubt = central_multipliers(points, exact, finals)
    known = good(exact) & (doubt <= _DOUBTFUL)
    return {"known": int(known.sum())} | {
        str(rtol): _compared(points, rtol, exact, np.where(known, reference, np.nan))
        for rtol in _TOLERANCES
    }


def _options(rtol: float) -> Options:
    return Options(rtol=rtol, stationary_rtol=rtol, max_error=1.0)


def central_multipliers(
    points: np.ndarray, results: np.ndarray, finals: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the multipliers (n,) of orbits from central differences, and their doubts (n,).

    `results` and `finals` are those of the orbits at the tolerance of the reference; NaN for those
    that are not ok.
    """
    physics = Options().physics
    states = finals.copy()
    conversion_of(physics).scale_states(points, states)
    halves = 2 * np.nan_to_num(column(results, "orbit_periods")).astype(np.int64)
    rows = np.flatnonzero(good(results))
    found = np.full((len(_SIZES), len(points)), np.nan)
    for size, radii in zip(_SIZES, found, strict=True):
        maps = _central_map(points[rows], states[rows], halves[rows], size)
        radii[rows] = [np.abs(np.linalg.eigvals(m)).max() for m in np.nan_to_num(maps, nan=1e9)]
    apart = np.abs(np.diff(found, axis=0))
    best = np.argmin(np.where(np.isnan(apart), np.inf, apart), axis=0)
    each = np.arange(len(points))
    return found[best + 1, each], apart[best, each]


def _central_map(
    points: np.ndarray, states: np.ndarray, halves: np.ndarray, size: float
) -> np.ndarray:
    """Return the maps (n, width, width) of small displacements over so many half periods."""
    physics = Options().physics
    width = model_of(physics).width
    sizes = size * np.where(np.arange(width) == 2, _FILM, 1.0)
    reduced = motions_of(points, physics).points
    columns = []
    for component in range(width):
        ends = []
        for side in (1.0, -1.0):
            displaced = states.copy()
            displaced[:, component] += side * sizes[component]
            ends.append(travelled(reduced, displaced, halves, _EXACT, physics))
        columns.append((ends[0] - ends[1]) / (2.0 * sizes[component]))
    return np.stack(columns, axis=2)


def _compared(
    points: np.ndarray, rtol: float, exact: np.ndarray, reference: np.ndarray
) -> dict[str, Any]:
    found = compute_orbits(points, _options(rtol))[0]
    same = same_counts(found, exact) & ~np.isnan(reference)
    same &= worse_errors(points, found, exact) <= _ELSEWHERE
    of = np.flatnonzero(same)
    multipliers, true = column(found, "floquet_multiplier")[of], reference[of]
    errors = np.abs(multipliers - true)
    errors[np.isnan(errors)] = 1.0
    allowed = np.maximum(_ALLOWED_ROOTS * np.sqrt(rtol) / np.maximum(1.0 - true, 1e-6), _ALLOWED)
    worst = [i for i in np.argsort(-errors / allowed)[:5] if errors[i] > allowed[i]]
    return {
        "compared": len(of),
        "held": float(np.mean(errors <= allowed)) if len(of) else float("nan"),
        "error_median": quantile(errors, 50),
        "error_95": quantile(errors, 95),
        "error_99": quantile(errors, 99),
        "error_max": float(errors.max(initial=0.0)),
        "missed": [
            description(points[of[i]], true=float(true[i]), found=float(multipliers[i]))
            for i in worst
        ],
    }
