"""Steps at equal error of the adaptive method with another tableau, or without one of its parts.

Each variant follows random points of five fluids over three drive periods from the start, over a
ladder of tolerances. The errors are those of the last period.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from inside.variants import OTHER, OWN, VARIANTS, Course, course_with
from shared.measuring import measure
from shared.points import amplitude_errors, drawn, log_uniform, parameter

from stickslip.parameters import Parameters

GAMMAS = (-2 / 3, -1 / 3, 0.0, 1 / 3, 2 / 3)
SEED, POINTS, FEW = 7, 40, 2
QUICK = (OWN, OTHER, "without the rounded cusp")

LADDER = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
COMPARED = {"1e-06": 4, "1e-08": 6}
"""The tolerances on the ladder at which the error of the package's own method is the target."""

USUAL, LAST = COMPARED["1e-06"], len(LADDER) - 1
REFERENCE, CHECK = 1e-12, 1e-11
"""Tolerances of the reference, and of a run of another tableau that must agree with it."""

_LEAST = 1e-14  # an error below this is rounding
_RESAMPLES = 300


def variants(quick: bool) -> dict[str, Any]:
    """Compare the variants at random points of each fluid."""
    runs = {name: course_with(VARIANTS[name]) for name in (QUICK if quick else VARIANTS)}
    points, fluids = drawn(len(GAMMAS) * POINTS, SEED, _draw), {}
    for i, gamma in enumerate(GAMMAS[:1] if quick else GAMMAS):
        fluid = _fluid(points[i * POINTS :][: FEW if quick else POINTS], runs)
        fluids[f"{gamma:.2f}"] = fluid
        print(f"gamma = {gamma:.2f}: references agree to", fluid["check_of_reference"], flush=True)
    return {"points": FEW if quick else POINTS, "fluids": fluids}


def _draw(rng: np.random.Generator, i: int) -> Parameters:
    return Parameters(
        rheological_index=GAMMAS[i // POINTS],
        temperature=rng.uniform(155, 285),
        angular_frequency=log_uniform(rng, 5, 60),
        viscosity_coefficient=log_uniform(rng, 1e3, 1e6),
    )


Run = Callable[[np.ndarray, float], Course]

STEPS, AMPLITUDE, MOTION, ATTEMPTED, ACCEPTED = range(5)
"""Numbers of a run: steps a period, two errors, and the steps of the last period."""


def _fluid(points: np.ndarray, runs: dict[str, Run]) -> dict[str, Any]:
    """Return what each variant takes, and the largest errors of the check of the reference."""
    exact = [runs[OWN](point, REFERENCE) for point in points]

    def numbers(name: str, rtol: float) -> list[tuple[float, ...]]:
        return [_numbers(p, runs[name](p, rtol), e) for p, e in zip(points, exact, strict=True)]

    check = np.max(numbers(OTHER, CHECK), axis=0)[[AMPLITUDE, MOTION]]
    tables = {name: np.array([numbers(name, rtol) for rtol in LADDER]) for name in runs}
    rows = {name: _row(tables[OWN], table) for name, table in tables.items()}
    return {"check_of_reference": check.tolist(), "variants": rows}


def _numbers(point: np.ndarray, course: Course, exact: Course) -> tuple[float, ...]:
    """Return the numbers of a run.

    The first error is that of the worse amplitude. The second is the largest at the sampled times,
    of x in X_m, of u in X_m omega, and of the force in its amplitude.
    """
    row, amplitudes = point[None], exact.amplitudes[None]
    x, u, force = np.abs(course.samples - exact.samples).max(axis=0)
    size = abs(float(parameter(row, "drive_amplitude")[0]))
    speed = size * float(parameter(row, "angular_frequency")[0])
    in_force = amplitude_errors(row, np.add(amplitudes, (0.0, force)), amplitudes).max()
    of_amplitudes = amplitude_errors(row, course.amplitudes[None], amplitudes).max()
    errors = (max(float(e), _LEAST) for e in (of_amplitudes, max(x / size, u / speed, in_force)))
    return course.steps, *errors, course.attempted, course.accepted


def _row(own: np.ndarray, table: np.ndarray) -> dict[str, Any]:
    """Return what a variant takes, from the numbers (tolerances, points, 5) of runs."""
    at_usual = table[USUAL]
    attempted, accepted = at_usual[:, [ATTEMPTED, ACCEPTED]].sum(axis=0)
    growth = np.log(table[LAST] / table[LAST - 1])[:, STEPS].mean()
    return {
        "steps_at_equal_error": {at: _compared(own, table, i) for at, i in COMPARED.items()},
        "times_more_steps_at_the_last_tolerance": float(np.exp(growth)),
        "rejected": float(1.0 - accepted / attempted),
        "largest_error_of_amplitude": float(at_usual[:, AMPLITUDE].max()),
        "most_steps_saved_by_it": float(1.0 - (own[USUAL] / at_usual)[:, STEPS].min()),
    }


def _compared(own: np.ndarray, table: np.ndarray, rung: int) -> list[dict[str, float | None]]:
    """Return ratios of steps at equal error of either kind, with standard errors.

    The standard errors are from resamples of the points.
    """
    count, rng, found = own.shape[1], np.random.default_rng(SEED), []
    resamples = rng.integers(0, count, (_RESAMPLES, count))
    for error in (AMPLITUDE, MOTION):
        mine, its = (np.log(each[:, :, [STEPS, error]]) for each in (own, table))
        ratio, *again = (
            _ratio(mine[:, some], its[:, some], rung) for some in (np.arange(count), *resamples)
        )
        # Without one, where some resamples lack a ratio: the others are no fair sample.
        deviation = None if None in again else float(np.std(np.array(again, float)))
        found.append({"ratio": ratio, "standard_error": deviation})
    return found


def _ratio(own: np.ndarray, other: np.ndarray, rung: int) -> float | None:
    """Return the ratio of steps at the mean error of the own method at a tolerance.

    The arguments are logarithms of steps and error (tolerances, points, 2). None where the error of
    the other method does not fall so far.
    """
    steps, error = own[rung].mean(axis=0)
    other_steps, errors = other.mean(axis=1).T
    falling = np.minimum.accumulate(errors)
    if not falling[-1] <= error <= falling[0]:
        return None
    return float(np.exp(np.interp(-error, -falling, other_steps) - steps))


if __name__ == "__main__":
    measure("methods", __doc__, {"variants": variants})
