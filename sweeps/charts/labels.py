"""Axis labels and shown units: the registry's symbols, and the only conversions of the project."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from stickslip.variables import (
    PARAMETERS,
    PHASES,
    PULLED,
    RESULTS,
    STROBOSCOPIC,
    TRAJECTORY,
    Variable,
)

Array = np.ndarray[Any, np.dtype[Any]]

VARIABLES: dict[str, Variable] = {
    **PARAMETERS,
    **TRAJECTORY,
    **STROBOSCOPIC,
    **PHASES,
    **PULLED,
    **RESULTS,
}

_MEANINGS = {variable.meaning: variable.units for variable in VARIABLES.values()}


class Scale(NamedTuple):
    """A shown unit, and the factor that converts a value from the unit of the file."""

    factor: float
    units: str


SCALES = {
    "Pa": Scale(1e-6, "MPa"),
    "N": Scale(1e3, "mN"),
    "J": Scale(1e9, "nJ"),
    "m": Scale(1e6, "µm"),
    "m s-1": Scale(1e6, "µm s-1"),
    "m2": Scale(1e12, "µm2"),
}
# Quantities far larger or smaller than others of their unit.
SCALES_BY_NAME = {
    "film_thickness": Scale(1e9, "nm"),
    "strain_relaxation_time": Scale(1e9, "ns"),
    "elastic_coefficient": Scale(1e-12, "TPa"),
}

# The names of the two directions along a followed axis.
DIRECTIONS = {"up": "upward", "down": "downward"}

_LARGEST_DENOMINATOR = 12  # beyond it a fraction is no easier to read than a decimal


@dataclass(frozen=True)
class Quantity:
    """Numbers in the unit in which they are shown, with their symbol and unit in mathtext."""

    values: Array
    symbol: str
    units: str

    @property
    def label(self) -> str:
        """Symbol and unit, as on an axis."""
        return f"{self.symbol} ({self.units})" if self.units else self.symbol

    @property
    def value(self) -> str:
        """The value of a scalar, with its unit."""
        return self.number + (f" {self.units}" if self.units else "")

    @property
    def number(self) -> str:
        """The value of a scalar alone."""
        return f"${_number(float(self.values), rational=not self.units)}$"

    @property
    def equation(self) -> str:
        """Symbol and value of a scalar, as in a legend; a word is not typeset as a product."""
        if not self.symbol.startswith("$"):
            return f"{self.symbol} {self.value}"
        return f"${self.symbol.strip('$')} = {self.value[1:]}"


def shown(data: xr.DataArray) -> Quantity:
    """Return a variable or coordinate as a quantity, in the unit in which it is shown."""
    name = str(data.name)
    variable = VARIABLES.get(name)
    units = str(data.attrs.get("units", variable.units if variable else "1"))
    called = str(data.attrs.get("long_name", name))
    if variable is None and called in _MEANINGS:
        # A variable of the user, such as mu = F / N, with the attributes of F copied by xarray.
        units = "1" if units == _MEANINGS[called] else units
        called = name
    scale = SCALES.get(units, Scale(1.0, units))
    if variable and name in SCALES_BY_NAME and units == variable.units:
        scale = SCALES_BY_NAME[name]
    given = np.asarray(data.values, dtype=float)
    with np.errstate(over="ignore"):
        values = given * scale.factor
    if (np.isinf(values) & np.isfinite(given)).any():  # a config may say 1e300 m
        values, scale = given, Scale(1.0, units)
    typeset = typeset_units(scale.units)
    if name == "viscosity_coefficient" and units == VARIABLES[name].units:
        typeset = _unit_of_k(data)
    return Quantity(values, f"${variable.tex}$" if variable else _in_words(called), typeset)


def _in_words(name: str) -> str:
    """Return a name with spaces for underscores, except in mathtext, where they make subscripts."""
    parts = name.split("$")
    parts[::2] = [part.replace("_", " ") for part in parts[::2]]
    return "$".join(parts)


def shown_number(name: str, value: float) -> Quantity:
    """Return one value of a variable of the registry as a quantity."""
    return shown(xr.DataArray(value, name=name, attrs={"units": VARIABLES[name].units}))


def with_error(value: float, error: float, *, mathtext: bool = False) -> str:
    """Return a value and its error, to two digits of the error: `-0.550±0.012`.

    An infinite error leaves the value alone. This needs the package uncertainties, which the rest
    of this module does not.
    """
    from uncertainties import ufloat

    if math.isinf(error):
        return f"{value:.7g}"
    return f"{ufloat(value, error):.2u{'L' if mathtext else 'P'}}"


def _unit_of_k(data: xr.DataArray) -> str:
    """Return the unit Pa s^(gamma+1) of k, Eq. 7; its power is a number if gamma is the same."""
    gamma = data.coords.get("rheological_index")
    if gamma is None or np.ptp(gamma.values) > 0:
        return r"Pa$\cdot$s$^{\gamma+1}$"
    power = _number(float(gamma.values.flat[0]) + 1.0, rational=True)
    return r"Pa$\cdot$s" + ("" if power == "1" else f"$^{{{power}}}$")


def slice_label(ds: xr.Dataset, places: Mapping[str, int]) -> str:
    """Return a label for a place along some dimensions: the values of their parameters."""
    point = ds.isel(places)
    names = [name for dim in places for name in parameters_along(ds, dim) or [dim]]
    return ", ".join(_equation(point[name]) for name in names)


def _equation(scalar: xr.DataArray) -> str:
    if scalar.dtype.kind not in "fiu":  # a direction, or the name of a result in a stack
        return DIRECTIONS.get(str(scalar.values), str(scalar.values))
    return shown(scalar).equation


def legend_label(ds: xr.Dataset, dim: str, index: int) -> str:
    """Return the label for a legend, with the kind of fluid for a rheological index."""
    label = slice_label(ds, {dim: index})
    return f"{fluid(float(ds[dim][index]))}, {label}" if dim == "rheological_index" else label


def fluid(gamma: float) -> str:
    """Return the kind of fluid that has this rheological index."""
    return "Newtonian" if gamma == 0 else "pseudoplastic" if gamma < 0 else "dilatant"


def parameters_along(ds: xr.Dataset, dim: str) -> list[str]:
    """Return the parameters that vary along a dimension: one, or those that cases link."""
    names = [str(name) for name in ds.coords if ds[name].dims == (dim,) and name in PARAMETERS]
    return sorted(names, key=lambda name: name != dim)


def changed_parameters(ds: xr.Dataset) -> str:
    """Return a sentence on the fixed parameters that differ from the paper's; empty if none does.

    Fitted parameters have another sentence, with their errors.
    """
    # One of them alone if the user has squeezed the fit.
    fitted = set(ds["free_parameter"].values.flat) if "free_parameter" in ds.coords else set()
    changed = [
        shown(ds[name].squeeze()).equation
        for name, parameter in PARAMETERS.items()
        if name in ds.variables
        and name not in fitted
        and ds[name].size == 1
        and not math.isclose(float(ds[name].values.flat[0]), parameter.default, rel_tol=1e-12)
    ]
    return f"With {', '.join(changed)}." if changed else ""


def typeset_units(units: str) -> str:
    r"""Return a UDUNITS string in mathtext, with a slash before divisors; empty for `1` or no unit.

    >>> typeset_units("m3 J-1 s-1")
    'm$^{3}$/(J$\\cdot$s)'
    """
    if units in ("1", ""):
        return ""
    powers = [_power(factor) for factor in units.split()]
    above = [_raised(unit, power) for unit, power in powers if power > 0]
    below = [_raised(unit, -power) for unit, power in powers if power < 0]
    product = r"$\cdot$".join(above) or "1"
    if not below:
        return product
    divisor = r"$\cdot$".join(below)
    return f"{product}/({divisor})" if len(below) > 1 else f"{product}/{divisor}"


def _power(factor: str) -> tuple[str, int]:
    match = re.fullmatch(r"(\D+?)(-?\d+)?", factor)
    return (match[1], int(match[2] or 1)) if match else (factor, 1)


def _raised(unit: str, power: int) -> str:
    return unit if power == 1 else f"{unit}$^{{{power}}}$"


def _number(value: float, rational: bool) -> str:
    """Return a number in mathtext; if `rational`, thirds, sevenths and the like are fractions."""
    if not math.isfinite(value):
        return r"\mathrm{nan}"
    plain = f"{value:.6g}"
    if rational and not math.isclose(float(plain), value, rel_tol=1e-12):
        fraction = Fraction(value).limit_denominator(_LARGEST_DENOMINATOR)
        if math.isclose(float(fraction), value, rel_tol=1e-9):
            return f"{fraction.numerator}/{fraction.denominator}"
    mantissa, _, exponent = plain.partition("e")
    return rf"{mantissa}\times10^{{{int(exponent)}}}" if exponent else mantissa
