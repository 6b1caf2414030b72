"""The choice of what is drawn of a Dataset: figures, variables, roles of axes, nearest points."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS, RESULTS, canonical_name, canonical_result
from sweeps.charts.labels import parameters_along, slice_label
from sweeps.config.numbers import number
from sweeps.figure_table import AMPLITUDES, FIGURES, Data
from sweeps.human import did_you_mean

ROLES = ("x", "y", "hue", "row", "col")


@dataclass(frozen=True)
class Choice:
    """Result variables and the roles of axes, by full name or symbol; what is left out is chosen.

    `at` has texts such as `temperature=228`: the nearest point of that axis. `log` names
    logarithmic scales, such as `x,z`; z is the scale of the variable.
    """

    variable: str | tuple[str, ...] | None = None
    x: str | None = None
    y: str | None = None
    hue: str | None = None
    row: str | None = None
    col: str | None = None
    at: tuple[str, ...] = ()
    log: str = ""

    @property
    def asks_for_axes(self) -> bool:
        """True if any option is chosen that only a picture of a sweep has."""
        return any(getattr(self, role) for role in ROLES) or bool(self.log)

    @property
    def variables(self) -> tuple[str, ...]:
        """The variables as they were named."""
        one = isinstance(self.variable, str)
        return (self.variable,) if one else tuple(self.variable or ())  # type: ignore[return-value]

    @property
    def scales(self) -> frozenset[str]:
        """The letters of `log`; raises ValueError for others than x, y and z."""
        letters = [letter.strip() for letter in self.log.split(",") if letter.strip()]
        if unknown := [letter for letter in letters if letter not in ("x", "y", "z")]:
            raise ValueError(f"log scales are x, y and z, as in `x,z`; there is no '{unknown[0]}'")
        return frozenset(letters)


def variables_of(ds: xr.Dataset, choice: Choice) -> tuple[str, ...]:
    """The result variables to draw: those asked for, or both amplitudes."""
    if choice.variable is None:
        return AMPLITUDES
    # Those that a user added have a number for each point of the result as well.
    points = set(ds["status"].dims) if "status" in ds else set(ds.dims)
    own = [
        str(name)
        for name, variable in ds.data_vars.items()
        if name not in RESULTS and variable.dtype.kind in "biuf" and set(variable.dims) == points
    ]
    return tuple(name if name in own else _result(ds, name, own) for name in choice.variables)


def _result(ds: xr.Dataset, name: str, own: list[str]) -> str:
    """Return the full name of a result variable; raises ValueError if the dataset has none such."""
    name = canonical_result(name) or name
    if name not in RESULTS:
        symbols = (variable.symbol for variable in RESULTS.values())
        names = [*own, *RESULTS]
        hint = did_you_mean(name, [*symbols, *names]) or f"; there are {', '.join(names)}"
        raise ValueError(f"unknown variable '{name}'{hint}")
    if name not in ds.variables:
        raise ValueError(
            f"this file lacks {name}: it was written by an older version; sweep it again"
        )
    return name


def named_roles(ds: xr.Dataset, choice: Choice) -> dict[str, str]:
    """The dimension of each role that has one by name."""
    roles: dict[str, str] = {}
    for role in ROLES:
        name = getattr(choice, role)
        if name is None:
            continue
        dim, _ = axis_named(ds, name)
        if other := next((known for known, taken in roles.items() if taken == dim), None):
            raise ValueError(f"{dim} is both {other} and {role}; an axis has one place")
        roles[role] = dim
    return roles


def lie_along(ds: xr.Dataset, choice: Choice) -> xr.Dataset:
    """The dataset with its cases along the linked parameter that is named for a role, if one is."""
    for role in ROLES:
        name = getattr(choice, role)
        if name is not None:
            dim, coordinate = axis_named(ds, name)
            ds = ds.swap_dims({dim: coordinate}) if dim != coordinate else ds
    return ds


# --- points, as texts such as `temperature=228` name them -----------------------------------------


def slice_at(ds: xr.Dataset, at: Iterable[str]) -> tuple[xr.Dataset, str]:
    """The dataset at the points that are nearest, and a sentence that says where that is.

    `temperature=180,220,300` keeps several points of an axis, and the axis with them.
    """
    ds = with_numbers(ds)
    texts: list[str] = []
    some: dict[str, list[int]] = {}
    for text in at:
        key, _, value = (part.strip() for part in text.partition("="))
        if "," not in value:
            texts.append(text)
            continue
        each = [f"{key}={one}" for one in value.strip("[]").split(",")]
        found = [places_at(ds, [one]) for one in each]
        some |= {dim: list(dict.fromkeys(place[dim] for place in found)) for dim in found[0]}
    ds = ds.isel(some)
    places = places_at(ds, texts)
    return ds.isel(places), f"At {slice_label(ds, places)}." if places else ""


def places_at(ds: xr.Dataset, at: Iterable[str]) -> dict[str, int]:
    """The nearest place along each dimension that texts such as `temperature=228` name.

    Raises ValueError for what is no axis, no value, or far off the axis.
    """
    places: dict[str, int] = {}
    for text in at:
        key, _, value = (part.strip() for part in text.partition("="))
        if not key or not value:
            raise ValueError(f"'{text}' must be KEY=VALUE, for example temperature=228")
        dim, name = axis_named(ds, key)
        if dim in places:
            raise ValueError(
                f"'{text}': {dim} is sliced before already; several points are {key}=180,220,300"
            )
        places[dim] = _nearest(ds[name], value, text)
    return places


def with_numbers(ds: xr.Dataset) -> xr.Dataset:
    """Give numbers to dimensions without a coordinate, as of results that were stacked."""
    bare = {dim: np.arange(n) for dim, n in ds.sizes.items() if dim not in ds.coords}
    return ds.assign_coords(bare) if bare else ds


def slice_in_the_middle(ds: xr.Dataset, dims: Iterable[str]) -> tuple[xr.Dataset, str]:
    """The dataset in the middle of some dimensions, and a sentence that says where that is."""
    places = {dim: ds.sizes[dim] // 2 for dim in dims}
    where = f"In the middle of further axes: {slice_label(ds, places)}." if places else ""
    return ds.isel(places), where


def axis_named(ds: xr.Dataset, name: str) -> tuple[str, str]:
    """The dimension along which a name varies, and the coordinate that it is."""
    full = canonical_name(name) or name
    if full in ds.sizes and ds.sizes[full] > 1:
        return full, full
    if full in ds.coords and ds[full].size > 1:
        return str(ds[full].dims[0]), full
    if full in ds.coords:
        value = ds[full].values.item()
        raise ValueError(f"{full} is {value} in all of this file; {_axes_of(ds)}")
    hint = did_you_mean(name, [*_varying(ds), *PARAMETERS])
    raise ValueError(f"unknown axis '{name}'{hint}; {_axes_of(ds)}")


def _nearest(coordinate: xr.DataArray, text: str, whole: str) -> int:
    values = coordinate.values
    if values.dtype.kind not in "fiu":
        known = [str(value) for value in values]
        if text in known:
            return known.index(text)
        raise ValueError(f"'{whole}': there are {' and '.join(known)}")
    try:
        value = number(text) if "/" in text else float(text)
    except ValueError:
        raise ValueError(f"'{whole}': {text} is no number") from None
    if not math.isfinite(value):
        raise ValueError(f"'{whole}': must be a finite number")
    low, high = float(values.min()), float(values.max())
    # Beyond the ends by the longest step there is: nobody means the last point.
    reach = float(np.diff(np.sort(values)).max(initial=0.0))
    if not low - reach <= value <= high + reach:
        raise ValueError(f"'{whole}': {coordinate.name} goes from {low:g} to {high:g} in this file")
    return int(np.argmin(np.abs(values - value)))


def _varying(ds: xr.Dataset) -> list[str]:
    dims = [str(dim) for dim, size in ds.sizes.items() if size > 1]
    return [name for dim in dims for name in dict.fromkeys([dim, *parameters_along(ds, dim)])]


def _axes_of(ds: xr.Dataset) -> str:
    symbols = {name: f" ({PARAMETERS[name].symbol})" for name in PARAMETERS}
    names = [f"{name}{symbols.get(name, '')}" for name in _varying(ds)]
    return f"its axes are {', '.join(names)}" if names else "it has no axes: it is a single point"


# --- figures --------------------------------------------------------------------------------------


def data_of(ds: xr.Dataset) -> Data:
    """Return the kind of a dataset: a trajectory, phases, a fit, indices, or else a sweep."""
    if "fitted_value" in ds.variables:
        return "fit"
    if "total_order" in ds.variables:
        return "indices"
    if "free_energy" in ds.variables or "melting_temperature" in ds.variables:
        return "phases"
    return "trajectory" if "elapsed_time" in ds.variables else "sweep"


def default_figure(ds: xr.Dataset) -> str:
    """The name of the figure that fits the dataset best."""
    data = data_of(ds)
    return next(name for name, entry in FIGURES.items() if entry.data == data)


def obstacle(ds: xr.Dataset, name: str) -> str:
    """Why a figure cannot be drawn of a dataset, as a sentence; empty where it can."""
    if name not in FIGURES:
        hint = did_you_mean(name, FIGURES) or f"; there are {', '.join(FIGURES)}"
        return f"unknown figure '{name}'{hint}"
    entry, data = FIGURES[name], data_of(ds)
    if "boundary_point" in ds.dims:
        return (
            "borders are drawn over their map: give the file of the map, and --boundaries this one"
        )
    lacking = [needed for needed in entry.variables if needed not in ds.variables]
    if entry.data != data:
        return f"the figure '{name}' draws {entry.drawn}, and this file holds none"
    if lacking:
        return f"the figure '{name}' needs {', '.join(lacking)}, which this file lacks"
    return ""
