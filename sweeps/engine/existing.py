"""What is there already: the points of a result file and of a journal, and whether they count."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS
from sweeps.config.diagnostics import Findings, Problem
from sweeps.config.load import Config, ConfigError, from_mapping
from sweeps.config.yaml_reader import read_text
from sweeps.files.chunks import Slabs
from sweeps.files.datasets import StorageError
from sweeps.files.journal import Journal, read_manifest
from sweeps.files.results import read_rows, seal_of, whole_chunks
from sweeps.grid import CASE, Grid
from sweeps.identity import Settings, differences, key_of, near_duplicates, seal_key, settings_of

Points = Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]

# What reading a damaged file has raised.
_DAMAGE = (OSError, RuntimeError, AttributeError, LookupError, TypeError, ValueError)

_NAMED = 5  # differences that a message lists


class RefusalError(Exception):
    """What is there does not fit what is asked for; the message says which option decides."""


@dataclass(frozen=True)
class Wanted:
    """What a sweep is to compute: the config and what follows from it."""

    config: Config
    grid: Grid
    settings: Settings
    key: bytes
    slabs: Slabs

    @classmethod
    def by(cls, config: Config) -> Wanted:
        """What this config asks for."""
        grid, settings = Grid.from_config(config), settings_of(config)
        return cls(config, grid, settings, key_of(settings, grid), Slabs(grid.shape))


@dataclass(frozen=True)
class Found:
    """Finished points that are there already, in the grid that they were computed in."""

    name: str
    config: Config
    grid: Grid
    settings: Settings
    points: Callable[[], Points]
    mixed: tuple[str, ...] = ()
    processors: frozenset[str] = frozenset()
    history: str = ""

    def carried(self, grid: Grid, keep: Callable[[NDArray[np.float64]], Any] | None) -> Points:
        """The points that a grid has too, by their numbers there."""
        for indices, rows in self.points():
            numbers = grid.locate(self.grid.rows(indices))
            kept = numbers >= 0
            if keep is not None:
                kept &= keep(rows)
            yield numbers[kept], rows[kept]

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

    def refuse_other_settings(self, settings: Settings) -> None:
        """Raise RefusalError where the points were computed with other settings."""
        lines = differences(self.settings, settings)
        if lines:
            listed = "\n".join(f"  {line}" for line in lines)
            raise RefusalError(
                f"{self.name} was computed with other settings:\n{listed}\n"
                "--recompute computes all points anew, --accept-mixed keeps the old ones and "
                "computes only the missing, -o writes elsewhere"
            )


@dataclass
class Stock:
    """The journal to go on with, where its points come from, and what looks odd about them."""

    journal: Journal
    found: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def found_in_file(path: Path) -> Found:
    """The finished points of a result file.

    Raises RefusalError where the file is no result of a sweep, StorageError where it cannot be
    read.
    """
    try:
        with netCDF4.Dataset(path) as file:
            attributes = {name: str(file.getncattr(name)) for name in file.ncattrs()}
            known = set(RESULT_COLUMNS) <= set(file.variables) and "config" in attributes
            config = _config_of(lambda: _described(file), path) if known else None
    except _DAMAGE as error:
        raise StorageError(
            f"{path} exists, but is not a readable NetCDF file ({error}); "
            "--overwrite replaces it, -o writes elsewhere"
        ) from error
    if config is None:
        raise RefusalError(
            f"{path} exists and is no result of a sweep; --overwrite replaces it, "
            "-o writes elsewhere"
        )
    grid = Grid.from_config(config)
    settings = settings_of(config, attributes.get("numerics_version", "0"))
    key, slabs = seal_key(settings, grid), Slabs(grid.shape)
    _check_seal(path, attributes.get("data_sha256"), key, slabs)
    return Found(
        name=str(path),
        config=config,
        grid=grid,
        settings=settings,
        points=lambda: _points_of_file(path, grid),
        mixed=tuple(filter(None, attributes.get("mixed_with", "").split("\n"))),
        processors=_listed(attributes.get("processor", "")),
        history=attributes.get("history", ""),
    )


def found_in_journal(path: Path, manifest: dict[str, Any]) -> Found:
    """The finished points of the journal of an unfinished sweep; raises StorageError."""
    config = _config_of(lambda: manifest["config"], path)
    grid = Grid.from_config(config)
    key, slabs = bytes.fromhex(manifest["key"]), Slabs(grid.shape)

    def points() -> Points:
        journal = Journal.open(path, key, slabs, grid.size, readonly=True)
        try:
            yield from journal.records()
        finally:
            journal.close()

    return Found(
        name=f"the journal in {path.parent}",
        config=config,
        grid=grid,
        settings=settings_of(config, manifest["numerics_version"]),
        points=points,
        mixed=tuple(manifest["mixed"]),
        processors=frozenset(manifest["processors"]),
        history=manifest["history"],
    )


def found_beside(output: Path, journal: Path) -> list[Found]:
    """All finished points that are there for an output; raises RefusalError and StorageError."""
    manifest = readable_manifest(journal)
    found = [found_in_journal(journal, manifest)] if manifest else []
    if output.exists() and not (manifest and manifest["afresh"]):
        found.append(found_in_file(output))
    return found


def readable_manifest(path: Path) -> dict[str, Any] | None:
    """The manifest of a journal, None where there is no journal.

    Raises StorageError where it cannot be read.
    """
    try:
        manifest = read_manifest(path)
    except FileNotFoundError:
        return None
    if manifest is None:
        raise StorageError(
            f"the beginning of {path} is damaged, so that its points cannot be told; move the file "
            "away to keep it, or take --overwrite to start afresh"
        )
    return manifest


def warnings_of_near_duplicates(found: Found, wanted: Wanted) -> list[str]:
    """One line where values of the new grid nearly are values of the old one."""
    near = near_duplicates(found.grid, wanted.grid)
    if not near:
        return []
    listed = "; ".join(near[:_NAMED]) + ("; ..." if len(near) > _NAMED else "")
    return [
        f"values that differ by less than 1e-9 from those of {found.name} are other "
        f"points: {listed}"
    ]


def not_ok(rows: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which rows are finished, but failed."""
    return np.asarray(rows[:, -1] != Status.OK)


def _check_seal(path: Path, seal: str | None, key: bytes, slabs: Slabs) -> None:
    """Raise StorageError where the numbers of a file are not those that were written."""
    try:
        sound = seal is None or seal_of(path, key, slabs) == seal  # None: of an earlier version
    except _DAMAGE:  # found by a checksum within the file
        sound = False
    if not sound:
        raise StorageError(
            f"{path} is damaged, or was changed after stickslip wrote it, and cannot be gone on "
            "with; --overwrite replaces it, -o writes elsewhere"
        )


def _described(file: netCDF4.Dataset) -> dict[str, Any]:
    """The config of a result file, its axes taken from the coordinates.

    They are many numbers where the YAML parser would take long, and what the file really holds.
    """
    axes = re.compile(r"^(sweep|cases):.*\n(  .*\n)*", re.MULTILINE)
    findings = Findings()
    root = read_text(axes.sub("", file.config), "config", findings)
    findings.raise_problems()
    dims = file["status"].dimensions
    tied = [name for name in PARAMETERS if file[name].dimensions == (CASE,)]
    settings = root.plain() if root else None
    if not isinstance(settings, dict):
        raise ConfigError([Problem("config", None, "", "is no mapping")])
    return settings | {
        "sweep": {dim: file[dim][:].tolist() for dim in dims if dim != CASE},
        "cases": {name: file[name][:].tolist() for name in file.variables if name in tied},
    }


def _config_of(described: Callable[[], dict[str, Any]], path: Path) -> Config:
    try:
        return from_mapping(described(), source=f"{path} (its config)")
    except ConfigError as error:
        raise RefusalError(
            f"{path} carries a config that this version cannot read:\n{error}\n"
            "--overwrite starts afresh, -o writes elsewhere"
        ) from error


def _points_of_file(path: Path, grid: Grid) -> Points:
    slabs = Slabs(grid.shape)
    with netCDF4.Dataset(path) as file:
        whole_chunks(file)
        for number in range(len(slabs)):
            rows = read_rows(file, slabs, number)
            there = np.flatnonzero(~np.isnan(rows[:, -1]))
            yield slabs.range(number)[0] + there, rows[there]


def _listed(text: str) -> frozenset[str]:
    return frozenset(filter(None, text.split(", ")))
