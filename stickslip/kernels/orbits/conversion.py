"""Conversion between SI units and the points' own units, at both ends of the lanes."""

from __future__ import annotations

import math
from functools import wraps
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, kernel_factory, named_kernel
from stickslip.kernels.orbits.states import state_functions
from stickslip.kernels.parameter_rows import FIRST_STEP, parameters_of
from stickslip.measure.results import (
    RecordUnits,
    record_units,
    write_stretch,
    write_whole_orbit,
)
from stickslip.model.drive import lengthened
from stickslip.model.models import Model, model_of
from stickslip.model.scaling import Reduced
from stickslip.options import Physics
from stickslip.parameters import Parameters

_AMPLITUDE = Parameters._fields.index("drive_amplitude")
_REDUCED_AMPLITUDE = Reduced._fields.index("drive_amplitude")


def make_record_units(model: Model) -> Any:
    """Return the inline function (p) that returns the units of lane records."""
    units_of = model.scaling.units_of

    @inline
    def own_record_units(p: Parameters) -> RecordUnits:
        return record_units(p, units_of(p))

    return own_record_units


class Conversion(NamedTuple):
    """The conversions of a model, for `points` (n, parameters) and `states` (n, width + 1).

    Points are in SI units. Each function has a kernel, which takes the unit of length in place of
    X_m.
    """

    reduce_points: Any
    """(points, reduced, states): write the parameters (n, reduced parameters), the starts and the
    first steps, in the points' own units."""

    restore_states: Any
    """(points, states): convert states of the lanes, at phase 0, to (x, v, psi, ...) in SI units.
    The states are overwritten."""

    scale_states: Any
    """(points, states): the inverse."""

    write_records: Any
    """(points, cycles, measured, records): write the records of whole orbits, in SI units, from
    `measured` (n, RECORD) over `cycles` (n,) half periods."""

    write_stretches: Any
    """(points, measured, records): the same for stretches of motion."""


def conversion_of(physics: Physics) -> Conversion:
    """Return the conversions of these physics, which typical and stochastic noise share."""
    typical = physics.typical
    kernels = (*_state_kernels(typical), *_record_kernels(typical))
    return Conversion(_with_amplitude(_reduction(typical)), *map(_with_length, kernels))


def _with_length(kernel: Any) -> Any:
    """Return a function that calls a kernel with the points' units of length in place of X_m."""

    @wraps(kernel.py_func)
    def convert(points: np.ndarray, *columns: np.ndarray) -> None:
        kernel(lengthened(points), *columns)

    convert.kernel = kernel  # type: ignore[attr-defined]
    return convert


def _with_amplitude(kernel: Any) -> Any:
    """Return this function for `reduce_points`; with harmonics the amplitude is not a unit."""
    convert = _with_length(kernel)

    @wraps(convert)
    def reduce_points(points: np.ndarray, reduced: np.ndarray, states: np.ndarray) -> None:
        convert(points, reduced, states)
        reduced[:, _REDUCED_AMPLITUDE] = points[:, _AMPLITUDE] / lengthened(points)[:, _AMPLITUDE]

    return reduce_points


@kernel_factory
def _reduction(physics: Physics) -> Any:
    model = model_of(physics)
    units_of, state_units, width = model.scaling.units_of, model.state_units, model.width
    start, relative_state = model.start, model.equations.relative_state
    write_reduced = model.write_reduced

    def reduce_points(points: np.ndarray, reduced_points: np.ndarray, states: np.ndarray) -> None:
        for i in range(points.shape[0]):
            p = parameters_of(points[i])
            units, y = state_units(units_of(p)), relative_state(p, 0.0, start(p))
            write_reduced(p, reduced_points[i])
            for component in range(width):
                states[i, component] = y[component] / units[component]
            # The unit of time is 1/omega: a drive period is 2 pi.
            states[i, width] = FIRST_STEP * (2.0 * math.pi)

    return named_kernel(f"reduce_points[{physics}]", reduce_points)


@kernel_factory
def _state_kernels(physics: Physics) -> tuple[Any, Any]:
    model = model_of(physics)
    units_of, state_units, width = model.scaling.units_of, model.state_units, model.width

    relative_state = model.equations.relative_state
    of_row = state_functions(model.components).of_row

    def restore_states(points: np.ndarray, states: np.ndarray) -> None:
        for i in range(points.shape[0]):
            p = parameters_of(points[i])
            units = state_units(units_of(p))
            # Units come first, as `relative_state` needs state and parameters in the same ones.
            for component in range(width):
                states[i, component] *= units[component]
            y = relative_state(p, 0.0, of_row(states[i]))
            for component in range(width):
                states[i, component] = y[component]
            states[i, width] /= p.angular_frequency

    def scale_states(points: np.ndarray, states: np.ndarray) -> None:
        for i in range(points.shape[0]):
            p = parameters_of(points[i])
            units, y = state_units(units_of(p)), relative_state(p, 0.0, of_row(states[i]))
            for component in range(width):
                states[i, component] = y[component] / units[component]
            states[i, width] *= p.angular_frequency

    return (
        named_kernel(f"restore_states[{physics}]", restore_states),
        named_kernel(f"scale_states[{physics}]", scale_states),
    )


@kernel_factory
def _record_kernels(physics: Physics) -> tuple[Any, Any]:
    own_units = make_record_units(model_of(physics))

    def write_records(
        points: np.ndarray, cycles: np.ndarray, measured: np.ndarray, records: np.ndarray
    ) -> None:
        for i in range(points.shape[0]):
            own = own_units(parameters_of(points[i]))
            write_whole_orbit(measured[i], own, cycles[i], records[i])

    def write_stretches(points: np.ndarray, measured: np.ndarray, records: np.ndarray) -> None:
        for i in range(points.shape[0]):
            write_stretch(measured[i], own_units(parameters_of(points[i])), 1, records[i])

    return (
        named_kernel(f"write_records[{physics}]", write_records),
        named_kernel(f"write_stretches[{physics}]", write_stretches),
    )
