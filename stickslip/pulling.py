"""Pulling the upper block, at a constant velocity or one that is linear between given times.

The velocity jumps where a time occurs twice. A pull is not periodic: a run has a duration, and
shows a steady force, or slips, which a machine records as a spring force that rises and falls.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.course import Course, PullError
from stickslip.datasets import parameter_scalars
from stickslip.dispatch.stop import run_interruptibly
from stickslip.kernels.adaptive.pulled_trajectory import CYCLE, pulled_trajectory
from stickslip.model.drive import HARMONIC_AMPLITUDES
from stickslip.options import PULL, Options
from stickslip.parameters import Parameters
from stickslip.status import IntegrationError, Status
from stickslip.variables import PULLED, TRAJECTORY

if TYPE_CHECKING:
    import xarray as xr

MELTING = "melting"
"""The dimension of meltings; each one ends a slip cycle."""

_MOST_MELTINGS = 100_000
# The summary uses the cycles in the last half of the time for which the last velocity is held,
# because a motion may start anywhere.
_SETTLED = 0.5
# The last part of a run, in which the change of a steady force is measured.
_LATE = 0.1


def pulled(
    parameters: Parameters,
    course: Course,
    duration: float | None,
    samples: int,
    state: np.ndarray,
    options: Options,
) -> xr.Dataset:
    """Return the time courses under a pull, from a state (width,).

    The run lasts `duration` [s], by default until the last time of the course, with `samples` + 1
    equidistant times. The slips are on the dimension `melting`; the attributes, `motion` first,
    summarise the motion that the run settles on.

    Raises PullError for a missing or invalid duration, and for too many meltings.
    """
    end = _duration(course, duration)
    sections, ends, jumps = _sections(parameters, course, end)
    table = np.empty((samples + 1, 9))
    cycles, counts = np.empty((_MOST_MELTINGS + 1, len(CYCLE))), np.zeros(3, np.int64)
    kernel = pulled_trajectory(options.physics._replace(drive=PULL))
    spacing = end / samples
    settings = options.settings()
    arguments = (sections, ends, jumps, settings, state, spacing, table, cycles, counts)
    status = Status(run_interruptibly(partial(kernel, *arguments)))
    if status is not Status.OK:
        raise IntegrationError(status)
    if counts[1] == _MOST_MELTINGS:
        raise PullError(f"the film melts more than {_MOST_MELTINGS} times: shorten the run")
    times = np.append(np.arange(samples) * spacing, end)
    return _dataset(parameters, course, times, table, cycles[: counts[1]])


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
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return the sections (m, columns) of a pull, their ends (m,), and which begin with a jump.

    The columns are in the order of `drive.PulledParameters`; only the velocity jumps.
    """
    inner = (course.time > 0.0) & (course.time < end)
    begins = np.concatenate([[0.0], np.unique(course.time[inner])])
    ends = np.append(begins[1:], end)
    at_begin, at_end = course.after(begins), course.before(ends)
    jumps = np.append(False, at_begin[1:] != at_end[:-1])
    durations = ends - begins
    moved = np.concatenate([[0.0], np.cumsum(0.5 * (at_begin + at_end) * durations)[:-1]])
    rates = (at_end - at_begin) / durations
    own = np.column_stack([begins, moved, at_begin, rates])
    scaled = np.tile(np.array(_scaled(parameters, course)), (len(begins), 1))
    return np.hstack([scaled, own]), ends, jumps


def _scaled(parameters: Parameters, course: Course) -> Parameters:
    """Return the parameters with an amplitude and a frequency that set the scales of a pull.

    X_m omega is the largest speed of the pull; omega belongs to the free oscillation of the block.
    """
    fastest = float(np.abs(course.velocity).max())
    stiffness = 2.0 * parameters.spring_stiffness
    omega = math.sqrt(stiffness / parameters.block_mass) if stiffness > 0.0 else 1.0
    harmonics = dict.fromkeys(HARMONIC_AMPLITUDES, 0.0)
    return parameters._replace(
        angular_frequency=omega, drive_amplitude=fastest / omega, **harmonics
    )


_SAMPLED = (
    "lower_displacement", "lower_velocity", "order_parameter", "upper_displacement",
    "upper_velocity", "elastic_strain", "elastic_stress", "viscous_stress", "friction_force",
)  # fmt: skip


def _dataset(
    parameters: Parameters,
    course: Course,
    times: np.ndarray,
    table: np.ndarray,
    cycles: np.ndarray,
) -> xr.Dataset:
    import xarray as xr

    data: dict[str, Any] = {
        name: ("elapsed_time", column, TRAJECTORY[name].attributes)
        for name, column in zip(_SAMPLED, table.T, strict=True)
    }
    slips = _slips(parameters, cycles)
    spring = 2.0 * parameters.spring_stiffness * table[:, 0]
    data["spring_force"] = ("elapsed_time", spring, PULLED["spring_force"].attributes)
    data |= {name: (MELTING, values, PULLED[name].attributes) for name, values in slips.items()}
    unused = ("drive_amplitude", "angular_frequency", *HARMONIC_AMPLITUDES)
    coords: dict[str, Any] = {
        "elapsed_time": ("elapsed_time", times, TRAJECTORY["elapsed_time"].attributes)
    }
    used = {name: value for name, value in parameters._asdict().items() if name not in unused}
    coords |= parameter_scalars(used)
    about = _summary(course, times, table[:, -1], slips)
    return xr.Dataset(data, coords, about)


def _slips(parameters: Parameters, cycles: np.ndarray) -> dict[str, NDArray[np.float64]]:
    """Return the variables (m,) of `variables.PULLED` over the cycles."""
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
    course: Course, times: np.ndarray, force: np.ndarray, slips: Mapping[str, NDArray[np.float64]]
) -> dict[str, Any]:
    """Return the kind of motion at the end of a run, and its period and forces."""
    end = times[-1]
    since = _held_since(course, end)
    begin = end - _SETTLED * (end - since)
    settled = (slips["melting_time"] > begin) & np.isfinite(slips["slip_period"])
    # Cycles that began before the velocity was held count only if there are no others.
    within = settled & (slips["melting_time"] - slips["slip_period"] >= since)
    settled = within if within.any() else settled
    periods = slips["slip_period"][settled]
    # A film that has not melted for two periods no longer slips.
    if len(periods) and end - slips["melting_time"][-1] <= 2.0 * periods.max():
        means = {
            name: float(np.average(slips[name][settled], weights=periods))
            for name in slips
            if name not in ("melting_time", "slip_period")
        }
        means["slip_period"] = float(periods.mean())
        return {"motion": "stick-slip", "settled_slips": int(settled.sum())} | means
    late = force[times >= end - _LATE * (end - since)]
    return {
        "motion": "steady",
        "steady_force": float(force[-1]),
        "steady_force_change": float(np.ptp(late)),
    }


def _held_since(course: Course, end: float) -> float:
    """Return the time from which the final velocity of a run is held; 0 if it is not held."""
    time, velocity = course
    last = course.before(np.array([end]))
    others = np.flatnonzero((velocity != last) & (time < end))
    since = time[others[-1] + 1] if len(others) and others[-1] + 1 < len(time) else 0.0
    return float(since) if since < end else 0.0
