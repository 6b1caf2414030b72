"""`simulation.drive`: a motion of the upper block that is not periodic."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from stickslip.course import COLUMNS, PullError, course_of
from sweeps.config.group import Group
from sweeps.config.numbers import Finite, Text, finite
from sweeps.config.written_config import Document
from sweeps.exits import ExpectedError
from sweeps.input_files import DataError, number_in, table_of
from sweeps.paths import expanded

# The config in a result file contains the nodes.
_MOST_NODES = 20_000


class Drive(Group):
    """A motion of the upper block: a constant velocity, or a velocity linear between nodes.

    The velocity is constant before the first node and after the last. Two nodes at the same time
    make it jump.
    """

    example: ClassVar[str] = "{velocity: 2e-6} or {table: FILE.csv}"

    velocity: float | None = Field(None, description="a constant velocity in m/s")
    table: Text | None = Field(
        None,
        description="a CSV file with the columns `elapsed_time` [s] and `velocity` [m/s] and at "
        f"most {_MOST_NODES} rows; a relative path starts in the folder of the config, and `~` and "
        "`$NAME` are allowed as in `output`",
    )
    nodes: Annotated[tuple[tuple[Finite, Finite], ...], Field(max_length=_MOST_NODES)] | None = (
        Field(None, description="the rows [s, m/s] of a table")
    )

    @model_validator(mode="after")
    def _is_one_motion(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            known = ", ".join(type(self).model_fields)
            raise ValueError(f"needs exactly one of {known}, such as {self.example}")
        if self.table is None:
            course_of(self.pull)
        return self

    @property
    def pull(self) -> Any:
        """The argument `drive` of `stickslip.simulate`."""
        if self.velocity is not None:
            return self.velocity
        nodes = np.array(self.nodes or (), dtype=float).reshape(-1, 2)
        return dict(zip(COLUMNS, nodes.T, strict=True))


class PulledError(ExpectedError, ValueError):
    """A sweep of a config whose upper block is pulled."""


def refuse_pull(drive: Drive | None) -> None:
    """Raise PulledError if the drive is not periodic."""
    if drive is not None:
        raise PulledError(
            "simulation.drive: a sweep computes orbits under the periodic drive, and a pull has no "
            "orbits; use `stickslip simulate`, or leave the drive out"
        )


def read_table(document: Document, folder: Path) -> None:
    """Replace the name of a table in a document by its rows; refuse a table with mistakes."""
    drive = document.section("simulation").get("drive")
    if not isinstance(drive, dict) or not isinstance(drive.get("table"), str):
        return
    if drive.get("nodes") is not None:  # `Drive` refuses a drive that has both
        return
    try:
        drive["nodes"] = _nodes(drive.pop("table"), folder)
    except DataError as error:
        for mistake in str(error).splitlines():
            document.refuse(mistake, "simulation", "drive", "table")
        del document.section("simulation")["drive"]


def _nodes(name: str, folder: Path) -> list[list[float]]:
    """Return the rows of a table, a time and a velocity each; raises DataError."""
    try:
        file = folder / expanded(name)
    except ValueError as error:
        raise DataError(f"{name} {error}") from None
    table = table_of(file)
    for name in COLUMNS:
        if (count := table.header.count(name)) != 1:
            needed = f"needs exactly one column each of {' and '.join(COLUMNS)}"
            table.refuse(f"{needed}; {name} is {'given twice' if count else 'missing'}", table.head)
    if len(table.cells) > _MOST_NODES:
        table.refuse(
            f"has {len(table.cells)} rows, more than {_MOST_NODES}; the velocity is linear between "
            "rows, so fewer may do"
        )
    table.raise_problems()
    places = {name: table.header.index(name) for name in COLUMNS}
    columns = table.columns(places, lambda cell, _: finite(number_in(cell)))
    try:
        course_of(columns)
    except PullError as error:
        table.refuse(error.what, None if error.row is None else table.lines[error.row])
    table.raise_problems()
    nodes: list[list[float]] = np.column_stack([*columns.values()]).tolist()
    return nodes
