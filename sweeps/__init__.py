"""Sweeps over many orbits: config, grid, blocks, Dataset, NetCDF, figures, command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sweeps.engine.run import run

__all__ = ["run"]


def __getattr__(name: str) -> Any:
    if name != "run":
        raise AttributeError(f"module 'sweeps' has no attribute {name!r}")
    from sweeps.engine.run import run

    globals()["run"] = run
    return run
