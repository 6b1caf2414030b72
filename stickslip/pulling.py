"""A block that is pulled: at a constant velocity, or one that is linear between given times.

Nothing is periodic then: a run has a duration, and shows slips, which a machine records as a spring
force that rises and falls, or a steady force.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.kernels.adaptive.pulled_trajectory import CYCLE, pulled_trajectory
from stickslip.options import Options
from stickslip.parameters import Parameters
from stickslip.status import IntegrationError, Status
from stickslip.variables import PARAMETERS, TRAJECTORY, Variable

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    Pull: TypeAlias = float | Mapping[str, ArrayLike] | pd.DataFrame

COLUMNS = ("elapsed_time", "velocity")
"""The columns of a pull that is given as a table."""

PULL_SAMPLES = 12_000
"""Samples of a pull, as many as six periods have."""

MELTING = "melting"
"""The dimension of meltings, each the end of a slip cycle."""

SLIPS: Mapping[str, Variable] = {
    variable.name: variable
    for variable in (
        Variable("melting_time", "t_m", r"t_\mathrm{m}", "s", "time at which the film melts"),
        Variable("slip_period", "t_s", r"t_\mathrm{s}", "s", "time since the melting before"),
        Variable("spring_force_max", "max 2Kx", r"\max 2Kx", "N", "largest spring force"),
        Variable("spring_force_min", "min 2Kx", r"\min 2Kx", "N", "least spring force"),
        Variable("slip_force_max", "max F", r"\max F", "N", "largest friction force"),
        Variable("slip_force_min", "min F", r"\min F", "N", "least friction force"),
        Variable("slip_force_mean", "mean F", r"\overline{F}", "N", "mean friction force"),
    )
}
"""What is told of each slip cycle, from one melting to the next."""

_MOST_MELTINGS = 100_000
# Of a motion that begins anywhere, the cycles of the last half count.
_SETTLED = 0.5
# The part of a run at its end in which a steady force is looked for.
_LATE = 0.1


SPRING_FORCE = Variable("spring_force", "2Kx", "2Kx", "N", "force of the springs of the block")
"""What a machine records of a pull, along `elapsed_time`."""


class PullError(ValueError):
    """A pull that is none; the message says what is wrong with it."""


class Course(NamedTuple):
    """The velocity [m/s] of the upper block at some times [s], (n,) each; linear in between.

    Before and after, it has the first and the last value.
    """

    time: NDArray[np.float64]
    velocity: NDArray[np.float64]


def course_of(pull: Pull) -> Course:
    """Return the course of a pull: a velocity, or a table with the columns of `COLUMNS`.

    Raises PullError, which names the row (from 0) of what is wrong.
    """
    if isinstance(pull, (int, float)) and not isinstance(pull, bool):
        time, velocity = np.zeros(1), np.array([float(pull)])
    else:
        time, velocity = _columns(pull)
    if len(time) != len(velocity) or not len(time):
        raise PullError(
            f"a pull needs as many velocities as times, and at least one: there are "
            f"{len(velocity)} and {len(time)}"
        )
    for name, values in zip(COLUMNS, (time, velocity), strict=True):
        if len(bad := np.flatnonzero(~np.isfinite(values))):
            raise PullError(f"row {bad[0]}: {name} is {values[bad[0]]}, and must be finite")
    if time[0] < 0.0:
        raise PullError(f"row 0: elapsed_time is {time[0]:g} s, and must not be negative")
    if len(late := np.flatnonzero(np.diff(time) <= 0.0)):
        row = int(late[0]) + 1
        raise PullError(
            f"row {row}: elapsed_time is {time[row]:g} s after {time[row - 1]:g} s; "
            "times must increase"
        )
    if not velocity.any():
        raise PullError("the velocity is 0 throughout: nothing would be pulled")
    return Course(time, velocity)


def _columns(pull: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    wanted = " and ".join(COLUMNS)
    try:
        missing = [name for name in COLUMNS if name not in pull]
        if missing:
            raise PullError(f"a pull needs the columns {wanted}; {', '.join(missing)} is missing")
        time, velocity = (np.asarray(pull[name], dtype=float) for name in COLUMNS)
    except (TypeError, ValueError) as error:
        if isinstance(error, PullError):
            raise
        raise PullError(
            f"a pull is a velocity in m/s, or a table of the columns {wanted}, not {pull!r}"
        ) from None
    if time.ndim != 1 or velocity.ndim != 1:
        raise PullError(f"the columns {wanted} must be lists of numbers")
    return time, velocity


def pulled(
    parameters: Parameters,
    course: Course,
    duration: float | None,
    samples: int,
    state: np.ndarray,
    options: Options,
) -> xr.Dataset:
    """Return the time courses of a block that is pulled, from a state (width,).

    Over `duration` [s], by default to the last time of the course, at `samples` + 1 equidistant
    times. The slips are on the dimension `melting`, and `motion` and others in the attributes say
    what the motion comes to.

    Raises PullError for a duration that is missing or no positive number.
    """
    end = _duration(course, duration)
    sections, ends = _sections(parameters, course, end)
    table = np.empty((samples + 1, 9))
    cycles, counts = np.empty((_MOST_MELTINGS + 1, len(CYCLE))), np.zeros(3, np.int64)
    kernel = pulled_trajectory(options.physics._replace(pulled=True))
    spacing = end / samples
    status = Status(
        kernel(sections, ends, options.settings(), state, spacing, table, cycles, counts)
    )
    if status is not Status.OK:
        raise IntegrationError(status)
    if counts[1] == _MOST_MELTINGS:
        raise PullError(f"the film melts more than {_MOST_MELTINGS} times: shorten the run")
    times = np.append(np.arange(samples) * spacing, end)
    return _dataset(parameters, times, table, cycles[: counts[1]])


def _duration(course: Course, duration: float | None) -> float:
    if duration is None:
        if course.time[-1] <= 0.0:
            raise PullError("a constant velocity needs a duration, in s")
        return float(course.time[-1])
    if not (math.isfinite(duration) and duration > 0.0):
        raise PullError(f"duration must be a time in s greater than 0, not {duration!r}")
    return float(duration)


def _sections(
    parameters: Parameters, course: Course, end: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the sections (m, columns) in the order of `drive.PulledParameters`, and their ends."""
    time, velocity = course
    # The velocity is held before the first time and after the last one.
    begins = np.concatenate([[0.0], time[(time > 0.0) & (time < end)]])
    ends = np.append(begins[1:], end)
    at_begin, at_end = (np.interp(times, time, velocity) for times in (begins, ends))
    durations = ends - begins
    moved = np.concatenate([[0.0], np.cumsum(0.5 * (at_begin + at_end) * durations)[:-1]])
    rates = (at_end - at_begin) / durations
    own = np.column_stack([begins, moved, at_begin, rates])
    scaled = np.tile(np.array(_scaled(parameters, course)), (len(begins), 1))
    return np.hstack([scaled, own]), ends


def _scaled(parameters: Parameters, course: Course) -> Parameters:
    """Return the parameters with an amplitude and a frequency that stand for the scales of a pull.

    The speed X_m omega is the largest one; the time is that of the free oscillation of the block.
    """
    fastest = float(np.abs(course.velocity).max())
    stiffness = 2.0 * parameters.spring_stiffness
    omega = math.sqrt(stiffness / parameters.block_mass) if stiffness > 0.0 else 1.0
    return parameters._replace(angular_frequency=omega, drive_amplitude=fastest / omega)


_SAMPLED = (
    "lower_displacement", "lower_velocity", "order_parameter", "upper_displacement",
    "upper_velocity", "elastic_strain", "elastic_stress", "viscous_stress", "friction_force",
)  # fmt: skip


def _dataset(
    parameters: Parameters, times: np.ndarray, table: np.ndarray, cycles: np.ndarray
) -> xr.Dataset:
    import xarray as xr

    data: dict[str, Any] = {
        name: ("elapsed_time", column, TRAJECTORY[name].attributes)
        for name, column in zip(_SAMPLED, table.T, strict=True)
    }
    slips = _slips(parameters, cycles)
    spring = 2.0 * parameters.spring_stiffness * table[:, 0]
    data["spring_force"] = ("elapsed_time", spring, SPRING_FORCE.attributes)
    data |= {name: (MELTING, values, SLIPS[name].attributes) for name, values in slips.items()}
    unused = ("drive_amplitude", "angular_frequency")
    coords: dict[str, Any] = {
        "elapsed_time": ("elapsed_time", times, TRAJECTORY["elapsed_time"].attributes)
    }
    coords |= {
        name: ((), value, PARAMETERS[name].attributes)
        for name, value in parameters._asdict().items()
        if name not in unused
    }
    about = _summary(times, table[:, -1], slips)
    return xr.Dataset(data, coords, about)


def _slips(parameters: Parameters, cycles: np.ndarray) -> dict[str, NDArray[np.float64]]:
    """Return the values (m,) of `SLIPS`."""
    end, least_x, largest_x, least_force, largest_force, force_time = cycles.T
    spring = 2.0 * parameters.spring_stiffness
    lasted = np.diff(end, prepend=0.0)
    period = lasted.copy()
    period[:1] = np.nan  # the first cycle begins with the run, not with a melting
    return {
        "melting_time": end,
        "slip_period": period,
        "spring_force_max": spring * largest_x,
        "spring_force_min": spring * least_x,
        "slip_force_max": largest_force,
        "slip_force_min": least_force,
        "slip_force_mean": force_time / lasted,
    }


def _summary(
    times: np.ndarray, force: np.ndarray, slips: Mapping[str, NDArray[np.float64]]
) -> dict[str, Any]:
    """Return what the motion comes to at the end of a run."""
    begin, end = _SETTLED * times[-1], times[-1]
    settled = (slips["melting_time"] > begin) & np.isfinite(slips["slip_period"])
    periods = slips["slip_period"][settled]
    # A film that has not melted for two periods no longer slips.
    if len(periods) and end - slips["melting_time"][-1] <= 2.0 * periods.max():
        means = {
            name: float(np.average(slips[name][settled], weights=periods))
            for name in SLIPS
            if name not in ("melting_time", "slip_period")
        }
        means["slip_period"] = float(periods.mean())
        return {"motion": "stick-slip", "settled_slips": int(settled.sum())} | means
    late = force[times >= (1.0 - _LATE) * end]
    return {
        "motion": "steady",
        "steady_force": float(force[-1]),
        "steady_force_change": float(np.ptp(late)),
    }
