"""The choice of what is drawn of a sweep: names and values, matched with its Dataset."""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from stickslip.variables import RESULTS, canonical_result
from sweeps.charts.at import axis_named
from sweeps.figure_table import AMPLITUDES
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
    return tuple(_variable(ds, name) for name in choice.variables)


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
        raise ValueError(f"this file lacks {name}: it is of an older version; sweep it again")
    return name


def _own_variables(ds: xr.Dataset) -> list[str]:
    """Return the variables that a user added: a number for each point of the result."""
    points = set(ds["status"].dims) if "status" in ds else set(ds.dims)
    return [
        str(name)
        for name, variable in ds.data_vars.items()
        if name not in RESULTS and variable.dtype.kind in "biuf" and set(variable.dims) == points
    ]


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
