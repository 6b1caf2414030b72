"""Sweeps over many orbits: config, grid, blocks, Dataset, NetCDF, figures, command line."""

from __future__ import annotations

import importlib

# Importing `typing` would delay the moment from which the command line answers Ctrl-C.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from sweeps.accessor import StickslipAccessor
    from sweeps.engine.run import run
    from sweeps.fitting.fitting import FitError, fit
    from sweeps.page.explorer import Explorer, explore

__all__ = ["Explorer", "FitError", "StickslipAccessor", "explore", "fit", "run"]

_HOMES = {
    "Explorer": "sweeps.page.explorer",
    "FitError": "sweeps.fitting.fitting",
    "StickslipAccessor": "sweeps.accessor",
    "explore": "sweeps.page.explorer",
    "fit": "sweeps.fitting.fitting",
    "run": "sweeps.engine.run",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'sweeps' has no attribute {name!r}")
    found = globals()[name] = getattr(importlib.import_module(_HOMES[name]), name)
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
