"""Films that hardly lose a memory of their start: verdicts, and the errors of means.

Weakly viscous films go round in cycles of many drive periods, or wander without end. What is called
aperiodic is compared with a plain iteration by the scalar drive from rest, long cycles are shown to
close there too, and stated errors of means to cover the true mean.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from inside.scalar import scalar_amplitudes, scalar_states, starting_state
from shared.points import (
    amplitude_errors,
    amplitudes,
    box_points,
    column,
    description,
    good,
    orbits,
    statuses,
    worse_errors,
)

from stability.stated import everywhere
from stickslip.measure.window import error_of_mean
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters
from stickslip.status import Status

_SEED = 2904
_PERIODS = 5000
_SETTLING, _PLAIN = 500, 3000
_RTOL = 1e-8
_SIGMAS = 3.0  # of a mean that its stated error has
_LONG = 32  # drive periods: a cycle that the first search does not look for
_CLOSED = 1e-5

# Films that wander (T, k, K, gamma, omega).
WANDERING = (
    (160.0, 1e5, 3000.0, -0.9, 10.0),
    (205.9, 22802.0, 2349.9, -2 / 3, 35.874),
    (151.78, 42088.0, 3606.9, -0.7822, 33.081),
    (262.39, 125.43, 5275.6, -0.5, 5.2979),
    (207.2, 784.25, 2167.4, -2 / 3, 13.929),
)
_WINDOWS, _LENGTHS = 100, (32, 64, 200)


def weakly_viscous(count: int) -> np.ndarray:
    """Return rows (count, parameters)."""
    return box_points(
        count,
        _SEED,
        rheological_index=("linear", -0.9, -0.5),
        viscosity_coefficient=("log", 100, 3e3),
        angular_frequency=("linear", 10, 60),
        temperature=("linear", 150, 300),
        spring_stiffness=("log", 500, 1e4),
    )


def run(quick: bool) -> dict[str, Any]:
    """Measure coverage of stated errors, verdicts on two boxes, and plain iterations."""
    covered = [_coverage(film, 8 if quick else _WINDOWS) for film in WANDERING]
    points = weakly_viscous(20 if quick else 400)
    weak, results, finals = _ended(points)
    return {
        "windows": covered,
        "weakly_viscous": weak,
        "everywhere": _ended(everywhere(20 if quick else 500))[0],
        "aperiodic": _plain(points, results, 2 if quick else 20, 200 if quick else _PLAIN),
        "long_cycles": _long_cycles(points, results, finals),
    }


def _coverage(film: tuple[float, ...], count: int) -> dict[str, Any]:
    """Return how often the mean over a window is off by no more than stated, by length.

    The windows are those of as many starts a thousandth of the drive's amplitude apart, forgotten
    before they begin; the true mean is that of all windows of the longest kind. Starts that end on
    a cycle are no windows.
    """
    names = (*Parameters._fields[:3], "rheological_index", "angular_frequency")
    p = Parameters(**dict(zip(names, film, strict=True)))
    apart = 1e-3 * p.drive_amplitude * np.random.default_rng(5).uniform(-1.0, 1.0, count)
    points = np.array([p._replace(initial_displacement=float(x)) for x in apart])
    found = {
        length: orbits(points, Options(window=length, max_periods=_PERIODS, max_error=1.0))
        for length in _LENGTHS
    }
    longest = found[_LENGTHS[-1]]
    truth = amplitudes(longest)[_wander(longest)].mean(axis=0)
    rows = {}
    for length, results in found.items():
        wanders = _wander(results)
        off = worse_errors(points, results, np.tile(truth, (count, 1)))
        stated = column(results, "amplitude_error")
        rows[str(length)] = {
            "aperiodic": int(wanders.sum()),
            "covered": float(np.mean((off <= stated)[wanders])),
            "stated_median": float(np.median(stated[wanders])),
            "off_median": float(np.median(off[wanders])),
        }
    return {"film": description(points[0]), "lengths": rows}


def _wander(results: np.ndarray) -> np.ndarray:
    return np.asarray(column(results, "status") == Status.APERIODIC)


def _ended(points: np.ndarray) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    results, finals = compute_orbits(points, Options(max_periods=_PERIODS))
    row = {
        "points": len(points),
        "statuses": statuses(results),
        "periods": int(column(results, "periods_integrated").sum()),
        "most_periods": int(column(results, "periods_integrated").max()),
    }
    return row, results, finals


def _plain(points: np.ndarray, results: np.ndarray, count: int, periods: int) -> dict[str, Any]:
    """Compare means of films called aperiodic with those of plain iteration from rest.

    How far apart they are, in standard errors of the two, summed in squares.
    """
    wander = np.flatnonzero(_wander(results))[:count]
    rows = []
    for i in wander:
        singles = _single_periods(points[i], periods)
        own, theirs = amplitudes(results[i : i + 1])[0], singles.mean(axis=0)
        scale = amplitude_errors(points[i : i + 1], own[None] + theirs, theirs[None])[0] / own
        stated = column(results, "amplitude_error")[i] / scale
        errors = np.array([error_of_mean(np.ascontiguousarray(a)[None]) for a in singles.T])
        apart = np.abs(own - theirs) / (np.hypot(stated, errors) / _SIGMAS)
        rows.append(description(points[i], standard_errors_apart=float(apart.max())))
    return {"periods": periods, "films": rows}


def _single_periods(row: np.ndarray, periods: int) -> np.ndarray:
    """Return amplitudes (periods, 2) of single periods by the scalar drive, after some."""
    start = np.array(starting_state(row))
    states = scalar_states(row, start, _SETTLING + periods, _RTOL)[_SETTLING:]
    return np.array([scalar_amplitudes(row, state, 1, _RTOL)[:2] for state in states])


def _long_cycles(points: np.ndarray, results: np.ndarray, finals: np.ndarray) -> dict[str, Any]:
    """Return cycles of many drive periods, which still close after as many more as `_PLAIN`."""
    long = np.flatnonzero(good(results) & (column(results, "orbit_periods") > _LONG))
    rows = []
    for i in long:
        cycle = int(column(results, "orbit_periods")[i])
        states = scalar_states(points[i], finals[i, :3], _PLAIN + cycle, _RTOL)
        motion = states[:, :2] / np.abs(states[:, :2]).max(axis=0)
        distances = np.abs(motion[_PLAIN:] - motion[_PLAIN - cycle : -cycle]).max()
        rows.append(description(points[i], periods=cycle, distance=float(distances)))
    return {"found": len(rows), "closed": sum(r["distance"] < _CLOSED for r in rows), "films": rows}
