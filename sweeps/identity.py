"""When two computations are the same: what enters the identity of a point, and how it is told.

A point is the same if all its parameters are equal as floats and the settings below are equal.
Title, output, execution, plot and simulation never enter, nor does an edit of the sources that
changes no number. A parameter or key that is younger than a file names its neutral value, under
which the file stays true; at that value it does not enter either.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.variables import PARAMETERS
from sweeps.config.load import Config
from sweeps.config.schema import SECTIONS
from sweeps.grid import Grid

Settings = Mapping[str, Any]

KEY_BYTES = 16
_NEAR = 1e-9  # relative: closer values differ by rounding rather than by intention


def settings_of(config: Config, numerics_version: int | str = NUMERICS_VERSION) -> Settings:
    """What, besides its parameters, makes a point's numbers: dotted names and their values."""
    parts = {name: section.identity() for name, section in config.defining().items()}
    flat = {f"{name}.{key}": v for name, part in parts.items() for key, v in part.items()}
    followed = {"follow": config.follow} if config.follow else {}  # refined points are the same
    return flat | followed | {"numerics_version": int(numerics_version)}


def differences(old: Settings, new: Settings) -> list[str]:
    """One line for each setting that differs, as `integrator.rtol: 1e-06 -> 1e-05`."""
    return [
        f"{name}: {_value(name, old)} -> {_value(name, new)}"
        for name in dict.fromkeys([*old, *new])
        if old.get(name) != new.get(name)
    ]


def _value(name: str, settings: Settings) -> Any:
    """The value of a setting, the neutral one where it did not enter."""
    section, _, key = name.partition(".")
    neutral = SECTIONS[section].neutral() if section in SECTIONS else {}
    return settings.get(name, neutral.get(key, "not set"))


def key_of(settings: Settings, grid: Grid) -> bytes:
    """The key of a computation: points of the same number mean the same under the same key."""
    digest = hashlib.blake2b(
        json.dumps(dict(settings), sort_keys=True).encode(), digest_size=KEY_BYTES
    )
    for name, value in sorted(grid.fixed.items()):
        if value != PARAMETERS[name].neutral:
            digest.update(f"{name}={value!r}\0".encode())
    for name, (dims, values) in sorted(grid.coords.items()):
        place = [grid.dims.index(dim) for dim in dims]
        digest.update(f"{name}{place}{len(values)}\0".encode() + values.tobytes())
    return digest.digest()


def seal_key(settings: Settings, grid: Grid) -> bytes:
    """The key with which the numbers of a file are sealed: of what it says of them but the version.

    A file of another version is sound, and refused for another reason.
    """
    lasting = {name: value for name, value in settings.items() if name != "numerics_version"}
    return key_of(lasting, grid)


def near_duplicates(old: Grid, new: Grid) -> list[str]:
    """Values of the new grid that differ from one of the old by rounding: other points."""
    told = []
    for name in (*new.fixed, *new.coords):
        if (name not in old.fixed and name not in old.coords) or name not in PARAMETERS:
            continue
        known, wanted = old.values(name), new.values(name)
        unknown = wanted[~np.isin(wanted, known)]
        place = np.searchsorted(known, unknown)
        for side in (np.maximum(place - 1, 0), np.minimum(place, len(known) - 1)):
            near = np.abs(unknown - known[side]) <= _NEAR * np.abs(unknown)
            pairs = zip(known[side][near].tolist(), unknown[near].tolist(), strict=True)
            told += [f"{name} {was!r} and {now!r}" for was, now in pairs]
    return list(dict.fromkeys(told))  # an outermost value has one neighbour, on both sides
