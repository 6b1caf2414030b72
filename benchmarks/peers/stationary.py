"""The stationary amplitudes as a user of numbalsoda would compute them: plain iteration.

All in compiled code, so that what is timed is LSODA. One call of LSODA goes over several periods,
more and more of them, because each call starts anew at first order.
"""

from __future__ import annotations

import time
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from peers.scaled import EQUATIONS, FLAGS
from peers.solvers import MOST_STEPS, PeerFailed, right_hand_side
from stickslip.kernels.parameter_rows import parameters_of
from stickslip.kernels.trajectories import start_kernel
from stickslip.options import DEFAULTS
from stickslip.parameters import Parameters

stress_and_force, write_start = EQUATIONS.exact, start_kernel(DEFAULTS.physics)

_TURN = 2.0 * np.pi
_LONGEST_CYCLE = 8
_CONFIRMATIONS = 2
_SAMPLES = 2000  # a period
_CLOSE_UP = 400  # samples between the neighbours of a sampled extremum
_EXTREMA = 4

# As in stickslip.model.state: ln phi is slaved to the motion and repeats less exactly.
_FILM_WEIGHT = 1e-3

_OK, _LSODA_FAILED, _NOT_STATIONARY = range(3)
_REASONS = {
    _LSODA_FAILED: "LSODA fails or ends with NaN",
    _NOT_STATIONARY: "not stationary within the allowed periods",
}


class StationaryOrbit(NamedTuple):
    """Half of max - min of stress [Pa] and force [N], what they took, and the orbit's period."""

    elastic_stress_amplitude: float
    friction_force_amplitude: float
    periods: int
    orbit_periods: int
    seconds: float


def numbalsoda_stationary(
    parameters: Parameters, rtol: float, max_periods: int = 5000, stationary_rtol: float = 1e-6
) -> StationaryOrbit:
    """Return stationary amplitudes by plain iteration with LSODA from the start of `parameters`.

    The orbit is stationary if, over 1 to 8 periods, it repeats to `stationary_rtol` in
    (x/X_m, v/(X_m omega)) and the remaining distance of a geometric sequence is not larger,
    twice in a row. Two samplings of the closed orbit follow: 2000 states a period, and then 400
    around each of the four extrema. Call it once before timing: the first call compiles.

    Raises PeerFailed where LSODA fails or the orbit does not become stationary.
    """
    row = np.array(parameters, dtype=float)
    begun = time.perf_counter()
    amplitudes, periods, cycle, status = _compiled_search()(
        right_hand_side().address, row, rtol, max_periods, stationary_rtol
    )
    seconds = time.perf_counter() - begun
    if status != _OK:
        raise PeerFailed(_REASONS[status])
    return StationaryOrbit(*amplitudes, int(periods), int(cycle), seconds)


@njit(**FLAGS)
def _scaled_start(row: np.ndarray) -> np.ndarray:
    state = np.empty(3)
    write_start(row, state)
    p = parameters_of(row)
    X_m = abs(p.drive_amplitude)
    # At phase 0 the drive stands still: u = -v.
    return np.array([state[0] / X_m, -state[1] / (X_m * p.angular_frequency), state[2]])


@njit(**FLAGS)
def _distance(newer: np.ndarray, older: np.ndarray) -> float:
    difference = np.abs(newer - older)
    return max(difference[0], max(difference[1], _FILM_WEIGHT * difference[2]))


@njit(**FLAGS)
def _closing_cycle(states: np.ndarray, newest: int, tolerance: float) -> int:
    """Return smallest number of periods after which the orbit closes; 0 where it does not yet."""
    for cycle in range(1, _LONGEST_CYCLE + 1):
        if 2 * cycle > newest:
            return 0
        moved = _distance(states[newest], states[newest - cycle])
        before = _distance(states[newest - cycle], states[newest - 2 * cycle])
        near = moved < before and moved <= tolerance
        if moved <= 1e-3 * tolerance or (near and moved**2 <= tolerance * (before - moved)):
            return _shortest(states, newest, cycle, tolerance)
    return 0


@njit(**FLAGS)
def _shortest(states: np.ndarray, newest: int, cycle: int, tolerance: float) -> int:
    """Return the smallest divisor of `cycle` after which the state is the same but for noise."""
    for shorter in range(1, cycle):
        close = _distance(states[newest], states[newest - shorter]) <= 10.0 * tolerance
        if cycle % shorter == 0 and close:
            return shorter
    return cycle


@njit(**FLAGS)
def _observe(p: Any, s: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return elastic stress and friction force, shape (2, n), at the phases `s`."""
    observed = np.empty((2, len(s)))
    V_m = abs(p.drive_amplitude) * p.angular_frequency
    for i in range(len(s)):
        observed[0, i], observed[1, i] = stress_and_force(
            p, states[i, 1] * V_m, np.exp(states[i, 2])
        )
    return observed


@njit(**FLAGS)
def _peak(values: np.ndarray, sign: float) -> float:
    """Return largest sign*value, refined by the parabola through its neighbours."""
    best = 0
    for i in range(len(values)):
        if sign * values[i] > sign * values[best]:
            best = i
    if best in (0, len(values) - 1):
        return sign * values[best]
    left, top, right = sign * values[best - 1], sign * values[best], sign * values[best + 1]
    bend = left - 2.0 * top + right
    return top - (right - left) ** 2 / (8.0 * bend) if bend < 0.0 else top


@njit(**FLAGS)
def _close_ups(s: np.ndarray, observed: np.ndarray) -> np.ndarray:
    """Return phases between the neighbours of the four sampled extrema, in order."""
    phases = np.empty(_EXTREMA * _CLOSE_UP + 1)
    phases[0] = s[0]
    for k in range(_EXTREMA):
        values = observed[k // 2] if k % 2 == 0 else -observed[k // 2]
        best = min(max(int(np.argmax(values)), 1), len(s) - 2)
        part = np.linspace(s[best - 1], s[best + 1], _CLOSE_UP)
        phases[1 + k * _CLOSE_UP : 1 + (k + 1) * _CLOSE_UP] = part
    return np.unique(phases)


@cache
def _compiled_search() -> Any:
    from numbalsoda import lsoda

    @njit(**FLAGS)
    def settle(address, row, rtol, max_periods, tolerance):
        """Return stroboscopic state on the orbit, periods, cycle, status."""
        states = np.empty((max_periods + 1, 3))
        states[0] = _scaled_start(row)
        done, held, previous = 0, 0, 0
        while done < max_periods:
            chunk = min(1 + done // 8, max_periods - done)
            phases = _TURN * np.arange(chunk + 1)
            ends, success = lsoda(address, states[done].copy(), phases, row, rtol, rtol, MOST_STEPS)
            if not (success and np.isfinite(ends).all()):
                return states[done], done, 0, _LSODA_FAILED
            for j in range(1, chunk + 1):
                done += 1
                states[done] = ends[j]
                cycle = _closing_cycle(states, done, tolerance)
                held = held + 1 if cycle > 0 and cycle == previous else min(cycle, 1)
                previous = cycle
                if held >= _CONFIRMATIONS:
                    return states[done], done, cycle, _OK
        return states[done], done, 0, _NOT_STATIONARY

    @njit(**FLAGS)
    def search(address, row, rtol, max_periods, tolerance):
        """Return the two amplitudes, periods, cycle, status."""
        y, periods, cycle, status = settle(address, row, rtol, max_periods, tolerance)
        amplitudes = (np.nan, np.nan)
        if status != _OK:
            return amplitudes, periods, cycle, status
        p = parameters_of(row)
        s = np.linspace(0.0, cycle * _TURN, cycle * _SAMPLES + 1)
        states, success = lsoda(address, y.copy(), s, row, rtol, rtol, MOST_STEPS)
        observed = _observe(p, s, states)
        near = _close_ups(s, observed)
        close, success_too = lsoda(address, y.copy(), near, row, rtol, rtol, MOST_STEPS)
        if not (success and success_too and np.isfinite(observed).all()):
            return amplitudes, periods, cycle, _LSODA_FAILED
        finer = _observe(p, near, close)
        stress, force = 0.0, 0.0
        for sign in (1.0, -1.0):
            stress += 0.5 * _best(observed[0], finer[0], sign)
            force += 0.5 * _best(observed[1], finer[1], sign)
        return (stress, force), periods + cycle, cycle, _OK

    return search


@njit(**FLAGS)
def _best(coarse: np.ndarray, fine: np.ndarray, sign: float) -> float:
    """Return largest sign*value: sampled, and refined in the close-ups."""
    return max(np.max(sign * coarse), _peak(fine, sign))
