"""A slow but obviously correct twin: the equations again, in plain Python with SciPy's solvers.

It shares nothing with `model` and `numerics`, so that it repeats none of their mistakes.
"""

from __future__ import annotations

import math
import warnings

import numpy as np

from stickslip.parameters import Parameters

_D_EFF_OVER_D = 0.28072974  # exp(E ln chi^2_1)


def right_hand_side(t: float, y: np.ndarray, p: Parameters) -> list[float]:
    """Rates of (x, v, ln phi) in SI units: Eqs. 2, 3, 10, 24, 26 and the noise closure.

    For a state (x, v, ln phi, eps) Eq. 23 replaces Eq. 24.
    """
    x, v, psi, *own_strain = y
    phi = math.exp(psi)
    V = upper_velocity(t, p)
    adiabatic = (V - v) * p.strain_relaxation_time / p.film_thickness
    strain = own_strain[0] if own_strain else adiabatic
    force = friction_force(V - v, phi, p, strain)
    B = 2 * p.thermal_coefficient * (p.temperature - p.critical_temperature)
    B += p.elastic_coefficient * strain**2
    growth = B - p.cubic_coefficient * phi + p.quartic_coefficient * phi**2
    growth += -p.quintic_coefficient * phi**3 + p.sextic_coefficient * phi**4
    noise = _D_EFF_OVER_D * p.noise_intensity / max(phi**2, 1e-300)
    acceleration = (force - 2 * p.spring_stiffness * x) / p.block_mass
    relaxing = [(adiabatic - strain) / p.strain_relaxation_time] * len(own_strain)
    return [v, acceleration, noise - p.kinetic_coefficient * growth, *relaxing]


def upper_velocity(t: float, p: Parameters) -> float:
    """Velocity of the upper block [m/s], Eq. 2 with harmonics."""
    omega, V = p.angular_frequency, 0.0
    for n, part in ((1, 1.0), (3, p.third_harmonic), (5, p.fifth_harmonic)):
        V -= part * p.drive_amplitude * n * omega * math.sin(n * omega * t)
    return V


def elastic_stress(u: float, phi: float, p: Parameters, strain: float | None = None) -> float:
    """Elastic stress [Pa], Eq. 13; without a strain by Eq. 24 at relative velocity `u` [m/s]."""
    adiabatic = u * p.strain_relaxation_time / p.film_thickness
    return p.elastic_coefficient * phi**2 * (adiabatic if strain is None else strain)


def friction_force(u: float, phi: float, p: Parameters, strain: float | None = None) -> float:
    """Friction force [N], Eqs. 10 and 11."""
    sign = 1.0 if u >= 0 else -1.0
    viscous = p.viscosity_coefficient * (abs(u) / p.film_thickness) ** (p.rheological_index + 1)
    return (elastic_stress(u, phi, p, strain) + sign * viscous) * p.contact_area


def starting_state(p: Parameters) -> list[float]:
    """Start (x_0, v_0, ln phi) with phi_0 raised to the level of the noise."""
    D_eff = _D_EFF_OVER_D * p.noise_intensity
    levels = []
    if p.quartic_coefficient:
        levels.append((D_eff / (p.quartic_coefficient * p.kinetic_coefficient)) ** 0.25)
    if p.sextic_coefficient:
        levels.append((D_eff / (p.sextic_coefficient * p.kinetic_coefficient)) ** (1 / 6))
    if p.cubic_coefficient:
        levels.append((D_eff / (p.cubic_coefficient * p.kinetic_coefficient)) ** (1 / 3))
    linear = 2 * p.thermal_coefficient * p.kinetic_coefficient
    linear *= p.temperature - p.critical_temperature
    if linear:
        levels.append(math.sqrt(D_eff / abs(linear)))
    phi = max(p.initial_order_parameter, min(levels))
    return [p.initial_displacement, p.initial_velocity, math.log(phi)]


def trajectory(
    p: Parameters,
    times: np.ndarray,
    method: str = "LSODA",
    rtol: float = 1e-8,
    *,
    relaxing: bool = False,
) -> np.ndarray:
    """States (x, v, ln phi) at `times` [s] from the start, shape (n, 3), by SciPy's `method`.

    With a `relaxing` strain they are (x, v, ln phi, eps), shape (n, 4).

    Raises RuntimeError if the solver gives up.
    """
    from scipy.integrate import solve_ivp

    X_m, start = abs(p.drive_amplitude), starting_state(p)
    sizes = [X_m, X_m * p.angular_frequency, 1.0]
    if relaxing:  # the drive begins at rest
        slope = p.strain_relaxation_time / p.film_thickness
        start.append(-p.initial_velocity * slope)
        sizes.append(X_m * p.angular_frequency * slope)
    solution = solve_ivp(
        right_hand_side,
        (float(times[0]), float(times[-1])),
        start,
        method=method,
        t_eval=times,
        args=(p,),
        rtol=rtol,
        atol=[rtol * size for size in sizes],
    )
    if not solution.success:
        raise RuntimeError(solution.message)
    return np.asarray(solution.y.T)


def work_of_a_period(p: Parameters, start: np.ndarray, rtol: float = 1e-9) -> tuple[float, float]:
    """Work [J] of a cosine in a period from a state (x, v, ln phi), by LSODA.

    The second number is the change of the state over the period, relative to X_m, X_m omega and 1.
    The relative velocity is a separate variable, as the rounding of V - v would hide a tiny slip.
    The work is the integral of F (V - v), which is complete if the state returns.

    Raises RuntimeError if the solver gives up, as it often does at the cusp of a law.
    """
    from scipy.integrate import solve_ivp

    X_m, omega = abs(p.drive_amplitude), p.angular_frequency
    energy = p.spring_stiffness * X_m**2

    def rates(phase: float, y: np.ndarray) -> list[float]:
        t, u = phase / omega, y[1] * X_m * omega
        v, force = upper_velocity(t, p) - u, friction_force(u, math.exp(y[2]), p)
        _, _, growth = right_hand_side(t, np.array([y[0] * X_m, v, y[2]]), p)
        # The same force, with u instead of the rounded V - v.
        v_rate = (force - 2 * p.spring_stiffness * y[0] * X_m) / p.block_mass
        u_rate = -p.drive_amplitude * omega**2 * math.cos(phase) - v_rate
        over_time = [v / X_m, u_rate / (X_m * omega), growth, force * u / energy]
        return [rate / omega for rate in over_time]

    x, v, psi = start
    begin = np.array([x / X_m, -v / (X_m * omega), psi, 0.0])
    atol = [rtol, 1e-6 * rtol, rtol, 1e-20]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # LSODA warns before it gives up
        solution = solve_ivp(
            rates, (0.0, 2.0 * math.pi), begin, "LSODA", rtol=rtol, atol=atol, max_step=0.05
        )
    if not solution.success:
        raise RuntimeError(solution.message)
    end = solution.y[:, -1]
    return float(end[3] * energy), float(np.abs(end - begin)[:3].max())


def map_of_displacements(p: Parameters, state: np.ndarray, size: float) -> np.ndarray:
    """Map (3, 3) of small displacements of (x, v, ln phi) over a drive period.

    It takes central differences at a state on an orbit, with `size` in units of X_m, X_m omega and
    0.01.
    """
    from scipy.integrate import solve_ivp

    X_m, period = abs(p.drive_amplitude), 2 * math.pi / p.angular_frequency
    units = np.array([X_m, X_m * p.angular_frequency, 100.0])

    def end(start: np.ndarray) -> np.ndarray:
        solution = solve_ivp(
            right_hand_side,
            (0.0, period),
            start,
            "LSODA",
            t_eval=[period],
            args=(p,),
            rtol=1e-11,
            atol=1e-11 * units * [1.0, 1.0, 0.01],
        )
        return np.asarray(solution.y[:, -1])

    columns = [
        (end(state + step) - end(state - step)) / (2.0 * size) for step in np.diag(size * units)
    ]
    return np.stack(columns, axis=1) / units[:, None]
