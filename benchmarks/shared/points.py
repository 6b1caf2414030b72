"""Points drawn at random, and how far the results of some are from those of others."""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.model.drive import full_forces
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

INDICES = (-2 / 3, -1 / 2, -1 / 3, 0, 1 / 3, 2 / 3)
DESCRIPTION = Parameters._fields[:5]
"""The parameters that vary between points, in the order of a row."""

AMPLITUDES = ("elastic_stress_amplitude", "friction_force_amplitude")
COUNTS = ("orbit_periods", "melting_count")
_FLOOR = 0.01  # of the force that springs or inertia need
_FAR_OFF = 3.0  # times the stated error


# --- points ---------------------------------------------------------------------------------------


def random_points(count: int, seed: int) -> np.ndarray:
    """Return rows (count, parameters) drawn from all over the range of the paper's claims."""
    rng = np.random.default_rng(seed)
    return np.array(
        [
            Parameters(
                temperature=rng.uniform(150, 330),
                viscosity_coefficient=log_uniform(rng, 1e4, 3e5),
                spring_stiffness=log_uniform(rng, 500, 1e4),
                rheological_index=rng.choice(INDICES),
                angular_frequency=log_uniform(rng, 5, 60),
            )
            for _ in range(count)
        ]
    )


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def box_points(count: int, seed: int, **ranges: tuple[str, float, float]) -> np.ndarray:
    """Return rows (count, parameters) from a box: each "linear" or "log" between two values."""
    rng = np.random.default_rng(seed)
    columns = {
        name: rng.uniform(low, high, count)
        if scale == "linear"
        else np.exp(rng.uniform(np.log(low), np.log(high), count))
        for name, (scale, low, high) in ranges.items()
    }
    return np.array(
        [
            Parameters(**{name: float(values[i]) for name, values in columns.items()})
            for i in range(count)
        ]
    )


def parameter(points: np.ndarray, name: str) -> np.ndarray:
    """Return the column of a parameter."""
    return points[:, Parameters._fields.index(name)]


def description(point: np.ndarray, **more: Any) -> dict[str, Any]:
    """Return a point in words, for a list of exceptions."""
    return {name: float(f"{point[i]:.6g}") for i, name in enumerate(DESCRIPTION)} | more


# --- results --------------------------------------------------------------------------------------


def orbits(points: np.ndarray, options: Options) -> np.ndarray:
    """Return result rows of the stationary orbits, (n, columns)."""
    return compute_orbits(points, options)[0]


def column(results: np.ndarray, name: str) -> np.ndarray:
    """Return the column of a result."""
    return results[:, RESULT_COLUMNS.index(name)]


def amplitudes(results: np.ndarray) -> np.ndarray:
    """Return amplitudes of stress [Pa] and force [N], (n, 2)."""
    return np.column_stack([column(results, name) for name in AMPLITUDES])


def good(results: np.ndarray) -> np.ndarray:
    """Return which points ended ok."""
    return column(results, "status") == Status.OK


def statuses(results: np.ndarray) -> dict[str, int]:
    """Count how many points ended how."""
    return count_by_name(column(results, "status"))


def count_by_name(codes: np.ndarray) -> dict[str, int]:
    """Count these statuses, by name."""
    values, counts = np.unique(np.asarray(codes).astype(int), return_counts=True)
    return {Status(v).name.lower(): int(n) for v, n in zip(values, counts, strict=True)}


def same_counts(results: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return points that are ok in both and have the same counts: others end on another orbit."""
    same = good(results) & good(reference)
    for name in COUNTS:
        same &= column(results, name) == column(reference, name)
    return same


# --- errors ---------------------------------------------------------------------------------------


def amplitude_errors(points: np.ndarray, found: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Return errors of the amplitudes of stress and force (n, 2), as `amplitude_error` counts them.

    Relative to the amplitude, or to 1 % of max(2K, M omega^2)|X_m|, summed over the harmonics (over
    A for the stress), where that is more. The first two columns of `found` and `exact` are the
    amplitudes.
    """
    force = _FLOOR * full_forces(points)
    floors = np.column_stack([force / parameter(points, "contact_area"), force])
    return np.abs(found[:, :2] - exact[:, :2]) / np.maximum(exact[:, :2], floors)


def worse_errors(points: np.ndarray, found: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Return errors of the worse amplitude (n,)."""
    return amplitude_errors(points, found, exact).max(axis=1)


def error_bars(
    points: np.ndarray, results: np.ndarray, exact: np.ndarray, of: np.ndarray, resolved: float
) -> dict[str, Any]:
    """Return the errors `of` some points, and how the stated ones bound them.

    As far as the reference resolves; `missed` are those whose stated error is below the true one.
    """
    from scipy.stats import spearmanr

    points, true = points[of], worse_errors(points, results, exact)[of]
    stated, resolvable = column(results, "amplitude_error")[of], np.maximum(true, resolved)
    rank = float(spearmanr(stated, resolvable)[0]) if len(true) > 2 else float("nan")
    return {
        "compared": len(true),
        "error_median": quantile(true, 50),
        "error_95": quantile(true, 95),
        "error_max": float(true.max(initial=0.0)),
        "held": float(np.mean(true <= stated + resolved)) if len(true) else float("nan"),
        "far_off": int(np.sum(true > _FAR_OFF * stated + resolved)),
        "over_median": quantile(stated / resolvable, 50),
        "over_95": quantile(stated / resolvable, 95),
        "rank_correlation": rank,
        "missed": [
            description(points[i], true=float(true[i]), stated=float(stated[i]))
            for i in np.flatnonzero(true > stated + resolved)
        ],
    }


def quantile(values: np.ndarray, percent: float) -> float:
    """Return a percentile as a plain number; NaN for nothing."""
    return float(np.percentile(values, percent)) if len(values) else float("nan")


def spread(values: np.ndarray) -> dict[str, float]:
    """Return median, 95 % and largest of some numbers."""
    return {"median": quantile(values, 50), "95": quantile(values, 95), "max": float(values.max())}
