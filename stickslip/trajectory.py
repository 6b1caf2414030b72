"""From parameters to trajectories: an xarray Dataset of the time courses."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from stickslip.kernels.trajectories import OBSERVABLES, observables_kernel, write_start
from stickslip.measure.results import STATUS
from stickslip.model.state import WIDTH
from stickslip.options import DEFAULTS, METHODS, Options
from stickslip.orbit import compute_orbits, prepared_points
from stickslip.parameters import Parameters
from stickslip.stability import step_as_text
from stickslip.status import Status
from stickslip.variables import PARAMETERS, TRAJECTORY, Variable

if TYPE_CHECKING:
    import xarray as xr

StartName = Literal["initial", "stationary"]

# What samples hold.
_SAMPLED = ("lower_displacement", "lower_velocity", "order_parameter")


class IntegrationError(RuntimeError):
    """A trajectory or orbit that could not be computed; `status` says how it ended."""

    def __init__(self, status: Status, context: str = "") -> None:
        super().__init__(f"{context}{status.sentence}")
        self.status = status


def simulate(
    parameters: Parameters | None = None,
    *,
    periods: int = 6,
    start: StartName = "initial",
    samples_per_period: int = 2000,
    method: str = DEFAULTS.method,
    rtol: float = DEFAULTS.rtol,
    dt: float = DEFAULTS.dt,
    noise: str = DEFAULTS.noise,
    friction: str = DEFAULTS.friction,
    max_steps: int | None = DEFAULTS.max_steps,
    max_periods: int = DEFAULTS.max_periods,
) -> xr.Dataset:
    """The time courses of one trajectory over a number of drive periods.

    Parameters
    ----------
    parameters
        The model's parameters; the paper's Fig. 3 by default.
    periods, samples_per_period
        Length and sampling; periods*samples_per_period + 1 equidistant samples.
    start
        'initial': from (x_0, v_0, phi_0). 'stationary': on the orbit that this start leads to.
    method, rtol, dt, noise, friction, max_steps, max_periods
        As for `stationary_orbit`.

    Returns
    -------
    xarray.Dataset
        Variables of `variables.TRAJECTORY` over the dimension `time` [s], the parameters as
        scalar coordinates; order 3 between the steps of the adaptive method.

    Raises
    ------
    IntegrationError
        The state diverged, the budget ran out, the fixed step is unstable or, from
        'stationary', no stationary orbit was reached.
    NoiseError
        phi_0 = 0 without noise.
    ValueError
        Fewer than one period or one sample a period.
    """
    if periods < 1 or samples_per_period < 1:
        raise ValueError("periods and samples_per_period must be at least 1")
    if start not in get_args(StartName):
        raise ValueError(f"start must be one of {get_args(StartName)}, not {start!r}")
    parameters = parameters or Parameters()
    options = Options(
        method=method,
        rtol=rtol,
        dt=dt,
        max_steps=max_steps,
        stationary_rtol=rtol,
        max_periods=max_periods,
        noise=noise,
        friction=friction,
    )
    point = prepared_points(np.array(parameters), noise)[0]
    samples = _sampled(point, options, start, periods, samples_per_period)
    period = 2.0 * math.pi / parameters.angular_frequency
    times = np.arange(len(samples)) * (period / samples_per_period)
    return _dataset(parameters, options, times, samples)


def _sampled(
    point: np.ndarray, options: Options, start: StartName, periods: int, per_period: int
) -> np.ndarray:
    """The states (x, v, phi) at the sample times, shape (periods*per_period + 1, WIDTH)."""
    method = METHODS[options.method].kernels
    limit = float(method.largest_step(point[None, :], options)[0])
    if options.dt > limit:
        largest = step_as_text(limit)
        context = f"dt = {options.dt:g} s is above the largest stable step {largest} s. "
        raise IntegrationError(Status.REFUSED, context)
    samples = np.empty((periods * per_period + 1, WIDTH))
    state = _start_state(point, options, start)
    status = Status(method.trajectory(point, options, state, per_period, samples))
    if status is not Status.OK:
        raise IntegrationError(status)
    return samples


def _start_state(point: np.ndarray, options: Options, start: StartName) -> np.ndarray:
    """The state (x, v, ln phi) at phase 0 from which a trajectory starts, shape (WIDTH,)."""
    if start == "stationary":
        results, finals = compute_orbits(point, options)
        status = Status(int(results[0, STATUS]))
        if status is not Status.OK:
            raise IntegrationError(status, "No stationary start: ")
        return finals[0, :WIDTH].copy()
    state = np.empty(WIDTH)
    write_start(point, state)
    return state


def _dataset(
    parameters: Parameters, options: Options, times: np.ndarray, samples: np.ndarray
) -> xr.Dataset:
    import xarray as xr

    observables = np.empty((len(times), len(OBSERVABLES)))
    u_s = METHODS[options.method].kernels.rounding(parameters, options)
    observables_kernel(options.friction)(np.array(parameters), times, samples, u_s, observables)
    states = dict(zip(_SAMPLED, samples.T, strict=True))
    columns = states | dict(zip(OBSERVABLES, observables.T, strict=True))
    data = {
        name: ("time", columns[name], attributes(TRAJECTORY[name]))
        for name in TRAJECTORY
        if name != "time"
    }
    coords = {"time": ("time", times, attributes(TRAJECTORY["time"]))} | {
        name: ((), value, attributes(PARAMETERS[name]))
        for name, value in parameters._asdict().items()
    }
    return xr.Dataset(data, coords)


def attributes(variable: Variable) -> dict[str, str]:
    """The CF attributes of a quantity: long_name, units, symbol and perhaps a comment."""
    named = {
        "long_name": variable.meaning,
        "units": variable.units,
        "symbol": variable.symbol,
    }
    return named | ({"comment": variable.comment} if variable.comment else {})
