"""The friendly door to trajectories: Parameters in, an xarray Dataset of the time courses out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from stickslip import kernels, stability
from stickslip.options import DEFAULTS, Options
from stickslip.orbit import compute_orbits, prepared_points
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import PARAMETERS, TRAJECTORY, Variable

if TYPE_CHECKING:
    import xarray as xr

StartName = Literal["initial", "stationary"]


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
    method, rtol, dt, noise, max_steps, max_periods
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
        method, rtol, dt, max_steps, stationary_rtol=rtol, max_periods=max_periods, noise=noise
    )
    point = prepared_points(np.array(parameters), noise)[0]
    samples = _sampled(point, options, start, periods, samples_per_period)
    period = 2.0 * math.pi / parameters.angular_frequency
    times = np.arange(len(samples)) * (period / samples_per_period)
    return _dataset(parameters, times, samples)


def _sampled(
    point: np.ndarray, options: Options, start: StartName, periods: int, per_period: int
) -> np.ndarray:
    """The states (x, v, phi) at the sample times, shape (periods*per_period + 1, 3)."""
    fixed = options.method == "euler-cromer"
    if fixed and options.dt > (limit := float(stability.largest_stable_step(point)[0])):
        largest = stability.step_as_text(limit)
        context = f"dt = {options.dt:g} s is above the largest stable step {largest} s. "
        raise IntegrationError(Status.REFUSED, context)
    samples = np.empty((periods * per_period + 1, 3))
    door = kernels.fixed_trajectory if fixed else kernels.adaptive_trajectory
    state = _start_state(point, options, start)
    status = Status(door(point, options.settings(), state, per_period, samples))
    if status is not Status.OK:
        raise IntegrationError(status)
    return samples


def _start_state(point: np.ndarray, options: Options, start: StartName) -> np.ndarray:
    """The state (x, v, ln phi) at phase 0 from which a trajectory starts."""
    if start == "stationary":
        results, finals = compute_orbits(point, options)
        status = Status(int(results[0, -1]))
        if status is not Status.OK:
            raise IntegrationError(status, "No stationary start: ")
        return finals[0, :3].copy()
    state = np.empty(3)
    kernels.starting_log_state(point, state)
    return state


def _dataset(parameters: Parameters, times: np.ndarray, samples: np.ndarray) -> xr.Dataset:
    import xarray as xr

    observables = np.empty((len(times), 6))
    kernels.trajectory_observables(np.array(parameters), times, samples, observables)
    columns = {
        "upper_displacement": observables[:, 0],
        "lower_displacement": samples[:, 0],
        "upper_velocity": observables[:, 1],
        "lower_velocity": samples[:, 1],
        "order_parameter": samples[:, 2],
        "elastic_strain": observables[:, 2],
        "elastic_stress": observables[:, 3],
        "viscous_stress": observables[:, 4],
        "friction_force": observables[:, 5],
    }
    data = {
        name: ("time", values, attributes(TRAJECTORY[name])) for name, values in columns.items()
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
