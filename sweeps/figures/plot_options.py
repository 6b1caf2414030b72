"""The options of the picture of a sweep: names and values, matched with its Dataset."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS, RESULTS, canonical_name, canonical_result
from sweeps.config.numbers import number
from sweeps.figure_table import AMPLITUDES
from sweeps.figures.labels import parameters_along, slice_label
from sweeps.figures.look import Look
from sweeps.human import did_you_mean

if TYPE_CHECKING:
    from sweeps.measurements import Measurements

ROLES = ("x", "y", "hue", "row", "col")


@dataclass(frozen=True)
class PlotOptions:
    """Result variables and the roles of axes, by full name or symbol; what is left out is chosen.

    `at` has texts such as `temperature=228`: the nearest point of that axis. `log` names
    logarithmic scales, such as `x,z`; z is the scale of the variable. `boundaries` are borders to
    draw on a map, `data` measurements to draw over curves. The `look` changes nothing of that.
    """

    variable: str | tuple[str, ...] | None = None
    x: str | None = None
    y: str | None = None
    hue: str | None = None
    row: str | None = None
    col: str | None = None
    at: tuple[str, ...] = ()
    log: str = ""
    boundaries: xr.Dataset | None = None
    data: Measurements | None = None
    look: Look = field(default_factory=Look)

    @property
    def asks(self) -> bool:
        """True if anything is chosen of what is to be drawn."""
        return bool(self.variable) or bool(self.at) or self.asks_for_axes

    @property
    def asks_for_axes(self) -> bool:
        """True if any option is chosen that only a picture of a sweep has."""
        over = self.boundaries is not None or self.data is not None
        return any(getattr(self, role) for role in ROLES) or bool(self.log) or over

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


def variables_of(ds: xr.Dataset, options: PlotOptions) -> tuple[str, ...]:
    """The result variables to draw: those asked for, or both amplitudes."""
    if options.variable is None:
        return AMPLITUDES
    return tuple(_variable(ds, name) for name in options.variables)


def _variable(ds: xr.Dataset, name: str) -> str:
    own = _own_variables(ds)
    if name in own:
        return name
    name = canonical_result(name) or name
    if name not in RESULTS:
        symbols = (variable.symbol for variable in RESULTS.values())
        names = [*own, *RESULTS]
        hint = did_you_mean(name, [*symbols, *names]) or f"; there are {', '.join(names)}"
        raise ValueError(f"unknown variable '{name}'{hint}")
    if name not in ds.variables:
        group = RESULTS[name].observable
        asking = f" with `observables: [{group}]`" if group else ""
        why = "was not asked for" if group else "is of an older version"
        raise ValueError(f"this file lacks {name}: it {why}; sweep it again{asking}")
    return name


def _own_variables(ds: xr.Dataset) -> list[str]:
    """Return the variables that a user added: a number for each point of the result."""
    points = set(ds["status"].dims) if "status" in ds else set(ds.dims)
    return [
        str(name)
        for name, variable in ds.data_vars.items()
        if name not in RESULTS and variable.dtype.kind in "biuf" and set(variable.dims) == points
    ]


def named_roles(ds: xr.Dataset, options: PlotOptions) -> dict[str, str]:
    """The dimension of each role that has one by name."""
    roles: dict[str, str] = {}
    for role in ROLES:
        name = getattr(options, role)
        if name is None:
            continue
        dim, _ = axis_named(ds, name)
        if other := next((known for known, taken in roles.items() if taken == dim), None):
            raise ValueError(f"{dim} is both {other} and {role}; an axis has one place")
        roles[role] = dim
    return roles


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


def lie_along(ds: xr.Dataset, options: PlotOptions) -> xr.Dataset:
    """The dataset with its cases along the linked parameter that is named for a role, if one is."""
    for role in ROLES:
        name = getattr(options, role)
        if name is not None:
            dim, coordinate = axis_named(ds, name)
            ds = ds.swap_dims({dim: coordinate}) if dim != coordinate else ds
    return ds


def with_numbers(ds: xr.Dataset) -> xr.Dataset:
    """Give numbers to dimensions without a coordinate, as of results that were stacked."""
    bare = {dim: np.arange(n) for dim, n in ds.sizes.items() if dim not in ds.coords}
    return ds.assign_coords(bare) if bare else ds


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


def slice_in_the_middle(ds: xr.Dataset, dims: Iterable[str]) -> tuple[xr.Dataset, str]:
    """The dataset in the middle of some dimensions, and a sentence that says where that is."""
    places = {dim: ds.sizes[dim] // 2 for dim in dims}
    where = f"In the middle of further axes: {slice_label(ds, places)}." if places else ""
    return ds.isel(places), where


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
