"""Orbits of many points in one call, from tables or arrays of parameters to a Dataset."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.accessors import register_accessors
from stickslip.datasets import parameter_scalars, result_variables
from stickslip.dispatch.ask import ask
from stickslip.dispatch.backend import own_workers
from stickslip.dispatch.blocks import SMALLEST_BLOCK, Blocks
from stickslip.dispatch.compilation import compile_kinds
from stickslip.dispatch.workers import Workers
from stickslip.kernels.families import KIND
from stickslip.options import Options, options_for_orbits
from stickslip.orbit import prepared_points
from stickslip.parameters import ParameterError, Parameters, as_float
from stickslip.variables import (
    ENERGY_COEFFICIENTS,
    PARAMETERS,
    RESULT_COLUMNS,
    RESULTS,
    canonical_name,
    full_names,
    unbounded,
)

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    Points: TypeAlias = Mapping[str, ArrayLike | xr.DataArray] | pd.DataFrame | xr.Dataset

POINT = "point"
"""The dimension of points in a list or a table."""

log = logging.getLogger(__name__)

_KIND = [Parameters._fields.index(name) for name in KIND]
_ENERGY = [Parameters._fields.index(name) for name in ENERGY_COEFFICIENTS]


def stationary_orbits(points: Points, **options: Any) -> xr.Dataset:
    """Return the stationary orbits of many points, computed together on all cores.

    The results equal those of `stationary_orbit`, and of a sweep bit for bit, in a fraction of the
    time. `joblib.parallel_config(...)` chooses the workers, with any backend that returns results
    as they finish (loky, threading and dask do); the default is one thread for each core.

    >>> ds = stationary_orbits({"temperature": [200, 250, 300], "k": 1e5})
    >>> ds.friction_force_amplitude.round(5).values.tolist()
    [0.00304, 0.00153, 0.0012]

    Parameters
    ----------
    points
        Parameters by name or symbol: numbers, lists and arrays of equal length, or of shapes that
        broadcast as in numpy, or DataArrays, which broadcast by the names of their dimensions. Or a
        DataFrame with parameters as columns and a point in each row, or a Dataset with parameters
        as variables and coordinates. All other parameters have the values of the paper's Fig. 3.
    **options
        As for `stationary_orbit`.

    Returns
    -------
    xarray.Dataset
        Variables of `variables.RESULTS`, in SI units, over the dimensions of the points: `point`
        for lists and rows, `dim_0`, `dim_1`, ... for arrays of more dimensions, or the dimensions
        of the DataArrays. Every parameter is a coordinate. `status` says how each search ended; a
        search that fails raises no exception.

    Raises
    ------
    ExecutorError
        The workers cannot be used, or were lost.
    NoiseError
        phi_0 = 0 without noise.
    OptionError
        A method, treatment or law is unknown, or a tolerance, step or budget out of range.
    ParameterError
        A value is out of range; the message names the parameter and the value.
    TypeError
        A parameter or option is unknown, or a parameter is given twice.
    ValueError
        Shapes do not broadcast, the coordinates of DataArrays differ, or a dimension has the name
        of a result, or of a parameter whose values do not lie along it.
    """
    places, chosen = places_of(points), options_for_orbits(**options)
    return results_at(places, orbit_rows(rows_of(places), chosen))


def results_at(places: xr.Dataset, rows: NDArray[np.float64]) -> xr.Dataset:
    """Return result rows (points, columns) as a Dataset with the coordinates of their points."""
    register_accessors()
    dims, shape = tuple(map(str, places.sizes)), tuple(places.sizes.values())
    return places.assign(result_variables(rows, dims, shape))


def places_of(points: Points) -> xr.Dataset:
    """Return a Dataset without variables, whose coordinates are the parameters of the points.

    Argument and errors are as in `stationary_orbits`.
    """
    import xarray as xr

    given = full_names(_columns(points))
    plain = {name: _numbers(name, v) for name, v in given.items() if not _is_labelled(v)}
    shape = _common_shape(plain)
    dims = [POINT] if len(shape) == 1 else [f"dim_{number}" for number in range(len(shape))]
    arrays = {name: _labelled(values, shape, dims) for name, values in plain.items()}
    for name, labelled in ((n, v) for n, v in given.items() if _is_labelled(v)):
        _numbers(name, labelled.values)  # refuses what is not a number, unlike `astype`
        arrays[name] = _without_ours(labelled, given).astype(float)
    try:
        xr.align(*arrays.values(), join="exact")
    except ValueError as error:
        raise ValueError(f"{_unequal('equal coordinates', arrays)}: {error}") from None
    _refuse_dimensions(arrays)
    for name, array in arrays.items():
        _refuse_invalid(name, np.asarray(array, dtype=float))
        array.attrs = PARAMETERS[name].attributes
    fixed = {name: v for name, v in Parameters()._asdict().items() if name not in arrays}
    return xr.Dataset(coords={name: arrays[name] for name in given} | parameter_scalars(fixed))


def rows_of(places: xr.Dataset) -> NDArray[np.float64]:
    """Return the parameters of points as an array (points, parameters), in C order.

    Raises ParameterError if coefficients of the free energy do not bound the order parameter.
    """
    names = Parameters._fields
    # Variables, not DataArrays: coordinates of one dataset need no alignment, the slowest part.
    columns = (places.variables[name].set_dims(places.sizes) for name in names)
    rows = np.stack([column.values.ravel() for column in columns], axis=1)
    for coefficients in np.unique(rows[:, _ENERGY], axis=0):
        if growth := unbounded(*coefficients):
            raise ParameterError(f"{growth}: otherwise the order parameter grows without bound")
    return rows


def orbit_rows(
    rows: NDArray[np.float64], options: Options, workers: Workers | None = None
) -> NDArray[np.float64]:
    """Return the result rows (n, columns) of points (n, parameters).

    `workers` compute them, by default `own_workers()`. Raises NoiseError.
    """
    results = np.empty((len(rows), len(RESULT_COLUMNS)))
    prepared_points(rows, options.noise)
    compile_kinds(options, rows[:, _KIND])  # here, or each worker would compile
    with own_workers() if workers is None else nullcontext(workers) as able:
        # A deferred point starts again with others like it, which pays if several blocks are
        # waiting.
        several = len(rows) > 2 * SMALLEST_BLOCK * able.slots
        order = Blocks(np.zeros(len(rows), dtype=bool), able.slots, defers=several)
        for block in ask(lambda some: rows[some], order, options, able):
            results[block.indices] = block.results
            for message in block.messages:
                log.error(message)
    return results


def _columns(points: Points) -> Mapping[Any, Any]:
    """Return the columns of a DataFrame as DataArrays along its rows; return a mapping as it is.

    Parameters in the index of a DataFrame, or among the coordinates of a Dataset, are columns too.
    """
    import pandas as pd
    import xarray as xr

    if isinstance(points, xr.Dataset):
        given = [name for name in points.coords if canonical_name(str(name))]
        return {name: points[name] for name in (*given, *points.data_vars)}
    if not isinstance(points, pd.DataFrame):
        is_mapping: bool = isinstance(points, Mapping)
        if not is_mapping:
            raise TypeError(
                "points must map parameters to their values, such as "
                f"{{'temperature': [200, 250]}}, or be a DataFrame, not {points!r}"
            )
        return points
    levels = [name for name in points.index.names if canonical_name(str(name))]
    names = pd.Index([*levels, *points.columns])
    if twice := [str(name) for name in names[names.duplicated()].unique()]:
        raise TypeError(f"{', '.join(twice)} is given twice, by the columns or index of the table")
    if levels:
        points = points.reset_index(level=levels)
    if points.index.nlevels > 1:
        points = points.reset_index(drop=True)
    return {
        name: column.to_xarray()
        for name, column in points.rename_axis(str(points.index.name or POINT)).items()
    }


def _numbers(name: str, values: Any) -> NDArray[np.float64]:
    """Return a number, list or array of numbers as a new array; raises ParameterError.

    As for `Parameters`, text and truth values are not numbers.
    """
    wanted = f"{name} must be a number, or an array or a list of numbers"
    if np.ma.is_masked(values):
        raise ParameterError(f"{wanted}, none of them masked")
    try:
        given = np.asarray(values)
    except ValueError as error:  # lists of unequal lengths in a list
        raise ParameterError(f"{wanted}: {error}") from None
    if given.dtype.kind == "O":
        each = [as_float(name, value) for value in given.flat]
        return np.array(each, dtype=float).reshape(given.shape)
    if given.dtype.kind not in "iuf" and given.size:
        raise ParameterError(f"{wanted}, not {given.flat[0].item()!r}")
    return given.astype(float)


def _common_shape(arrays: Mapping[str, NDArray[np.float64]]) -> tuple[int, ...]:
    """Return the shape to which arrays broadcast; raises ValueError, with their shapes."""
    try:
        return np.broadcast_shapes(*(values.shape for values in arrays.values()))
    except ValueError:
        raise ValueError(_unequal("the same number of values", arrays)) from None


def _unequal(what: str, arrays: Mapping[str, Any]) -> str:
    sizes = ((name, " x ".join(map(str, array.shape))) for name, array in arrays.items())
    listed = ", ".join(f"{name} {size}" for name, size in sizes if size)
    return f"parameters that vary need {what}, but have: {listed}"


def _is_labelled(values: Any) -> bool:
    import xarray as xr

    return isinstance(values, xr.DataArray)


def _without_ours(labelled: xr.DataArray, given: Iterable[str]) -> xr.DataArray:
    """Return an array without coordinates that would hide parameters and results of its points.

    A slice of a result has them, and a stacked one has parameters as levels of an index. Raises
    ValueError for such a level whose values are not given.
    """
    ours = (PARAMETERS.keys() | RESULTS.keys()) & labelled.coords.keys() - set(labelled.dims)
    levels = [name for name in labelled.indexes if name in ours]
    if lost := [name for name in levels if name in PARAMETERS and name not in given]:
        raise ValueError(
            f"{', '.join(map(str, lost))} is an index of the points, but its values are not given; "
            "give them too, or drop the index"
        )
    whole = {name for level in levels for name in labelled.xindexes.get_all_coords(level)}
    return labelled.reset_index(list(whole)).drop_vars(ours)


def _labelled(values: NDArray[np.float64], shape: tuple[int, ...], dims: list[str]) -> xr.DataArray:
    """Return a copy of a plain array with named dimensions; a number has none."""
    import xarray as xr

    if values.ndim == 0:
        return xr.DataArray(values.copy())
    return xr.DataArray(np.broadcast_to(values, shape).copy(), dims=dims)


def _refuse_dimensions(arrays: Mapping[str, xr.DataArray]) -> None:
    """Raise ValueError for a dimension named like a parameter whose values do not lie along it.

    Nor may it be named like a result.
    """
    for name in dict.fromkeys(dim for array in arrays.values() for dim in array.dims):
        if name in RESULTS:
            raise ValueError(
                f"{name} is a dimension of the points and also a result; rename the dimension"
            )
        if name in PARAMETERS and (name not in arrays or arrays[str(name)].dims != (name,)):
            raise ValueError(
                f"{name} is a dimension of the points, but its values are not along it; give them "
                f"as a DataArray with this dimension alone, or rename the dimension"
            )


def _refuse_invalid(name: str, values: NDArray[np.float64]) -> None:
    variable = PARAMETERS[name]
    # The valid values are an interval, perhaps without 0, so the extreme values decide for all.
    odd = values[~np.isfinite(values) | ((values == 0) & variable.nonzero)]
    for value in (*odd.ravel()[:1], *([values.min(), values.max()] if values.size else [])):
        if complaint := variable.complaint(float(value)):
            raise ParameterError(f"{name} {complaint}")
