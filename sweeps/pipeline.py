"""A sweep from a config to a Dataset."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.kernels import RESULT_COLUMNS
from sweeps.config import Config, from_mapping, load
from sweeps.dataset import result_dataset
from sweeps.execute import Block, compute
from sweeps.grid import Grid
from sweeps.options import options_of, unstable_step

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

    Parameters
    ----------
    source
        A YAML file, a dict of the same shape, or a Config.
    workers
        Threads; by default what the config says.
    on_block
        Called with each block of points as it is finished.

    Raises
    ------
    ConfigError
        The config cannot be used; all problems are reported at once.
    """
    config = source if isinstance(source, Config) else read_config(source)
    grid = Grid.from_config(config)
    results = compute(
        grid,
        options_of(config),
        workers=workers or config.execution.workers,
        block_points=config.execution.block_points,
        on_block=on_block,
    )
    return result_dataset(config, grid, results)


def pending_dataset(config: Config) -> xr.Dataset:
    """The Dataset of a sweep of which nothing is computed yet."""
    grid = Grid.from_config(config)
    return result_dataset(config, grid, np.full((grid.size, len(RESULT_COLUMNS)), np.nan))
