"""Euler-Cromer in lanes: doors that march many points through drive periods.

A point marches in units of its own (fixed_units.py), in which its row of numbers stays from the
first period to the last. A door works for a given number of steps and leaves everything it needs
to go on in the arrays that it was given. The numbers are those of the scalar drive
(methods.fixed_period) but for rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import door, inline, jit
from stickslip.compiled.elementary import reciprocal
from stickslip.kernels.euler_cromer.layout import (
    FORCE_MIN,
    RECORD,
    SLOTS,
    STRESS_MIN,
    clear_records,
    fill_rows,
    read_records,
    read_states,
)
from stickslip.kernels.euler_cromer.scaling import StepParameters, model_values
from stickslip.measure import accumulate
from stickslip.model import drive, film
from stickslip.model.rhs import State, block_acceleration, film_melting_function, stress_and_force
from stickslip.numerics.euler_cromer_lanes import FREE, PENDING, Tasks, at, make_fixed_lanes, put
from stickslip.parameters import Parameters, ParameterValues

_GAMMA = Parameters._fields.index("rheological_index")
_NOISE = Parameters._fields.index("noise_intensity")

# Steps of all lanes together between two looks at the interpreter: a tenth of a second.
_AT_A_TIME = 2**20

_UNLIMITED = 2**62

_UNSEEN, _MELTED, _SOLID = 0.0, 1.0, 2.0  # as in accumulate.py


class _Lane(NamedTuple):
    """What a step needs to know: the parameters in two shapes."""

    values: ParameterValues
    own: StepParameters


@inline
def _own_parameters(lanes: np.ndarray, lane: int) -> StepParameters:
    return StepParameters(
        at(lanes, FREE, lane),
        at(lanes, FREE + 1, lane),
        at(lanes, FREE + 2, lane),
        at(lanes, FREE + 3, lane),
        at(lanes, FREE + 4, lane),
        at(lanes, FREE + 5, lane),
        at(lanes, FREE + 6, lane),
        at(lanes, FREE + 7, lane),
        at(lanes, FREE + 8, lane),
        at(lanes, FREE + 9, lane),
        at(lanes, FREE + 10, lane),
        at(lanes, FREE + 11, lane),
    )


@inline
def _sine(p: _Lane, n: int) -> tuple[float, float]:
    """Velocity of the upper block at step n and its change since step n - 1."""
    angle = p.own.angle
    slope = drive.upper_acceleration(n - 0.5, 1.0, angle)
    return drive.upper_velocity(float(n), 1.0, angle), slope * (2.0 * math.sin(0.5 * angle) / angle)


@inline
def _quiet_increments(p: _Lane, V: float, y: State) -> tuple[float, float]:
    """What v and phi gain in a step from the old state (Eqs. 3 and 26), without noise."""
    x, v, phi = y
    u = V - v
    _, F = stress_and_force(p.values, u, phi)
    rate = film.order_parameter_rate(
        phi,
        film_melting_function(p.values, u),
        p.values.cubic_coefficient,
        p.values.quartic_coefficient,
        p.values.kinetic_coefficient,
    )
    return block_acceleration(p.values, x, F), rate


@inline
def _noisy_increments(p: _Lane, V: float, y: State) -> tuple[float, float]:
    """The same with the typical path of the noise."""
    dv, dphi = _quiet_increments(p, V, y)
    return dv, dphi + _kick(y[2], p.own)


@inline
def _kick(phi: float, own: StepParameters) -> float:
    """`noise.typical_kick` for a step of 1, without its root and its division."""
    return own.D_eff * reciprocal(phi if phi > own.least_phi else own.least_phi)


@inline
def _ignore(p: _Lane, V: float, y: State, lanes: np.ndarray, lane: int) -> None:
    pass


@inline
def _raise(lanes: np.ndarray, slot: int, lane: int, value: float) -> None:
    """Raise the number in a slot of the record to `value`."""
    old = at(lanes, RECORD + slot, lane)
    put(lanes, RECORD + slot, lane, value if value > old else old)


@inline
def _lower(lanes: np.ndarray, slot: int, lane: int, value: float) -> None:
    """Lower the number in a slot of the record to `value`."""
    old = at(lanes, RECORD + slot, lane)
    put(lanes, RECORD + slot, lane, value if value < old else old)


@inline
def _add(lanes: np.ndarray, slot: int, lane: int, value: float) -> None:
    put(lanes, RECORD + slot, lane, at(lanes, RECORD + slot, lane) + value)


@inline
def _see_point(p: _Lane, V: float, y: State, lanes: np.ndarray, lane: int) -> None:
    """`accumulate.see_point` for a step of 1, with choices instead of branches."""
    _, v, phi = y
    sigma_el, F = stress_and_force(p.values, V - v, phi)
    _raise(lanes, accumulate.STRESS_MAX, lane, sigma_el)
    _lower(lanes, STRESS_MIN, lane, sigma_el)
    _raise(lanes, accumulate.FORCE_MAX, lane, F)
    _lower(lanes, FORCE_MIN, lane, F)
    _add(lanes, accumulate.DRIVE_WORK, lane, F * V)
    _add(lanes, accumulate.ABSOLUTE_WORK, lane, abs(F * V))
    _add(lanes, accumulate.BLOCK_WORK, lane, F * v)
    _raise(lanes, accumulate.PHI_MAX, lane, phi)
    _see_phase(p.own, phi, lanes, lane)


@inline
def _see_phase(own: StepParameters, phi: float, lanes: np.ndarray, lane: int) -> None:
    first = at(lanes, RECORD + accumulate.FIRST_PHASE, lane)
    last = at(lanes, RECORD + accumulate.LAST_PHASE, lane)
    melted = phi <= own.melted
    phase = _MELTED if melted else last
    phase = _SOLID if phi >= own.solid else phase
    melts = melted & (last == _SOLID)
    _add(lanes, accumulate.MELTINGS, lane, 1.0 if melts else 0.0)
    first = phase if first == _UNSEEN else first
    put(lanes, RECORD + accumulate.FIRST_PHASE, lane, first)
    put(lanes, RECORD + accumulate.LAST_PHASE, lane, phase)


def _make_work(gamma: float | None) -> Any:
    """The march of fluids with the rheological index `gamma`, or with any for None.

    It maps (tasks, queue, noisy, measured, budget) to what is left of the budget.
    """
    any_gamma = gamma is None
    own_gamma = math.nan if gamma is None else gamma

    @inline
    def parameters(lanes: np.ndarray, lane: int) -> _Lane:
        own = _own_parameters(lanes, lane)
        return _Lane(model_values(own, own.gamma if any_gamma else own_gamma), own)

    travel, noisy_travel, measure, noisy_measure = (
        make_fixed_lanes(parameters, increments, observe, _sine, SLOTS)
        for observe in (_ignore, _see_point)
        for increments in (_quiet_increments, _noisy_increments)
    )

    @jit
    def work(tasks: Tasks, queue: np.ndarray, noisy: bool, measured: bool, budget: int) -> int:
        if measured:
            if noisy:
                return noisy_measure(tasks, queue, budget)
            return measure(tasks, queue, budget)
        if noisy:
            return noisy_travel(tasks, queue, budget)
        return travel(tasks, queue, budget)

    return work


_pseudoplastic, _newtonian = _make_work(-2.0 / 3.0), _make_work(0.0)
_dilatant, _general = _make_work(2.0 / 3.0), _make_work(None)


@door
def pseudoplastic_march(
    tasks: Tasks, queue: np.ndarray, noisy: bool, measured: bool, budget: int
) -> int:
    """Steps of points with gamma = -2/3: those among the rows of `queue` that are PENDING.

    `noisy` takes the noise into account, `measured` keeps the record. At most `budget` steps are
    done, of all lanes together; what is left of them is returned, 0 where there is more to do.
    """
    return _pseudoplastic(tasks, queue, noisy, measured, budget)


@door
def newtonian_march(
    tasks: Tasks, queue: np.ndarray, noisy: bool, measured: bool, budget: int
) -> int:
    """Steps of points with gamma = 0; as `pseudoplastic_march`."""
    return _newtonian(tasks, queue, noisy, measured, budget)


@door
def dilatant_march(
    tasks: Tasks, queue: np.ndarray, noisy: bool, measured: bool, budget: int
) -> int:
    """Steps of points with gamma = 2/3; as `pseudoplastic_march`."""
    return _dilatant(tasks, queue, noisy, measured, budget)


@door
def general_march(tasks: Tasks, queue: np.ndarray, noisy: bool, measured: bool, budget: int) -> int:
    """Steps of points with any gamma, by a general power; as `pseudoplastic_march`."""
    return _general(tasks, queue, noisy, measured, budget)


SPECIAL_MARCHES = {
    -2.0 / 3.0: pseudoplastic_march,
    0.0: newtonian_march,
    2.0 / 3.0: dilatant_march,
}
"""Fluids with kernels of their own, by their rheological index; `general_march` does the others."""


class FixedLanes:
    """Many points on their way through drive periods by Euler-Cromer, in lanes.

    Parameters
    ----------
    points
        (n, 20) parameters in SI units, in the order of `Parameters._fields`.
    steps
        (n,) steps a drive period, from `write_steps`.
    states
        (n, 3) states (x, v, phi) at phase 0, in SI units.
    """

    def __init__(self, points: np.ndarray, steps: np.ndarray, states: np.ndarray) -> None:
        self.points, self.steps = points, steps
        count = len(points)
        self.tasks = Tasks(
            rows=np.zeros((count, SLOTS)),
            done=np.zeros(count, np.int64),
            total=np.zeros(count, np.int64),
            status=np.zeros(count, np.int64),
        )
        fill_rows(points, steps, states, self.tasks.rows)

    def start(self, which: np.ndarray, limits: np.ndarray | None = None) -> None:
        """Put the points with the indices `which` to the beginning of a period.

        They are to go to its end, or for as many steps as `limits` (one each) allows.
        """
        tasks, total = self.tasks, self.steps[which]
        tasks.total[which] = total if limits is None else np.minimum(total, limits)
        tasks.done[which], tasks.status[which] = 0, PENDING

    def clear_records(self, which: np.ndarray) -> None:
        """Forget what was measured of some points."""
        clear_records(self.tasks.rows, which)

    def march(self, measured: bool = False, budget: int | None = None) -> int:
        """Let the points that were started go on, for at most `budget` steps of all lanes.

        Returns what is left of the budget, 0 where there is more to do: call it again. The
        statuses are in `tasks.status`: PENDING, OK at the end, DIVERGED.
        """
        left = _UNLIMITED if budget is None else budget
        for march, noisy, queue in self._families():
            while left > 0 and np.any(self.tasks.status[queue] == PENDING):
                given = min(left, _AT_A_TIME)
                left -= given - march(self.tasks, queue, noisy, measured, given)
        return left

    def _families(self) -> Iterator[tuple[Any, bool, np.ndarray]]:
        """Points that share a kernel: the kernel, whether there is noise, their indices."""
        pending = np.flatnonzero(self.tasks.status == PENDING)
        gammas, noisy = self.points[pending, _GAMMA], self.points[pending, _NOISE] > 0.0
        special = [(march, gammas == gamma) for gamma, march in SPECIAL_MARCHES.items()]
        others = ~np.any([chosen for _, chosen in special], axis=0)
        for march, chosen in [*special, (general_march, others)]:
            for noise in (False, True):
                yield march, noise, pending[chosen & (noisy == noise)]

    def states(self) -> np.ndarray:
        """The states (x, v, phi) in SI units, (n, 3)."""
        states = np.empty((len(self.points), 3))
        read_states(self.points, self.steps, self.tasks.rows, states)
        return states

    def records(self) -> np.ndarray:
        """What was measured, in SI units, (n, accumulate.LENGTH)."""
        records = np.empty((len(self.points), accumulate.LENGTH))
        read_records(self.points, self.steps, self.tasks.rows, records)
        return records
