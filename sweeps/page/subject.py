"""The subject of a page: its first point, and the points that it shows, as addresses and texts.

The end of an address gives a point as the `--set` options that change the paper's point to it, or
as `at.NAME` with its place in the file. The script of the page writes and reads the rest of the
address: what is chosen, kept and zoomed.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from stickslip.options import default_window
from stickslip.parameters import Parameters
from stickslip.symbols import plain
from stickslip.variables import PARAMETERS, canonical_name
from sweeps.charts.chart import require_borders_of
from sweeps.charts.choice import places_at
from sweeps.charts.labels import parameters_along, shown_number, slice_label
from sweeps.config.load import Config, from_mapping
from sweeps.config.schema import Integrator, Simulation
from sweeps.config.yaml_writer import block_yaml
from sweeps.page.controls import Scale, decimal_text, exact_text, scales_of
from sweeps.points import Point, PointError, Start, curve_or_map, point_at

_SECTIONS = ("integrator", "stationary", "noise", "film")  # of a config: how a point is computed
_AT = "at."


@dataclass(frozen=True)
class ShownPoint:
    """A point to show: how to compute it, its label, and its place in the file, if it has one."""

    point: Point
    label: str
    place: Mapping[str, int] | None = None

    @property
    def config(self) -> Config:
        """The config of this point alone."""
        return self.point.config


@dataclass(frozen=True)
class Subject:
    """The first point, the sliders and, for a file, the result from which to choose points.

    `borders` are drawn on the map of the result, which is the slice `at` some points of `source`.
    """

    name: str
    first: ShownPoint
    scales: Mapping[str, Scale]
    result: xr.Dataset | None = None
    notes: tuple[str, ...] = ()
    borders: xr.Dataset | None = None
    at: tuple[str, ...] = ()
    source: xr.Dataset | None = None


def subject_of_paper() -> Subject:
    """Return the paper's values as the subject of a page."""
    config = from_mapping({})
    return Subject("", point_alone(config, config.parameters()), scales_of({}))


def subject_of_config(config: Config, name: str) -> Subject:
    """Return the subject of a config; it opens in the middle of the axes, at the first case."""
    middle = {axis: values[len(values) // 2] for axis, values in config.sweep.items()}
    first = {linked: values[0] for linked, values in config.cases.items()}
    adaptive, notes = _adaptive(config)
    alone = point_alone(adaptive, config.parameters()._replace(**middle, **first))
    return Subject(name, alone, scales_of({**config.sweep, **config.cases}), notes=notes)


def subject_of_result(
    result: xr.Dataset,
    name: str,
    notes: tuple[str, ...] = (),
    borders: xr.Dataset | None = None,
    at: Sequence[str] = (),
    source: xr.Dataset | None = None,
) -> Subject:
    """Return the subject of a result, which opens in the middle of its axes.

    `source` is the whole file if the result is a slice `at` some of its points.

    Raises PointError if it is not the result of a sweep, or the borders belong to another result.
    """
    source, result = result if source is None else source, curve_or_map(result)
    if borders is not None:
        try:
            require_borders_of(result, borders)
        except ValueError as error:
            raise PointError(plain(str(error))) from None
    middle = {str(dim): size // 2 for dim, size in result.sizes.items() if size > 1}
    first, more = _point_and_notes(result, middle)
    names = [name for dim in middle for name in parameters_along(result, dim)]
    scales = scales_of({name: result[name].values.tolist() for name in names})
    notes = (*notes, *more)
    shown = result if middle else None
    return Subject(name, first, scales, shown, notes, borders, tuple(at), source)


def point_of_result(result: xr.Dataset, place: Mapping[str, int]) -> ShownPoint:
    """Return the point of a result at given places on its axes."""
    return _point_and_notes(result, place)[0]


def _point_and_notes(
    result: xr.Dataset, place: Mapping[str, int]
) -> tuple[ShownPoint, tuple[str, ...]]:
    point = point_at(result, place)
    config, notes = _adaptive(_config_of_point(point.config, point.parameters))
    if notes and point.loose:
        raise PointError(
            f"this result is a stack, and {notes[0][0].lower()}{notes[0][1:-1]}, so it cannot tell "
            "whether the config applies to a point; explore each original result"
        )
    # Numbers that another method computed are not compared.
    stored = {} if notes else point.stored
    label = plain(slice_label(result, place)) or "the only point"
    return ShownPoint(replace(point, config=config, stored=stored), label, place), notes


def point_alone(config: Config, parameters: Parameters) -> ShownPoint:
    """Return a point with the settings of a config that starts from its initial values."""
    changed = [
        plain(shown_number(name, value).equation)
        for name, value in _changed_parameters(parameters).items()
    ]
    label = f"{', '.join(changed)}; the rest as in the paper" if changed else "the paper's values"
    nothing = np.empty((0, len(Parameters._fields)))
    point = Point(_config_of_point(config, parameters), label, stored={}, before=nothing)
    return ShownPoint(point, label)


def _config_of_point(config: Config, parameters: Parameters) -> Config:
    """Return the config of one point and its stationary orbit."""
    alone: dict[str, Any] = {"title": None, "model": parameters._asdict(), "sweep": {}, "cases": {}}
    alone |= {"follow": None, "refine": None, "simulation": Simulation()}
    return config.model_copy(update=alone)


def _adaptive(config: Config) -> tuple[Config, tuple[str, ...]]:
    """Return the config with the adaptive method, and a note if it had another, slower method."""
    method, adaptive = config.integrator.method, Integrator()
    if method == adaptive.method:
        return config, ()
    note = f"This page computes with the method {adaptive.method}, not with {method}."
    return config.model_copy(update={"integrator": adaptive}), (note,)


# --- a point as text to copy: a config, or a command line -----------------------------------------


def config_text(shown_point: ShownPoint, periods: int = 1, start: Start = "stationary") -> str:
    """Return a config of the point alone, for `stickslip sweep` and `simulate`."""
    config = shown_point.config
    written: dict[str, Any] = {
        "model": _changed_parameters(config.parameters()),
        **_changed_settings(config),
        "simulation": {"periods": periods, "start": start},
    }
    return _remark(shown_point, "below") + block_yaml(written)


def command_text(shown_point: ShownPoint, periods: int = 1, start: Start = "stationary") -> str:
    """Return the command that computes the time courses of the point, over its orbit by default."""
    changes = _changes_text(shown_point) | {"simulation.start": start}
    words = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    command = shlex.join(["stickslip", "simulate", *words, "--periods", str(periods)])
    return _remark(shown_point, "of this command") + command


def _remark(shown_point: ShownPoint, where: str) -> str:
    """Return a comment on what the texts cannot express, if there is anything."""
    if not len(shown_point.point.before):
        return ""
    return (
        "# In the file this point starts from the orbit of its neighbour. From the initial\n"
        f"# values {where} it may reach another orbit.\n"
    )


def _changes_text(shown_point: ShownPoint) -> dict[str, str]:
    """Return the keys and values that change the paper's point to this one, as for `--set`."""
    changed = _changed_parameters(shown_point.point.parameters)
    changes = {name: exact_text(value) for name, value in changed.items()}
    for section, keys in _changed_settings(shown_point.config).items():
        changes |= {f"{section}.{key}": _text(value) for key, value in keys.items()}
    return changes


def _changed_parameters(parameters: Parameters) -> dict[str, float]:
    """Return the parameters that differ from the paper's."""
    values = parameters._asdict().items()
    return {name: value for name, value in values if value != PARAMETERS[name].default}


def _changed_settings(config: Config) -> dict[str, dict[str, Any]]:
    """Return the keys, by section, that are not at their defaults."""
    default = from_mapping({})
    window = {"window": default_window(config.noise.treatment)}
    stationary = default.stationary.model_copy(update=window)
    default = default.model_copy(update={"stationary": stationary})
    changed = {}
    for section in _SECTIONS:
        usual, values = (getattr(one, section).used() for one in (default, config))
        changed[section] = {k: v for k, v in values.items() if usual.get(k, ...) != v}
    return {section: keys for section, keys in changed.items() if keys}


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return exact_text(value) if isinstance(value, float) else str(value)


# --- a point as the end of an address -------------------------------------------------------------


def changes_of(shown_point: ShownPoint) -> dict[str, str]:
    """Return the changes from the paper's point to this one, and in any case the temperature."""
    usual = {"temperature": exact_text(shown_point.point.parameters.temperature)}
    return usual | _changes_text(shown_point)


def place_of(shown_point: ShownPoint, result: xr.Dataset | None) -> dict[str, str] | None:
    """Return the place of a point in the file, as `at.NAME` and values; None for other points."""
    if shown_point.place is None or result is None:
        return None
    values = {dim: result[dim].values[at] for dim, at in shown_point.place.items()}
    return {
        # The script of the page, which looks for it along the axis, does not read -2/3.
        _AT + dim: decimal_text(float(value)) if value.dtype.kind in "fiu" else str(value)
        for dim, value in values.items()
    }


def point_of_address(parts: Mapping[str, str], result: xr.Dataset | None) -> ShownPoint:
    """Return the point that an address names.

    Raises ConfigError for a bad value, and PointError for a key that is neither a parameter nor a
    setting, or for a place that the file does not have.
    """
    place = {k.removeprefix(_AT): part for k, part in parts.items() if k.startswith(_AT)}
    if place:
        if result is None:
            raise PointError("this page has no result file, so it cannot open a point from one")
        try:
            at = places_at(result, [f"{name}={value}" for name, value in place.items()])
        except ValueError as error:
            raise PointError(str(error)) from None
        if left := [d for d, size in result.sizes.items() if size > 1 and d not in at]:
            raise PointError(f"several points remain: at.{left[0]} is missing")
        return point_of_result(result, at)
    for key in parts:  # most importantly, refuse keys that name a file to read
        section, dot, _ = key.partition(".")
        if not (section in _SECTIONS if dot else canonical_name(key)):
            raise PointError(f"{key} is neither a parameter nor a setting")
    config = from_mapping({}, overrides=[f"{key}={part}" for key, part in parts.items()])
    if config.sweep or config.cases:
        raise PointError("an address must have a single value for each parameter")
    return point_alone(config, config.parameters())
