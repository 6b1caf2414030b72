"""Text files that people write: how configs and tables are read, and the cells of a table."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from sweeps.exits import Exit, ExpectedError
from sweeps.human import counted, reason, shortened

Floats: TypeAlias = NDArray[np.float64]

_MIB = 1 << 20
_MOST_MIB = 4  # the largest table: a hundred thousand rows
_MOST_COLUMNS = 1000  # each unknown name is compared with all known names
_SHOWN = 20  # mistakes shown at once

_MISSING = re.compile(r"#?n[./]?[ad]\.?n?|[-\u2013\u2014.?*]+|none|null|missing", re.IGNORECASE)
_WITH_UNIT = re.compile(r"[-+]?(\.\d+|\d+(\.\d*)?)([eE][-+]?\d+)?\s*[^\d\s.,eE].*")


class NotTextError(ValueError):
    """A file that is not UTF-8 text; the first wrong byte is in `line`."""

    def __init__(self, line: int) -> None:
        super().__init__("is not UTF-8 text; save the file in UTF-8 encoding")
        self.line = line


class DataError(ExpectedError, ValueError):
    """A table with mistakes; the message has a line for each."""


class UnreadableError(DataError):
    """The file of a table cannot be read."""

    code = Exit.STORAGE


def text_of(path: Path, most: int, kind: str) -> str:
    """Return the text of a regular file of at most `most` MiB; `kind` names it in messages.

    A UTF-8 byte order mark, which some editors write, is left out. Raises NotTextError for another
    encoding, and OSError if the file cannot be read.
    """
    if path.exists() and not path.is_file():
        # A FIFO would wait for its writer forever, and a device may have no end.
        raise OSError(None, "it is not a regular file")
    try:
        with path.open("rb") as file:
            content = file.read(most * _MIB + 1)
    except ValueError:
        raise OSError(None, "its name contains a NUL character") from None
    if len(content) > most * _MIB:
        raise OSError(None, f"it is larger than {most} MiB, too large for a {kind}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise NotTextError(content.count(b"\n", 0, error.start) + 1) from None


@dataclass
class Cells:
    """The cells of a table, texts or numbers, the names of the columns, and the mistakes so far.

    `lines` are the line numbers of the rows in the file, and `head` is the line of the names. For a
    table in Python `source` is empty, `head` is None, and rows are counted from 0.
    """

    source: str
    header: list[str]
    cells: list[list[Any]]
    lines: list[int]
    head: int | None = None
    _problems: list[tuple[int, str]] = field(default_factory=list)

    def refuse(self, what: str, line: int | None = None, column: str = "") -> None:
        """Note a mistake in the table, in a line, or in a cell."""
        place = self.source or "table"
        if line is not None:
            place = f"{self.source}:{line}" if self.source else f"row {line}"
        where = f"{place}, column {shortened(column)}" if column else place
        self._problems.append((line or 0, f"{where}: {what}"))

    def raise_problems(self) -> None:
        """Raise DataError if there are mistakes."""
        if self._problems:
            texts = [text for _, text in sorted(self._problems, key=lambda problem: problem[0])]
            more = [f"... and {len(texts) - _SHOWN} more"] if len(texts) > _SHOWN else []
            raise DataError("\n".join([*texts[:_SHOWN], *more]))

    def columns(
        self, places: Mapping[str, int], number: Callable[[Any, str], float]
    ) -> dict[str, Floats]:
        """Return the numbers (rows,) of some columns, whose positions are given by name.

        `number` converts a cell of the column of this name, or raises ValueError. Raises DataError
        with all mistakes, including rows that lack cells.
        """
        columns = {name: np.full(len(self.cells), np.nan) for name in places}
        for row, (line, cells) in enumerate(zip(self.lines, self.cells, strict=True)):
            if len(cells) != len(self.header):
                unlike = f"{counted(len(cells), 'cell')} for {counted(len(self.header), 'column')}"
                few = len(cells) < len(self.header)
                remedy = "a missing value needs an empty cell" if few else "decimals have a point"
                self.refuse(f"{unlike}; {remedy}", line)
                continue
            for name, place in places.items():
                try:
                    columns[name][row] = number(cells[place], name)
                except ValueError as error:
                    self.refuse(str(error), line, self.header[place])
        self.raise_problems()
        return columns


def table_of(path: Path) -> Cells:
    """Return the table in a CSV file.

    Lines that begin with `#` are comments. If the first row holds numbers, the names are in the
    last comment above it, where `numpy.savetxt` writes them. Raises DataError.
    """
    rows = _rows(path)
    # `#N/A` is a missing value.
    body = [row for row in rows if not row[1][0].startswith("#") or _MISSING.fullmatch(row[1][0])]
    if body and _holds_numbers(body[0][1]):
        body.insert(0, _names_in_comment(path, rows, body[0]))
    if len(body) < 2:
        raise DataError(f"{path} holds no data; it needs a line of names, then the values")
    (head, header), *values = body
    if len(header) == 1 and re.search(r"[;\t]", header[0]):
        raise DataError(
            f"{path}:{head}: separate cells with commas, and write decimals with a point; "
            f"there is only one column, {shortened(header[0])!r}"
        )
    if len(header) > _MOST_COLUMNS:
        raise DataError(f"{path}:{head}: has {len(header)} columns, too many for a table")
    return Cells(str(path), header, [row for _, row in values], [line for line, _ in values], head)


def number_in(cell: Any, *, may_be_empty: bool = False) -> float:
    """Return the number in a cell, NaN if it is empty where that is allowed; raises ValueError."""
    if cell == "":
        if may_be_empty:
            return math.nan
        raise ValueError("is empty; each row needs a value here")
    try:
        value = float(cell.replace("\N{MINUS SIGN}", "-") if isinstance(cell, str) else cell)
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    if not math.isnan(value):
        return value
    text, hint = str(cell), ""
    if _MISSING.fullmatch(text):
        optional = "leave the cell empty where nothing was measured"
        hint = f"; {optional if may_be_empty else 'each row needs a value here'}"
    elif "," in text:
        hint = " (use a decimal point, and no thousands separators)"
    elif _WITH_UNIT.fullmatch(text):
        hint = "; write the number alone"
    raise ValueError(f"must be a number in SI units, not {shortened(text)!r}{hint}")


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Return the rows of a CSV file that are not empty, with line numbers; raises DataError."""
    try:
        text = text_of(path, _MOST_MIB, "table")
        if "\0" in text:  # UTF-16 without a mark, which decodes as UTF-8
            raise NotTextError(text.count("\n", 0, text.index("\0")) + 1)
    except OSError as error:
        raise UnreadableError(f"{path} cannot be read: {reason(error)}") from None
    except NotTextError as error:
        raise DataError(f"{path}:{error.line}: {error}") from None
    reader = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True)
    try:
        rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error:  # a cell too long; the reader takes everything else
        raise DataError(
            f"{path}:{reader.line_num}: a cell has more than {csv.field_size_limit()} characters; "
            "is a closing quote missing?"
        ) from None
    return [(line, cells) for line, cells in rows if any(cells)]


def _holds_numbers(cells: list[str]) -> bool:
    """Return whether a row has numbers only; they may be separated by spaces."""
    try:
        return bool([number_in(word) for cell in cells for word in cell.split()])
    except ValueError:
        return False


def _names_in_comment(
    path: Path, rows: list[tuple[int, list[str]]], first: tuple[int, list[str]]
) -> tuple[int, list[str]]:
    """Return the names in a comment above the first row of numbers; raises DataError."""
    above, (line, numbers) = rows[: rows.index(first)], first
    if len(numbers) == 1 and " " in numbers[0]:
        raise DataError(f"{path}:{line}: separate cells with commas, not with spaces")
    for place, cells in reversed(above):
        if len(cells) == len(numbers):
            return place, [cells[0].lstrip("#").strip(), *cells[1:]]
    raise DataError(f"{path}:{line}: holds numbers; the line of column names above them is missing")
