"""From result rows to the Dataset that is written: names, units, flags, provenance."""

from __future__ import annotations

import platform
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib import metadata

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.compiled import source_hash
from stickslip.kernels import NUMERICS_VERSION, RESULT_COLUMNS
from stickslip.status import Status
from stickslip.trajectory import attributes
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.config import Config
from sweeps.grid import CASE, Grid

COUNTS = ("orbit_periods", "melting_count", "periods_integrated")

_PACKAGES = ("stickslip", "numpy", "numba", "llvmlite", "xarray", "netCDF4", "joblib")

REFERENCE = (
    "I. A. Lyashenko and A. M. Zaskoka, Stick-slip mode of boundary friction as the first-order "
    "phase transition, Ukr. J. Phys. 58, 91 (2013), arXiv:1302.0720"
)


def result_dataset(config: Config, grid: Grid, results: NDArray[np.float64]) -> xr.Dataset:
    """The Dataset of a sweep as it is written to a file.

    Parameters
    ----------
    config, grid
        What was computed.
    results
        (grid.size, 13), columns as `kernels.RESULT_COLUMNS`; NaN rows, not yet computed, get the
        status `pending`.
    """
    data = {name: _variable(name, results[:, i], grid) for i, name in enumerate(RESULT_COLUMNS)}
    return xr.Dataset(data, _coordinates(grid), _global_attributes(config))


def _variable(name: str, column: NDArray[np.float64], grid: Grid) -> xr.Variable:
    attrs: dict[str, object] = dict(attributes(RESULTS[name]))
    if name == "status":
        pending = np.isnan(column)
        values = np.where(pending, Status.PENDING, np.nan_to_num(column)).astype(np.int8)
        attrs |= _flags()
    elif name in COUNTS:
        values = np.nan_to_num(column, nan=-1.0).astype(np.int32)
    else:
        values = column.astype(np.float64)
    return xr.Variable(grid.dims, values.reshape(grid.shape), attrs)


def _flags() -> dict[str, object]:
    return {
        "flag_values": np.array([int(status) for status in Status], dtype=np.int8),
        "flag_meanings": " ".join(status.name.lower() for status in Status),
    }


def _coordinates(grid: Grid) -> dict[str, xr.Variable]:
    varied = {
        name: xr.Variable(dims, values, _coordinate_attributes(name))
        for name, (dims, values) in grid.coords.items()
    }
    fixed = {
        name: xr.Variable((), np.float64(value), _coordinate_attributes(name))
        for name, value in grid.fixed.items()
    }
    return varied | fixed


def _coordinate_attributes(name: str) -> Mapping[str, str]:
    if name == CASE:
        return {"long_name": "number of the case", "units": "1"}
    return attributes(PARAMETERS[name])


def _global_attributes(config: Config) -> dict[str, str]:
    version = metadata.version("stickslip")
    return {
        "Conventions": "CF-1.8",
        "title": config.title or "Stationary amplitudes of boundary friction",
        "summary": "Amplitudes of elastic stress and friction force over the stationary orbit "
        "of a block that is driven through a boundary lubricant film",
        "source": f"stickslip {version}, method {config.integrator.method}",
        "history": f"{_now()} {_command_line()}",
        "references": REFERENCE,
        "config": config.resolved_yaml(),
        "config_sha256": config.sha256(),
        "software": software(),
        "code_sha256": source_hash(),
        "numerics_version": str(NUMERICS_VERSION),
    }


def software() -> str:
    """Versions of Python and of the packages that enter the numbers or the file."""
    versions = [f"{name} {metadata.version(name)}" for name in _PACKAGES]
    return ", ".join([f"Python {platform.python_version()}", *versions])


def _now() -> str:
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def _command_line() -> str:
    """The command as it was typed, by the name of the program alone."""
    program, *arguments = sys.argv
    return " ".join([program.rsplit("/", 1)[-1], *arguments])


def add_provenance(ds: xr.Dataset, config: Config, title: str) -> xr.Dataset:
    """The same trajectory Dataset with the global attributes of a file."""
    attrs = _global_attributes(config) | {
        "title": title,
        "summary": "Time courses of a block that is driven through a boundary lubricant film",
    }
    return ds.assign_attrs(attrs)
