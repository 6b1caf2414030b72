"""What a user chooses to draw of a Dataset: figure, variables, roles of axes, nearest points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS, RESULTS, TRAJECTORY, canonical_name, canonical_result
from sweeps.charts.labels import parameters_along, slice_label
from sweeps.config.numbers import finite
from sweeps.config.yaml_reader import scalar
from sweeps.figure_table import AMPLITUDES, FIGURES, Data
from sweeps.grid import QUANTILE
from sweeps.human import did_you_mean

ROLES = ("x", "y", "hue", "row", "col")


@dataclass(frozen=True)
class Choice:
    """The result variables and the axes to draw, by full name or symbol; None means the default.

    `at` has texts such as `temperature=228`, which select the nearest point of an axis. `log` names
    the logarithmic scales, such as `x,z`, where z is the scale of the variable.
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
        """True if the user set an option that only pictures of sweeps have."""
        return any(getattr(self, role) for role in ROLES) or bool(self.log)

    @property
    def variables(self) -> tuple[str, ...]:
        """The variables, named as the user named them."""
        if isinstance(self.variable, str):
            return (self.variable,)
        return tuple(self.variable or ())

    @property
    def scales(self) -> frozenset[str]:
        """The letters of `log`; raises ValueError for a letter other than x, y and z."""
        letters = [letter.strip() for letter in self.log.split(",") if letter.strip()]
        if unknown := [letter for letter in letters if letter not in ("x", "y", "z")]:
            raise ValueError(f"log scales are x, y and z, as in `x,z`; there is no '{unknown[0]}'")
        return frozenset(letters)


def variables_of(ds: xr.Dataset, choice: Choice) -> tuple[str, ...]:
    """Return the result variables to draw: the chosen ones, each once, or both amplitudes."""
    if not choice.variables:
        return AMPLITUDES
    # A variable that the user added also has a number for each point of the result.
    points = set(ds["status"].dims) if "status" in ds else set(ds.dims) - {QUANTILE}
    own = [
        str(name)
        for name, variable in ds.data_vars.items()
        if name not in RESULTS
        and variable.dtype.kind in "biuf"
        and set(variable.dims) - {QUANTILE} == points
    ]
    names = (name if name in own else _result(ds, name, own) for name in choice.variables)
    return tuple(dict.fromkeys(names))


def _result(ds: xr.Dataset, name: str, own: list[str]) -> str:
    """Return the full name of a result variable; raises ValueError if the dataset lacks it."""
    name = canonical_result(name) or name
    if name not in RESULTS:
        symbols = (variable.symbol for variable in RESULTS.values())
        names = [*own, *RESULTS]
        hint = did_you_mean(_amplitude_of(name) or name, [*symbols, *names])
        hint = hint or f"; there are {', '.join(names)}"
        raise ValueError(f"unknown variable '{name}'{hint}")
    if name not in ds.variables:
        if QUANTILE in ds.dims:
            known = ", ".join(str(n) for n, each in ds.data_vars.items() if QUANTILE in each.dims)
            raise ValueError(f"there are no quantiles of {name}, only of {known}")
        raise ValueError(
            f"this result lacks {name}: it was left out, or an older version made the result; "
            "take the whole result, or sweep it again"
        )
    return name


def _amplitude_of(name: str) -> str:
    """Return the symbol of the amplitude of a quantity, such as F_max for F; empty if none."""
    for quantity, variable in TRAJECTORY.items():
        amplitude = RESULTS.get(f"{quantity}_amplitude")
        if amplitude and name in (quantity, variable.symbol):
            return amplitude.symbol
    return ""


def named_roles(ds: xr.Dataset, choice: Choice) -> dict[str, str]:
    """Return the dimension of each role that the user named."""
    roles: dict[str, str] = {}
    for role in ROLES:
        name = getattr(choice, role)
        if name is None:
            continue
        dim, _ = axis_named(ds, name)
        if other := next((known for known, taken in roles.items() if taken == dim), None):
            raise ValueError(f"{dim} is both {other} and {role}; an axis has only one role")
        roles[role] = dim
    return roles


def lie_along(ds: xr.Dataset, choice: Choice) -> xr.Dataset:
    """Return the dataset with its cases along the linked parameter that the user gave a role."""
    for role in ROLES:
        name = getattr(choice, role)
        if name is not None:
            dim, coordinate = axis_named(ds, name)
            ds = ds.swap_dims({dim: coordinate}) if dim != coordinate else ds
    return ds


# --- the points that texts such as `temperature=228` select ---------------------------------------


def slice_at(ds: xr.Dataset, at: Iterable[str]) -> tuple[xr.Dataset, str]:
    """Return the dataset at the nearest points, and a sentence that says where they are.

    `temperature=180,220,300` keeps several points of an axis, so the axis stays.
    """
    refuse_empty(ds)
    ds = with_numbers(ds)
    if "status" in ds.variables:  # what a user computes, as with `xr.where`, may have another order
        ds = ds.transpose(*ds["status"].dims, ...)
    texts: list[str] = []
    some: dict[str, list[int]] = {}
    for text in at:
        key, _, value = (part.strip() for part in text.partition("="))
        if "," not in value:
            texts.append(text)
            continue
        each = [f"{key}={one}" for one in value.strip("[]").split(",")]
        found = [places_at(ds, [one]) for one in each]
        (dim,) = found[0]
        if dim in some:
            raise _sliced_again(text, dim, key)
        kept = list(dict.fromkeys(place[dim] for place in found))
        if len(kept) == 1:  # all of them are nearest to the same point
            texts.append(each[0])
        else:
            some[dim] = kept
    sliced = set(some)
    for text in texts:
        (dim,) = places_at(ds, [text])
        if dim in sliced:
            raise _sliced_again(text, dim, text.partition("=")[0].strip())
        sliced.add(dim)
    ds = ds.isel(some)
    places = places_at(ds, texts)
    return ds.isel(places), f"At {slice_label(ds, places)}." if places else ""


def text_of(value: Any) -> str:
    """Return one value or several, such as an array, as the option `--at` takes them."""
    values = np.asarray(value).tolist() if np.ndim(value) or hasattr(value, "ndim") else value
    return ",".join(map(str, values)) if isinstance(values, list) else str(values)


def places_at(ds: xr.Dataset, at: Iterable[str]) -> dict[str, int]:
    """Return the nearest place along each dimension that texts such as `temperature=228` name.

    Raises ValueError for an unknown axis, for a text that is not a value, and for a value far
    beyond the ends of the axis.
    """
    places: dict[str, int] = {}
    for text in at:
        key, _, value = (part.strip() for part in text.partition("="))
        if not key or not value:
            raise ValueError(f"'{text}' must be KEY=VALUE, for example temperature=228")
        dim, name = axis_named(ds, key)
        if dim in places:
            raise ValueError(f"'{text}' slices {dim} a second time; leave one out")
        places[dim] = _nearest(ds[name], value, text)
        _refuse_equals(ds, dim, name, places[dim], text)
    return places


def _refuse_equals(ds: xr.Dataset, dim: str, name: str, place: int, text: str) -> None:
    """Raise ValueError if another place of a dimension has the same value of a coordinate."""
    values = ds[name].values
    equal = int(np.count_nonzero(values == values[place]))
    if equal > 1:
        # The values of an axis repeat in results that were joined along it.
        example = f"by {dim}, for example {dim}={ds[dim].values[place]}"
        remedy = "with isel()" if name == dim else example
        raise ValueError(
            f"'{text}': {equal} points along {dim} have this value; choose one {remedy}"
        )


def _sliced_again(text: str, dim: str, key: str) -> ValueError:
    return ValueError(
        f"'{text}' slices {dim} a second time; for several points write {key}=180,220,300"
    )


def with_numbers(ds: xr.Dataset) -> xr.Dataset:
    """Number the points of dimensions without a coordinate, such as a stack of results.

    Raises ValueError for an axis whose values were dropped: numbers would pass for values.
    """
    bare = {dim: np.arange(n) for dim, n in ds.sizes.items() if dim not in ds.coords}
    if lost := [str(dim) for dim in bare if dim in PARAMETERS]:
        raise ValueError(f"the values of {lost[0]} were dropped from this result; keep them")
    return ds.assign_coords(bare) if bare else ds


def refuse_empty(ds: xr.Dataset) -> None:
    """Raise ValueError for a selection without any point, such as `ds.isel(temperature=[])`."""
    # A pull may have no meltings.
    sizes = (ds["elapsed_time"] if "elapsed_time" in ds.variables else ds).sizes
    if empty := [str(dim) for dim, size in sizes.items() if size == 0]:
        raise ValueError(f"this selection has no points along {', '.join(empty)}")


def slice_in_the_middle(ds: xr.Dataset, dims: Iterable[str]) -> tuple[xr.Dataset, str]:
    """Return the dataset in the middle of some dimensions, and a sentence that says where it is."""
    places = {dim: ds.sizes[dim] // 2 for dim in dims}
    where = f"Other axes at their middle: {slice_label(ds, places)}." if places else ""
    return ds.isel(places), where


def axis_named(ds: xr.Dataset, name: str) -> tuple[str, str]:
    """Return the dimension along which a quantity varies, and the name of its coordinate."""
    full = canonical_name(name) or name
    if full in ds.sizes and ds.sizes[full] > 1:
        return full, full
    if full in ds.coords and ds[full].size > 1:
        dims = list(map(str, ds[full].dims))
        if len(dims) > 1:
            raise ValueError(f"{full} varies along {' and '.join(dims)} together; name one of them")
        return dims[0], full
    if full in ds.coords:
        value = ds[full].values.item()
        raise ValueError(f"{full} is {value} throughout this file; {_axes_of(ds)}")
    hint = did_you_mean(name, [*_varying(ds), *PARAMETERS])
    raise ValueError(f"unknown axis '{name}'{hint}; {_axes_of(ds)}")


def _nearest(coordinate: xr.DataArray, text: str, whole: str) -> int:
    values = coordinate.values
    if values.dtype.kind not in "fiu":
        known = [str(value) for value in values]
        if text in known:
            return known.index(text)
        raise ValueError(f"'{whole}': the values are {' and '.join(known)}")
    try:
        value = finite(scalar(text))  # as in a config
    except ValueError as problem:
        raise ValueError(f"'{whole}': {problem}") from None
    low, high = float(values.min()), float(values.max())
    # A value farther beyond the last point than the longest step cannot be meant for that point.
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
    return f"its axes are {', '.join(names)}" if names else "it is a single point and has no axes"


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
    """Return the name of the figure that suits the dataset best."""
    data = data_of(ds)
    return next(name for name, entry in FIGURES.items() if entry.data == data)


# The dimensions that a part of a dataset may have lost, for example by `squeeze`.
_ALONG = {
    "fit": ("datum", "free_parameter"),
    "free_energy": ("temperature",),
    "landscape": ("temperature",),
    "posterior": ("free_parameter",),
    "indices": ("parameter", "result"),
}


def obstacle(ds: xr.Dataset, name: str) -> str:
    """Return why a figure of a dataset cannot be drawn; empty if it can be."""
    if name not in FIGURES:
        hint = did_you_mean(name, FIGURES) or f"; there are {', '.join(FIGURES)}"
        return f"unknown figure '{name}'{hint}"
    entry, data = FIGURES[name], data_of(ds)
    if "boundary_point" in ds.dims:
        return (
            "borders are drawn over their map; plot the file of the map, with this one as "
            "--boundaries"
        )
    lacking = [needed for needed in entry.variables if needed not in ds.variables]
    if entry.data != data:
        return f"the figure '{name}' draws {entry.drawn}, and this file holds none"
    if lacking:
        return f"the figure '{name}' needs {', '.join(lacking)}, which this file lacks"
    if lost := [dim for dim in _ALONG.get(name, ()) if dim not in ds.dims]:
        return (
            f"the figure '{name}' needs the dimension {lost[0]}: keep it, as with "
            f"isel({lost[0]}=[0]), and without squeeze()"
        )
    return ""
