"""How much Eq. 23 changes the amplitudes, by another integrator: LSODA on both models.

The changes are as small as 1e-9; ours are differences of two orbits at rtol 1e-12. Here LSODA, that
of numbalsoda, goes three drive periods on from the same settled states, and the extrema of the last
one are sampled, then sampled again finely around each.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from common import AMPLITUDES, arguments
from numba import carray, cfunc, njit
from numbalsoda import lsoda, lsoda_sig
from peers.scaled import FLAGS

from stickslip import Parameters, stationary_orbit
from stickslip.kernels.points import parameters_of
from stickslip.model.models import model_of
from stickslip.options import ADIABATIC, RELAXING, Physics

SCENES = {
    "the paper's film": Parameters(),
    "T = 250 K": Parameters(temperature=250.0),
    "omega = 38 rad/s": Parameters(angular_frequency=38.0),
    "h, tau, k = 1e-6, 1e-5, 5e5": Parameters(
        film_thickness=1e-6, strain_relaxation_time=1e-5, viscosity_coefficient=5e5
    ),
}
TOLERANCES = (1e-11, 1e-12)
PERIODS, SAMPLES = 3, 8001
TIGHT, MOST_STEPS = 1e-12, 100_000_000
_COUNT = len(Parameters._fields)


def main() -> None:
    tolerances = TOLERANCES[:1] if arguments(__doc__).quick else TOLERANCES
    for name, p in SCENES.items():
        orbits = {strain: _settled(p, strain) for strain in (ADIABATIC, RELAXING)}
        before, after = (_amplitudes(orbits[strain]) for strain in (ADIABATIC, RELAXING))
        print(name, "ours", [b / a - 1.0 for a, b in zip(before, after, strict=True)])
        for rtol in tolerances:
            found = [_by_lsoda(p, strain, orbit, rtol) for strain, orbit in orbits.items()]
            print(f"    LSODA at {rtol:.0e}", [b / a - 1.0 for a, b in zip(*found, strict=True)])


def _settled(p: Parameters, strain: str) -> Any:
    return stationary_orbit(p, strain=strain, rtol=TIGHT)


def _amplitudes(orbit: Any) -> list[float]:
    return [getattr(orbit, name) for name in AMPLITUDES]


def _make(strain: str) -> tuple[Any, Any]:
    """The right-hand side in units of X_m, X_m omega and the strain at that speed; observables."""
    model = model_of(Physics("power-law", strain)).equations
    rhs, observables, width = model.rhs, model.observables, 3 if strain == ADIABATIC else 4

    @njit(**FLAGS)
    def units(p):
        V = p.drive_amplitude * p.angular_frequency
        return p.drive_amplitude, V, V * p.strain_relaxation_time / p.film_thickness

    @cfunc(lsoda_sig, **FLAGS)
    def rates(s, state, out, row):
        p = parameters_of(carray(row, (_COUNT,)))
        y, dy, omega = carray(state, (width,)), carray(out, (width,)), p.angular_frequency
        X, V, strain_unit = units(p)
        if width == 3:
            x, u, psi = rhs(p, s / omega, (y[0] * X, y[1] * V, y[2]), 0.0)
        else:
            x, u, psi, eps = rhs(p, s / omega, (y[0] * X, y[1] * V, y[2], y[3] * strain_unit), 0.0)
            dy[3] = eps / (strain_unit * omega)
        dy[0], dy[1], dy[2] = x / V, u / (V * omega), psi / omega

    @njit(**FLAGS)
    def observe(row, states, out):
        p = parameters_of(row)
        X, V, strain_unit = units(p)
        for i in range(states.shape[0]):
            y, phi = states[i], math.exp(states[i, 2])
            if width == 3:
                out[i] = observables(p, (y[0] * X, y[1] * V, y[2]), phi, 0.0)
            else:
                own = (y[0] * X, y[1] * V, y[2], y[3] * strain_unit)
                out[i] = observables(p, own, phi, 0.0)

    return rates, observe


_MODELS = {strain: _make(strain) for strain in (ADIABATIC, RELAXING)}


def _by_lsoda(p: Parameters, strain: str, orbit: Any, rtol: float) -> list[float]:
    """Amplitudes of stress [Pa] and force [N] over the last of a few periods."""
    rates, observe = _MODELS[strain]
    row, V = np.array(p), p.drive_amplitude * p.angular_frequency
    x, v, psi, *rest = orbit.state
    unit = V * p.strain_relaxation_time / p.film_thickness
    state = np.array([x / p.drive_amplitude, -v / V, psi, *(eps / unit for eps in rest)])

    def go(begin: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        states, success = lsoda(rates.address, begin, times, row, rtol, 1e-2 * rtol, MOST_STEPS)
        if not success:
            raise RuntimeError("LSODA reports no success")
        seen = np.empty((len(times), 2))
        observe(row, states, seen)
        return states, seen

    def extrema(column: int) -> Iterator[float]:
        for sign in (1.0, -1.0):
            place = int(np.argmax(sign * seen[:, column]))
            first, last = max(place - 2, 0), min(place + 2, len(times) - 1)
            around = go(states[first].copy(), np.linspace(times[first], times[last], SAMPLES))[1]
            yield (sign * around[:, column]).max()

    for _ in range(PERIODS - 1):
        state = go(state, np.array([0.0, 2.0 * math.pi]))[0][-1].copy()
    times = np.linspace(0.0, 2.0 * math.pi, SAMPLES)
    states, seen = go(state, times)
    return [0.5 * sum(extrema(column)) for column in range(2)]


if __name__ == "__main__":
    main()
