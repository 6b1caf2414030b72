"""Existing results: the points of a result file and of a journal, and whether they count."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import PARAMETERS
from sweeps.config.load import Config, ConfigError, from_mapping
from sweeps.config.parameter_space import PARAMETER_SECTIONS
from sweeps.config.yaml_reader import read_mapping
from sweeps.engine.order.follow import lines_of, unchanged
from sweeps.engine.order.part import Part
from sweeps.exits import ExpectedError
from sweeps.files.atomic import StorageError
from sweeps.files.attributes import data_sha256
from sweeps.files.chunks import Chunks
from sweeps.files.columns import STATUS, Rows, conformed, lacking
from sweeps.files.datasets import DAMAGE
from sweeps.files.journal import Journal, columns_of, readable_manifest
from sweeps.files.results import Digests, columns_in, digests_of, read_rows, whole_chunks
from sweeps.files.run_folder import RunFolder
from sweeps.files.versions import is_newer, unknown_keys, unknown_variables
from sweeps.files.watch import require_readable
from sweeps.grid import CASE, Grid
from sweeps.identity import Settings, differences, key_of, near_duplicates, seal_key, settings_of

Points = Iterator[tuple[NDArray[np.int64], Rows]]

# Which points (n,), by their numbers (n,) and rows (n, columns), are not to be kept.
Drop = Callable[[NDArray[np.int64], Rows], NDArray[np.bool_]]

_NAMED = 5  # differences that a message lists

WAYS_OUT = "--overwrite replaces it, -o writes elsewhere"
"""What ends a complaint about an output."""


class RefusalError(ExpectedError):
    """Existing results do not fit what is asked for; the message says which option decides."""


@dataclass(frozen=True)
class Target:
    """What a sweep is to compute: the config, what follows from it, and perhaps a part of it."""

    config: Config
    grid: Grid
    settings: Settings
    key: bytes
    chunks: Chunks
    part: Part | None = None

    @classmethod
    def of(cls, config: Config, part: Part | None = None) -> Target:
        """What this config asks for; raises RefusalError for parts of a refined grid."""
        if part is not None and config.refine is not None:
            raise RefusalError(
                "a refined grid has no parts: which points are computed depends on all of the "
                "others; leave out --part, or `refine`"
            )
        grid, settings = Grid.from_config(config), settings_of(config)
        return cls(config, grid, settings, key_of(settings, grid), Chunks(grid.shape), part)

    @cached_property
    def needed(self) -> NDArray[np.bool_]:
        """Which points (grid.size,) are asked for."""
        return self.part.points(self.grid) if self.part else np.ones(self.grid.size, dtype=bool)

    def failed(self, indices: NDArray[np.int64], rows: Rows) -> NDArray[np.bool_]:
        """Which points (n,) with rows (n, columns) are asked for and did not end ok."""
        ok = np.isin(rows[:, STATUS], [status for status in Status if status.is_result])
        return np.asarray(~ok & self.needed[indices])


@dataclass(frozen=True)
class ExistingPoints:
    """Finished points, in the grid that they were computed in.

    `points` gives their numbers (n,) and result rows (n, columns) with the columns of today, those
    that were interpolated left out; `lacking` names those that an older version did not compute,
    `foreign` what a user added, `part` the part of the grid that they are, if they are one.
    """

    name: str
    config: Config
    grid: Grid
    settings: Settings
    points: Callable[[], Points]
    lacking: tuple[str, ...] = ()
    foreign: tuple[str, ...] = ()
    mixed: tuple[str, ...] = ()
    processors: frozenset[str] = frozenset()
    part: str = ""
    history: str = ""

    def fits(self, target: Target) -> bool:
        """Whether the points are what the target would compute again."""
        return self.settings == target.settings and not self.lacking

    def differences(self, target: Target) -> list[str]:
        """One line for each thing in which the points differ from what is asked for."""
        lacks = [f"variables: lacks {', '.join(self.lacking)}"] if self.lacking else []
        return differences(self.settings, target.settings) + lacks

    def warnings(self, target: Target) -> list[str]:
        """One line where values of the new grid nearly are old ones, and one for what is lost."""
        told = []
        if near := near_duplicates(self.grid, target.grid):
            listed = "; ".join(near[:_NAMED]) + ("; ..." if len(near) > _NAMED else "")
            told.append(
                f"values that differ by less than 1e-9 from those of {self.name} are other "
                f"points: {listed}"
            )
        if self.foreign:
            told.append(
                f"{self.name} has variables that stickslip did not write and that are not carried "
                f"over: {', '.join(self.foreign)}"
            )
        return told

    def carried(self, grid: Grid, drop: Drop | None = None) -> Points:
        """The points that a grid has too, by their numbers there, but those to be dropped."""
        usable = self._usable(grid, drop)
        for indices, rows in self.points():
            numbers = self.grid.counterparts(indices, grid)
            kept = numbers >= 0
            if usable is not None:
                kept &= usable[indices]
            if drop is not None:
                kept &= ~drop(numbers, rows)
            yield numbers[kept], rows[kept]

    def _usable(self, grid: Grid, drop: Drop | None) -> NDArray[np.bool_] | None:
        """Which points of followed lines (n,) a grid would follow in the same way; None: all.

        What follows a point that is dropped is computed anew with it.
        """
        if not (self.grid.followed and self.grid.followed == grid.followed):
            return None
        usable = unchanged(self.grid, grid)
        if drop is not None:
            for indices, rows in self.points():
                gone = drop(self.grid.counterparts(indices, grid), rows)
                usable &= ~lines_of(self.grid, indices[gone])
        return usable

    def refuse_other_parts(self, target: Target) -> None:
        """Raise RefusalError where finished points belong to other parts than the target's."""
        numbers = (found for found, _ in self.carried(target.grid))
        lost = sum(int(np.count_nonzero(~target.needed[found])) for found in numbers)
        if lost:
            raise RefusalError(
                f"{self.name} has {lost} finished points that do not belong to part {target.part} "
                "and would be lost: leave out --part to compute all of them anew, -o writes "
                "elsewhere, --overwrite drops them"
            )

    def refuse_lost_points(self, grid: Grid) -> None:
        """Raise RefusalError where finished points have no place in a grid."""
        lost, example = 0, None
        for indices, _ in self.points():
            rows = self.grid.rows(indices)
            gone = np.flatnonzero(grid.locate(rows) < 0)
            lost += len(gone)
            if len(gone) and example is None:
                example = dict(zip(Parameters._fields, rows[gone[0]].tolist(), strict=True))
        if example is not None:
            varied = [name for name in self.grid.coords if name in example]
            such = ", ".join(f"{name} = {example[name]:g}" for name in varied)
            raise RefusalError(
                f"{self.name} has {lost} finished points that the config no longer names"
                f"{f', such as {such}' if such else ''}. They would be lost: --overwrite starts "
                "afresh and drops them, -o writes elsewhere"
            )

    def refuse_differences(self, target: Target) -> None:
        """Raise RefusalError where the points are not what the target would compute again."""
        if self.settings != target.settings:
            told = self.differences(target)
            was, now = (s["numerics_version"] for s in (self.settings, target.settings))
            if len(told) == 1 and was != now:
                how = f"by numerics version {was}, this is {now}"
            else:
                how = "\n  ".join(["with other settings:", *told])
            raise RefusalError(
                f"{self.name} was computed {how}\n"
                "--recompute computes all points anew, --accept-mixed keeps the old ones and "
                "computes only the missing, -o writes elsewhere"
            )
        if self.lacking:
            count = sum(len(indices) for indices, _ in self.points())
            raise RefusalError(
                f"{self.name} was written by an older version and lacks the variables "
                f"{', '.join(self.lacking)}: its {count} points would have to be computed again. "
                "--recompute does so, --accept-mixed keeps them (the new variables stay missing "
                "in them), -o writes elsewhere"
            )


def found_in_file(path: Path, *, unsealed: bool = False) -> ExistingPoints:
    """The finished points of a result file; `unsealed` accepts one that carries no seal.

    Raises RefusalError where the file is no result of a sweep, that of a newer version, or without
    a seal, StorageError where it cannot be read or its numbers are not those of its seal.
    """
    require_readable(path)
    try:
        with netCDF4.Dataset(path) as file:
            attributes = {name: str(file.getncattr(name)) for name in file.ncattrs()}
            _refuse_other_file(file, path, attributes)
            lacks, foreign = lacking(file.variables), unknown_variables(file.variables)
            config = _config_of(lambda: _described(file), path)
    except DAMAGE as error:
        raise StorageError(
            f"{path} exists, but is not a readable NetCDF file ({error}); {WAYS_OUT}"
        ) from error
    grid = Grid.from_config(config)
    settings = settings_of(config, attributes.get("numerics_version", "0"))
    key, chunks = seal_key(settings, grid), Chunks(grid.shape)
    seal = attributes.get("data_sha256")
    if seal is None and not unsealed:
        raise RefusalError(
            f"{path} carries no seal, so nothing tells whether its numbers are those that were "
            f"computed; --accept-unsealed takes them as they are, {WAYS_OUT}"
        )
    _check_seal(path, seal, key, chunks)
    return ExistingPoints(
        name=str(path),
        config=config,
        grid=grid,
        settings=settings,
        points=lambda: _points_of_file(path, chunks, seal, key),
        lacking=lacks,
        foreign=tuple(foreign),
        mixed=tuple(filter(None, attributes.get("mixed_with", "").split("\n"))),
        processors=frozenset(filter(None, attributes.get("processor", "").split(", "))),
        history=attributes.get("history", ""),
        part=attributes.get("part", ""),
    )


def found_in_journal(path: Path, manifest: dict[str, Any]) -> ExistingPoints:
    """The finished points of the journal of an unfinished sweep.

    Raises RefusalError where a newer version wrote it, StorageError where it cannot be read.
    """
    columns = columns_of(manifest)
    _refuse_newer(path, unknown_variables(columns))
    config = _config_of(lambda: manifest["config"], path)
    grid = Grid.from_config(config)

    def points() -> Points:
        journal = Journal.open(path, manifest, Chunks(grid.shape), grid.size, readonly=True)
        with closing(journal):
            for indices, rows in journal.records():
                conforming = conformed(rows, columns)
                computed = conforming[:, STATUS] != Status.INTERPOLATED
                yield indices[computed], conforming[computed]

    return ExistingPoints(
        name=f"the journal in {path.parent}",
        config=config,
        grid=grid,
        settings=settings_of(config, manifest["numerics_version"]),
        points=points,
        lacking=lacking(columns),
        mixed=tuple(manifest["mixed"]),
        processors=frozenset(manifest["processors"]),
        history=manifest["history"],
    )


def found_beside(folder: RunFolder, *, unsealed: bool = False) -> list[ExistingPoints]:
    """All finished points for an output; raises RefusalError and StorageError."""
    manifest = readable_manifest(folder.journal)
    found = [found_in_journal(folder.journal, manifest)] if manifest else []
    if folder.output.exists() and not (manifest and manifest["afresh"]):
        found.append(found_in_file(folder.output, unsealed=unsealed))
    return found


def seal_note(path: Path) -> str:
    """A sentence where a sweep's result does not hold what its seal says; empty for all else."""
    try:
        found_in_file(path, unsealed=True)
    except StorageError:
        return (
            f"the numbers of {path} are not those that stickslip wrote: the file is damaged, or "
            "was edited afterwards"
        )
    except RefusalError:
        return ""
    return ""


def _refuse_other_file(file: netCDF4.Dataset, path: Path, attributes: dict[str, str]) -> None:
    """Raise RefusalError where a file is no result of a sweep, or that of a newer version."""
    if "config" not in file.ncattrs() or "status" not in file.variables:
        raise RefusalError(f"{path} exists and is not a result of a sweep; {WAYS_OUT}")
    if is_newer(attributes):
        _refuse_newer(path, unknown_variables(file.variables))


def _refuse_newer(path: Path, unknown: list[str]) -> None:
    if unknown:
        raise RefusalError(
            f"{path} was written by a newer version of stickslip: this one does not know "
            f"{', '.join(unknown)}. Update stickslip to use its points; {WAYS_OUT}"
        )


def _check_seal(path: Path, seal: str | None, key: bytes, chunks: Chunks) -> None:
    """Raise StorageError where the numbers of a file are not those that were written."""
    try:
        sound = seal is None or data_sha256(key, digests_of(path, chunks)) == seal
    except DAMAGE:  # found by a checksum within the file
        sound = False
    if not sound:
        raise _damaged(path)


def _damaged(path: Path) -> StorageError:
    return StorageError(
        f"{path} is damaged, or was changed after stickslip wrote it, and cannot be resumed; "
        f"{WAYS_OUT}"
    )


def _described(file: netCDF4.Dataset) -> dict[str, Any]:
    """The config of a result file, its axes taken from the coordinates.

    They are many numbers where the YAML parser would take long, and what the file really holds.
    """
    axes = re.compile(r"^(sweep|cases):.*\n(  .*\n)*", re.MULTILINE)
    written = read_mapping(axes.sub("", file.config), "config")
    axes_of_file = [dim for dim in file["status"].dimensions if dim in PARAMETERS]
    parameters = [name for name in file.variables if name in PARAMETERS]
    tied = [name for name in parameters if file[name].dimensions == (CASE,)]
    return written | {
        "sweep": {name: file[name][:].tolist() for name in axes_of_file},
        "cases": {name: file[name][:].tolist() for name in tied},
    }


def _config_of(described: Callable[[], dict[str, Any]], path: Path) -> Config:
    """The config of an existing result, of this version or an older one; raises RefusalError."""
    try:
        written = described()
        _refuse_newer(path, unknown_keys(written))
        _refuse_unknown_values(path, written)
        return from_mapping(written, source=f"{path} (its config)", older=True)
    except ConfigError as error:
        raise RefusalError(
            f"{path} carries a config that this version cannot read:\n{error}\n"
            "--overwrite starts afresh, -o writes elsewhere"
        ) from error


def _refuse_unknown_values(path: Path, written: dict[str, Any]) -> None:
    """Raise RefusalError where a file says nothing of a parameter that has no neutral value."""
    given = {name for part in PARAMETER_SECTIONS for name in written.get(part) or {}}
    added = PARAMETERS.keys() - given
    if unknown := sorted(name for name in added if PARAMETERS[name].neutral is None):
        raise RefusalError(
            f"{path} was written by an older version and lacks the parameters "
            f"{', '.join(unknown)}, whose values for its points are not known; {WAYS_OUT}"
        )


def _points_of_file(path: Path, chunks: Chunks, seal: str | None, key: bytes) -> Points:
    """The points of a file; raises StorageError at the end where they are not those of the seal.

    The file was sound when it was opened, but much time may have passed.
    """
    try:
        with netCDF4.Dataset(path) as file:
            whole_chunks(file)
            digests = Digests(columns_in(file))
            for number in range(len(chunks)):
                rows = read_rows(file, chunks, number, digests)
                status = rows[:, STATUS]
                there = np.flatnonzero(~np.isnan(status) & (status != Status.INTERPOLATED))
                yield chunks.range(number)[0] + there, rows[there]
    except DAMAGE as error:
        raise _damaged(path) from error
    if seal is not None and data_sha256(key, digests.hexadecimal()) != seal:
        raise _damaged(path)
