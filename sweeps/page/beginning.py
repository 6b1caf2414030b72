"""The initial point of the page: the paper's, that of a config, or one of a result file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from stickslip.parameters import Parameters
from stickslip.symbols import plain
from stickslip.variables import PARAMETERS
from sweeps.charts.borders import require_borders_of
from sweeps.charts.labels import parameters_along, shown_number, slice_label
from sweeps.config.load import Config, from_mapping
from sweeps.config.schema import Integrator, Simulation
from sweeps.page.ranges import Scale, scales_of
from sweeps.points import Point, PointError, curve_or_map, point_of

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Opened:
    """A point to show: what computes it, what to call it, and its place in the file, if any."""

    point: Point
    label: str
    place: Mapping[str, int] | None = None

    @property
    def config(self) -> Config:
        """The config that asks for this point alone."""
        return self.point.config


@dataclass(frozen=True)
class Beginning:
    """The first point, the sliders and, of a file, the result to choose points from.

    `borders` are drawn on the map of the result.
    """

    name: str
    first: Opened
    scales: Mapping[str, Scale]
    result: xr.Dataset | None = None
    notes: tuple[str, ...] = ()
    borders: xr.Dataset | None = None


def of_nothing() -> Beginning:
    """The paper's values."""
    config = from_mapping({})
    return Beginning("", lone(with_parameters(config, config.parameters())), scales_of({}))


def of_config(config: Config, name: str) -> Beginning:
    """The fixed values of a config, the middle of its axes, its first case."""
    middle = {axis: values[len(values) // 2] for axis, values in config.sweep.items()}
    first = {linked: values[0] for linked, values in config.cases.items()}
    parameters = config.parameters()._replace(**middle, **first)
    alone, notes = _adaptive(with_parameters(config, parameters))
    return Beginning(name, lone(alone), scales_of({**config.sweep, **config.cases}), notes=notes)


def of_result(
    result: xr.Dataset,
    name: str,
    notes: tuple[str, ...] = (),
    borders: xr.Dataset | None = None,
) -> Beginning:
    """A result, opened in the middle of its axes.

    Raises PointError if it is no result of a sweep, or the borders are not its own.
    """
    result = curve_or_map(result)
    if borders is not None:
        try:
            require_borders_of(result, borders)
        except ValueError as error:
            raise PointError(plain(str(error))) from None
    middle = {str(dim): size // 2 for dim, size in result.sizes.items() if size > 1}
    first, more = _opened(result, middle)
    axes = {str(dim): parameters_along(result, str(dim)) for dim in middle}
    values = {n: result[n].values.tolist() for names in axes.values() for n in names}
    shown = result if middle else None
    return Beginning(name, first, scales_of(values), shown, (*notes, *more), borders)


def open_point(result: xr.Dataset, place: Mapping[str, int]) -> Opened:
    """The point of a result at a place along each of its axes."""
    return _opened(result, place)[0]


def lone(config: Config) -> Opened:
    """The point of a config without axes, which begins at its own initial values."""
    nothing, label = np.empty((0, len(Parameters._fields))), _in_words(config.parameters())
    return Opened(Point(config, label, stored={}, before=nothing), label)


def with_parameters(config: Config, parameters: Parameters) -> Config:
    """The config of one point and its stationary orbit."""
    return config.model_copy(
        update={
            "title": None,
            "model": parameters._asdict(),
            "sweep": {},
            "cases": {},
            "follow": None,
            "refine": None,
            "simulation": Simulation(),
        }
    )


def _opened(result: xr.Dataset, place: Mapping[str, int]) -> tuple[Opened, tuple[str, ...]]:
    point = point_of(result.isel(dict(place)))
    config, notes = _adaptive(with_parameters(point.config, point.parameters))
    # Of a point that another method computed there is nothing to compare with.
    stored = {} if notes else point.stored
    label = plain(slice_label(result, place)) or "the only point"
    return Opened(replace(point, config=config, stored=stored), label, place), notes


def _adaptive(config: Config) -> tuple[Config, tuple[str, ...]]:
    """The config with the adaptive method, and a note where it had another, too slow to follow."""
    method, adaptive = config.integrator.method, Integrator()
    if method == adaptive.method:
        return config, ()
    note = f"This page computes with the method {adaptive.method}, not with {method}."
    return config.model_copy(update={"integrator": adaptive}), (note,)


def changed_parameters(parameters: Parameters) -> dict[str, float]:
    """Return the parameters that are not the paper's."""
    values = parameters._asdict().items()
    return {name: value for name, value in values if value != PARAMETERS[name].default}


def _in_words(parameters: Parameters) -> str:
    """Return the parameters that are not the paper's in words, such as `T = 250 K`."""
    values = changed_parameters(parameters).items()
    changed = [plain(shown_number(name, value).equation) for name, value in values]
    return f"{', '.join(changed)}; the rest as in the paper" if changed else "the paper's values"
