"""Measurements as a table: parameters, measured variables and their errors as columns."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.variables import BY_SYMBOL, PARAMETERS, RESULTS, canonical_name
from sweeps.exits import Exit, ExpectedError
from sweeps.human import counted, did_you_mean
from sweeps.paths import path_of

if TYPE_CHECKING:
    import pandas as pd

    Table: TypeAlias = str | Path | pd.DataFrame | Mapping[str, Sequence[float]]

Floats: TypeAlias = NDArray[np.float64]

_ERROR = "_error"

MEASURABLE: Mapping[str, str] = {
    spelling: name
    for name, variable in RESULTS.items()
    if variable.dtype == "f8" and variable.unit and not name.endswith(_ERROR)
    for spelling in (name, variable.symbol)
}
"""The variables that can be measured, by name and symbol: those with a unit, but no errors."""

_SHOWN = 20  # mistakes that are told in one go
_TABLE = "table"  # the source of mistakes of a table in Python

# A unit behind a name, and parts of the names that errors have in a laboratory.
_UNIT = re.compile(r"\s*[(\[/].*$")
_ERRORS = ("err", "std", "sd", "uncert", "sigma", "df", "±")


class DataError(ExpectedError, ValueError):
    """Measurements that cannot be used; the message has a line for each mistake."""


class UnreadableError(DataError):
    """A file of measurements that cannot be read."""

    code = Exit.STORAGE


@dataclass(frozen=True)
class Measurements:
    """Measurements: parameters (rows,) of each row, and data (n,) that lie on rows.

    `variable` and `row` tell for each datum what was measured, and where. `error` is the standard
    error, in the unit of the variable; where `relative`, none was given, and it is the value, so
    that all errors have a common unknown factor.
    """

    parameters: Mapping[str, Floats]
    variable: tuple[str, ...]
    row: NDArray[np.int64]
    value: Floats
    error: Floats
    relative: bool

    @property
    def rows(self) -> int:
        """The number of rows, each of one point."""
        return len(next(iter(self.parameters.values()))) if self.parameters else 1


@dataclass
class _Reading:
    """Texts or numbers of a table, and the mistakes so far.

    `lines` are the numbers of the rows in the file.
    """

    source: str
    header: list[str]
    cells: list[list[Any]]
    lines: list[int]
    problems: list[tuple[int, str]] = field(default_factory=list)

    def refuse(self, what: str, line: int | None = None, column: str = "") -> None:
        """Note a mistake."""
        if self.source != _TABLE:
            place = self.source if line is None else f"{self.source}:{line}"
        else:  # rows in Python have no lines; they are counted from 0
            place = _TABLE if line is None else f"row {line}"
        where = f"{place}, column {column}" if column else place
        self.problems.append((line or 0, f"{where}: {what}"))

    def raise_problems(self) -> None:
        """Raise DataError if there were mistakes."""
        if self.problems:
            said = [what for _, what in sorted(self.problems, key=lambda problem: problem[0])]
            more = [f"... and {len(said) - _SHOWN} more"] if len(said) > _SHOWN else []
            raise DataError("\n".join([*said[:_SHOWN], *more]))


def read_data(source: Table) -> Measurements:
    """Return the measurements of a CSV file, a DataFrame or a dict of columns.

    Columns are parameters, measured variables and, with `_error` behind the name of one, its
    standard errors, by names or symbols, in SI units. Empty cells were not measured.

    Raises DataError, which names all mistakes at once.
    """
    reading = _read_csv(path_of(source)) if isinstance(source, (str, Path)) else _read_table(source)
    roles = _roles(reading)
    reading.raise_problems()
    columns = {role: _numbers(reading, place, role) for role, place in roles.items()}
    reading.raise_problems()
    return _measurements(reading, columns, {name for name in roles if name in PARAMETERS})


def _read_csv(path: Path) -> _Reading:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file, skipinitialspace=True)
            rows = [
                (reader.line_num, [cell.strip() for cell in row])
                for row in reader
                if any(cell.strip() for cell in row) and not row[0].startswith("#")
            ]
    except OSError as error:
        raise UnreadableError(f"{path} cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path} is no CSV file in UTF-8: {error}") from None
    if len(rows) < 2:
        raise DataError(f"{path} holds no data: a line of names comes first, then the values")
    (_, header), body = rows[0], rows[1:]
    return _Reading(str(path), header, [row for _, row in body], [line for line, _ in body])


def _read_table(source: Any) -> _Reading:
    import pandas as pd

    if not isinstance(source, (pd.DataFrame, Mapping)):
        raise DataError(f"data are a CSV file, a DataFrame or a dict of columns, not {source!r}")
    try:
        frame = pd.DataFrame(source)
    except ValueError:
        sizes = {name: np.shape(column) for name, column in source.items()}
        if all(len(shape) == 1 for shape in sizes.values()):
            listed = ", ".join(f"{name} {size}" for name, (size,) in sizes.items())
            raise DataError(f"columns need equally many values, but have: {listed}") from None
        raise DataError("each column must be a list of numbers, one for each row") from None
    if frame.empty:
        raise DataError("the table holds no data")
    cells = frame.astype(object).where(frame.notna(), "").to_numpy().tolist()
    return _Reading(_TABLE, [str(name) for name in frame], cells, list(range(len(frame))))


def _roles(reading: _Reading) -> dict[str, int]:
    """Return the place of each column by its role: a full name, with `_error` behind it."""
    roles: dict[str, int] = {}
    for place, name in enumerate(reading.header):
        role = _role(name)
        if role is None:
            reading.refuse(_unknown(name, reading.header), _first(reading), name or "without name")
        elif role in roles:
            reading.refuse(f"{role} is given twice; leave one out", _first(reading), name)
        else:
            roles[role] = place
    measured = [role for role in roles if role in MEASURABLE]
    for role in roles:
        if role.endswith(_ERROR) and role.removesuffix(_ERROR) not in measured:
            what = f"there is no column {role.removesuffix(_ERROR)} that these are the errors of"
            reading.refuse(what, _first(reading), role)
    if not measured:
        known = ", ".join(
            f"{name} ({RESULTS[name].symbol})" for name in RESULTS if name in MEASURABLE
        )
        reading.refuse(f"no column is a measured variable; there are {known}", _first(reading))
    lacking = [name for name in measured if name + _ERROR not in roles]
    if lacking and len(lacking) < len(measured):
        what = "give errors of all measured variables or of none; there are none of"
        reading.refuse(f"{what} {', '.join(lacking)}", _first(reading))
    return roles


def _first(reading: _Reading) -> int | None:
    return None if reading.source == _TABLE else 1


def _role(name: str) -> str | None:
    if parameter := canonical_name(name):
        return parameter
    if measured := MEASURABLE.get(name):
        return measured
    measured = MEASURABLE.get(name.removesuffix(_ERROR))
    return measured + _ERROR if measured and name.endswith(_ERROR) else None


def _unknown(name: str, header: Sequence[str]) -> str:
    if len(header) == 1 and (";" in name or "\t" in name):
        return "cells are separated by commas, and decimals have a point"
    known = [
        *PARAMETERS,
        *BY_SYMBOL,
        *MEASURABLE,
        *(f"{measured}{_ERROR}" for measured in MEASURABLE),
    ]
    what = "is neither a parameter nor a measured variable nor the error of one"
    bare = _UNIT.sub("", name)
    units = "" if bare == name else "; a name has no unit, since all values are in SI units"
    meant = _meant(bare.lower())
    hint = f" (did you mean {meant!r}?)" if meant else did_you_mean(bare, known)
    return what + (hint + units or "; rename it or leave it out")


def _meant(word: str) -> str:
    """Return the column that a word of a laboratory stands for; empty for other words."""
    stress = "stress" in word
    measured = "elastic_stress_amplitude" if stress else "F_max"
    if any(part in word for part in _ERRORS):
        return measured + _ERROR
    is_force = stress or "force" in word or "friction" in word or word == "f"
    return measured if is_force else ""


def _numbers(reading: _Reading, place: int, role: str) -> Floats:
    """Return a column (rows,); NaN for empty cells."""
    name, numbers = reading.header[place], np.full(len(reading.cells), np.nan)
    for row, (line, cells) in enumerate(zip(reading.lines, reading.cells, strict=True)):
        if len(cells) != len(reading.header):
            if place == 0:
                what = f"{counted(len(cells), 'cell')} below {counted(len(reading.header), 'name')}"
                reading.refuse(f"{what}; cells that were not measured stay empty", line)
            continue
        try:
            numbers[row] = _number(cells[place], role)
        except ValueError as error:
            reading.refuse(str(error), line, name)
    return numbers


def _number(cell: Any, role: str) -> float:
    """Return the number in a cell; raises ValueError."""
    if cell == "":
        if role in PARAMETERS:
            raise ValueError("is empty; each row needs its parameters")
        return math.nan
    try:
        value = float(cell)
    except (TypeError, ValueError):
        hint = " (decimals have a point)" if "," in str(cell) else ""
        raise ValueError(f"must be a number in SI units, not {cell!r}{hint}") from None
    if role in PARAMETERS:
        complaint = PARAMETERS[role].complaint(value)
    elif role.endswith(_ERROR):
        good = math.isfinite(value) and value > 0
        complaint = None if good else f"must be greater than 0, not {value!r}"
    else:
        complaint = None if math.isfinite(value) else f"must be a finite number, not {value!r}"
    if complaint:
        raise ValueError(complaint)
    return value


def _measurements(
    reading: _Reading, columns: Mapping[str, Floats], parameters: set[str]
) -> Measurements:
    measured = [name for name in columns if name in MEASURABLE]
    relative = not any(name.endswith(_ERROR) for name in columns)
    data = [
        (name, row, value, abs(value) if relative else columns[name + _ERROR][row])
        for name in measured
        for row, value in enumerate(columns[name].tolist())
        if not math.isnan(value)
    ]
    for name, row, _, error in data:
        if not error > 0:
            remedy = "errors are relative to the values" if relative else "a value needs its error"
            column = next(c for c in reading.header if MEASURABLE.get(c) == name)
            what = f"a value without an error ({remedy}); fill the column {column}{_ERROR}"
            reading.refuse(what, reading.lines[row], column)
    reading.raise_problems()
    if not data:
        raise DataError("no value was measured: all their cells are empty")
    names, rows, values, errors = zip(*data, strict=True)
    return Measurements(
        parameters={name: columns[name] for name in columns if name in parameters},
        variable=names,
        row=np.array(rows, dtype=np.int64),
        value=np.array(values),
        error=np.array(errors, dtype=float),
        relative=relative,
    )


def columns_of(data: Measurements) -> Iterator[tuple[str, Floats]]:
    """Yield parameters that differ between rows, with their values (rows,)."""
    for name, values in data.parameters.items():
        if np.ptp(values) > 0:
            yield name, values
