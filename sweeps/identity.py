"""The identity of points: which computations are the same.

Two points are the same if all their parameters are equal as floats and the settings below are
equal. They then have the same key, even in different grids. Title, output, execution, plot and
simulation never enter a key, nor does a change of the sources that changes no number.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.keys import Keys, keys_of_lines, keys_of_points, secret_of
from stickslip.variables import PARAMETERS
from sweeps.config.checks import NEAR
from sweeps.config.load import Config, from_mapping
from sweeps.grid import Grid

Settings = Mapping[str, Any]

_AT_ONCE = 1 << 14  # points whose keys are computed together


def settings_of(config: Config) -> Settings:
    """Return the settings that determine a point besides its parameters, by dotted name."""
    sections = config.defining().items()
    flat = {f"{name}.{key}": value for name, section in sections for key, value in section.items()}
    # `refine` is no setting: it leaves the points as they are.
    return flat | ({"follow": config.follow} if config.follow else {})


def differences(old: Settings, new: Settings) -> list[str]:
    """Return a line for each setting that differs, such as `integrator.rtol: 1e-06 -> 1e-05`."""
    return [
        f"{name}: {old.get(name, 'not set')} -> {new.get(name, 'not set')}"
        for name in dict.fromkeys([*old, *new])
        if old.get(name) != new.get(name)
    ]


class PointKeys:
    """The keys of the points of a grid, and the search for points by key.

    A key encodes the parameters of a point, all `settings` that differ from the defaults, and the
    numerics version. On a followed line it also encodes the parameters of all earlier points,
    unless the points are taken `alone`. All keys of a grid differ, since a config cannot repeat
    cases.
    """

    def __init__(self, grid: Grid, settings: Settings, *, alone: bool = False) -> None:
        chosen = {name: v for name, v in settings.items() if _defaults().get(name) != v}
        self._secret = secret_of(json.dumps(chosen, sort_keys=True), NUMERICS_VERSION)
        self._grid, self._alone = grid, alone or not grid.followed

    def of(self, numbers: NDArray[np.int64]) -> Keys:
        """Return the keys (n, 2) of points by their numbers (n,)."""
        if self._alone:
            return keys_of_points(self._grid.rows(numbers), self._secret)
        return self._along_lines[numbers]

    def find(self, keys: Keys) -> NDArray[np.int64]:
        """Return, for each key (n, 2), the number (n,) of its point, or -1 if the grid has none.

        The search takes eight bytes of memory for each point of the grid, until `release`.
        """
        found = np.full(len(keys), -1)
        if not len(keys):
            return found
        words, mask = self._sorted
        sought = keys[:, 0] & ~mask
        left = np.argsort(sought)  # neighbours lie in the same part of the memory
        place = np.empty(len(keys), dtype=np.int64)
        place[left] = np.searchsorted(words, sought[left])
        while len(left := left[place[left] < len(words)]):
            word = words[place[left]]
            likely = word & ~mask == sought[left]
            left, candidates = left[likely], (word[likely] & mask).astype(np.int64)
            right = (self.of(candidates) == keys[left]).all(axis=1)
            found[left[right]] = candidates[right]
            left = left[~right]
            place[left] += 1
        return found

    def release(self) -> None:
        """Free the memory of `find`, whose next call sorts the points again."""
        self.__dict__.pop("_sorted", None)

    def numbers_of(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the numbers (n,) of points (n, parameters), as `find` does.

        Each point is taken alone, which on a followed line means its upward direction.
        """
        return self.find(keys_of_points(points, self._secret))

    @cached_property
    def _sorted(self) -> tuple[NDArray[np.uint64], np.uint64]:
        """A word for each point, in the order of the keys, and a mask.

        The bits of a word under the mask are the number of the point; the others come from its key.
        The words can therefore be sorted in place.
        """
        size = self._grid.size
        mask = np.uint64((1 << size.bit_length()) - 1)
        words = np.empty(size, dtype=np.uint64)
        for first in range(0, size, _AT_ONCE):
            numbers = np.arange(first, min(first + _AT_ONCE, size))
            words[numbers] = self.of(numbers)[:, 0] & ~mask | numbers.astype(np.uint64)
        words.sort()
        return words, mask

    @cached_property
    def _along_lines(self) -> Keys:
        """The keys (size, 2) of all points of followed lines."""
        keys = np.empty((self._grid.size, 2), dtype=np.uint64)
        lines = self._grid.lines()
        at_once = max(_AT_ONCE // lines.shape[1], 1)
        for first in range(0, len(lines), at_once):
            some = lines[first : first + at_once]
            points = self._grid.rows(some.ravel())
            keys[some] = keys_of_lines(points.reshape(*some.shape, -1), self._secret)
        return keys


@cache
def _defaults() -> Settings:
    """Return the settings of an empty config."""
    return settings_of(from_mapping({}))


def near_duplicates(old: Grid, new: Grid) -> list[str]:
    """Return pairs of old and new values that differ only by rounding but make different points."""
    pairs = []
    for name in (*new.fixed, *new.coords):
        if (name not in old.fixed and name not in old.coords) or name not in PARAMETERS:
            continue
        known, values = old.values(name), new.values(name)
        unknown = values[~np.isin(values, known)]
        place = np.searchsorted(known, unknown)
        for side in (np.maximum(place - 1, 0), np.minimum(place, len(known) - 1)):
            near = np.abs(unknown - known[side]) <= NEAR * np.abs(unknown)
            neighbours = zip(known[side][near].tolist(), unknown[near].tolist(), strict=True)
            pairs += [f"{name} {before!r} and {after!r}" for before, after in neighbours]
    return list(dict.fromkeys(pairs))  # an outermost value has the same neighbour on both sides
