"""A sweep from a config to a Dataset, in memory and without files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweeps.config.load import Config, from_mapping, load
from sweeps.engine.dispatch import compute
from sweeps.engine.options import options_of, unstable_step
from sweeps.engine.worker import Block
from sweeps.files.attributes import result_dataset
from sweeps.grid import Grid

if TYPE_CHECKING:
    import xarray as xr


def read_config(source: str | Path | Mapping[str, Any], overrides: Sequence[str] = ()) -> Config:
    """The config in a file or a dict, checked with the physics; raises ConfigError."""
    if isinstance(source, Mapping):
        return from_mapping(source, overrides=overrides, checks=[unstable_step])
    return load(source, overrides, checks=[unstable_step])


def run(
    source: str | Path | Mapping[str, Any] | Config,
    *,
    workers: int | None = None,
    on_block: Callable[[Block], None] | None = None,
) -> xr.Dataset:
    """The result of a sweep, as the command line would write it to a file.

    Nothing is written: for a grid that does not fit into memory, or takes long enough to be
    interrupted, use `sweeps.engine.sweep`, which is the command line's.

    Parameters
    ----------
    source
        A YAML file, a dict of the same shape, or a Config.
    workers
        Threads or processes; by default what the config says.
    on_block
        Called, in the calling thread, with each block of points as it is finished, in any order.

    Raises
    ------
    ConfigError
        The config cannot be used; all problems are reported at once.
    BackendError
        The workers that the config asks for cannot be had.
    RuntimeError
        Points were lost on the way.
    """
    config = source if isinstance(source, Config) else read_config(source)
    grid = Grid.from_config(config)
    execution = config.execution
    if workers is not None:
        execution = execution.model_copy(update={"workers": workers})
    results = compute(grid, options_of(config), execution=execution, on_block=on_block)
    return result_dataset(config, grid, results)
