"""What is measured of an orbit in lanes: extrema, integrals and phases, half period by half period.

A lane integrates half a drive period and is then mirrored, (x, v) -> (-x, -v), so that it is
always at a phase between 0 and pi. Records are kept in the mirrored frame of the moment: when
the frame turns, maxima and minima change places.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.elementary import exponentials
from stickslip.compiled.simd import LANES, for_lanes
from stickslip.kernels.problem import Scene, scene_jacobian, scene_rhs
from stickslip.model import drive, film
from stickslip.model.rhs import (
    observables_and_rates,
    relative_velocity,
    stress_and_force,
)
from stickslip.model.scaling import Reduced
from stickslip.numerics.adaptive_lanes import (
    ACCEPTED,
    D10,
    D11,
    D12,
    D20,
    D21,
    D22,
    EVENT,
    FROM,
    OLD0,
    OLD1,
    OLD2,
    PARAMETERS,
    USED,
    at,
    put,
    state_of,
)
from stickslip.numerics.extrema import vertex
from stickslip.numerics.linear import Vector, larger
from stickslip.numerics.rosenbrock import interpolate

PARAMETER_SLOTS = len(Reduced._fields)
_FIRST = PARAMETERS + PARAMETER_SLOTS

# Slots of a record, in the units of model/units.py: maxima of stress and force and of their
# negatives; integrals of F v and |F V| over time; the largest order parameter; meltings; the
# first and the last phase seen. Behind it stress, force and their rates at the end of the last
# accepted step, and whether an extremum inside the step tried last could beat the record.
(
    STRESS_MAX, STRESS_MINUS_MIN, FORCE_MAX, FORCE_MINUS_MIN,
    BLOCK_WORK, ABSOLUTE_WORK, PHI_MAX, MELTINGS, FIRST_PHASE, LAST_PHASE,
    STRESS, FORCE, STRESS_RATE, FORCE_RATE, PROMISING,
    SLOTS,
) = range(_FIRST, _FIRST + 16)  # fmt: skip
RECORD = STRESS - STRESS_MAX
"""Length of a record."""

# Where a step is looked at, and the weights of Lobatto's quadrature.
_INNER = 0.5 * math.sqrt(0.2)
NODES = (0.0, 0.5 - _INNER, 0.5 + _INNER, 1.0)
WEIGHTS = (1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0)

Values = tuple[float, float, float, float]

_UNSEEN, MELTED, SOLID = 0.0, 1.0, 2.0


@inline
def _step_of(lanes: np.ndarray, lane: int) -> tuple[float, float, Vector, Vector, Vector, Vector]:
    """The step tried last: its begin, length, and what `interpolate` needs."""
    return (
        at(lanes, FROM, lane),
        at(lanes, USED, lane),
        (at(lanes, OLD0, lane), at(lanes, OLD1, lane), at(lanes, OLD2, lane)),
        state_of(lanes, lane),
        (at(lanes, D10, lane), at(lanes, D11, lane), at(lanes, D12, lane)),
        (at(lanes, D20, lane), at(lanes, D21, lane), at(lanes, D22, lane)),
    )


@inline
def _phase(p: Any, phi: float) -> float:
    """Solid, melted, or neither (the hysteresis of the count)."""
    solid = film.solid_threshold(
        p.temperature,
        p.thermal_coefficient,
        p.critical_temperature,
        p.cubic_coefficient,
        p.quartic_coefficient,
    )
    melted = MELTED if phi <= film.MELTED_PART * solid else _UNSEEN
    return SOLID if phi >= solid else melted


@inline
def _see_extrema(
    lanes: np.ndarray, lane: int, seen: bool, values: Values, rates: tuple[float, float], slot: int
) -> bool:
    """Update the record at `slot` with the values at the nodes; whether to look between them.

    That is so where the observable turns and what lies between could beat the record.
    """
    begin, first, second, end = values
    high, low = at(lanes, slot, lane), at(lanes, slot + 1, lane)
    put(lanes, slot, lane, larger(end, high) if seen else high)
    put(lanes, slot + 1, lane, larger(-end, low) if seen else low)
    top = larger(larger(first, second), end)
    bottom = larger(larger(-first, -second), -end)
    rise0, rise1, rise2 = first - begin, second - first, end - second
    turns = (rates[0] * rates[1] < 0.0) | (rise0 * rise1 < 0.0) | (rise1 * rise2 < 0.0)
    reach = abs(rise0) + abs(rise1) + abs(rise2)
    return seen & turns & ((top + reach >= high) | (bottom + reach >= low))


@inline
def _see_phase(lanes: np.ndarray, lane: int, p: Any, phi: float, seen: bool) -> None:
    """Update the largest order parameter and count a melting."""
    phase = _phase(p, phi)
    news = seen & (phase != _UNSEEN)
    first, last = at(lanes, FIRST_PHASE, lane), at(lanes, LAST_PHASE, lane)
    melts = news & (phase == MELTED) & (last == SOLID)
    put(lanes, MELTINGS, lane, at(lanes, MELTINGS, lane) + (1.0 if melts else 0.0))
    put(lanes, FIRST_PHASE, lane, phase if news & (first == _UNSEEN) else first)
    put(lanes, LAST_PHASE, lane, phase if news else last)
    largest = at(lanes, PHI_MAX, lane)
    put(lanes, PHI_MAX, lane, phi if seen & (phi > largest) else largest)


@inline
def _see_work(
    lanes: np.ndarray, lane: int, p: Any, t: float, used: float, v: Values, F: Values
) -> None:
    """Add a step to the integrals, by Lobatto's rule of order 6."""
    done, total = 0.0, 0.0
    for node in range(4):
        V = drive.upper_velocity(t + NODES[node] * used, p.drive_amplitude, p.angular_frequency)
        done += WEIGHTS[node] * (F[node] * v[node])
        total += WEIGHTS[node] * abs(F[node] * V)
    seen = at(lanes, ACCEPTED, lane) > 0.0  # a rejected step need not be finite
    work, size = at(lanes, BLOCK_WORK, lane), at(lanes, ABSOLUTE_WORK, lane)
    put(lanes, BLOCK_WORK, lane, work + used * done if seen else work)
    put(lanes, ABSOLUTE_WORK, lane, size + used * total if seen else size)


@inline
def _node(
    p: Any, t: float, used: float, theta: float, y0: Vector, y1: Vector, d1: Vector, d2: Vector
) -> Values:
    """Velocity, order parameter, stress and force on the continuous extension of a step."""
    _, v, psi = interpolate(theta, y0, y1, d1, d2)
    phi, _ = exponentials(psi)
    sigma, F = stress_and_force(p, relative_velocity(p, t + theta * used, v), phi)
    return v, phi, sigma, F


def make_see(scenes: Callable[..., Scene]) -> Any:
    """What takes in the step tried last, in every lane where it was accepted; maps lanes to None.

    `scenes(lanes, lane)` is the scene of a lane.
    """

    @inline
    def lane_see(lane: int, lanes: np.ndarray) -> None:
        p, u_s = scenes(lanes, lane)
        t, used, y0, y1, d1, d2 = _step_of(lanes, lane)
        seen = at(lanes, ACCEPTED, lane) > 0.0
        va, phia, sigmaa, Fa = _node(p, t, used, NODES[1], y0, y1, d1, d2)
        vb, phib, sigmab, Fb = _node(p, t, used, NODES[2], y0, y1, d1, d2)
        sigma1, F1, sigma_rate1, F_rate1 = observables_and_rates(p, t + used, y1, u_s)
        sigma0, F0 = at(lanes, STRESS, lane), at(lanes, FORCE, lane)
        sigma_rate0, F_rate0 = at(lanes, STRESS_RATE, lane), at(lanes, FORCE_RATE, lane)
        stresses, forces = (sigma0, sigmaa, sigmab, sigma1), (F0, Fa, Fb, F1)
        inside = _see_extrema(lanes, lane, seen, stresses, (sigma_rate0, sigma_rate1), STRESS_MAX)
        inside = inside | _see_extrema(lanes, lane, seen, forces, (F_rate0, F_rate1), FORCE_MAX)
        put(lanes, PROMISING, lane, 1.0 if inside else 0.0)
        put(lanes, EVENT, lane, 1.0 if inside else at(lanes, EVENT, lane))
        _see_phase(lanes, lane, p, phia, seen)
        _see_phase(lanes, lane, p, phib, seen)
        _see_phase(lanes, lane, p, exponentials(y1[2])[0], seen)
        _see_work(lanes, lane, p, t, used, (y0[1], va, vb, y1[1]), forces)
        put(lanes, STRESS, lane, sigma1 if seen else sigma0)
        put(lanes, FORCE, lane, F1 if seen else F0)
        put(lanes, STRESS_RATE, lane, sigma_rate1 if seen else sigma_rate0)
        put(lanes, FORCE_RATE, lane, F_rate1 if seen else F_rate0)

    @jit
    def see(lanes: np.ndarray) -> None:
        for_lanes(LANES, lane_see, (lanes,))

    return see


def make_start(scenes: Callable[..., Scene]) -> Any:
    """What makes a lane ready for half a period, with a new record if `fresh`.

    It maps (lanes, lane, fresh) to None.
    """

    @jit
    def start(lanes: np.ndarray, lane: int, fresh: bool) -> None:
        (p, u_s), y = scenes(lanes, lane), state_of(lanes, lane)
        values = observables_and_rates(p, 0.0, y, u_s)
        put(lanes, STRESS, lane, values[0])
        put(lanes, FORCE, lane, values[1])
        put(lanes, STRESS_RATE, lane, values[2])
        put(lanes, FORCE_RATE, lane, values[3])
        if fresh:
            for slot in range(STRESS_MAX, STRESS):
                put(lanes, slot, lane, -np.inf if slot < BLOCK_WORK else 0.0)

    return start


def make_refine(scenes: Callable[..., Scene], shorter_step: Any) -> Any:
    """The search for extrema inside a promising step; maps (lanes, lane) to None.

    It finds their places on the continuous extension and goes there with `shorter_step`, the step
    of the method: the extension is of lower order, and a force can be steep in it.
    """

    @jit
    def see_inside(lanes: np.ndarray, lane: int, t: float, y0: Vector, used: float) -> None:
        scene = scenes(lanes, lane)
        f, J = scene_rhs(scene, t, y0), scene_jacobian(scene, t, y0)
        _, v, psi = shorter_step(scene, t, y0, used, f, J)[0]
        phi, _ = exponentials(psi)
        sigma, F = stress_and_force(scene[0], relative_velocity(scene[0], t + used, v), phi)
        for slot, value in ((STRESS_MAX, sigma), (FORCE_MAX, F)):
            put(lanes, slot, lane, max(at(lanes, slot, lane), value))
            put(lanes, slot + 1, lane, max(at(lanes, slot + 1, lane), -value))

    @jit
    def see_vertices(lanes: np.ndarray, lane: int, values: Values) -> None:
        t, used, y0, _, _, _ = _step_of(lanes, lane)
        for i in range(2):
            x0, x1, x2 = NODES[i], NODES[i + 1], NODES[i + 2]
            place = vertex(x0, x1, x2, values[i], values[i + 1], values[i + 2])
            if x0 < place < x2:
                see_inside(lanes, lane, t, y0, place * used)

    @jit
    def refine(lanes: np.ndarray, lane: int) -> None:
        p, _ = scenes(lanes, lane)
        t, used, y0, y1, d1, d2 = _step_of(lanes, lane)
        _, _, sigma0, F0 = _node(p, t, used, NODES[0], y0, y1, d1, d2)
        _, _, sigmaa, Fa = _node(p, t, used, NODES[1], y0, y1, d1, d2)
        _, _, sigmab, Fb = _node(p, t, used, NODES[2], y0, y1, d1, d2)
        _, _, sigma1, F1 = _node(p, t, used, NODES[3], y0, y1, d1, d2)
        see_vertices(lanes, lane, (sigma0, sigmaa, sigmab, sigma1))
        see_vertices(lanes, lane, (F0, Fa, Fb, F1))

    return refine


@jit
def turn(lanes: np.ndarray, lane: int) -> None:
    """Mirror the frame of a record: maxima become minima."""
    for slot in (STRESS_MAX, FORCE_MAX):
        high = at(lanes, slot, lane)
        put(lanes, slot, lane, at(lanes, slot + 1, lane))
        put(lanes, slot + 1, lane, high)
