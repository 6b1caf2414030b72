"""Points drawn at random, their orbits, and how far some orbits are from others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stickslip.model.drive import full_forces
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, full_name

INDICES = (-2 / 3, -1 / 2, -1 / 3, 0, 1 / 3, 2 / 3)
DESCRIPTION = Parameters._fields[:5]
"""The parameters that vary between points, in the order of a row."""

AMPLITUDES = ("elastic_stress_amplitude", "friction_force_amplitude")
COUNTS = ("orbit_periods", "melting_count")
_FLOOR = 0.01  # of the force that springs or inertia need
_FAR_OFF = 3.0  # times the stated error


# --- points ---------------------------------------------------------------------------------------


def drawn(
    count: int, seed: int, draw: Callable[[np.random.Generator, int], Parameters]
) -> np.ndarray:
    """Return rows (count, parameters) of what `draw` makes of random numbers and of the row."""
    rng = np.random.default_rng(seed)
    return np.array([draw(rng, i) for i in range(count)])


def random_points(count: int, seed: int) -> np.ndarray:
    """Return rows (count, parameters) drawn from all over the range of the paper's claims."""
    return drawn(
        count,
        seed,
        lambda rng, _: Parameters(
            temperature=rng.uniform(150, 330),
            viscosity_coefficient=log_uniform(rng, 1e4, 3e5),
            spring_stiffness=log_uniform(rng, 500, 1e4),
            rheological_index=rng.choice(INDICES),
            angular_frequency=log_uniform(rng, 5, 60),
        ),
    )


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


class Log(NamedTuple):
    """A range in which logarithms are uniform."""

    low: float
    high: float


def box(seed: int, **ranges: tuple[float, float]) -> Callable[[int], np.ndarray]:
    """Return what draws so many films (n, parameters), within ranges of parameters by symbol."""

    def points(count: int) -> np.ndarray:
        rng, rows = np.random.default_rng(seed), np.tile(Parameters(), (count, 1))
        for symbol, ends in ranges.items():
            log = isinstance(ends, Log)
            values = rng.uniform(*(np.log(ends) if log else ends), count)
            parameter(rows, full_name(symbol))[:] = np.exp(values) if log else values
        return rows

    return points


def parameter(points: np.ndarray, name: str) -> np.ndarray:
    """Return the column of a parameter, a view."""
    return points[:, Parameters._fields.index(name)]


def description(point: np.ndarray, **more: Any) -> dict[str, Any]:
    """Return a point in words, for a list of exceptions."""
    return {name: float(f"{point[i]:.6g}") for i, name in enumerate(DESCRIPTION)} | more


def descriptions(
    points: np.ndarray, which: np.ndarray, **columns: np.ndarray
) -> list[dict[str, Any]]:
    """Return some of the points in words, with their numbers out of these columns."""
    return [
        description(points[i], **{name: float(values[i]) for name, values in columns.items()})
        for i in np.flatnonzero(which)
    ]


# --- orbits ---------------------------------------------------------------------------------------


class Orbits:
    """The stationary orbits of points: `rows` of results (n, columns) and `finals`, their states.

    A result is the attribute of its name (n,); an index picks some of the orbits.
    """

    def __init__(self, points: np.ndarray, rows: np.ndarray, finals: np.ndarray) -> None:
        self.points, self.rows, self.finals = points, rows, finals

    def __getattr__(self, name: str) -> np.ndarray:
        if name not in RESULT_COLUMNS:
            raise AttributeError(name)
        return self.rows[:, RESULT_COLUMNS.index(name)]

    def __getitem__(self, which: Any) -> Orbits:
        return Orbits(self.points[which], self.rows[which], self.finals[which])

    def __len__(self) -> int:
        return len(self.points)

    @property
    def ok(self) -> np.ndarray:
        """Which of them ended ok."""
        return self.status == Status.OK

    @property
    def amplitudes(self) -> np.ndarray:
        """Amplitudes of stress [Pa] and force [N], (n, 2)."""
        return np.column_stack([getattr(self, name) for name in AMPLITUDES])

    def statuses(self) -> dict[str, int]:
        """Return how many ended how."""
        return count_by_name(self.status)

    def same_counts(self, other: Orbits) -> np.ndarray:
        """Return which are ok in both and have the same counts: others are other orbits."""
        same = [getattr(self, name) == getattr(other, name) for name in COUNTS]
        return self.ok & other.ok & np.all(same, axis=0)

    def errors(self, exact: Orbits | np.ndarray) -> np.ndarray:
        """Return the errors of the worse amplitude (n,)."""
        amplitudes = exact.amplitudes if isinstance(exact, Orbits) else exact
        return amplitude_errors(self.points, self.amplitudes, amplitudes).max(axis=1)

    def error_bars(
        self, exact: Orbits | np.ndarray, of: np.ndarray, resolved: float
    ) -> dict[str, Any]:
        """Return the errors `of` some orbits, and how the stated ones bound them."""
        true = self.errors(exact)[of]
        return error_bars(self.points[of], true, self.amplitude_error[of], resolved)


def orbits(points: np.ndarray, **options: Any) -> Orbits:
    """Return the stationary orbits of points; the options are fields of `Options`."""
    return Orbits(points, *compute_orbits(points, Options(**options)))


def at(rtol: float) -> dict[str, float]:
    """Return the options for a tolerance of the integration and of stationarity."""
    return {"rtol": rtol, "stationary_rtol": rtol}


def count_by_name(codes: np.ndarray) -> dict[str, int]:
    """Return how many of these statuses there are, by name."""
    values, counts = np.unique(np.asarray(codes).astype(int), return_counts=True)
    return {Status(v).name.lower(): int(n) for v, n in zip(values, counts, strict=True)}


# --- errors ---------------------------------------------------------------------------------------


def amplitude_errors(points: np.ndarray, found: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Return errors of amplitudes of stress and force (n, 2), as `amplitude_error` counts them.

    Relative to the amplitude, or to 1 % of max(2K, M omega^2)|X_m|, summed over the harmonics (over
    A for the stress), where that is more.
    """
    force = _FLOOR * full_forces(points)
    floors = np.column_stack([force / parameter(points, "contact_area"), force])
    return np.abs(found - exact) / np.maximum(exact, floors)


def error_bars(
    points: np.ndarray, true: np.ndarray, stated: np.ndarray, resolved: float
) -> dict[str, Any]:
    """Return relative errors, and how the stated ones bound them.

    As far as the reference resolves; `missed` are those whose stated error is below the true one.
    """
    return {
        "compared": len(true),
        "error_median": quantile(true, 50),
        "error_95": quantile(true, 95),
        "error_max": float(true.max(initial=0.0)),
        "held": float(np.mean(true <= stated + resolved)) if len(true) else float("nan"),
        "far_off": int(np.sum(true > _FAR_OFF * stated + resolved)),
        "over_median": quantile(stated / np.maximum(true, resolved), 50),
        "missed": descriptions(points, true > stated + resolved, true=true, stated=stated),
    }


def quantile(values: np.ndarray, percent: float) -> float:
    """Return a percentile as a plain number; NaN for nothing."""
    return float(np.percentile(values, percent)) if len(values) else float("nan")


def spread(values: np.ndarray) -> dict[str, float]:
    """Return median, 95 % and largest of some numbers."""
    return {"median": quantile(values, 50), "95": quantile(values, 95), "max": float(values.max())}
