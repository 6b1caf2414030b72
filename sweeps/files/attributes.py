"""The Dataset of a file, made from result rows: names, units, flags, provenance."""

from __future__ import annotations

import hashlib
import platform
import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.compiled.cache import processor, source_hash
from stickslip.datasets import result_attributes, result_variables
from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.variables import PARAMETERS, PHASES, PULLED, RESULTS, STROBOSCOPIC, TRAJECTORY
from sweeps.config.load import Config
from sweeps.files.result_rows import STATUS, failures, status_counts
from sweeps.grid import CASE, DIRECTION, Grid
from sweeps.human import shortened

if TYPE_CHECKING:
    import xarray as xr

_REGISTERED: Mapping[str, Mapping[str, Any]] = {
    name: variable.attributes
    for variables in (PARAMETERS, TRAJECTORY, PULLED, STROBOSCOPIC, PHASES)
    for name, variable in variables.items()
} | {name: result_attributes(name) for name in RESULTS}

# Attributes by which a reader changes the values; no file is written with them.
_DECODED = {
    *("missing_value", "scale_factor", "add_offset", "_Unsigned", "dtype", "calendar"),
    *("valid_min", "valid_max", "valid_range", "flag_masks"),
}

Place = tuple[tuple[str, ...], NDArray[np.generic]]
"""The dimensions and the values of a coordinate."""

Coordinate = tuple[tuple[str, ...], NDArray[np.generic], dict[str, str]]

_PACKAGES = ("stickslip", "numpy", "numba", "llvmlite", "xarray", "netCDF4", "joblib")

REFERENCE = (
    "I. A. Lyashenko and A. M. Zaskoka, Stick-slip mode of boundary friction as the first-order "
    "phase transition, Ukr. J. Phys. 58, 91 (2013), arXiv:1302.0720"
)


def result_dataset(config: Config, grid: Grid, results: NDArray[np.float64]) -> xr.Dataset:
    """Return the Dataset of a sweep as it is written to a file.

    `results` (grid.size, columns) are in the order of `RESULT_COLUMNS`; NaN rows get the status
    `pending`.
    """
    import xarray as xr

    data = result_variables(results, grid.dims, grid.shape)
    digests = [hashlib.sha256(values.tobytes()).hexdigest() for _, values, _ in data.values()]
    along = {name: xr.Variable(*described) for name, described in coordinates(grid).items()}
    seal = {"data_sha256": data_sha256(seal_key(config.resolved_yaml(), places(grid)), digests)}
    computed = results[~np.isnan(results[:, STATUS]), STATUS]
    breaks = breaks_of(config, status_counts(computed))
    return xr.Dataset(data, along, global_attributes(config) | breaks | seal)


def seal_key(config: str, coordinates: Mapping[str, Place]) -> bytes:
    """Return a digest of the config, as text, and the coordinates of a file."""
    digest = hashlib.sha256(config.encode())
    for name, (dims, values) in sorted(coordinates.items()):
        digest.update(f"\0{name}{dims}{values.shape}\0".encode() + values.tobytes())
    return digest.digest()


def data_sha256(key: bytes, digests: Sequence[str]) -> str:
    """Return the seal of a file, which reveals changes made after it was written.

    `key` is the `seal_key` of the file, `digests` the SHA-256 of each of its result variables, in
    the order of `RESULT_COLUMNS`.
    """
    return hashlib.sha256(key + "".join(digests).encode()).hexdigest()


def coordinates(grid: Grid) -> dict[str, Coordinate]:
    """Return dimensions, values and attributes of a grid's parameters, whether varied or fixed."""
    fixed = {name: ((), np.array(value, np.float64)) for name, value in grid.fixed.items()}
    own: dict[str, dict[str, str]] = {
        CASE: {"long_name": "case number", "units": "1"},
        DIRECTION: {"long_name": f"direction along the followed axis, {grid.followed}"},
    }
    return {
        name: (dims, values, own.get(name) or dict(PARAMETERS[name].attributes))
        for name, (dims, values) in (*grid.coords.items(), *fixed.items())
    }


def places(grid: Grid) -> dict[str, Place]:
    """Return the `coordinates` of a grid without their attributes."""
    return {name: (dims, values) for name, (dims, values, _) in coordinates(grid).items()}


def global_attributes(config: Config) -> dict[str, str]:
    """Return the global attributes of a file: conventions, provenance, the resolved config."""
    version = metadata.version("stickslip")
    return {
        "Conventions": "CF-1.8",
        "title": config.title or "Stationary amplitudes of boundary friction",
        "summary": "Amplitudes of elastic stress and friction force over the stationary orbit "
        "of a block that is driven through a boundary lubricant film",
        "source": f"stickslip {version}, method {config.integrator.method}",
        "history": f"{now()} {command_line()}",
        "references": REFERENCE,
        "config": config.resolved_yaml(),
        "config_sha256": config.sha256(),
        "software": software(),
        "code_sha256": source_hash(),
        "numerics_version": str(NUMERICS_VERSION),
        "processor": processor(),
        **({"sample": str(config.sample)} if config.sample else {}),
    }


def breaks_of(config: Config, statuses: NDArray[np.int64]) -> dict[str, str]:
    """Return as an attribute how often a followed line had to skip a point without a result.

    `statuses` (STATUS_CODES,) counts the points of each status.
    """
    return {"follow_breaks": str(failures(statuses))} if config.follow else {}


@cache
def software() -> str:
    """Return the versions of Python and of the packages that affect the numbers or the file."""
    versions = [f"{name} {metadata.version(name)}" for name in _PACKAGES]
    return ", ".join([f"Python {platform.python_version()}", *versions])


def now() -> str:
    """Return the current time in UTC, as used for provenance."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def command_line() -> str:
    """Return the command as a user can type it again, without the path of the program."""
    program, *arguments = sys.argv or [""]  # an embedded Python may have none
    return shlex.join([program.rsplit("/", 1)[-1], *arguments])


def foreign_attributes(name: str, attributes: Mapping[str, Any]) -> Iterator[str]:
    """Yield each fault in the attributes of a variable that would mislead a reader.

    Missing attributes are allowed: a Dataset made from a result may have lost them. So are unknown
    flags: a later version may have added them.
    """
    own = _REGISTERED.get(name)
    if own is None:
        return
    for attribute in _DECODED & attributes.keys():
        yield f"has {attribute} = {_shown(attributes[attribute])}, but should have none"
    fill = attributes.get("_FillValue")
    if fill is not None and not (isinstance(fill, np.floating) and np.isnan(fill)):
        yield f"has _FillValue = {_shown(fill)}, but only NaN marks a missing value"
    if attributes.get("units", own["units"]) != own["units"]:
        yield f"has units = {_shown(attributes['units'])}, where {own['units']!r} is expected"
    if {"flag_values", "flag_meanings"} & attributes.keys():
        yield from _foreign_flags(flags_of(own), flags_of(attributes))


def _foreign_flags(own: Mapping[int, str], found: Mapping[int, str]) -> Iterator[str]:
    for value, meaning in found.items():
        if own.get(value, meaning) != meaning:
            yield (
                f"has flag_meanings with {_shown(meaning)} for the value {value}, where "
                f"{own[value]!r} is expected"
            )
    if not found:
        yield "has flag_values and flag_meanings that do not match"


def flags_of(attributes: Mapping[str, Any]) -> dict[int, str]:
    """Return the meanings of flags by value; none if the two lists differ in length."""
    values = np.atleast_1d(attributes.get("flag_values", []))
    meanings = str(attributes.get("flag_meanings", "")).split()
    if len(values) != len(meanings) or values.dtype.kind not in "iu":
        return {}
    return dict(zip(values.tolist(), meanings, strict=True))


def _shown(value: object) -> str:
    return shortened(repr(value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value))


def add_provenance(ds: xr.Dataset, config: Config, title: str, summary: str) -> xr.Dataset:
    """Add the global attributes of a file to a Dataset that is not the result of a sweep."""
    return ds.assign_attrs(global_attributes(config) | {"title": title, "summary": summary})
