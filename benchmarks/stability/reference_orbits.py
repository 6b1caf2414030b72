"""Stationary orbits of 500 random points by plain iteration with the scalar drive: a reference.

Half an hour of two cores, run once; writes `tests/golden/random_orbits.csv`. 400 points are drawn
from far around the paper's values, 100 within 5 K of T_c. Each goes on from rest at a tolerance of
1e-10 until the remaining distance to a cycle of at most 32 drive periods is below 1e-9, or for 8000
periods; the orbit is then measured at 32 places in each step.
"""

from __future__ import annotations

import csv
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from inside.scalar import scalar_amplitudes, scalar_states, starting_state
from shared.points import DESCRIPTION, log_uniform

from stickslip.parameters import Parameters

PATH = Path(__file__).parents[2] / "tests" / "golden" / "random_orbits.csv"
COLUMNS = (
    *DESCRIPTION, "elastic_stress_amplitude", "friction_force_amplitude", "orbit_periods",
    "melting_count", "periods", "distance",
)  # fmt: skip

_WIDE, _NEAR = 400, 100
_SEED = 20261122
_RTOL = 1e-10
_ENOUGH = 1e-9
_CLOSE = 1e-5
_MOST_PERIODS = 8000
_AT_A_TIME = 64
_LONGEST = 32
# As in stickslip.model.state: ln phi is slaved to the motion and repeats less exactly.
_FILM_WEIGHT = 1e-3


def points() -> np.ndarray:
    """Return the rows of parameters (500, 20)."""
    rng, rows = np.random.default_rng(_SEED), []
    for i in range(_WIDE + _NEAR):
        near = i >= _WIDE
        rows.append(
            Parameters(
                temperature=rng.uniform(285, 295) if near else rng.uniform(100, 350),
                angular_frequency=log_uniform(rng, 2, 100) if near else rng.uniform(2, 100),
                viscosity_coefficient=log_uniform(rng, 5e2, 1e6),
                spring_stiffness=log_uniform(rng, 100, 2e4),
                rheological_index=-2 / 3 if rng.random() < 0.25 else rng.uniform(-0.9, 0.95),
            )
        )
    return np.array(rows)


def main() -> None:
    with ProcessPoolExecutor() as pool, PATH.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for i, row in enumerate(pool.map(reference, points(), chunksize=4)):
            writer.writerow(row)
            print(i, *row[len(DESCRIPTION) :], flush=True)


def reference(row: np.ndarray) -> list[float]:
    """Return a row of the table; an orbit of 0 periods is none that closed."""
    state, states = np.array(starting_state(row)), np.empty((0, 3))
    cycle, distance = 0, np.inf
    while cycle == 0 and len(states) < _MOST_PERIODS:
        more = scalar_states(row, state, _AT_A_TIME, _RTOL)
        states, state = np.concatenate([states, more]), more[-1]
        cycle, distance = _closed(_scaled(row, states))
    amplitudes = scalar_amplitudes(row, state, max(cycle, 1), _RTOL)
    return [*row[: len(DESCRIPTION)].tolist(), *amplitudes[:2], cycle, amplitudes[2], len(states),
            float(f"{distance:.2g}")]  # fmt: skip


def _scaled(row: np.ndarray, states: np.ndarray) -> np.ndarray:
    p = Parameters(*row)
    length = abs(p.drive_amplitude)
    film = np.maximum(states[:, 2], -300.0)
    return np.column_stack(
        [states[:, 0] / length, states[:, 1] / (length * p.angular_frequency), _FILM_WEIGHT * film]
    )


def _closed(z: np.ndarray) -> tuple[int, float]:
    """Return the cycle on which states (n, 3) end, 0 for none yet, and what distance is left."""
    for cycle in range(1, min(_LONGEST, len(z) // 3) + 1):
        moved, before = (np.abs(z[end] - z[end - cycle]).max() for end in (-1, -1 - cycle))
        # Where it no longer contracts it is at the noise: then the last displacement is all.
        left = moved * max(1.0, moved / (before - moved)) if moved < before else 10.0 * moved
        if left <= _ENOUGH:
            return cycle, float(left)
        if moved <= _CLOSE:
            return 0, np.inf  # on its way to this cycle: a longer one would close by chance
    return 0, np.inf


if __name__ == "__main__":
    main()
