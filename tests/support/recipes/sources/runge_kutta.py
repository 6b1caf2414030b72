"""Classical Runge-Kutta with a fixed step, of order 4, as a method in one file for teaching.

It integrates the right-hand side of the model, for (x, u, ln phi) in SI units. A step is recorded
at its start, which makes the results of second order. `kernels/plain_iteration/` does the rest to
find orbits.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import jit, kernel, kernel_factory, named_kernel
from stickslip.kernels.families import FamilyKernel
from stickslip.kernels.fastest_rates import largest_stable_step
from stickslip.kernels.orbits.states import state_functions
from stickslip.kernels.parameter_rows import parameters_of
from stickslip.kernels.plain_iteration import orbits as plain
from stickslip.kernels.plain_iteration.march import WIDTH
from stickslip.measure.accumulate import (
    FORCE_MAX,
    RECORD,
    STRESS_MAX,
    Moment,
    accumulator,
    make_see_integrals,
)
from stickslip.measure.results import RecordUnits, write_stretch, write_whole_orbit
from stickslip.model import block, drive, film, solids
from stickslip.model.models import Model, model_of
from stickslip.model.solids import Thresholds
from stickslip.model.state import State
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT
from stickslip.numerics.linear import algebra
from stickslip.options import HARMONICS, Options, Physics, Settings
from stickslip.parameters import Parameters

# ln(phi) returns to the level of the noise at twice the rate of phi.
_STABLE_PART = 0.5

_record = accumulator(1, 0)
_clear, _see_extremum, _see_phase = _record.clear, _record.see_extremum, _record.see_phase
_see_solid = _record.see_solid


def _make_see(model: Model) -> Any:
    """Return the function (p, phases, t, h, y, record) that records the state y for a step h."""
    equations = model.equations
    observables, strain = equations.observables, equations.strain
    power, loss = equations.power, equations.loss
    see_integrals = make_see_integrals(_record, (1.0,))

    @jit
    def see(
        p: Parameters, phases: Thresholds, t: float, h: float, y: State, record: np.ndarray
    ) -> None:
        phi, V = math.exp(y[2]), drive.upper_velocity(p, t)
        sigma, F = observables(p, y, phi, 0.0)
        B, melted = film.melting_function(p, strain(p, y)), solids.MELTED_PART * phases.solid
        _see_extremum(record, 0, STRESS_MAX, sigma, True)
        _see_extremum(record, 0, FORCE_MAX, F, True)
        phase = p.angular_frequency * t
        gained, lost = power(p, V, y, F), loss(p, V, y, F)
        motion = block.harmonic_force(p, y[0], V - y[1])
        moment = Moment(y[0], V, y[1], phi, sigma, F, gained, lost, motion, phase)
        see_integrals(record, 0, (moment,), h, True)
        _see_phase(record, 0, phi, phases.solid, melted, h, True)
        is_soft = solids.is_soft(phases, phi, B)
        _see_solid(record, 0, phi <= melted, is_soft, phi >= phases.hard, True)

    return see


def _make_steps(model: Model) -> Any:
    """Return the function (p, t, h, count, y, measured, record) that takes `count` steps from y."""
    rhs, see, own = model.equations.rhs, _make_see(model), algebra(model.width)
    add, finite = own.add, own.finite

    @jit
    def step(p: Parameters, t: float, h: float, y: State) -> State:
        k1 = rhs(p, t, y, 0.0)
        k2 = rhs(p, t + h / 2.0, add(y, h / 2.0, k1), 0.0)
        k3 = rhs(p, t + h / 2.0, add(y, h / 2.0, k2), 0.0)
        k4 = rhs(p, t + h, add(y, h, k3), 0.0)
        y = add(add(y, h / 6.0, k1), h / 3.0, k2)
        return add(add(y, h / 3.0, k3), h / 6.0, k4)

    @jit
    def steps(
        p: Parameters,
        t: float,
        h: float,
        count: int,
        y: State,
        measured: bool,
        record: np.ndarray,
    ) -> tuple[State, bool]:
        phases = solids.thresholds(p)
        for i in range(count):
            if measured:
                see(p, phases, t + i * h, h, y, record)
            y = step(p, t + i * h, h, y)
            if not finite(y):
                return y, False
        return y, True

    return steps


class Kernels(NamedTuple):
    """The kernels of a model; states are (x, u, ln phi) in SI units."""

    march: Any
    """(points, steps, which, limits, measured, states, records, outcomes): as `March.period`, which
    returns `outcomes` (m,)."""

    trajectory: Any
    """(point, settings, start, per_period, stream, samples): as `adaptive_trajectory`."""


@kernel_factory
def kernels_of(physics: Physics) -> Kernels:
    """Return the kernels of these physics, which serve all drives, as harmonics may be 0."""
    model = model_of(physics._replace(drive=HARMONICS))
    steps_from, of_row = _make_steps(model), state_functions(model.components).of_row
    relative_state = model.equations.relative_state

    def march(
        points: np.ndarray,
        steps: np.ndarray,
        which: np.ndarray,
        limits: np.ndarray,
        measured: bool,
        states: np.ndarray,
        records: np.ndarray,
        outcomes: np.ndarray,
    ) -> None:
        for k in range(which.shape[0]):
            i = which[k]
            p, count = parameters_of(points[i]), min(steps[i], limits[k])
            h, y = drive.period(p) / steps[i], of_row(states[i])
            y, finite = steps_from(p, 0.0, h, count, y, measured, records[i])
            for component in range(states.shape[1]):
                states[i, component] = y[component]
            outcomes[k] = (OK if count == steps[i] else STEP_LIMIT) if finite else DIVERGED

    def trajectory(
        point: np.ndarray,
        settings: Settings,
        start: np.ndarray,
        per_period: int,
        stream: np.ndarray,
        samples: np.ndarray,
    ) -> int:
        p, nothing = parameters_of(point), np.empty(0)
        spacing, y = drive.period(p) / per_period, relative_state(p, 0.0, of_row(start))
        count = math.ceil(spacing / settings.dt)
        for i in range(samples.shape[0]):
            t, row = (i % per_period) * spacing, samples[i]
            row[0], row[1], row[2] = relative_state(p, t, y)
            row[2] = math.exp(row[2])
            if i + 1 < samples.shape[0]:
                if (i + 1) * count > settings.max_steps:
                    return STEP_LIMIT
                y, finite = steps_from(p, t, spacing / count, count, y, False, nothing)
                if not finite:
                    return DIVERGED
        return OK

    return Kernels(
        named_kernel(f"rk4_march[{physics}]", march),
        named_kernel(f"rk4_trajectory[{physics}]", trajectory, makes_arrays=True),
    )


@kernel
def clear_records(records: np.ndarray, which: np.ndarray) -> None:
    """Make the records (n, RECORD) with the indices `which` (m,) ready for a new orbit."""
    for i in which:
        _clear(records[i], 0)


@kernel
def write_records(
    points: np.ndarray, records: np.ndarray, closed: bool, target: np.ndarray
) -> None:
    """Write records (n, RECORD) of whole periods in SI units, with times in half periods."""
    for i in range(points.shape[0]):
        units = RecordUnits(1.0, 1.0, 1.0, 2.0 / drive.period(parameters_of(points[i])))
        if closed:
            write_whole_orbit(records[i], units, 2, target[i])
        else:
            write_stretch(records[i], units, 1, target[i])


class March:
    """The march of plain iteration: arguments as in `march.MakeMarch`, the rest as in `March`."""

    def __init__(
        self, points: np.ndarray, steps: np.ndarray, states: np.ndarray, physics: Physics
    ) -> None:
        self._points, self._steps, self._march = points, steps, kernels_of(physics).march
        self._states = states * (1.0, -1.0, 1.0)  # at phase 0 the upper block stands: u = -v
        self._states[:, 2] = np.log(states[:, 2])
        self._records = np.empty((len(points), RECORD))
        self.clear_records(np.arange(len(points)))

    def states(self) -> np.ndarray:
        """As `plain_iteration.march.March`."""
        states = self._states * (1.0, -1.0, 1.0)
        states[:, 2] = np.exp(states[:, 2])
        return states

    def period(self, which: np.ndarray, limits: np.ndarray, *, measured: bool) -> np.ndarray:
        """As `plain_iteration.march.March`."""
        outcomes = np.empty(len(which), np.int64)
        self._march(
            self._points, self._steps, which, limits, measured, self._states, self._records,
            outcomes,
        )  # fmt: skip
        return outcomes

    def clear_records(self, which: np.ndarray) -> None:
        """As `plain_iteration.march.March`."""
        clear_records(self._records, which)

    def records(self, closed: bool = True) -> np.ndarray:
        """As `plain_iteration.march.March`."""
        records = np.empty_like(self._records)
        write_records(self._points, self._records, closed, records)
        return records


def family_kernels(kinds: np.ndarray, options: Options) -> Iterator[FamilyKernel]:
    """As `adaptive.driver.family_kernels`, with one kernel for all fluids."""
    yield from plain.reference_kernels(kinds, options)
    nobody, nothing = np.empty((0, len(Parameters._fields))), np.empty(0, np.int64)
    march = March(nobody, nothing, np.empty((0, WIDTH)), options.physics)
    compiled = partial(march.period, nothing, nothing, measured=False)
    yield FamilyKernel(kernels_of(options.physics).march, compiled)


def largest_step(points: np.ndarray, options: Options) -> np.ndarray:
    """As `adaptive.driver.largest_step`."""
    return _STABLE_PART * largest_stable_step(points, options.friction)


def rounding(options: Options) -> float:
    """As `adaptive.driver.rounding`; it rounds nothing."""
    return 0.0


def trajectory_kernel(physics: Physics) -> Any:
    """As `adaptive_trajectory`; the time between two samples is divided evenly."""
    return kernels_of(physics).trajectory


def orbits(
    points: np.ndarray,
    options: Options,
    starts: np.ndarray,
    results: np.ndarray,
    finals: np.ndarray,
    patience: int = 0,
) -> None:
    """As `adaptive.driver.orbits`."""
    plain.write_orbits(March, points, options, starts, results, finals)
