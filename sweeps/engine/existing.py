"""The target of a sweep, and the finished points of earlier files and journals."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import netCDF4
import numpy as np
from numpy.typing import NDArray

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS
from sweeps.config.load import Config, ConfigError, from_mapping
from sweeps.config.pull import refuse_pull
from sweeps.engine.settings import config_without_axes
from sweeps.exits import StorageError
from sweeps.files.attributes import data_sha256, seal_key
from sweeps.files.journal import Journal
from sweeps.files.netcdf import DAMAGE
from sweeps.files.outputs import WAYS_OUT
from sweeps.files.outputs import RefusalError as RefusalError  # public under this name
from sweeps.files.result_rows import STATUS, Chunks, Rows
from sweeps.files.sweep_file import (
    Digests,
    columns_in,
    coordinates_in,
    digests_of,
    open_file,
    read_rows,
    whole_chunks,
)
from sweeps.grid import CASE, DIRECTION, Grid
from sweeps.human import counted
from sweeps.identity import PointKeys, Settings, differences, near_duplicates, settings_of
from sweeps.watch import require_readable

Points = Iterator[tuple[NDArray[np.int64], Rows]]

_NOT_AS_WRITTEN = (
    "is no longer as stickslip wrote it: cut down, edited or damaged. It can be drawn, "
    "exported and replayed, but not resumed"
)
_NAMED = 5  # differences that a message lists

_PART = re.compile(r"(\d+)/(\d+)")
_MOST_PARTS = 1_000_000


@dataclass(frozen=True)
class Part:
    """Part `number` of `of`, counted from 1: every `of`-th point, or line of a followed axis."""

    number: int
    of: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the part of a text such as `2/16`; raises ValueError."""
        found = _PART.fullmatch(text.strip())
        part = cls(int(found[1]), int(found[2])) if found else None
        if part is None or not 1 <= part.number <= part.of <= _MOST_PARTS:
            raise ValueError(f"{text!r} is not a part; write, for example, 1/16 to 16/16")
        return part

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    @property
    def suffix(self) -> str:
        """The suffix that a file name gets for this part."""
        return f"part-{self.number}-of-{self.of}"

    def points(self, grid: Grid) -> NDArray[np.bool_]:
        """Return which points of a grid (grid.size,) belong to this part.

        The points of a followed line need each other, so they stay together.
        """
        if not grid.followed:
            return np.asarray(np.arange(grid.size) % self.of == self.number - 1)
        chosen = np.zeros(grid.size, dtype=bool)
        chosen[grid.lines()[self.number - 1 :: self.of]] = True
        return chosen


@dataclass(frozen=True)
class Target:
    """The target of a sweep: a config, what follows from it, and the part to compute, if any."""

    config: Config
    grid: Grid
    settings: Settings
    chunks: Chunks
    part: Part | None = None

    @classmethod
    def of(cls, config: Config, part: Part | None = None) -> Target:
        """Return the target of a config.

        Raises RefusalError for a part of a refined grid, PulledError for a block that is pulled.
        """
        refuse_pull(config.simulation.drive)
        if part is not None and config.refine is not None:
            raise RefusalError(
                "a refined grid cannot be split into parts: which points are computed depends on "
                "all the others; leave out --part or `refine`"
            )
        grid, settings = Grid.from_config(config), settings_of(config)
        return cls(config, grid, settings, Chunks(grid.shape), part)

    @property
    def points(self) -> int:
        """The number of points to compute; for a part it may be off by up to one point or line."""
        return self.grid.size // (self.part.of if self.part else 1)

    @cached_property
    def needed(self) -> NDArray[np.bool_]:
        """Flags (grid.size,) of the points to compute."""
        return self.part.points(self.grid) if self.part else np.broadcast_to(True, self.grid.size)

    @cached_property
    def sha256(self) -> str:
        """The hash of the config."""
        return self.config.sha256()

    @cached_property
    def keys(self) -> PointKeys:
        """The keys of the grid's points."""
        return PointKeys(self.grid, self.settings)


@dataclass(frozen=True)
class ExistingPoints:
    """Finished points, on the grid on which they were computed.

    `points` yields their numbers (n,) and result rows (n, columns), without interpolated points;
    `foreign` names the variables that a user added, `part` the part of the grid, if they are one,
    and `sample` how they were drawn, if they were.
    """

    name: str
    config: Config
    grid: Grid
    settings: Settings
    points: Callable[[], Points]
    foreign: tuple[str, ...] = ()
    processors: frozenset[str] = frozenset()
    part: str = ""
    history: str = ""
    sample: str = ""

    @property
    def is_fit(self) -> bool:
        """Whether the points are the fitted curve in the file of a fit."""
        return "fitted_value" in self.foreign

    def fits(self, target: Target) -> bool:
        """Return whether the target would compute the same rows."""
        return self.settings == target.settings

    def differences(self, target: Target) -> list[str]:
        """Return a line for each setting in which the points differ from the target."""
        return differences(self.settings, target.settings)

    def warnings(self, target: Target) -> list[str]:
        """Return warnings of new values almost equal to old ones, and of variables to be lost."""
        lines = []
        if near := near_duplicates(self.grid, target.grid):
            listed = "; ".join(near[:_NAMED]) + ("; ..." if len(near) > _NAMED else "")
            lines.append(
                f"values within a relative 1e-9 of those of {self.name} count as different "
                f"points: {listed}"
            )
        if self.foreign:
            lines.append(
                f"{self.name} has variables that stickslip did not write and that are not carried "
                f"over: {', '.join(self.foreign)}"
            )
        return lines

    def carried(self, target: Target) -> Points:
        """Yield the points that the target also has, with their numbers there."""
        keys = PointKeys(self.grid, self.settings)
        for indices, rows in self.points():
            numbers = target.keys.find(keys.of(indices))
            yield numbers[numbers >= 0], rows[numbers >= 0]

    def refuse_lost_points(self, target: Target) -> None:
        """Raise RefusalError if the grid of the target lacks finished points.

        On a followed line a point may have another key there; then it is computed again.
        """
        keys, lost, example = PointKeys(target.grid, self.settings, alone=True), 0, None
        for indices, _ in self.points():
            rows = self.grid.rows(indices)
            gone = np.flatnonzero(keys.numbers_of(rows) < 0)
            lost += len(gone)
            if len(gone) and example is None:
                example = dict(zip(Parameters._fields, rows[gone[0]].tolist(), strict=True))
        if example is not None:
            varied = [name for name in self.grid.coords if name in example]
            such = ", ".join(f"{name} = {example[name]:g}" for name in varied)
            raise RefusalError(
                f"{self.name} has {counted(lost, 'finished point')} that the config no longer has"
                f"{f', such as {such}' if such else ''}. They would be lost: --overwrite starts "
                "afresh and drops them, -o writes elsewhere"
            )

    def refuse_differences(self, target: Target) -> None:
        """Raise RefusalError if the target has other settings."""
        if not self.fits(target):
            changed = "\n  ".join(self.differences(target))
            raise RefusalError(
                f"{self.name} was computed with different settings:\n  {changed}\n{WAYS_OUT}"
            )


def found_in_file(path: Path) -> ExistingPoints:
    """Return the finished points of a result file.

    Raises RefusalError if the file is not the result of a sweep, was computed by another numerics
    version or has no seal; StorageError if it cannot be read or its numbers do not match its seal.
    """
    require_readable(path)
    try:
        with open_file(path) as file:
            attributes = {name: str(file.getncattr(name)) for name in file.ncattrs()}
            _refuse_other_file(path, file.variables, attributes)
            config = _config_of(lambda: _described(file), path)
            key = seal_key(attributes["config"], coordinates_in(file))
            known = (*RESULT_COLUMNS, *PARAMETERS, CASE, DIRECTION)
            foreign = tuple(name for name in file.variables if name not in known)
    except DAMAGE as error:
        raise StorageError(
            f"{path} exists, but is not a readable NetCDF file ({error}); {WAYS_OUT}"
        ) from error
    grid, seal = Grid.from_config(config), attributes["data_sha256"]
    chunks = Chunks(grid.shape)
    try:
        sound = data_sha256(key, digests_of(path, chunks)) == seal
    except DAMAGE:  # a checksum within the file does not match
        sound = False
    if not sound:
        raise _damaged(path)
    return ExistingPoints(
        name=str(path),
        config=config,
        grid=grid,
        settings=settings_of(config),
        points=lambda: _points_of_file(path, chunks, seal, key),
        foreign=foreign,
        processors=frozenset(filter(None, attributes.get("processor", "").split(", "))),
        history=attributes.get("history", ""),
        sample=attributes.get("sample", ""),
        part=attributes.get("part", ""),
    )


def found_in_journal(path: Path, manifest: dict[str, Any]) -> ExistingPoints:
    """Return the finished points of the journal of an unfinished sweep.

    Raises RefusalError if its config cannot be read, StorageError if the journal cannot.
    """
    config = _config_of(lambda: manifest["config"], path)
    grid = Grid.from_config(config)
    settings, chunks = settings_of(config), Chunks(grid.shape)

    def points() -> Points:
        keys = PointKeys(grid, settings)
        with closing(Journal.open(path, manifest, keys, chunks, readonly=True)) as journal:
            for number in range(len(chunks)):
                rows = journal.chunk(number)
                finished = np.flatnonzero(~np.isnan(rows[:, STATUS]))
                yield chunks.range(number)[0] + finished, rows[finished]

    return ExistingPoints(
        name=f"the journal in {path.parent}",
        config=config,
        grid=grid,
        settings=settings,
        points=points,
        processors=frozenset(manifest["processors"]),
        history=manifest["history"],
    )


def found_in_input(path: Path) -> ExistingPoints:
    """Return the points of a file that is only read; errors do not offer options for an output."""
    try:
        return found_in_file(path)
    except (RefusalError, StorageError) as error:
        raise type(error)(str(error).removesuffix(WAYS_OUT).rstrip("; \n")) from error


def seal_note(path: Path) -> str:
    """Return a sentence if a sweep's result does not match its seal, else an empty text."""
    try:
        found_in_file(path)
    except StorageError:
        return f"{path} {_NOT_AS_WRITTEN} or merged"
    except RefusalError:
        return ""
    return ""


def _refuse_other_file(
    path: Path, variables: Container[str], attributes: Mapping[str, str]
) -> None:
    """Raise RefusalError if a sweep of this version cannot use the points of a file."""
    if "config" not in attributes or "status" not in variables:
        raise RefusalError(f"{path} exists but is not the result of a sweep; {WAYS_OUT}")
    version = attributes.get("numerics_version", "none")
    if version != str(NUMERICS_VERSION):
        raise RefusalError(
            f"{path} was computed by numerics version {version}; this is {NUMERICS_VERSION}, which "
            f"gives different numbers; {WAYS_OUT}"
        )
    if missing := [name for name in RESULT_COLUMNS if name not in variables]:
        raise RefusalError(
            f"{path} lacks {', '.join(missing)}, which this version computes for every point; it "
            f"can still be drawn and replayed; {WAYS_OUT}"
        )
    if "data_sha256" not in attributes:
        raise RefusalError(
            f"{path} carries no seal (the attribute data_sha256), so there is no telling whether "
            f"its numbers have been changed; {WAYS_OUT}"
        )


def _damaged(path: Path) -> StorageError:
    return StorageError(f"{path} {_NOT_AS_WRITTEN}; {WAYS_OUT}")


def _described(file: netCDF4.Dataset) -> dict[str, Any]:
    """Return the config of a result file, with the axes taken from its coordinates."""
    written = dict(config_without_axes(file.config, "config"))
    axes_of_file = [dim for dim in file["status"].dimensions if dim in PARAMETERS]
    parameters = [name for name in file.variables if name in PARAMETERS]
    tied = [name for name in parameters if file[name].dimensions == (CASE,)]
    return written | {
        "sweep": {name: file[name][:].tolist() for name in axes_of_file},
        "cases": {name: file[name][:].tolist() for name in tied},
    }


def _config_of(described: Callable[[], dict[str, Any]], path: Path) -> Config:
    """Return the config of an existing result; raises RefusalError."""
    try:
        return from_mapping(described(), source=f"{path} (its config)")
    except ConfigError as error:
        raise RefusalError(
            f"{path} carries a config that this version cannot read:\n{error}\n{WAYS_OUT}"
        ) from error


def _points_of_file(path: Path, chunks: Chunks, seal: str, key: bytes) -> Points:
    """Yield the points of a file; raises StorageError at the end if they do not match the seal.

    The file was sound when it was first read, but it may have changed since.
    """
    try:
        with open_file(path) as file:
            whole_chunks(file)
            digests = Digests(columns_in(file).values())
            for number in range(len(chunks)):
                rows = read_rows(file, chunks, number, digests)
                status = rows[:, STATUS]
                finished = np.flatnonzero(~np.isnan(status) & (status != Status.INTERPOLATED))
                yield chunks.range(number)[0] + finished, rows[finished]
    except DAMAGE as error:
        raise _damaged(path) from error
    if data_sha256(key, digests.hexadecimal()) != seal:
        raise _damaged(path)
