"""Result rows as variables of an xarray Dataset: names, types, units and flags."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS, RESULTS

_FLAGS = {"status": Status, "regime": Regime}


def result_values(name: str, column: NDArray[np.float64]) -> NDArray[np.generic]:
    """Return a column (n,) of result rows in its file type, with missing values for NaN."""
    variable = RESULTS[name]
    real = np.isnan(variable.missing)
    return (column if real else np.nan_to_num(column, nan=variable.missing)).astype(variable.dtype)


def result_attributes(name: str) -> dict[str, Any]:
    """Return the CF attributes of a result variable: meaning, unit, symbol and flags."""
    described: dict[str, Any] = dict(RESULTS[name].attributes)
    if name in _FLAGS:
        codes = list(_FLAGS[name])
        described["flag_values"] = np.array([int(code) for code in codes], dtype=np.int8)
        described["flag_meanings"] = " ".join(code.name.lower() for code in codes)
    return described


def result_variables(
    rows: NDArray[np.float64], dims: tuple[str, ...], shape: tuple[int, ...]
) -> dict[str, tuple[tuple[str, ...], NDArray[np.generic], dict[str, Any]]]:
    """Return result rows (points, columns) as variables: their dimensions, values and attributes.

    The points are in C order, the columns in the order of `RESULT_COLUMNS`.
    """
    columns = dict(zip(RESULT_COLUMNS, rows.T, strict=True))
    return {
        name: (dims, result_values(name, columns[name]).reshape(shape), result_attributes(name))
        for name in RESULT_COLUMNS
    }


def parameter_scalars(values: Mapping[str, float]) -> dict[str, tuple[tuple[()], float, Any]]:
    """Return parameters with a single value as scalar coordinates, with their attributes."""
    return {name: ((), value, PARAMETERS[name].attributes) for name, value in values.items()}
