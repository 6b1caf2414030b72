"""Trajectories: time courses as an xarray Dataset, from parameters."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np

from stickslip.accessors import register_accessors
from stickslip.course import PULL_SAMPLES, course_of
from stickslip.datasets import parameter_scalars
from stickslip.dispatch.stop import run_interruptibly
from stickslip.kernels.families import physics_at
from stickslip.kernels.streams import streams_of
from stickslip.kernels.trajectories import (
    OBSERVABLES,
    new_stream,
    observables_kernel,
    start_kernel,
    write_trajectory,
)
from stickslip.measure.results import STATUS
from stickslip.model.models import model_of
from stickslip.model.state import FILM, Component
from stickslip.options import DEFAULTS, METHODS, NoiseError, Options
from stickslip.orbit import compute_orbits, prepared_points, typical_options
from stickslip.parameters import Parameters, given_or_default
from stickslip.pulling import pulled
from stickslip.stability import step_as_text
from stickslip.status import IntegrationError, Status
from stickslip.variables import STARTING, TRAJECTORY, full_names

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.course import Pull

StartName = Literal["initial", "stationary"]

# CF reserves the name `time` for calendar times.
TIME = "elapsed_time"

REALIZATION = "realization"
"""The dimension of the paths of a stochastic film."""

_NOISE = Parameters._fields.index("noise_intensity")
_PHI_0 = Parameters._fields.index("initial_order_parameter")

# This far below the level of the noise, in ln phi, noise alone moves the film.
_FAR_BELOW = 10.0

# The logarithm of the smallest number with all its digits; smaller ones have fewer, down to none.
_LEAST = math.log(np.finfo(float).tiny)

# The first columns of the samples.
_SAMPLED = ("lower_displacement", "lower_velocity", "order_parameter")


def simulate(
    parameters: Parameters | None = None,
    *,
    periods: int = 6,
    start: StartName | Sequence[float] = "initial",
    samples_per_period: int = 2000,
    schedule: Mapping[str, Sequence[float]] | None = None,
    drive: Pull | None = None,
    duration: float | None = None,
    samples: int = PULL_SAMPLES,
    method: str = DEFAULTS.method,
    rtol: float = DEFAULTS.rtol,
    dt: float = DEFAULTS.dt,
    noise: str = DEFAULTS.noise,
    realizations: int = 1,
    seed: int = DEFAULTS.seed,
    friction: str = DEFAULTS.friction,
    strain: str = DEFAULTS.strain,
    max_steps: int | None = DEFAULTS.max_steps,
    max_periods: int = DEFAULTS.max_periods,
) -> xr.Dataset:
    """Return the time courses of one trajectory, over drive periods or under a pull.

    >>> path = simulate(Parameters(temperature=250), periods=2, samples_per_period=100)
    >>> path.sizes["elapsed_time"]
    201
    >>> pulled = simulate(drive=2e-6, duration=1)
    >>> pulled.attrs["motion"]
    'stick-slip'

    Parameters
    ----------
    parameters
        The model's parameters; the paper's Fig. 3 by default.
    periods, samples_per_period
        Length and sampling, with periods*samples_per_period + 1 equidistant samples.
    start
        'initial' to start from (x_0, v_0, phi_0), 'stationary' to start on the orbit that this
        motion reaches, or a state (x, v, ln phi, followed by the strain if that relaxes) at phase 0
        of the drive, such as `Orbit.state`. Noise lifts phi at once to just below its level.
    schedule
        Parameters that change along the run, each with the same number of values: the first values
        hold for `periods` drive periods, the second for as many, and so on (Fig. 6 of the paper).
        Each section begins at phase 0 of the drive, in the state (x, v, phi) at the end of the
        previous one.
    drive, duration, samples
        A pull of the upper block instead of the periodic drive: a constant velocity [m/s], or a
        table, such as a DataFrame, with the columns `elapsed_time` [s] and `velocity` [m/s]. The
        velocity is linear between the rows and constant before and after them; it jumps where two
        rows have the same time. The run lasts `duration` [s], by default until the last time of the
        table, and is sampled at samples + 1 equidistant times. X(0) = 0. X_m, omega, `periods` and
        `samples_per_period` are not used. A pull needs the adaptive method, and excludes stochastic
        noise.
    realizations, seed
        The number of paths of a stochastic film, and the seed of their random numbers.
    method, rtol, dt, noise, friction, strain, max_steps, max_periods
        As for `stationary_orbit`; `max_steps` is the budget of each section.

    Returns
    -------
    xarray.Dataset
        Variables of `variables.TRAJECTORY` over the dimension `elapsed_time` [s]. The parameters
        are scalar coordinates, or vary along time if they are scheduled; the sample between two
        sections has the parameters of the first. Between the steps of the adaptive method the
        samples are interpolated to order 3. A stochastic film adds the dimension `realization`. A
        pull adds the dimension `melting` with `variables.PULLED`; its attribute `motion` is
        'stick-slip' or 'steady', and further attributes give the period and the forces.

    Raises
    ------
    IntegrationError
        The state diverged, the budget ran out, the fixed step is unstable or, for the start
        'stationary', no stationary orbit was reached.
    NoiseError
        phi_0 = 0 without noise in the first section, unless `start` is a state; or the adaptive
        method reaches phi = 0 at the end of a section that is not the last.
    ParameterError, TypeError
        A scheduled value is out of range, a scheduled name is not a parameter, or `parameters` or
        `schedule` has the wrong type.
    ValueError
        There is less than one period, one sample per period or one sample; the start is neither a
        name nor a state; a schedule has no values, or unequal numbers of them; a pull is invalid
        (PullError), or combined with an option that it excludes.
    """
    if min(periods, samples_per_period, samples) < 1:  # the kernel writes a sample in any case
        raise ValueError("periods, samples_per_period and samples must be at least 1")
    scheduled = _scheduled({} if schedule is None else schedule)
    sections = _sections(given_or_default(parameters), scheduled)
    options = Options(
        method=method,
        rtol=rtol,
        dt=dt,
        max_steps=max_steps,
        stationary_rtol=rtol,
        max_periods=max_periods,
        noise=noise,
        realizations=realizations,
        seed=seed,
        friction=friction,
        strain=strain,
    )
    _refuse_unknown_start(start, model_of(options.physics).components)
    # Only the first section starts at phi_0, and not even that if its state is given.
    points = prepared_points(np.array(sections), noise, starting=int(isinstance(start, str)))
    if drive is not None or duration is not None:
        _refuse_with_a_pull(drive, start, schedule, options)
    else:
        _refuse_unstable(points, options)
    state = _start_state(points[0], options, start)
    if drive is not None:
        register_accessors()
        prepared, state = Parameters(*points[0]), _lifted(state, points[0], options)
        return pulled(prepared, course_of(drive), duration, samples, state, options)
    run = _Run(sections, points, options, periods, samples_per_period, tuple(scheduled))
    register_accessors()
    if not options.physics.chance:
        return run.path(state, new_stream())
    # The whole run uses the streams of the first section.
    return _together([run.path(state, new_stream(own)) for own in streams_of(points[:1], options)])


def _refuse_with_a_pull(
    drive: Pull | None,
    start: StartName | Sequence[float],
    schedule: Mapping[str, Sequence[float]] | None,
    options: Options,
) -> None:
    """Raise ValueError for options that a pull excludes."""
    complaints = {
        "duration needs a drive: give one, or give periods": drive is None,
        "start 'stationary' needs a periodic drive: a pull has no stationary orbit; leave it out, "
        "or give a state": isinstance(start, str) and start == "stationary",
        "schedule needs a periodic drive: leave it out": bool(schedule),
        "a pull needs the method 'adaptive'": options.method != "adaptive",
        "a pull cannot have stochastic noise": options.physics.chance,
    }
    if found := [complaint for complaint, holds in complaints.items() if holds]:
        raise ValueError("; ".join(found))


class _Run(NamedTuple):
    """Consecutive sections of a trajectory, each of the same number of periods."""

    sections: Sequence[Parameters]
    points: np.ndarray
    options: Options
    periods: int
    per_period: int
    scheduled: tuple[str, ...]

    def path(self, state: np.ndarray, stream: np.ndarray) -> xr.Dataset:
        """Return the trajectory from a state (width,), with the random numbers of a stream."""
        parts: list[xr.Dataset] = []
        begin = 0.0
        for section, point in zip(self.sections, self.points, strict=True):
            state = _lifted(state, point, self.options)
            if self.options.method == "adaptive":
                _refuse_lost(state, len(parts))
            samples = _sampled(point, self.options, state, self.periods, self.per_period, stream)
            step = 2.0 * math.pi / section.angular_frequency / self.per_period
            # The drive is at phase 0 again, so the section's own time begins at 0. It is taken
            # modulo a period: the slip of a locked film is the small difference of two velocities,
            # to which a long time would add its rounding.
            number = np.arange(len(samples))
            times, phases = begin + number * step, (number % self.per_period) * step
            parts.append(_section(section, self.options, phases, times, samples))
            state, begin = _state_of(samples[-1]), times[-1]
        return _joined(parts, self.scheduled)


def _together(paths: list[xr.Dataset]) -> xr.Dataset:
    """Join the realizations of a stochastic film along a new dimension."""
    import xarray as xr

    together = xr.concat(paths, dim=REALIZATION, coords="minimal", compat="override")
    attrs = {"long_name": "realization"}
    return together.assign_coords({REALIZATION: (REALIZATION, np.arange(len(paths)), attrs)})


def _scheduled(schedule: Mapping[str, Sequence[float]]) -> dict[str, Sequence[float]]:
    """Return the values of a schedule by full names; raises TypeError or ValueError."""
    # A caller without a type checker may pass anything.
    is_mapping: bool = isinstance(schedule, Mapping)
    if not is_mapping or any(np.ndim(values) != 1 for values in schedule.values()):
        raise TypeError(f"schedule must map parameters to lists of values, not {schedule!r}")
    scheduled = full_names(schedule)
    if starting := [name for name in scheduled if name in STARTING]:
        raise ValueError(f"{', '.join(starting)} cannot be scheduled: a run begins only once")
    lengths = {len(values) for values in scheduled.values()}
    if len(lengths) > 1 or 0 in lengths:
        listed = ", ".join(f"{name} {len(values)}" for name, values in scheduled.items())
        raise ValueError(f"scheduled parameters need the same number of values, but have: {listed}")
    return scheduled


def _sections(parameters: Parameters, scheduled: Mapping[str, Sequence[float]]) -> list[Parameters]:
    """Return the parameters of each section."""
    steps: Iterable[tuple[float, ...]] = (
        zip(*scheduled.values(), strict=True) if scheduled else [()]
    )
    return [parameters._replace(**dict(zip(scheduled, step, strict=True))) for step in steps]


def _refuse_unstable(points: np.ndarray, options: Options) -> None:
    """Raise IntegrationError if a fixed step is unstable at any of the points (n, parameters)."""
    limit = float(METHODS[options.method].kernels.largest_step(points, options).min())
    if options.dt > limit:
        largest = step_as_text(limit)
        context = f"dt = {options.dt:g} s is above the largest stable step {largest} s. "
        raise IntegrationError(Status.REFUSED, context)


def _sampled(
    point: np.ndarray,
    options: Options,
    state: np.ndarray,
    periods: int,
    per_period: int,
    stream: np.ndarray,
) -> np.ndarray:
    """Return the states (x, v, phi, ...) at the samples, (periods*per_period + 1, width)."""
    samples = np.empty((periods * per_period + 1, _width(options)))
    write = partial(write_trajectory, point, options, state, per_period, samples, stream)
    status = Status(run_interruptibly(write))
    if status is not Status.OK:
        raise IntegrationError(status)
    return samples


def _width(options: Options) -> int:
    """Return the number of state variables."""
    return model_of(options.physics).width


def _refuse_unknown_start(
    start: StartName | Sequence[float], components: tuple[Component, ...]
) -> None:
    """Raise ValueError for a start that is neither a name nor a finite state."""
    names = get_args(StartName)
    if not (start in names if isinstance(start, str) else _is_state(start, len(components))):
        state = ", ".join(component.symbol for component in components)
        raise ValueError(
            f"start must be one of {names}, or a state ({state}) of finite numbers; not {start!r}"
        )


def _is_state(start: Any, width: int) -> bool:
    """Return whether a start is a state (width,) of finite numbers."""
    try:
        state = np.asarray(start, dtype=float)
    except (TypeError, ValueError):
        return False
    return state.shape == (width,) and bool(np.isfinite(state).all())


def _start_state(
    point: np.ndarray, options: Options, start: StartName | Sequence[float]
) -> np.ndarray:
    """Return the state (x, v, ln phi) at phase 0 from which a trajectory starts, (width,)."""
    if not isinstance(start, str):
        return np.array(start, dtype=float)
    if start == "stationary":
        results, finals = compute_orbits(point, typical_options(options))
        status = Status(int(results[0, STATUS]))
        if not status.is_result:
            raise IntegrationError(status, "No stationary start: ")
        return finals[0, :-1].copy()
    return _initial_state(point, options)


def _initial_state(point: np.ndarray, options: Options) -> np.ndarray:
    """Return the model's own start, with phi_0 raised to the noise level, (width,)."""
    state = np.empty(_width(options))
    start_kernel(options.physics.typical)(point, state)
    return state


def _lifted(state: np.ndarray, point: np.ndarray, options: Options) -> np.ndarray:
    """Return a state whose phi, if far below the noise level, is raised to just below it.

    Noise lifts it there at once, in less than 1e-8 of the time it takes to reach the level, and the
    rate of ln phi on the way, D_eff/phi^2, would be too high for any step.
    """
    if options.method != "adaptive" or options.physics.chance or point[_NOISE] == 0.0:
        return state
    resting = np.where(np.arange(len(point)) == _PHI_0, 0.0, point)
    least = state.copy()
    least[FILM] = _initial_state(resting, options)[FILM] - _FAR_BELOW
    return np.maximum(state, least)


def _refuse_lost(state: np.ndarray, before: int) -> None:
    """Raise NoiseError if a section after `before` others cannot continue in the logarithm of phi.

    The kernels return phi, which underflows while its logarithm still falls. How far it fell
    decides when the film solidifies again, so no substitute value is right.
    """
    if before and state[FILM] < _LEAST:
        raise NoiseError(
            f"section {before + 1} of the schedule begins at phi = 0, as phi has underflowed: "
            "without noise, the order parameter of a melted film falls forever, and the film "
            "could not solidify when it should; use noise treatment 'typical-path' with "
            "noise_intensity > 0, or fewer periods"
        )


def _state_of(sample: np.ndarray) -> np.ndarray:
    """Return the state (x, v, ln phi) of a sample (x, v, phi, ...), (width,)."""
    with np.errstate(divide="ignore"):  # a fixed step may end at phi = 0
        return np.where(np.arange(len(sample)) == FILM, np.log(np.abs(sample)), sample)


def _section(
    parameters: Parameters,
    options: Options,
    phases: np.ndarray,
    times: np.ndarray,
    samples: np.ndarray,
) -> xr.Dataset:
    """Return the Dataset of a section; `phases` are times in a drive period, `times` in the run."""
    import xarray as xr

    observables = np.empty((len(phases), len(OBSERVABLES)))
    rtol = METHODS[options.method].kernels.rounding(options)
    point = np.array(parameters)
    observables_kernel(physics_at(point, options.physics.typical))(
        point, phases, samples, rtol, observables
    )
    states = dict(zip(_SAMPLED, samples.T, strict=False))  # a strain is an observable
    columns = states | dict(zip(OBSERVABLES, observables.T, strict=True))
    data = {
        name: (TIME, columns[name], TRAJECTORY[name].attributes)
        for name in TRAJECTORY
        if name != TIME
    }
    coords: dict[str, Any] = {TIME: (TIME, times, TRAJECTORY[TIME].attributes)}
    return xr.Dataset(data, coords | parameter_scalars(parameters._asdict()))


def _joined(parts: list[xr.Dataset], scheduled: Iterable[str]) -> xr.Dataset:
    """Join the sections in time, without repeated samples; scheduled parameters vary along time."""
    import xarray as xr

    if not scheduled:
        return parts[0]
    rest = (part.isel({TIME: slice(1, None)}) for part in parts[1:])
    along = [
        part.assign_coords({name: part[name].broadcast_like(part[TIME]) for name in scheduled})
        for part in (parts[0], *rest)
    ]
    return xr.concat(along, dim=TIME)
