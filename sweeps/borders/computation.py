"""The kinds of motion on a map, and the points computed between its points to find borders."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dispatch.ask import ask
from stickslip.dispatch.backend import own_workers
from stickslip.dispatch.compilation import compile_kinds
from stickslip.dispatch.in_flight import InFlight
from stickslip.dispatch.listed import Listed
from stickslip.dispatch.task import Block
from stickslip.kernels.families import KIND
from stickslip.options import OPTIONS, Options
from stickslip.parameters import Parameters
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS, RESULTS
from sweeps.borders.crossings import NO_KIND, Axis, Bisection, Crossings, Floats, Kinds
from sweeps.charts.axes import is_geometric
from sweeps.charts.choice import refuse_empty
from sweeps.charts.missing import trusted
from sweeps.config.load import Config, ConfigError, from_mapping
from sweeps.config.schema import Execution
from sweeps.config.yaml_reader import read_mapping
from sweeps.engine.progress import in_flight_text
from sweeps.engine.settings import SOURCE, options_of
from sweeps.exits import ExpectedError
from sweeps.grid import DIRECTION, Grid
from sweeps.human import clock, counted
from sweeps.points import Point, PointError, config_of, curve_or_map, point_of

Kind = Literal["regime", "orbit"]

# The bits of each part in the number of a kind, the last part lowest: numbers sort by regime.
_BITS = {"regime": 8, "orbit_periods": 16, "melting_count": 31}

PARTS: dict[str, tuple[str, ...]] = {"regime": ("regime",), "orbit": tuple(_BITS)}
"""The result variables in which motions of different kinds differ."""

NEEDED = ("status", "regime", "orbit_periods", "melting_count")
"""The result variables that determine the kind of a motion."""

_RESULTS = [status for status in Status if status.is_result]

_KIND = [Parameters._fields.index(name) for name in KIND]

PATIENT, LIMIT = 1e-3, 128
"""A bracket wider than this fraction of its axis waits for its middle, however slow that is.

A narrower one stays as it is if its middle has not reached its orbit after `LIMIT` drive periods
(docs/decisions/borders.md). No motion is called aperiodic after so few periods.
"""


def numbered(values: Callable[[str], NDArray[np.generic]], kind: Kind) -> NDArray[np.int64]:
    """Return kinds of motion as numbers, `NO_KIND` for points without a result.

    `values` returns a result variable by name, in any shape. The counts of an aperiodic motion are
    left out, because they depend on when it is observed.
    """
    missing = RESULTS["regime"].missing
    regime = np.nan_to_num(values("regime"), nan=missing).astype(np.int64)  # NaN: masked by `ok`
    known = np.isin(values("status"), _RESULTS) & (regime != missing)
    numbers = np.zeros(regime.shape, dtype=np.int64)
    for name, bits in _BITS.items():
        counts = name == "regime" or (kind == "orbit" and regime != Regime.APERIODIC)
        part = np.where(known & counts, values(name), 0).astype(np.int64)
        numbers = (numbers << bits) + part
    return np.where(known, numbers, NO_KIND)


def part_of(numbers: NDArray[np.int64], name: str) -> NDArray[np.int64]:
    """Return one part, the regimes or a count, of kinds given as numbers."""
    later = list(_BITS)[list(_BITS).index(name) + 1 :]
    return (numbers >> sum(_BITS[other] for other in later)) % (1 << _BITS[name])


class BoundaryError(ExpectedError, ValueError):
    """A result whose borders cannot be computed; the message says why, and what would help."""


class Bisecting:
    """The progress of a bisection: the points computed, and those known to follow.

    An edge that turns out to cross two borders needs more points.
    """

    def __init__(self) -> None:
        self.done, self.left, self.in_flight = 0, 0, InFlight()
        self._begun = time.monotonic()

    @property
    def goal(self) -> int:
        """The number of points computed and of those known to follow."""
        return self.done + self.left

    @property
    def headline(self) -> str:
        """The numbers of points, and the time."""
        elapsed, points = clock(time.monotonic() - self._begun), counted(self.goal, "point")
        return f"bisecting: {self.done} of about {points}, {elapsed} elapsed"

    @property
    def outlook(self) -> str:
        """The points in flight, which take a long time near a motion that never closes."""
        return in_flight_text(self.in_flight)


@dataclass(frozen=True)
class Map:
    """A result over one axis or two, between whose points others can be computed.

    `config` describes its first point alone; `kinds` and `multipliers` have the shape of the map.
    """

    names: tuple[str, ...]
    axes: tuple[Axis, ...]
    kinds: Kinds
    multipliers: Floats
    config: Config
    kind: Kind
    workers: int
    progress: Bisecting = field(default_factory=Bisecting)

    def crossings(self, accuracy: float) -> Crossings:
        """Return where borders cross the edges of the map, in brackets of at most `accuracy`.

        The bisection of a narrow bracket ends at a slow middle; see `PATIENT`.
        """
        bisection = Bisection(self.axes, self.kinds, self.multipliers, accuracy, pause=PATIENT)
        points = Listed(self.workers)
        self._bisect(bisection, points)
        bisection.resume()
        self._bisect(bisection, points, limit=LIMIT)
        return bisection.crossings()

    def _bisect(self, bisection: Bisection, points: Listed, *, limit: int = 0) -> None:
        """Compute the middles of brackets, with a list that grows until no more are needed."""
        self._add(points, bisection.middles(len(points)))
        for block in self._computed(points, limit=limit):
            bisection.take_in(block.indices, *self._seen(block))
            self._add(points, bisection.middles(len(points)))
            self.progress.left = bisection.left

    def kinds_at(self, places: Floats) -> Kinds:
        """Return the kinds (n,) at places (n, axes) of the map."""
        kinds, points = np.empty(len(places), dtype=np.int64), Listed(self.workers)
        self._add(points, places)
        for block in self._computed(points):
            kinds[block.indices], _ = self._seen(block)
        return kinds

    @property
    def _options(self) -> Options:
        """The options of the map, with the shortest window.

        For a motion that never closes, only the kind is needed. The growth of its neighbours
        decides the kind, over the same periods for any window; a longer window only improves the
        statistics.
        """
        shortest = int(OPTIONS["window"].range.lower)
        return replace(options_of(self.config), window=shortest)

    def _add(self, points: Listed, places: Floats) -> None:
        """Add the points at places (n, axes) to a list, and compile the kernels they need."""
        if not len(places):
            return
        rows = np.tile(np.array(self.config.parameters()), (len(places), 1))
        rows[:, [Parameters._fields.index(name) for name in self.names]] = places
        if not len(points) or not set(KIND).isdisjoint(self.names):
            # Otherwise all threads would wait for the first one to compile.
            compile_kinds(self._options, rows[:, _KIND])
        points.add(rows)

    def _computed(self, points: Listed, *, limit: int = 0) -> Iterator[Block]:
        """Yield the blocks of a list of points, which may grow in the meantime."""
        flying = self.progress.in_flight = InFlight()
        with own_workers(self.workers) as workers:
            for block in ask(
                points.rows, points, self._options, workers, in_flight=flying, limit=limit
            ):
                self.progress.done += len(block.indices)
                yield block

    def _seen(self, block: Block) -> tuple[Kinds, Floats]:
        """Return the kinds (n,) and the multipliers (n,) of a block's points."""
        found = dict(zip(RESULT_COLUMNS, block.results.T, strict=True))
        return numbered(found.__getitem__, self.kind), found["floquet_multiplier"]


def map_of(ds: xr.Dataset, kind: Kind, workers: int | None = None) -> Map:
    """Return a result as a map, with increasing axes.

    Raises BoundaryError if the result is not a map, or its points depend on more than parameters.
    """
    if "config" not in ds.attrs or (lacking := [n for n in NEEDED if n not in ds.variables]):
        what = f"lacks {', '.join(lacking)}" if "config" in ds.attrs else "has no config"
        raise BoundaryError(f"this is not the result of a sweep: it {what}")
    try:
        refuse_empty(ds)
        ds = curve_or_map(ds)
    except ValueError as error:
        raise BoundaryError(str(error)) from None
    names = _axes_of(ds)
    ds = ds.squeeze().sortby(list(names)).transpose(*names)
    config = _config_of(ds)
    _refuse_other_settings(ds)
    multipliers = ds.get("floquet_multiplier", xr.full_like(ds["status"], np.nan, dtype=float))
    return Map(
        names=names,
        axes=tuple(Axis(ds[name].values, is_geometric(ds[name].values)) for name in names),
        kinds=numbered(lambda name: ds[name].values, kind),
        multipliers=multipliers.values,
        config=config,
        kind=kind,
        workers=workers or Execution().slots,
    )


def _axes_of(ds: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the one or two parameters that vary."""
    if DIRECTION in ds.coords:
        raise BoundaryError(
            "points of a followed axis start from their neighbours, so points between them have "
            "no motion of their own: sweep without `follow`"
        )
    names = tuple(str(dim) for dim, size in ds.sizes.items() if size > 1)
    if not 1 <= len(names) <= 2:
        several = f"this result varies along {', '.join(names) or 'nothing'}"
        raise BoundaryError(
            f"borders need one axis or two, but {several}"
            + ("; select a point of the others first, as with --at K=1000 or sel()" * bool(names))
        )
    varying = [name for name in PARAMETERS if name in ds.coords and ds[name].size > 1]
    if sorted(varying) != sorted(names):
        raise BoundaryError(
            "borders need axes of single parameters: there are no points between linked cases; "
            "select a case first, as with --at case=0"
        )
    return names


def _config_of(ds: xr.Dataset) -> Config:
    """Return the config of the first point of a map."""
    known = [name for name in PARAMETERS if name in ds.variables]
    model = {name: float(ds[name].values.flat[0]) for name in known}
    try:
        config = config_of(ds, model)
    except PointError as error:
        raise BoundaryError(str(error)) from None
    except ConfigError as error:
        raise BoundaryError(f"the config of this result cannot be read:\n{error}") from None
    if options_of(config).physics.chance:
        raise BoundaryError(
            "a stochastic film has no borders: its kind of motion is that of the typical path; "
            "sweep with `noise: {treatment: typical-path}`"
        )
    return config


def _refuse_other_settings(ds: xr.Dataset) -> None:
    """Raise BoundaryError if points of a map were computed with settings other than its config's.

    A stack of results has the config of its first. So one point of the map is computed again, and
    one at each value that the config does not name.
    """
    grid = Grid.from_config(from_mapping(read_mapping(str(ds.attrs["config"]), SOURCE), SOURCE))
    parts = [ds]
    for name in map(str, ds["status"].dims):
        named = np.isclose(ds[name].values[:, None], grid.values(name), 1e-9, 0.0).any(axis=1)
        parts += [ds.isel({name: place}) for place in np.flatnonzero(~named)]
    for part in parts:
        if why := next((point.other_settings() for point in _quickest(part)), ""):
            raise BoundaryError(f"{why}; compute the borders of each original result")


def _quickest(part: xr.Dataset) -> Iterator[Point]:
    """Yield the computed point that took the fewest periods; none if no point has a result."""
    if "periods_integrated" not in part:
        return
    periods = trusted(part, "periods_integrated").where(part["status"] != Status.INTERPOLATED)
    for place in np.argwhere(periods.values == np.fmin.reduce(periods.values, axis=None))[:1]:
        yield point_of(part.isel(dict(zip(periods.dims, place, strict=True))))
