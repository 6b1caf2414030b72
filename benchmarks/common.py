"""What several benchmarks share: random points, errors of amplitudes, timings, the two modes."""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from environment import write_results
from pages.headlines import headline

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


def arguments(
    description: str | None, full: str = "the same here", parts: Iterable[str] = ()
) -> argparse.Namespace:
    """The command line of a script: `--quick`, `--full` with what it does more, some `parts`."""
    parser = argparse.ArgumentParser(description=(description or "").split("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="keeps the script alive, no more")
    parser.add_argument("--full", action="store_true", help=f"also what takes long: {full}")
    if parts := list(parts):
        parser.add_argument("parts", nargs="*", metavar="PART", help=f"only {', '.join(parts)}")
    chosen = parser.parse_args()
    if parts and (unknown := set(chosen.parts) - set(parts)):
        parser.error(f"no part is called {', '.join(sorted(unknown))}")
    return chosen


def finish(name: str, results: dict[str, Any], *, quick: bool) -> Path:
    """Print the headline and write the results where those of this mode belong."""
    print()
    for what, value in headline(name, results).items():
        print(f"{what:66}  {value}")
    path = write_results(f"quick/{name}" if quick else name, {"quick": quick} | results)
    print(path)
    return path


def random_points(count: int, seed: int) -> np.ndarray:
    """Rows (count, parameters) drawn from all over the range of the paper's claims."""
    rng = np.random.default_rng(seed)

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    return np.array(
        [
            Parameters(
                temperature=rng.uniform(150, 330),
                viscosity_coefficient=log_uniform(1e4, 3e5),
                spring_stiffness=log_uniform(500, 1e4),
                rheological_index=rng.choice(INDICES),
                angular_frequency=log_uniform(5, 60),
            )
            for _ in range(count)
        ]
    )


def box_points(count: int, seed: int, **ranges: tuple[str, float, float]) -> np.ndarray:
    """Rows (count, parameters) from a box: each "linear" or "log" between two values."""
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
    """The column of a parameter."""
    return points[:, Parameters._fields.index(name)]


def column(results: np.ndarray, name: str) -> np.ndarray:
    """The column of a result."""
    return results[:, RESULT_COLUMNS.index(name)]


def amplitudes(results: np.ndarray) -> np.ndarray:
    """Amplitudes of stress [Pa] and force [N], (n, 2)."""
    return np.column_stack([column(results, name) for name in AMPLITUDES])


def good(results: np.ndarray) -> np.ndarray:
    """Which points ended ok."""
    return column(results, "status") == Status.OK


def amplitude_errors(points: np.ndarray, amplitudes: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Errors of the amplitudes of stress and force (n, 2), as `amplitude_error` counts them.

    Relative to the amplitude, or to 1 % of max(2K, M omega^2)|X_m| (over A for the stress) where
    that is more.
    """
    inertia = parameter(points, "block_mass") * parameter(points, "angular_frequency") ** 2
    force = _FLOOR * np.maximum(2.0 * parameter(points, "spring_stiffness"), inertia)
    force = force * np.abs(parameter(points, "drive_amplitude"))
    floors = np.column_stack([force / parameter(points, "contact_area"), force])
    return np.abs(amplitudes[:, :2] - exact[:, :2]) / np.maximum(exact[:, :2], floors)


def error_bars(true: np.ndarray, stated: np.ndarray, resolved: float) -> dict[str, Any]:
    """True errors (n,), and how the stated ones bound them, as far as the reference resolves."""
    from scipy.stats import spearmanr

    seen = np.maximum(true, resolved)
    return {
        "compared": len(true),
        "error_median": quantile(true, 50),
        "error_95": quantile(true, 95),
        "error_max": float(true.max(initial=0.0)),
        "held": float(np.mean(true <= stated + resolved)) if len(true) else float("nan"),
        "far_off": int(np.sum(true > _FAR_OFF * stated + resolved)),
        "over_median": quantile(stated / seen, 50),
        "over_95": quantile(stated / seen, 95),
        "rank_correlation": float(spearmanr(stated, seen)[0]) if len(true) > 2 else float("nan"),
    }


def missed(
    points: np.ndarray, true: np.ndarray, stated: np.ndarray, of: np.ndarray, resolved: float
) -> list[dict[str, Any]]:
    """Those `of` the points whose stated error is below the true one, with both."""
    return [
        described(points[i], true=float(true[i]), stated=float(stated[i]))
        for i in np.flatnonzero(of & (true > stated + resolved))
    ]


def statuses(results: np.ndarray) -> dict[str, int]:
    """How many points ended how."""
    codes, counts = np.unique(column(results, "status").astype(int), return_counts=True)
    return {Status(c).name.lower(): int(n) for c, n in zip(codes, counts, strict=True)}


def described(point: np.ndarray, **more: Any) -> dict[str, Any]:
    """A point in words, for a list of exceptions."""
    return {name: float(f"{point[i]:.6g}") for i, name in enumerate(DESCRIPTION)} | more


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """What a call returns, and its seconds."""
    begun = time.perf_counter()
    value = call()
    return value, time.perf_counter() - begun


def median_seconds(call: Callable[[], Any], runs: int) -> float:
    """Median of so many timings [s]."""
    return statistics.median(timed(call)[1] for _ in range(runs))


def medians_in_turn(calls: Sequence[Callable[[], Any]], runs: int) -> list[float]:
    """Medians of so many timings [s] of each call, in turn: what disturbs one disturbs all."""
    rounds = [[timed(call)[1] for call in calls] for _ in range(runs)]
    return [statistics.median(times) for times in zip(*rounds, strict=True)]


def quantile(values: np.ndarray, percent: float) -> float:
    """A percentile as a plain number; NaN for nothing."""
    return float(np.percentile(values, percent)) if len(values) else float("nan")


def orbits(points: np.ndarray, options: Options) -> np.ndarray:
    """Result rows of the stationary orbits, (n, columns)."""
    return compute_orbits(points, options)[0]


def not_ok(points: np.ndarray, results: np.ndarray) -> list[dict[str, Any]]:
    """Points that did not end ok, with their status."""
    return [
        described(points[i], status=int(column(results, "status")[i]))
        for i in np.flatnonzero(~good(results))
    ]


def spread(values: np.ndarray) -> dict[str, float]:
    """Median, 95 % and largest of some numbers."""
    return {"median": quantile(values, 50), "95": quantile(values, 95), "max": float(values.max())}


def same_counts(results: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Points that are ok in both and have the same counts: others end on another orbit."""
    same = good(results) & good(reference)
    for name in COUNTS:
        same &= column(results, name) == column(reference, name)
    return same
