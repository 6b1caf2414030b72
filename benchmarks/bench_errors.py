"""True error of the amplitudes against the stated one, on random points at default settings.

The reference is the same computation at rtol 1e-9, its orbit at 1e-11. Points on which the two
end in different orbits (another number of meltings or periods) are listed, not averaged.
"""

from __future__ import annotations

import time

import numpy as np
from environment import write_results

from stickslip.kernels import RESULT_COLUMNS
from stickslip.orbit import Options, compute_orbits
from stickslip.parameters import Parameters

POINTS, SEED = 200, 2013
INDICES = (-2 / 3, -1 / 2, -1 / 3, 0, 1 / 3, 2 / 3)
REFERENCE = Options(rtol=1e-9, stationary_rtol=1e-9)


def main() -> None:
    points = random_points()
    results, seconds = _timed(points, Options())
    reference, reference_seconds = _timed(points, REFERENCE)
    errors = _errors(points, results, reference)
    stated = results[:, RESULT_COLUMNS.index("amplitude_error")]
    ok = (results[:, -1] == 0) & (reference[:, -1] == 0)
    same = ok & (results[:, 8] == reference[:, 8]) & (results[:, 9] == reference[:, 9])
    true = errors[same]
    summary = {
        "points": POINTS,
        "not ok at default": int((results[:, -1] != 0).sum()),
        "not ok at reference": int((reference[:, -1] != 0).sum()),
        "other orbit": points[ok & ~same, :5].tolist(),
        "error_median": float(np.median(true)),
        "error_95_percent": float(np.percentile(true, 95)),
        "error_max": float(true.max()),
        "bounded": float(np.mean(stated[same] >= true)),
        "overestimate_median": float(np.median(stated[same] / np.maximum(true, 1e-16))),
        "periods_median": float(np.median(results[ok, 11])),
        "periods_95_percent": float(np.percentile(results[ok, 11], 95)),
        "seconds_default": round(seconds, 2),
        "seconds_reference": round(reference_seconds, 2),
    }
    for name, value in summary.items():
        print(f"{name:22}{value}")
    print(write_results("errors", summary))


def random_points() -> np.ndarray:
    """The rows of parameters of the random points, shape (POINTS, 20)."""
    rng = np.random.default_rng(SEED)
    return np.array(
        [
            Parameters(
                temperature=rng.uniform(150, 330),
                viscosity_coefficient=np.exp(rng.uniform(np.log(1e4), np.log(3e5))),
                spring_stiffness=np.exp(rng.uniform(np.log(500), np.log(1e4))),
                rheological_index=rng.choice(INDICES),
                angular_frequency=rng.uniform(5, 60),
            )
            for _ in range(POINTS)
        ]
    )


def _timed(points: np.ndarray, options: Options) -> tuple[np.ndarray, float]:
    compute_orbits(points[:0], options)
    begun = time.perf_counter()
    results, _ = compute_orbits(points, options)
    return results, time.perf_counter() - begun


def _errors(points: np.ndarray, results: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Worse relative error of the two amplitudes, as `amplitude_error` is defined."""
    p = Parameters._fields
    K, X_m, A = (
        points[:, p.index(name)] for name in ("spring_stiffness", "drive_amplitude", "contact_area")
    )
    floor = 0.01 * 2 * K * np.abs(X_m)
    stress = np.abs(results[:, 0] - reference[:, 0]) / np.maximum(reference[:, 0], floor / A)
    force = np.abs(results[:, 1] - reference[:, 1]) / np.maximum(reference[:, 1], floor)
    return np.maximum(stress, force)


if __name__ == "__main__":
    main()
