"""Acceleration against plain iteration: whether it is the same orbit, and periods it saves.

Random points as in `bench_errors.py`, default settings. Orbits are the same if both amplitudes
agree to 1e-3 and the periods of the orbit are equal; others are listed.
"""

from __future__ import annotations

import time

import numpy as np
from bench_errors import random_points
from environment import write_results

from stickslip.orbit import Options, compute_orbits

POINTS = 80


def main() -> None:
    points = random_points()[:POINTS]
    plain, plain_seconds = _timed(points, Options(accelerate=False))
    quick, quick_seconds = _timed(points, Options())
    both = (plain[:, -1] == 0) & (quick[:, -1] == 0)
    close = np.isclose(plain[:, :2], quick[:, :2], rtol=1e-3, atol=0).all(axis=1)
    same = (close | _both_liquid(plain, quick)) & (plain[:, 8] == quick[:, 8])
    summary = {
        "points": POINTS,
        "ok by plain iteration": int((plain[:, -1] == 0).sum()),
        "ok accelerated": int((quick[:, -1] == 0).sum()),
        "same orbit": int((both & same).sum()),
        "other orbit": points[both & ~same, :5].tolist(),
        "periods, plain (median, mean)": _periods(plain),
        "periods, accelerated (median, mean)": _periods(quick),
        "seconds, plain": round(plain_seconds, 1),
        "seconds, accelerated": round(quick_seconds, 1),
    }
    for name, value in summary.items():
        print(f"{name:38}{value}")
    print(write_results("stationarity", summary))


def _timed(points: np.ndarray, options: Options) -> tuple[np.ndarray, float]:
    compute_orbits(points[:0], options)
    begun = time.perf_counter()
    results, _ = compute_orbits(points, options)
    return results, time.perf_counter() - begun


def _both_liquid(plain: np.ndarray, quick: np.ndarray) -> np.ndarray:
    """Stresses below 1 Pa are those of a liquid film; then the forces decide."""
    forces = np.isclose(plain[:, 1], quick[:, 1], rtol=1e-3, atol=0)
    return (plain[:, 0] < 1.0) & (quick[:, 0] < 1.0) & forces


def _periods(results: np.ndarray) -> list[float]:
    return [float(np.median(results[:, 11])), round(float(results[:, 11].mean()), 1)]


if __name__ == "__main__":
    main()
