"""Trajectories from a config: one, or one for each value of a single axis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from stickslip.kernels.families import physics_at
from stickslip.kernels.trajectories import (
    OBSERVABLES,
    observables_kernel,
    start_kernel,
    write_trajectory,
)
from stickslip.model.models import model_of
from stickslip.options import METHODS
from stickslip.orbit import typical_options
from stickslip.parameters import Parameters
from stickslip.trajectory import TIME, simulate
from sweeps.config.load import Config
from sweeps.config.pull import Drive, PulledError
from sweeps.config.schema import Simulation
from sweeps.engine.computing import compile_kernels
from sweeps.engine.progress import SILENT, Compiling
from sweeps.engine.settings import options_of
from sweeps.exits import ExpectedError
from sweeps.files.attributes import add_provenance
from sweeps.grid import Grid
from sweeps.human import counted

if TYPE_CHECKING:
    import xarray as xr


_SUMMARY = "Time courses of a block that is driven through a boundary lubricant film"


# A very short pull, which needs the same kernels.
_MOMENT = Simulation(drive=Drive(velocity=1e-9), duration=1e-12, samples=2)


class AxisLeftError(ExpectedError, ValueError):
    """A trajectory needs a config without axes; the message gives the `--set` to choose a point."""

    def __init__(self, config: Config) -> None:
        choices = [f"--set {name}={values[0]!r}" for name, values in config.sweep.items()]
        if config.cases:
            choices.append("--set case=0")
        choices += [f"--set {key}=null" for key in config.order()]  # no axis is left for them
        super().__init__(
            f"the config has {Grid.from_config(config).size} points, but a trajectory has "
            f"only one: pick it, for example with {' '.join(choices)}"
        )


class OtherAxesError(ExpectedError, ValueError):
    """A config for several trajectories that does not have exactly one axis."""


def trajectory(
    config: Config, compiling: Compiling = SILENT, *, start: Sequence[float] | None = None
) -> xr.Dataset:
    """Return the trajectory that a config without axes describes.

    `compiling` shows that kernels are being compiled. `start` is a state (x, v, ln phi) to start
    from, in place of `simulation.start`.

    Raises AxisLeftError, and what `stickslip.simulate` raises.
    """
    if config.sweep or config.cases:
        raise AxisLeftError(config)
    with compiling:
        compile_trajectory_kernels(config)
    title = config.title or "Trajectory"
    simulated = _simulated(config, config.parameters(), start)
    return add_provenance(simulated, config, title, _SUMMARY)


def trajectories(config: Config, compiling: Compiling = SILENT) -> xr.Dataset:
    """Return one trajectory for each value of the only axis of a config, along (axis, sample).

    `elapsed_time` becomes a coordinate along both dimensions, because drive periods differ.

    Raises OtherAxesError; PulledError for a pulled block, since the number of slips differs between
    runs; and what `stickslip.simulate` raises.
    """
    import xarray as xr

    if config.simulation.drive is not None:
        raise PulledError(
            "simulation.drive: pulls along an axis have different numbers of slips, and do not fit "
            "into one file; simulate one at a time, with --set"
        )
    if len(config.sweep) != 1 or config.cases or config.follow:
        raise OtherAxesError(
            "several trajectories need a config with exactly one axis, without `cases` and "
            "`follow`: fix the other parameters under `model`"
        )
    grid = Grid.from_config(config)
    (axis,) = grid.dims
    with compiling:
        compile_trajectory_kernels(config)
    runs = [
        _simulated(config, Parameters(*point)).reset_index(TIME).rename_dims({TIME: "sample"})
        for point in grid.points(0, grid.size)
    ]
    together = xr.concat(
        [run.reset_coords(TIME) for run in runs], dim=axis, combine_attrs="drop_conflicts"
    )
    together = together.set_coords(TIME)
    return add_provenance(together, config, config.title or "Trajectories", _SUMMARY)


# A force that changes by more than this fraction in the last tenth of a run is not steady yet.
_STEADY = 1e-3


def pull_summary(ds: xr.Dataset) -> Iterator[str]:
    """Yield the lines of a summary of a pulled block's motion, none for other trajectories."""
    about = ds.attrs
    if about.get("motion") == "stick-slip":
        yield f"stick-slip: one melting event every {about['slip_period']:.6g} s"
        for name, what in (("spring_force", "spring force 2Kx"), ("slip_force", "friction force")):
            low, high = (about[f"{name}_{end}"] for end in ("min", "max"))
            yield f"{what}: {low:.6g} to {high:.6g} N"
        yield f"mean friction force: {about['slip_force_mean']:.6g} N"
        count = ds.sizes["melting"]
        yield f"(means over the last {about['settled_slips']} of {count} melting events)"
    elif about.get("motion") == "steady":
        force, change = about["steady_force"], about["steady_force_change"]
        before = f" ({counted(count, 'melting')} before)" if (count := ds.sizes["melting"]) else ""
        yield f"no stick-slip at the end{before}: friction force {force:.6g} N"
        if change > _STEADY * abs(force):
            yield f"still changing, by {change:.2g} N in the last tenth; use a longer duration"


def compile_trajectory_kernels(config: Config) -> None:
    """Compile or load the kernels of `simulate`: a trajectory of no steps calls them all."""
    if config.simulation.drive:
        _simulated(config.model_copy(update={"simulation": _MOMENT}), config.parameters())
        return
    options, grid = options_of(config), Grid.from_config(config)
    width = model_of(options.physics).width
    point, start, states = grid.points(0, 1)[0], np.empty(width), np.empty((1, width))
    METHODS[options.method].kernels.largest_step(point[None, :], options)
    start_kernel(options.physics.typical)(point, start)
    write_trajectory(point, options, start, 1, states)
    observables = np.empty((0, len(OBSERVABLES)))
    physics = physics_at(point, options.physics.typical)
    observables_kernel(physics)(point, np.empty(0), states[:0], 0.0, observables)
    if config.simulation.start == "stationary":
        compile_kernels(typical_options(options), grid)


def _simulated(
    config: Config, parameters: Parameters, start: Sequence[float] | None = None
) -> xr.Dataset:
    options = asdict(options_of(config))
    for option in ("stationary_rtol", "window", "max_error", "accelerate", "observables"):
        del options[option]
    run = config.simulation.arguments() | ({} if start is None else {"start": start})
    return simulate(parameters, **run, **options)
