"""Trajectories of Euler-Cromer, one at a time, by the scalar integrator."""

from __future__ import annotations

import math
from typing import Any

from stickslip.compiled.decorators import inline, jit, kernel_factory, named_kernel
from stickslip.kernels.streams import KEY_HIGH, KEY_LOW, PATH, PERIOD, SIGNS, first_sign, signs
from stickslip.kernels.trajectories import BITS, DRAWN, Samples, make_sample_step, make_trajectory
from stickslip.model import block, drive, film, noise
from stickslip.model.models import model_of
from stickslip.model.rhs import film_melting_function, relative_motion
from stickslip.model.state import STATE, State
from stickslip.numerics.euler_cromer import make_euler_cromer
from stickslip.options import Physics, Settings
from stickslip.parameters import Parameters


@inline
def _with_phi(p: Parameters, y: State) -> State:
    return y[0], y[1], math.exp(y[2])


@inline
def _as_it_is(p: Parameters, t: float, y: State) -> State:
    return y


@inline
def _draw_sign(s: Samples) -> float:
    stream = s.stream
    drawn = int(stream[DRAWN])
    if drawn % SIGNS == 0:
        low, high, path, period = stream[KEY_LOW], stream[KEY_HIGH], stream[PATH], stream[PERIOD]
        stream[BITS] = signs(low, high, path, period, float(drawn // SIGNS))
    sign, stream[BITS] = first_sign(stream[BITS])
    stream[DRAWN] += 1.0
    return sign


@kernel_factory
def euler_cromer_trajectory(physics: Physics) -> Any:
    """Return the kernel of a trajectory by Euler-Cromer; arguments as in `adaptive_trajectory`.

    The steps divide the drive period evenly, so they may be slightly shorter than dt.
    """
    equations = model_of(physics).equations
    stress_and_force = equations.exact
    relative_velocity = relative_motion(equations.upper).velocity
    sample_step, chance = make_sample_step(len(STATE)), physics.chance

    @inline
    def increments(p: Parameters, t: float, dt: float, y: State, xi: float) -> tuple[float, float]:
        x, v, phi = y
        u = relative_velocity(p, t, v)
        _, F = stress_and_force(p, u, phi)
        rate = film.order_parameter_rate(p, phi, film_melting_function(p, u))
        kick = noise.random_kick(p, dt, xi) if chance else noise.typical_kick(p, phi, dt)
        return dt * block.acceleration(p, x, v, F), dt * rate + kick

    @inline
    def observe(p: Parameters, t: float, h: float, y0: State, y1: State, s: Samples) -> None:
        zero = (0.0, 0.0, 0.0)
        sample_step(t, h, y0, y1, zero, zero, s)

    march = make_euler_cromer(increments, observe, *((_draw_sign,) if chance else ()))

    @jit
    def period(
        p: Parameters, settings: Settings, y: State, h: float, budget: int, s: Samples
    ) -> Any:
        steps = math.ceil(drive.period(p) / settings.dt)
        y, used, status = march(p, 0.0, drive.period(p), steps, y, budget, s)
        return y, h, used, status

    trajectory = make_trajectory(len(STATE), period, _with_phi, _as_it_is)
    return named_kernel(f"euler_cromer_trajectory[{physics}]", trajectory, makes_arrays=True)
