"""The identity of points: when two computations are the same.

A point is the same if all its parameters are equal as floats and the settings below are equal.
Title, output, execution, plot and simulation never enter, nor does an edit of the sources that
changes no number.
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
from sweeps.config.schema import without_newer
from sweeps.grid import Grid

Settings = Mapping[str, Any]

KEY_BYTES = 16
_NEAR = 1e-9  # relative: closer values differ by rounding rather than by intention


def settings_of(config: Config) -> Settings:
    """Return the settings that, besides its parameters, determine a point, by dotted name."""
    parts = {name: section.used() for name, section in config.defining().items()}
    flat = {f"{name}.{key}": v for name, part in parts.items() for key, v in part.items()}
    followed = {"follow": config.follow} if config.follow else {}  # refined points are the same
    return flat | followed | config.asked()


def differences(old: Settings, new: Settings) -> list[str]:
    """Return a line for each setting that differs, as `integrator.rtol: 1e-06 -> 1e-05`."""
    return [
        f"{name}: {old.get(name, 'not set')} -> {new.get(name, 'not set')}"
        for name in dict.fromkeys([*old, *new])
        if old.get(name) != new.get(name)
    ]


def key_of(settings: Settings, grid: Grid) -> bytes:
    """Return the key of a computation: under one key, a point's number has one meaning."""
    parts = [dict(settings), without_newer(grid.fixed), NUMERICS_VERSION]
    digest = hashlib.blake2b(json.dumps(parts, sort_keys=True).encode(), digest_size=KEY_BYTES)
    for name, (dims, values) in sorted(grid.coords.items()):
        place = [grid.dims.index(dim) for dim in dims]
        digest.update(f"{name}{place}{len(values)}\0".encode() + values.tobytes())
    return digest.digest()


def near_duplicates(old: Grid, new: Grid) -> list[str]:
    """List values of the new grid that differ from old ones by rounding, yet are other points."""
    pairs = []
    for name in (*new.fixed, *new.coords):
        if (name not in old.fixed and name not in old.coords) or name not in PARAMETERS:
            continue
        known, values = old.values(name), new.values(name)
        unknown = values[~np.isin(values, known)]
        place = np.searchsorted(known, unknown)
        for side in (np.maximum(place - 1, 0), np.minimum(place, len(known) - 1)):
            near = np.abs(unknown - known[side]) <= _NEAR * np.abs(unknown)
            neighbours = zip(known[side][near].tolist(), unknown[near].tolist(), strict=True)
            pairs += [f"{name} {before!r} and {after!r}" for before, after in neighbours]
    return list(dict.fromkeys(pairs))  # an outermost value has the same neighbour on both sides
