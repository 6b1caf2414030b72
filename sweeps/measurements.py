"""Tables of measurements, with parameters, measured variables and their errors as columns."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.variables import (
    BY_SYMBOL,
    PARAMETERS,
    RESULTS,
    canonical_name,
    canonical_result,
)
from sweeps.human import did_you_mean
from sweeps.input_files import Cells, DataError, Floats, number_in, table_of
from sweeps.paths import path_of

if TYPE_CHECKING:
    import pandas as pd

    Table: TypeAlias = str | Path | pd.DataFrame | Mapping[str, Sequence[float]]

__all__ = ["DataError", "Floats", "Measurements", "read_data"]

_ERROR = "_error"
# Variables that can be measured: floats with a unit, but no errors.
_MEASURABLE = [
    name
    for name, variable in RESULTS.items()
    if variable.dtype == "f8" and variable.unit and not name.endswith(_ERROR)
]
# A unit after a name, and parts of the names that laboratories give to errors.
_UNIT = re.compile(r"\s*[(\[/].*$")
_ERRORS = ("err", "std", "sd", "uncert", "sigma", "df", "±")


@dataclass(frozen=True)
class Measurements:
    """Measurements: the parameters (rows,) of each row, and data (n,) that belong to rows.

    `variable` and `row` are the measured variable and the row of each datum. `error` is the
    standard error in the unit of the variable. If `relative`, the table has no errors, and `error`
    is the absolute value of the datum, so that all errors have a common unknown factor.
    """

    parameters: Mapping[str, Floats]
    variable: tuple[str, ...]
    row: NDArray[np.int64]
    value: Floats
    error: Floats
    relative: bool

    @property
    def rows(self) -> int:
        """The number of rows; each is one point."""
        return max(map(len, self.parameters.values()), default=int(self.row.max()) + 1)


def read_data(source: Table) -> Measurements:
    """Return the measurements in a CSV file, a DataFrame or a dict of columns.

    Columns are parameters and measured variables, by name or symbol, in SI units. A column of
    standard errors has the name of its variable followed by `_error`. An empty cell means that
    nothing was measured.

    Raises DataError with all mistakes at once.
    """
    table = table_of(path_of(source)) if isinstance(source, (str, Path)) else _in_python(source)
    roles = _roles(table)
    columns = table.columns(roles, _number)
    relative = not any(role.endswith(_ERROR) for role in roles)
    data = []
    for name in (role for role in roles if role in _MEASURABLE):
        errors = np.abs(columns[name]) if relative else columns[name + _ERROR]
        for row in np.flatnonzero(~np.isnan(columns[name])).tolist():
            data.append((name, row, columns[name][row], errors[row]))
            if not errors[row] > 0:
                column = table.header[roles[name]]
                mistake = (
                    f"an error relative to a value of 0 is 0; add the column {column}{_ERROR}"
                    if relative
                    else f"a value without an error; fill in the column {column}{_ERROR}"
                )
                table.refuse(mistake, table.lines[row], column)
    table.raise_problems()
    if not data:
        raise DataError("there are no measured values: all cells of measured variables are empty")
    names, rows, values, uncertainties = zip(*data, strict=True)
    return Measurements(
        parameters={role: columns[role] for role in roles if role in PARAMETERS},
        variable=names,
        row=np.array(rows, dtype=np.int64),
        value=np.array(values),
        error=np.array(uncertainties),
        relative=relative,
    )


def _in_python(source: Any) -> Cells:
    import pandas as pd

    if not isinstance(source, (pd.DataFrame, Mapping)):
        raise DataError(f"data must be a CSV file, DataFrame or dict of columns, not {source!r}")
    try:
        frame = pd.DataFrame(source)
    except ValueError:
        sizes = {name: np.shape(column) for name, column in source.items()}
        if all(len(shape) == 1 for shape in sizes.values()):
            listed = ", ".join(f"{name} {size}" for name, (size,) in sizes.items())
            raise DataError(f"columns need the same number of values, but have: {listed}") from None
        raise DataError("each column must be a list of numbers, one for each row") from None
    # Parameters in the index, which `set_index` and `groupby` put there, are columns.
    inside = [name for name in frame.index.names if name is not None and name not in frame]
    frame = frame.reset_index([name for name in inside if _role(str(name))])
    if frame.empty:
        raise DataError("the table holds no data")
    cells = frame.astype(object).where(frame.notna(), "").to_numpy().tolist()
    return Cells("", [str(name) for name in frame], cells, list(range(len(frame))))


def _roles(table: Cells) -> dict[str, int]:
    """Return the position of each column by its role: a full name, with `_error` for errors.

    Raises DataError with all mistakes in the names.
    """
    roles: dict[str, int] = {}
    for place, name in enumerate(table.header):
        role = _role(name)
        if role is None:
            table.refuse(_unknown(name), table.head, name or "without name")
        elif role in roles:
            table.refuse(f"{role} is given twice; leave one out", table.head, name)
        else:
            roles[role] = place
    measured = [role for role in roles if role in _MEASURABLE]
    for role in roles:
        if role.endswith(_ERROR) and role.removesuffix(_ERROR) not in measured:
            mistake = f"there is no column {role.removesuffix(_ERROR)} that these errors belong to"
            table.refuse(mistake, table.head, role)
    if not measured:
        known = ", ".join(f"{name} ({RESULTS[name].symbol})" for name in _MEASURABLE)
        table.refuse(f"no column is a measured variable; known names: {known}", table.head)
    lacking = [name for name in measured if name + _ERROR not in roles]
    if 0 < len(lacking) < len(measured):
        mistake = "give errors for all measured variables or for none; there are none for"
        table.refuse(f"{mistake} {', '.join(lacking)}", table.head)
    table.raise_problems()
    return roles


def _role(name: str) -> str | None:
    """Return the full name of a column, or None for an unknown one."""
    if parameter := canonical_name(name):
        return parameter
    bare = name.removesuffix(_ERROR)
    measured = canonical_result(bare)
    return measured + name[len(bare) :] if measured in _MEASURABLE else None


def _unknown(name: str) -> str:
    """Return a complaint about the unknown name of a column, with a known name that is close."""
    bare = _UNIT.sub("", name)
    no_unit = "" if bare == name else "; leave units out of names, since all values are in SI units"
    measured = [*_MEASURABLE, *(RESULTS[each].symbol for each in _MEASURABLE)]
    known = [*PARAMETERS, *BY_SYMBOL, *measured, *(each + _ERROR for each in measured)]
    meant = _meant(bare.lower())
    hint = f" (did you mean {meant!r}?)" if meant else did_you_mean(bare, known)
    complaint = "is neither a parameter nor a measured variable nor the error of one"
    return complaint + (hint + no_unit or "; rename it or leave it out")


def _meant(word: str) -> str:
    """Return the column that a word used in laboratories stands for, or an empty text."""
    measured = "elastic_stress_amplitude" if "stress" in word else "F_max"
    if any(part in word for part in _ERRORS):
        return measured + _ERROR
    is_force = word == "f" or any(part in word for part in ("stress", "force", "friction"))
    return measured if is_force else ""


def _number(cell: Any, role: str) -> float:
    """Return the number in a cell of a column with this role; raises ValueError."""
    value = number_in(cell, may_be_empty=role not in PARAMETERS)
    if math.isnan(value):
        return value
    if role in PARAMETERS:
        if complaint := PARAMETERS[role].complaint(value):
            raise ValueError(complaint)
    elif math.isinf(value):
        raise ValueError(f"must be a finite number, not {value!r}")
    elif role.endswith(_ERROR) and not value > 0:
        raise ValueError(f"must be greater than 0, not {value!r}")
    return value
