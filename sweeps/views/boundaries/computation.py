"""The points of a map that are computed to find its borders, as its sweep would compute them."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import ClassVar

import joblib
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.compiled.cache import source_hash
from stickslip.compiled.simd import LANES
from stickslip.kernels.families import KIND
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS
from sweeps.config.load import Config, ConfigError
from sweeps.config.schema import Execution
from sweeps.engine.executors.kernels import compile_kinds
from sweeps.engine.executors.worker import Task, compute_block
from sweeps.engine.settings import options_of
from sweeps.exits import ExpectedError
from sweeps.figures.layout import is_geometric
from sweeps.files.columns import STATUS
from sweeps.grid import DIRECTION
from sweeps.human import clock, counted
from sweeps.views.boundaries.bisection import LATE, Axis, Floats, Kinds
from sweeps.views.boundaries.kinds import NEEDED, Kind, numbered
from sweeps.views.points import config_of, config_without_axes, curve_or_map

# Drive periods. Near a border a few points take thousands, and one that goes on alone costs as much
# as a core full of them: they wait for each other.
_PATIENCE = 64

# Of quick points each worker gets several shares, so that all end at about the same time.
_SHARES = 4

_KIND = [Parameters._fields.index(name) for name in KIND]


class BoundaryError(ExpectedError, ValueError):
    """A result whose borders cannot be computed; the message says why, and what would help."""


class Bisecting:
    """Says how many points have been computed; how many it will be, nobody knows."""

    goal: ClassVar[None] = None
    outlook: ClassVar[str] = ""

    def __init__(self) -> None:
        self.done = 0
        self._begun = time.monotonic()

    @property
    def headline(self) -> str:
        """The number of points so far, and the time."""
        return f"bisecting: {counted(self.done, 'point')} ({clock(time.monotonic() - self._begun)})"


@dataclass(frozen=True)
class Map:
    """A result over one axis or two, from which other points between its own can be computed.

    `config` asks for its first point alone; `kinds` and `multipliers` have the shape of the map.
    """

    names: tuple[str, ...]
    axes: tuple[Axis, ...]
    kinds: Kinds
    multipliers: Floats
    config: Config
    kind: Kind
    workers: int
    progress: Bisecting = field(default_factory=Bisecting)

    def look(self, places: Floats, patient: bool = True) -> tuple[Kinds, Floats]:
        """Compute the points at some places (n, axes); returns their kinds and multipliers (n,).

        Unless one is `patient`, points that take far longer than most are `LATE`.
        """
        point = self.config.parameters()
        rows = np.tile(np.array(point), (len(places), 1))
        columns = [Parameters._fields.index(name) for name in self.names]
        rows[:, columns] = places
        # Threads would wait for the first of them to compile.
        compile_kinds(options_of(self.config), rows[:, _KIND])
        results = self._computed(rows, 0 if patient else _PATIENCE)
        found = dict(zip(RESULT_COLUMNS, results.T, strict=True))
        kinds = numbered(found.__getitem__, self.kind)
        late = found["status"] == Status.PENDING
        return np.where(late, LATE, kinds), found["floquet_multiplier"]

    def _computed(self, points: NDArray[np.float64], patience: int) -> NDArray[np.float64]:
        """Return the result rows (n, columns) of points (n, parameters), computed in threads."""
        options, shares = options_of(self.config), self.workers * (_SHARES if patience else 1)
        count = max(1, min(shares, len(points) // LANES))
        results = np.empty((len(points), len(RESULT_COLUMNS)))
        tasks = [
            Task(share, points[share], options, source_hash(), patience=patience)
            for share in (np.arange(first, len(points), count) for first in range(count))
        ]
        parallel = joblib.Parallel(self.workers, require="sharedmem")
        for block in parallel(joblib.delayed(compute_block)(task) for task in tasks):
            results[block.indices] = block.results
            finished = block.results[:, STATUS] != Status.PENDING
            self.progress.done += int(finished.sum())
        return results


def map_of(ds: xr.Dataset, kind: Kind, workers: int | None = None) -> Map:
    """Return the map that a result is; its axes become increasing.

    Raises BoundaryError if it is none, or if its points depend on more than their parameters.
    """
    if "config" not in ds.attrs or (lacking := [n for n in NEEDED if n not in ds.variables]):
        what = f"lacks {', '.join(lacking)}" if "config" in ds.attrs else "has no config"
        raise BoundaryError(f"this is no result of a sweep: it {what}")
    ds = curve_or_map(ds)
    names = _axes_of(ds)
    ds = ds.squeeze().sortby(list(names)).transpose(*names)
    multipliers = ds.get("floquet_multiplier", xr.full_like(ds["status"], np.nan, dtype=float))
    return Map(
        names=names,
        axes=tuple(_axis(ds[name].values) for name in names),
        kinds=numbered(lambda name: ds[name].values, kind),
        multipliers=multipliers.values,
        config=_config_of(ds),
        kind=kind,
        workers=workers or Execution().slots,
    )


def _axes_of(ds: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the one or two parameters along which points differ."""
    if DIRECTION in ds.coords:
        raise BoundaryError(
            "points of a followed axis start from their neighbours, so that those between them "
            "have no motion of their own: sweep without `follow`"
        )
    names = tuple(str(dim) for dim, size in ds.sizes.items() if size > 1)
    if not 1 <= len(names) <= 2:
        several = f"this result varies along {', '.join(names) or 'nothing'}"
        raise BoundaryError(
            f"borders need one axis or two, and {several}"
            + ("; select a point of the others first, as with --at K=1000 or sel()" * bool(names))
        )
    varying = [name for name in PARAMETERS if name in ds.coords and ds[name].size > 1]
    if sorted(varying) != sorted(names):
        raise BoundaryError(
            "borders need axes of single parameters: between linked cases there are no points; "
            "select a case first, as with --at case=0"
        )
    return names


def _axis(values: Floats) -> Axis:
    return Axis(values, is_geometric(values))


def _config_of(ds: xr.Dataset) -> Config:
    """Return the config of the first point of a map."""
    known = [name for name in PARAMETERS if name in ds.variables]
    model = {name: float(ds[name].values.flat[0]) for name in known}
    try:
        config = config_of(config_without_axes(str(ds.attrs["config"])), model)
    except ConfigError as error:
        raise BoundaryError(f"the config of this result cannot be read:\n{error}") from None
    if options_of(config).physics.chance:
        raise BoundaryError(
            "a stochastic film has no border: its kind is that of the typical path; "
            "sweep with `noise: {treatment: typical-path}`"
        )
    return config
