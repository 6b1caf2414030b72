"""Configs in the engine: checked with the physics, made into kernel options, read from results."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import stability
from stickslip.laws import LawError
from stickslip.model.laws import friction_law
from stickslip.options import DEFAULTS, METHODS, Options
from sweeps.config.load import Config, ConfigError, Problem, from_mapping, load
from sweeps.config.schema import Film
from sweeps.config.yaml_reader import read_mapping
from sweeps.grid import Grid
from sweeps.human import counted

SOURCE = "the config of this result"
_AXES = re.compile(r"^(sweep|cases):.*\n(  .*\n)*", re.MULTILINE)
_NAME = re.compile(r"^  (\w+):", re.MULTILINE)

CHUNK = 100_000
"""How many points are checked at a time for a stable step."""


def read_config(source: str | Path | Mapping[str, Any], overrides: Sequence[str] = ()) -> Config:
    """Return the config in a file or a dict, checked with the physics; raises ConfigError."""
    if isinstance(source, Mapping):
        return from_mapping(source, overrides=overrides, checks=CHECKS)
    return load(source, overrides, checks=CHECKS)


@lru_cache(maxsize=1)
def config_without_axes(text: str, source: str = SOURCE) -> Mapping[str, Any]:
    """Return the config in a result without its axes; raises ConfigError.

    Axes may have many numbers, which the YAML parser reads slowly. The last config is cached,
    because a report asks for many points of one result.
    """
    return read_mapping(_AXES.sub("", text), source)


@lru_cache(maxsize=1)
def varied_in(text: str) -> tuple[str, ...]:
    """Return the parameters that vary in the config of a result."""
    return tuple(name for found in _AXES.finditer(text) for name in _NAME.findall(found[0]))


def swept_in(text: str) -> tuple[str, ...]:
    """Return the axes in the config of a result, without linked cases."""
    swept = (found[0] for found in _AXES.finditer(text) if found[1] == "sweep")
    return tuple(name for axes in swept for name in _NAME.findall(axes))


def options_of(config: Config) -> Options:
    """Return the options of a config for `compute_orbits`.

    Raises ConfigError if the friction law here does not have the identity that the config names.
    """
    for key, message in changed_law(config):
        raise ConfigError([Problem("", None, key, message)])
    noise = config.noise
    return Options(
        **config.integrator.model_dump(),
        stationary_rtol=config.stationary.rtol,
        max_periods=config.stationary.max_periods,
        window=config.stationary.window,
        accelerate=config.stationary.accelerate,
        noise=noise.treatment,
        seed=DEFAULTS.seed if noise.seed is None else noise.seed,
        realizations=DEFAULTS.realizations if noise.realizations is None else noise.realizations,
        friction=_law_name(config.film),
        strain=config.film.strain,
    )


def coarse_step(config: Config) -> Iterator[str]:
    """Yield a warning if a fixed step is unstable for some points, or inaccurate."""
    if not _has_fixed_step(config):
        return
    dt, largest = config.integrator.dt, _largest_steps(config, Grid.from_config(config), 0)
    refused = int((dt > largest).sum())
    if refused:
        yield (
            f"integrator.dt: the step of {dt:g} s is unstable for {refused} of "
            f"the {counted(len(largest), 'point')} checked; those points will be refused"
        )
    elif (dt > stability.ACCURATE_PART * largest).any():
        yield (
            f"integrator.dt: the step of {dt:g} s is stable, but coarse: errors "
            f"are proportional to it; use {stability.step_as_text(largest.min() / 4)} s or less"
        )


def changed_law(config: Config) -> Iterator[tuple[str, str]]:
    """Yield a complaint if a friction law is missing, breaks a promise, or has changed."""
    try:
        friction_law(_law_name(config.film))
    except LawError as error:
        yield "film.friction", str(error)


def unstable_step(config: Config) -> Iterator[tuple[str, str]]:
    """Yield a complaint if a fixed step is unstable for every point of the config."""
    if not _has_fixed_step(config) or any(changed_law(config)):
        return
    grid, largest = Grid.from_config(config), 0.0
    for start in range(0, grid.size, CHUNK):
        largest = max(largest, float(_largest_steps(config, grid, start).max()))
        if config.integrator.dt <= largest:
            return
    allowed = stability.step_as_text(largest)
    yield (
        "integrator.dt",
        f"the step of {config.integrator.dt:g} s is unstable for every point and would give "
        f"finite but wrong amplitudes; the largest allowed step is {allowed} s",
    )


def missing_scheduler(config: Config) -> Iterator[tuple[str, str]]:
    """Yield a complaint if a config asks for a cluster without naming one."""
    if config.execution.backend == "dask" and config.execution.scheduler is None:
        yield (
            "execution.backend",
            "`dask` needs the address of a scheduler, such as --scheduler tcp://host:8786; "
            "for processes on this machine, use `loky`",
        )


CHECKS = (missing_scheduler, changed_law, unstable_step)


def _law_name(film: Film) -> str:
    return film.friction if film.law is None else f"{film.friction}@{film.law}"


def _has_fixed_step(config: Config) -> bool:
    return METHODS[config.integrator.method].own_option == "dt"


def _largest_steps(config: Config, grid: Grid, start: int) -> NDArray[np.float64]:
    """Return the largest stable step [s] of each point of the chunk that begins with `start`."""
    points = grid.points(start, min(start + CHUNK, grid.size))
    kernels = METHODS[config.integrator.method].kernels
    return np.asarray(kernels.largest_step(points, options_of(config)))
