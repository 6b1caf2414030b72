"""The two integrators bound to the model: one drive period with each.

`adaptive_period` and `fixed_period` have the same signature: (p, settings, y, h, budget, record) to
(y, h, steps, status). The adaptive method has the state (x, v, ln phi) and remembers the step h to
go on with; Euler-Cromer has the state (x, v, phi) and remembers nothing.
"""

from __future__ import annotations

import math
from typing import Any

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.elementary import exponentials
from stickslip.kernels.observers import Record, see_fixed_step, see_step
from stickslip.kernels.rows import Settings, period_of
from stickslip.model import film, noise
from stickslip.model.rhs import (
    State,
    block_acceleration,
    film_melting_function,
    jacobian,
    relative_velocity,
    rhs,
    stress_and_force,
)
from stickslip.numerics.adaptive import make_adaptive
from stickslip.numerics.euler_cromer import make_fixed
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.parameters import Parameters

# An error of the velocity counts also by the error of the force that it makes, against this many
# times the force that locks the block: a locked block moves with the drive to parts in 1e5, and its
# slip must be right, not just its speed.
_FORCE_WEIGHT = 20.0
_LARGEST_AT_CUSP = 100.0


# The cusp of a pseudoplastic fluid is rounded below this many tolerances of X_m omega: there the
# velocity is not known anyway, and a step may cross the cusp without falling into it.
_ROUNDING = 1.0

# Where the noise holds ln(phi) up, it forgets an error at the rate 2 D_eff/phi^2. The error counts
# less there, by this many times that rate over the film's own, but at least a thousandth.
_FORGETTING_WEIGHT, _LARGEST_RELIEF = 10.0, 1000.0
_SLOWEST_FILM = 100.0  # rates omega

Scene = tuple[Parameters, float]
"""What the adaptive method integrates: parameters, and the speed below which a cusp is rounded."""


@inline
def scene_of(p: Parameters, rtol: float) -> Scene:
    """The scene of `p` for a tolerance."""
    return p, _ROUNDING * rtol * (abs(p.drive_amplitude) * p.angular_frequency)


@inline
def scene_rhs(scene: Scene, t: float, y: State) -> State:
    """The right-hand side of a scene."""
    return rhs(scene[0], t, y, scene[1])


@inline
def scene_jacobian(scene: Scene, t: float, y: State) -> tuple[State, State, State, State]:
    """The Jacobian of a scene."""
    return jacobian(scene[0], t, y, scene[1])


@inline
def error_weight(scene: Scene, y: State, J: tuple[State, State, State, State]) -> State:
    """Weights [1/m, s/m, 1] with which the errors of (x, v, ln phi) count."""
    p, _ = scene
    X_m = abs(p.drive_amplitude)
    V_m = X_m * p.angular_frequency
    locking = 2.0 * p.spring_stiffness * X_m + p.block_mass * p.angular_frequency * V_m
    force = V_m * (-J[1][1] * p.block_mass) / (_FORCE_WEIGHT * locking)
    if p.rheological_index < 0.0:  # the slope of the rounded cusp grows with the tolerance
        force = _LARGEST_AT_CUSP if force > _LARGEST_AT_CUSP else force
    _, inverse_phi = exponentials(y[2])
    D_eff = noise.effective_intensity(p.noise_intensity)
    forgetting = _FORGETTING_WEIGHT * (2.0 * noise.typical_path(inverse_phi, D_eff))
    heating = 2.0 * p.thermal_coefficient * abs(p.temperature - p.critical_temperature)
    own = _SLOWEST_FILM * p.angular_frequency + p.kinetic_coefficient * heating
    most = _LARGEST_RELIEF * own
    forgetting = most if forgetting > most else forgetting
    return 1.0 / X_m, (1.0 + force) / V_m, own / ((1.0 + abs(y[2])) * (own + forgetting))


@inline
def _see(
    scene: Scene, t: float, h: float, y0: State, y1: State, d1: State, d2: State, record: Record
) -> None:
    see_step(scene[0], t, h, y0, y1, d1, d2, record)


_travel = make_adaptive(scene_rhs, scene_jacobian, error_weight, _see, RODAS4P2)


@jit
def adaptive_period(
    p: Parameters, settings: Settings, y: State, h: float, budget: int, record: Record
) -> Any:
    """One drive period of the adaptive method from the state (x, v, ln phi)."""
    scene = scene_of(p, settings.rtol)
    return _travel(scene, settings.rtol, 0.0, period_of(p), y, h, budget, record)


@inline
def same_state(y: State) -> State:
    """The state (x, v, ln phi) for itself."""
    return y


@inline
def _increments(p: Parameters, t: float, dt: float, y: State) -> tuple[float, float]:
    """What v and phi gain in a fixed step from the old state (Eqs. 3 and 26)."""
    x, v, phi = y
    u = relative_velocity(p, t, v)
    _, F = stress_and_force(p, u, phi)
    rate = film.order_parameter_rate(
        phi,
        film_melting_function(p, u),
        p.cubic_coefficient,
        p.quartic_coefficient,
        p.kinetic_coefficient,
    )
    kick = noise.typical_kick(phi, noise.effective_intensity(p.noise_intensity), dt)
    return dt * block_acceleration(p, x, F), dt * rate + kick


_march = make_fixed(_increments, see_fixed_step)


@inline
def _fixed_steps(p: Parameters, settings: Settings) -> int:
    """Steps a period: the drive period is divided evenly, so a step may be a little below dt."""
    return math.ceil(period_of(p) / settings.dt)


@jit
def fixed_period(
    p: Parameters, settings: Settings, y: State, h: float, budget: int, record: Record
) -> Any:
    """One drive period of Euler-Cromer from the state (x, v, phi)."""
    steps = _fixed_steps(p, settings)
    y, used, status = _march(p, 0.0, period_of(p), steps, y, budget, record)
    return y, h, used, status


@inline
def log_state(y: State) -> State:
    """The state (x, v, ln phi) for a state (x, v, phi)."""
    return y[0], y[1], math.log(y[2])


@inline
def phi_state(y: State) -> State:
    """The state (x, v, phi) for a state (x, v, ln phi)."""
    return y[0], y[1], math.exp(y[2])
