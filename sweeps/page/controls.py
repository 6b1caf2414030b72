"""The controls of a page that computes: a slider and a box for every parameter, and settings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

from stickslip.options import FRICTION_LAWS, METHODS, NOISE_TREATMENTS, STRAINS
from stickslip.symbols import as_html, plain
from stickslip.variables import PARAMETERS, ParameterVariable
from sweeps.charts.labels import typeset_units
from sweeps.config.load import Config
from sweeps.config.numbers import number
from sweeps.page.ranges import Scale, exact_text

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
"""The parameters by group; the last group has all that no other one names."""

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
    called = f"{words}, {plain(unit)}" if unit else words
    slider = f'<input type="range" id="slider-{name}" step="any" aria-label="{words}">'
    box = f'<input type="text" id="box-{name}" aria-label="{escape(called)}" spellcheck="false">'
    symbol = f'<span class="symbol" title="{escape(_help(parameter))}">{_symbol(parameter)}</span>'
    return f'<div class="control">{symbol}{slider}{box}<span>{as_html(unit)}</span></div>'


def _menus(config: Config) -> Iterable[tuple[str, str, tuple[str, ...]]]:
    """Yield the key of each setting, its label and its values; of one value there is no choice."""
    rtol = exact_text(config.integrator.rtol)
    tolerances = dict.fromkeys([*map(exact_text, _TOLERANCES), rtol])
    yield "integrator.rtol", "tolerance (rtol), also of stationarity", tuple(tolerances)
    yield "noise.treatment", "noise", tuple(NOISE_TREATMENTS)
    if len(FRICTION_LAWS) > 1:
        yield "film.friction", "friction law", tuple(FRICTION_LAWS)
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
    """Return why a text is no value of a parameter, as a sentence; None where it is one."""
    try:
        value = read_number(text)
    except ValueError as error:
        return f"{name} {error}"
    why = PARAMETERS[name].complaint(value)
    return None if why is None else f"{name} {why}"


def read_number(text: str) -> float:
    """The number in a text as of `--set`; raises ValueError with the end of a sentence."""
    try:
        return float(text) + 0.0
    except ValueError:
        return number(text)


def _symbol(parameter: ParameterVariable) -> str:
    return as_html(f"${parameter.tex}$")


def units_of(parameter: ParameterVariable) -> str:
    """Return the unit of a parameter, in which its box takes numbers, in mathtext."""
    if parameter.name == "viscosity_coefficient":
        return r"Pa$\cdot$s$^{\gamma+1}$"  # Eq. 7
    return typeset_units(parameter.units)


def _help(parameter: ParameterVariable) -> str:
    default = f"{exact_text(parameter.default)} {plain(units_of(parameter))}".strip()
    comment = f" ({parameter.comment})" if parameter.comment else ""
    return f"{parameter.name}: {parameter.meaning}{comment}; in the paper {default}"
