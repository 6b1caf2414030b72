"""Films that hardly lose a memory of their start: verdicts, and the errors of means.

Weakly viscous films go round in cycles of many drive periods, or wander without end. What is called
aperiodic is compared with a plain iteration by the scalar integrator from rest, long cycles are
shown to close there too, and stated errors of means to cover the true mean.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from inside.scalar import scalar_amplitudes, scalar_states, starting_state
from shared.points import Log, Orbits, amplitude_errors, box, description, orbits

from stability.stated import everywhere
from stickslip.measure.window import error_of_mean
from stickslip.parameters import Parameters
from stickslip.status import Status

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


_weakly_viscous = box(
    2904, gamma=(-0.9, -0.5), k=Log(100, 3e3), omega=(10, 60), T=(150, 300), K=Log(500, 1e4)
)


def run(quick: bool) -> dict[str, Any]:
    """Measure coverage of stated errors, verdicts on two boxes, and plain iterations."""
    covered = [_coverage(film, 8 if quick else _WINDOWS) for film in WANDERING]
    weak = orbits(_weakly_viscous(20 if quick else 400), max_periods=_PERIODS)
    others = orbits(everywhere(20 if quick else 500), max_periods=_PERIODS)
    return {
        "windows": covered,
        "weakly_viscous": {"points": len(weak), "statuses": weak.statuses()},
        "everywhere": {"points": len(others), "statuses": others.statuses()},
        "aperiodic": _plain(weak[_wander(weak)][: 2 if quick else 20], 200 if quick else _PLAIN),
        "long_cycles": _long_cycles(weak[weak.ok & (weak.orbit_periods > _LONG)]),
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
        length: orbits(points, window=length, max_periods=_PERIODS, max_error=1.0)
        for length in _LENGTHS
    }
    longest = found[_LENGTHS[-1]]
    truth = longest.amplitudes[_wander(longest)].mean(axis=0)
    rows = {}
    for length, each in found.items():
        wanders = _wander(each)
        off = each.errors(np.tile(truth, (count, 1)))
        covered = float(np.mean((off <= each.amplitude_error)[wanders]))
        rows[str(length)] = {"aperiodic": int(wanders.sum()), "covered": covered}
    return {"film": description(points[0]), "lengths": rows}


def _wander(found: Orbits) -> np.ndarray:
    return np.asarray(found.status == Status.APERIODIC)


def _plain(wandering: Orbits, periods: int) -> dict[str, Any]:
    """Compare means of films called aperiodic with those of plain iteration from rest.

    How far apart they are, in standard errors of the two, summed in squares.
    """
    rows = []
    for point, own, error in zip(
        wandering.points, wandering.amplitudes, wandering.amplitude_error, strict=True
    ):
        singles = _single_periods(point, periods)
        theirs = singles.mean(axis=0)
        scale = amplitude_errors(point[None], own[None] + theirs, theirs[None])[0] / own
        errors = np.array([error_of_mean(np.ascontiguousarray(a)[None]) for a in singles.T])
        apart = np.abs(own - theirs) / (np.hypot(error / scale, errors) / _SIGMAS)
        rows.append(description(point, standard_errors_apart=float(apart.max())))
    return {"periods": periods, "films": rows}


def _single_periods(row: np.ndarray, periods: int) -> np.ndarray:
    """Return amplitudes (periods, 2) of single periods by the scalar integrator, after some."""
    start = np.array(starting_state(row))
    states = scalar_states(row, start, _SETTLING + periods, _RTOL)[_SETTLING:]
    return np.array([scalar_amplitudes(row, state, _RTOL) for state in states])


def _long_cycles(long: Orbits) -> dict[str, Any]:
    """Return how well cycles of many drive periods close after as many more as `_PLAIN`."""
    rows = []
    for point, final, periods in zip(long.points, long.finals, long.orbit_periods, strict=True):
        cycle = int(periods)
        states = scalar_states(point, final[:3], _PLAIN + cycle, _RTOL)
        motion = states[:, :2] / np.abs(states[:, :2]).max(axis=0)
        distances = np.abs(motion[_PLAIN:] - motion[_PLAIN - cycle : -cycle]).max()
        rows.append(description(point, periods=cycle, distance=float(distances)))
    return {"found": len(rows), "closed": sum(r["distance"] < _CLOSED for r in rows), "films": rows}
