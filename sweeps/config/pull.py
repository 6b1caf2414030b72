"""`simulation.drive`: a motion of the upper block other than the periodic one."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from stickslip.course import COLUMNS, PullError, course_of
from sweeps.config.diagnostics import Document
from sweeps.config.group import Group
from sweeps.config.numbers import Text, finite
from sweeps.exits import ExpectedError
from sweeps.human import counted, reason
from sweeps.paths import expanded

# A file of a result holds the nodes in its config.
_MOST_NODES = 20_000

Number = Annotated[float, BeforeValidator(finite)]


class Drive(Group):
    """A motion of the upper block: a constant velocity, or one that is linear between nodes.

    The velocity is held before the first node and after the last one.
    """

    example: ClassVar[str] = "{velocity: 2e-6} or {table: FILE.csv}"

    velocity: Number | None = Field(None, description="a constant velocity in m/s")
    table: Text | None = Field(
        None,
        description="a CSV file with the columns `elapsed_time` [s] and `velocity` [m/s]; from "
        "the folder of the config, or with `~` and `$NAME` as in `output`",
    )
    nodes: Annotated[tuple[tuple[Number, Number], ...], Field(max_length=_MOST_NODES)] | None = (
        Field(None, description="the rows [s, m/s] of such a table")
    )

    @model_validator(mode="after")
    def _is_one_motion(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"must be one of {', '.join(type(self).model_fields)}: {self.example}")
        if self.table is None:
            course_of(self.pull)
        return self

    @property
    def pull(self) -> Any:
        """The same for `stickslip.simulate`."""
        if self.velocity is not None:
            return self.velocity
        nodes = np.array(self.nodes or (), dtype=float).reshape(-1, 2)
        return dict(zip(COLUMNS, nodes.T, strict=True))


class PulledError(ExpectedError, ValueError):
    """A sweep was asked of a config whose upper block is pulled."""


def refuse_pull(drive: Drive | None) -> None:
    """Raise PulledError where there is another drive than the periodic one."""
    if drive is not None:
        raise PulledError(
            "simulation.drive: a sweep computes orbits under the periodic drive, and a pull has "
            "none; use `stickslip simulate`, or leave the drive out"
        )


def read_table(document: Document, folder: Path) -> None:
    """Put the rows of a table in the place of its name in a document; refuse what is wrong."""
    drive = document.section("simulation").get("drive")
    if not isinstance(drive, dict) or not isinstance(drive.get("table"), str):
        return
    try:
        file = _file(folder, drive.pop("table"))
        rows = list(_rows(file))
        _judge(file, rows)
    except PullError as error:
        document.refuse(str(error), "simulation", "drive", "table")
        del document.section("simulation")["drive"]
    else:
        drive["nodes"] = [[time, velocity] for _, time, velocity in rows]


def _file(folder: Path, name: str) -> Path:
    try:
        return folder / expanded(name)
    except ValueError as error:
        raise PullError(f"{name} {error}") from None


def _rows(file: Path) -> Iterator[tuple[int, float, float]]:
    """Yield the line and the two numbers of each row; raises PullError."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise PullError(f"{file} cannot be read: {reason(error)}") from None
    except UnicodeDecodeError:
        raise PullError(f"{file} is not UTF-8 text; save it in the encoding UTF-8") from None
    reader = csv.reader(text.splitlines(), skipinitialspace=True)
    header = [name.strip() for name in next(reader, [])]
    if missing := [name for name in COLUMNS if name not in header]:
        wanted = " and ".join(COLUMNS)
        hint = "; cells are separated by commas" if len(header) < len(COLUMNS) else ""
        raise PullError(
            f"{file}:1: needs the columns {wanted}; {' and '.join(missing)} missing{hint}"
        )
    places = [header.index(name) for name in COLUMNS]
    for row in reader:
        if any(cell.strip() for cell in row):
            place = f"{file}:{reader.line_num}"
            time, velocity = (_number(place, header, row, column) for column in places)
            yield reader.line_num, time, velocity


def _number(place: str, header: list[str], row: list[str], column: int) -> float:
    if len(row) != len(header):
        raise PullError(
            f"{place}: {counted(len(row), 'cell')} below {counted(len(header), 'name')}"
        )
    text = row[column].strip()
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise PullError(f"{place}: {header[column]} must be a finite number, not {text!r}")
    return value


def _judge(file: Path, rows: list[tuple[int, float, float]]) -> None:
    if len(rows) > _MOST_NODES:
        raise PullError(f"{file} has {len(rows)} rows, more than {_MOST_NODES}; take fewer")
    lines, times, velocities = np.array(rows, dtype=float).reshape(-1, 3).T
    try:
        course_of(dict(zip(COLUMNS, (times, velocities), strict=True)))
    except PullError as error:
        line = "" if error.row is None else f":{int(lines[error.row])}"
        raise PullError(f"{file}{line}: {error.what}") from None
