"""The controls of a served page: a slider and a box for every parameter, and settings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from html import escape
from typing import Any

import numpy as np

from stickslip.options import FRICTION_LAWS, METHODS, NOISE_TREATMENTS, STRAINS
from stickslip.symbols import as_html, plain
from stickslip.variables import PARAMETERS, ParameterVariable
from sweeps.charts.axes import is_even, is_geometric
from sweeps.charts.labels import typeset_units
from sweeps.config.load import Config
from sweeps.config.numbers import number

GROUPS: dict[str, tuple[str, ...]] = {
    "": (
        "temperature",
        "viscosity_coefficient",
        "spring_stiffness",
        "rheological_index",
        "angular_frequency",
        "drive_amplitude",
    ),
    "Block and start": (
        "block_mass",
        "initial_displacement",
        "initial_velocity",
        "initial_order_parameter",
    ),
    "Film": ("film_thickness", "contact_area", "strain_relaxation_time"),
}
GROUPS["Free energy, kinetics, noise"] = tuple(
    name for name in PARAMETERS if not any(name in group for group in GROUPS.values())
)
"""The parameters by group; the last group has all others."""

_TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)


def controls_html(config: Config) -> str:
    """Return a slider and a box for every parameter, and a menu for every setting."""
    groups = []
    for title, names in GROUPS.items():
        rows = "".join(map(_row, names))
        groups.append(f"<details><summary>{title}</summary>{rows}</details>" if title else rows)
    menus = "".join(_menu(*menu) for menu in _menus(config))
    return "".join(groups) + f"<details><summary>How it is computed</summary>{menus}</details>"


def _row(name: str) -> str:
    parameter = PARAMETERS[name]
    words, unit = name.replace("_", " "), units_of(parameter)
    default = f"{exact_text(parameter.default)} {plain(unit)}".strip()
    comment = f" ({parameter.comment})" if parameter.comment else ""
    title = escape(f"{name}: {parameter.meaning}{comment}; by default {default}")
    called = escape(f"{words}, {plain(unit)}" if unit else words)
    symbol = f'<span class="symbol" title="{title}">{as_html(f"${parameter.tex}$")}</span>'
    slider = f'<input type="range" id="slider-{name}" step="any" aria-label="{words}">'
    box = f'<input type="text" id="box-{name}" aria-label="{called}" spellcheck="false">'
    return f'<div class="control">{symbol}{slider}{box}<span>{as_html(unit)}</span></div>'


def _menus(config: Config) -> Iterable[tuple[str, str, tuple[str, ...]]]:
    """Yield the key, label and values of each setting that has more than one value."""
    rtol = exact_text(config.integrator.rtol)
    tolerances = dict.fromkeys([*map(exact_text, _TOLERANCES), rtol])
    yield "integrator.rtol", "tolerance (rtol), also for stationarity", tuple(tolerances)
    yield "noise.treatment", "noise", tuple(NOISE_TREATMENTS)
    laws = dict.fromkeys([*FRICTION_LAWS, config.film.friction])  # it may be that of a package
    if len(laws) > 1:
        yield "film.friction", "friction law", tuple(laws)
    known = tuple(name for name in STRAINS if name in METHODS[config.integrator.method].strains)
    if len(known) > 1:
        yield "film.strain", "strain", known


def _menu(key: str, label: str, values: Iterable[str]) -> str:
    options = "".join(f"<option>{escape(value)}</option>" for value in values)
    return f'<label class="menu">{label}<select data-setting="{key}">{options}</select></label>'


def scales_data(scales: Mapping[str, Scale]) -> dict[str, Any]:
    """Return the ranges of the sliders, for the script of the page."""
    return {
        name: {"low": s.lower, "high": s.upper, "log": s.logarithmic, "step": s.step}
        for name, s in scales.items()
    }


def settings_of(config: Config) -> dict[str, str]:
    """Return the value of each setting, by its key."""
    return {
        "integrator.rtol": exact_text(config.integrator.rtol),
        "noise.treatment": config.noise.treatment,
        "film.friction": config.film.friction,
        "film.strain": config.film.strain,
    }


def complaint_of(name: str, text: str) -> str | None:
    """Return a sentence on why a text is not a valid value of a parameter; None if it is valid."""
    try:
        value = read_number(text)
    except ValueError as error:
        return f"{name} {error}"
    why = PARAMETERS[name].complaint(value)
    return None if why is None else f"{name} {why}"


def read_number(text: str) -> float:
    """Return the number in a text, as `--set` reads it; raises ValueError with half a sentence."""
    if "_" in text or not text.isascii():  # float() reads these, and YAML does not
        return number(text)
    try:
        return float(text) + 0.0
    except ValueError:
        return number(text)


def units_of(parameter: ParameterVariable) -> str:
    """Return the unit of the numbers in the box of a parameter, in mathtext."""
    if parameter.name == "viscosity_coefficient":
        return r"Pa$\cdot$s$^{\gamma+1}$"  # Eq. 7
    return typeset_units(parameter.units)


# --- the values that a slider reaches, and their texts --------------------------------------------

_STEPS = 200  # of a linear slider, or up to 2.5 times as many
_DECADE = 100  # steps of a logarithmic slider over a factor of ten
_WIDE = 100.0  # the factor from the default to the ends of a slider that is not in the table
_LARGEST_DENOMINATOR, _LARGEST_FRACTION = 12, 2  # beyond them, a decimal is easier to read
_LONGEST = 9  # characters that a box shows
_SMALL = 1e-3  # smaller numbers are written with an exponent


@dataclass(frozen=True)
class Scale:
    """The values of a slider from `lower` to `upper`, evenly spaced, or in their logarithm."""

    lower: float
    upper: float
    logarithmic: bool = False

    @property
    def step(self) -> float:
        """The distance between neighbouring positions, which are values or logarithms of them."""
        if self.logarithmic:
            return 1.0 / _DECADE
        fine = (self.upper - self.lower) / _STEPS
        power = 10.0 ** math.floor(math.log10(fine))
        return next(factor * power for factor in (5.0, 2.0, 1.0) if factor * power <= fine * 1.001)

    def reaching(self, value: float) -> Scale:
        """Return this slider, extended if necessary to reach a value of its kind."""
        if self.logarithmic and value <= 0.0:
            return self
        return replace(self, lower=min(self.lower, value), upper=max(self.upper, value))


# Where one might look for a lubricant; the paper's values lie well inside.
_SCALES = {
    "temperature": Scale(100.0, 350.0),
    "viscosity_coefficient": Scale(1e3, 1e7, logarithmic=True),
    "spring_stiffness": Scale(10.0, 1e5, logarithmic=True),
    "rheological_index": Scale(-0.95, 1.0),
    "angular_frequency": Scale(0.1, 1e3, logarithmic=True),
    "drive_amplitude": Scale(1e-8, 1e-4, logarithmic=True),
    "initial_displacement": Scale(-2e-6, 2e-6),
    "initial_velocity": Scale(-2e-5, 2e-5),
    "initial_order_parameter": Scale(0.0, 1.0),
    "critical_temperature": Scale(200.0, 400.0),
    "noise_intensity": Scale(1e-30, 1e-6, logarithmic=True),
}


def scale_of(name: str) -> Scale:
    """Return the slider of a parameter; if it is not in the table, its default gives the range."""
    if name in _SCALES:
        return _SCALES[name]
    parameter = PARAMETERS[name]
    if parameter.default > 0.0 and parameter.lower >= 0.0:
        return Scale(parameter.default / _WIDE, parameter.default * _WIDE, logarithmic=True)
    reach = _WIDE * abs(parameter.default) or 1.0
    return Scale(max(-reach, parameter.lower), min(reach, parameter.upper))


def scale_of_axis(name: str, values: Sequence[float]) -> Scale:
    """Return the slider of a parameter that a sweep varies, from its lowest to highest value."""
    ordered = np.unique(np.array(values, dtype=float))
    low, high = float(ordered[0]), float(ordered[-1])
    if low == high:
        return scale_of(name).reaching(low)
    wanted = scale_of(name).logarithmic and low > 0.0 and not is_even(ordered)
    return Scale(low, high, logarithmic=wanted or is_geometric(ordered))


def scales_of(axes: Mapping[str, Sequence[float]]) -> dict[str, Scale]:
    """Return the slider of each parameter; `axes` has the values of those that a sweep varies."""
    return {
        name: scale_of_axis(name, axes[name]) if name in axes else scale_of(name)
        for name in PARAMETERS
    }


def exact_text(value: float) -> str:
    """Return the shortest text that reads as the same number, such as `8e-7` or `-2/3`."""
    short = _rounded(value)
    if float(short) == value:
        return short
    fraction = Fraction(value).limit_denominator(_LARGEST_DENOMINATOR)
    if abs(fraction) < _LARGEST_FRACTION and float(fraction) == value:
        return str(fraction)
    return decimal_text(value)


def decimal_text(value: float) -> str:
    """Return the shortest decimal that reads as the same number, such as `-0.6666666666666666`."""
    return _tidied(repr(value))


def short_text(value: float) -> str:
    """Return a number as a box shows it: `exact_text` or, if that is too long, six digits."""
    exact = exact_text(value)
    return exact if len(exact) <= _LONGEST else _rounded(value)


def _rounded(value: float) -> str:
    """Return a number rounded to six digits."""
    return _tidied(f"{value:.5e}" if 0.0 < abs(value) < _SMALL else f"{value:.6g}")


def _tidied(written: str) -> str:
    """Return a number without zeros at the end of its digits and the start of its exponent."""
    mantissa, _, exponent = written.partition("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return f"{mantissa}e{int(exponent)}" if exponent else mantissa
