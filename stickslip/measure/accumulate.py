"""What is measured over a stationary orbit: a record that compiled code fills step by step.

The record is an array of the slots below; the functions of this module
are the only ones that know them.
"""

from __future__ import annotations

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.model import drive, film
from stickslip.model.rhs import State, relative_velocity, stress_and_force
from stickslip.parameters import Parameters

# Slots: maxima of stress and force and of their negatives; integrals over time; extremes of the
# order parameter; the melting count with the first and the last phase that was seen.
(
    STRESS_MAX,
    STRESS_MINUS_MIN,
    FORCE_MAX,
    FORCE_MINUS_MIN,
    DRIVE_WORK,
    ABSOLUTE_WORK,
    BLOCK_WORK,
    PHI_MAX,
    MELTINGS,
    FIRST_PHASE,
    LAST_PHASE,
    SLOTS,
) = range(12)

# Behind the slots lie the values of stress and force at the nodes of the current step.
_NODES = 7
LENGTH = SLOTS + 2 * _NODES

_UNSEEN, _MELTED, _SOLID = 0.0, 1.0, 2.0


@inline
def stress_nodes(record: np.ndarray) -> np.ndarray:
    """Scratch for the stress at the nodes of a step, shape (7,)."""
    return record[SLOTS : SLOTS + _NODES]


@inline
def force_nodes(record: np.ndarray) -> np.ndarray:
    """Scratch for the force at the nodes of a step, shape (7,)."""
    return record[SLOTS + _NODES :]


@inline
def start(record: np.ndarray) -> None:
    """Make `record` ready for a new orbit."""
    for slot in range(LENGTH):
        record[slot] = 0.0
    for slot in (STRESS_MAX, STRESS_MINUS_MIN, FORCE_MAX, FORCE_MINUS_MIN):
        record[slot] = -np.inf


@inline
def see_phase(p: Parameters, phi: float, record: np.ndarray) -> None:
    """Update the extremes of the order parameter and count a melting."""
    record[PHI_MAX] = max(record[PHI_MAX], phi)
    solid = film.solid_threshold(
        p.temperature,
        p.thermal_coefficient,
        p.critical_temperature,
        p.cubic_coefficient,
        p.quartic_coefficient,
    )
    phase = _UNSEEN
    if phi >= solid:
        phase = _SOLID
    elif phi <= film.MELTED_PART * solid:
        phase = _MELTED
    if phase == _UNSEEN:
        return
    if phase == _MELTED and record[LAST_PHASE] == _SOLID:
        record[MELTINGS] += 1.0
    if record[FIRST_PHASE] == _UNSEEN:
        record[FIRST_PHASE] = phase
    record[LAST_PHASE] = phase


@inline
def see_work(
    p: Parameters, t: float, v: float, F: float, weight: float, record: np.ndarray
) -> None:
    """Add `weight` [s] times the powers of drive and block to the integrals."""
    V = drive.upper_velocity(t, p.drive_amplitude, p.angular_frequency)
    record[DRIVE_WORK] += weight * (F * V)
    record[ABSOLUTE_WORK] += weight * abs(F * V)
    record[BLOCK_WORK] += weight * (F * v)


@inline
def see_point(p: Parameters, t: float, dt: float, v: float, phi: float, record: np.ndarray) -> None:
    """Take in the state at one time, which stands for the interval `dt`."""
    sigma_el, F = stress_and_force(p, relative_velocity(p, t, v), phi)
    record[STRESS_MAX] = max(record[STRESS_MAX], sigma_el)
    record[STRESS_MINUS_MIN] = max(record[STRESS_MINUS_MIN], -sigma_el)
    record[FORCE_MAX] = max(record[FORCE_MAX], F)
    record[FORCE_MINUS_MIN] = max(record[FORCE_MINUS_MIN], -F)
    see_phase(p, phi, record)
    see_work(p, t, v, F, dt, record)


@jit
def meltings(record: np.ndarray) -> int:
    """Solid to liquid transitions, counted cyclically over the closed orbit."""
    wrapped = record[LAST_PHASE] == _SOLID and record[FIRST_PHASE] == _MELTED
    return int(record[MELTINGS]) + (1 if wrapped else 0)


@jit
def asymmetry(record: np.ndarray) -> float:
    """|max + min|/(max - min) of the elastic stress; 0 where max - min < 1 Pa."""
    high, low = record[STRESS_MAX], -record[STRESS_MINUS_MIN]
    return abs(high + low) / (high - low) if high - low >= 1.0 else 0.0


@jit
def block_energy(p: Parameters, y: State) -> float:
    """Energy of the lower block and its springs [J]: M v^2/2 + K x^2."""
    x, v, _ = y
    return 0.5 * p.block_mass * (v * v) + p.spring_stiffness * (x * x)


@jit
def power_balance_error(p: Parameters, record: np.ndarray, begin: State, end: State) -> float:
    """|work of the drive - dissipation - energy gained| / integral of |F V| over the orbit.

    The dissipation is the integral of F (V - v), so the difference of the first two is the work
    done on the block.
    """
    gained = block_energy(p, end) - block_energy(p, begin)
    absolute = record[ABSOLUTE_WORK]
    return abs(record[BLOCK_WORK] - gained) / absolute if absolute > 0.0 else 0.0


@jit
def balance_kept(p: Parameters, record: np.ndarray, error: float, cycle: int, limit: float) -> bool:
    """Whether the power balance holds to `limit`.

    The yardstick is at least a thousandth of the full spring force times the way of the drive:
    where the force vanishes, its work is rounding.
    """
    X_m = abs(p.drive_amplitude)
    floor = 0.001 * (2.0 * p.spring_stiffness * X_m) * (4.0 * X_m * cycle)
    return error * record[ABSOLUTE_WORK] <= limit * max(record[ABSOLUTE_WORK], floor)


@jit
def amplitudes(record: np.ndarray) -> tuple[float, float]:
    """Half of maximum minus minimum of elastic stress [Pa] and friction force [N]."""
    return (
        0.5 * (record[STRESS_MAX] + record[STRESS_MINUS_MIN]),
        0.5 * (record[FORCE_MAX] + record[FORCE_MINUS_MIN]),
    )


@jit
def amplitude_error(p: Parameters, record: np.ndarray, better: np.ndarray) -> float:
    """Worse relative difference of the two amplitudes between an orbit and a better one.

    Each counts against max(amplitude, 1 % of the full spring force 2K|X_m|), over A for a stress:
    near melting the stress itself is a meaningless yardstick.
    """
    floor = 0.01 * (2.0 * p.spring_stiffness * abs(p.drive_amplitude))
    stress, force = amplitudes(record)
    better_stress, better_force = amplitudes(better)
    stress_scale = max(better_stress, floor / p.contact_area)
    force_scale = max(better_force, floor)
    stress_error = abs(stress - better_stress) / stress_scale if stress_scale > 0.0 else 0.0
    force_error = abs(force - better_force) / force_scale if force_scale > 0.0 else 0.0
    return max(stress_error, force_error)


@jit
def bounds_kept(p: Parameters, record: np.ndarray, phi_start: float) -> bool:
    """Whether the order parameter stayed below the value that it cannot exceed."""
    bound = film.largest_order_parameter(
        p.temperature,
        p.thermal_coefficient,
        p.critical_temperature,
        p.cubic_coefficient,
        p.quartic_coefficient,
    )
    return record[PHI_MAX] <= max(bound, phi_start) * 1.001
