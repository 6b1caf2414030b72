"""The points of a result, computed again from the file or Dataset alone: orbits and motions."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip import IntegrationError, NoiseError
from stickslip.datasets import result_values
from stickslip.dispatch.lines import remember_starts, start_after
from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.orbit import Orbit, compute_orbits, orbit_of_row
from stickslip.parameters import Parameters
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.tables import value_table
from stickslip.trajectory import REALIZATION
from stickslip.variables import PARAMETERS, RESULT_COLUMNS, RESULTS, STROBOSCOPIC
from sweeps.charts.choice import places_at, with_numbers
from sweeps.config.load import Config, ConfigError, from_mapping
from sweeps.config.schema import Execution
from sweeps.config.yaml_reader import read_mapping
from sweeps.engine.settings import SOURCE, config_without_axes, options_of
from sweeps.engine.trajectories import trajectory
from sweeps.exits import ExpectedError
from sweeps.files.attributes import software
from sweeps.grid import CASE, DIRECTION, DIRECTIONS, Grid
from sweeps.identity import PointKeys

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Start = Literal["initial", "stationary"]

# They show that a point was computed with other settings, and have no other unit to convert to.
_TELLTALE = ("status", "periods_integrated", "amplitude_error")
_ROUNDED = 1e-5  # relative: a Dataset in single precision is the same

# Drive periods that are shown of an orbit that does not close, and of one that was not found.
_APERIODIC_PERIODS, _FAILED_PERIODS = 20, 6

_OWN_DIMS = {*PARAMETERS, CASE, DIRECTION}
_IN_PAPER = {name for name, parameter in PARAMETERS.items() if parameter.in_paper}


# What the points of files that are of another version, or were edited, have raised.
_OBSTACLES = (ExpectedError, IntegrationError, NoiseError, ArithmeticError, ValueError)


class PointError(ExpectedError, ValueError):
    """No one point of a result is meant, or it cannot be computed again; the message says why."""


@dataclass(frozen=True, repr=False)
class Point:
    """A point of a result, which can be computed again; made by `point_of`.

    `config` asks for this point alone; `where` names it in words. `stored` are the values of its
    result variables, as the file has them; `before` (n, parameters) the points of a followed line
    that lead to it. `versions` names what the numbers depend on and is different here. Of a `loose`
    point, from a Dataset that may be made of several results, the config may be that of another.
    """

    config: Config
    where: str
    stored: Mapping[str, float]
    before: NDArray[np.float64]
    versions: tuple[str, ...] = ()
    loose: bool = False

    def __repr__(self) -> str:
        return f"<Point {self.where}: {self.status.name.lower()}>"

    def _repr_html_(self) -> str:
        flags = {"status": self.status, "regime": Regime(int(self.stored.get("regime", 127)))}
        shown = {name: flags.get(name, value) for name, value in self.stored.items()}
        return f"<p>{self.where}</p>{value_table(shown, RESULTS)}"

    @property
    def parameters(self) -> Parameters:
        """All parameters of the point."""
        return self.config.parameters()

    @property
    def status(self) -> Status:
        """The status of the point in the file."""
        return Status(int(self.stored["status"]))

    @property
    def is_comparable(self) -> bool:
        """True if the file holds numbers that were computed for this point."""
        return self.status not in (Status.INTERPOLATED, Status.PENDING)

    @cached_property
    def _start(self) -> NDArray[np.float64]:
        """The state (final columns,) that it starts from; NaN for the one of its parameters."""
        return start_after(self.before, options_of(self.config))

    @cached_property
    def _computed(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        point = np.array([self.parameters])
        rows, finals = compute_orbits(point, options_of(self.config), self._start[None])
        return rows[0], finals[0]

    def orbit(self) -> Orbit:
        """The stationary orbit, computed again: the bits of the file, by the same version.

        Raises PointError if the config of the Dataset is not the one of its numbers.
        """
        # The stored values may have been made with other settings than those of the config.
        for name, (stored, computed) in self.differences().items() if self.loose else ():
            near = np.isclose(stored, computed, rtol=_ROUNDED, atol=0.0)
            if name in _TELLTALE and not near and not self.versions:
                raise PointError(
                    f"{self.where}: the Dataset has {name} {stored:g}, and its config gives "
                    f"{computed:g}: it was made of results with other settings, or changed; take "
                    "the point from the result that it comes from"
                )
        return orbit_of_row(*self._computed)

    def differences(self) -> dict[str, tuple[float, float]]:
        """The result variables whose computed value is not the stored one, with (stored, computed).

        A point that was interpolated is compared in nothing.
        """
        if not self.is_comparable:
            return {}
        row = dict(zip(RESULT_COLUMNS, self._computed[0], strict=True))
        computed = {name: result_values(name, value[None]).item() for name, value in row.items()}
        pairs = {name: (value, computed[name]) for name, value in self.stored.items()}
        return {  # all NaNs are equal
            name: (stored, now)
            for name, (stored, now) in pairs.items()
            if stored != now and not (np.isnan(stored) and np.isnan(now))
        }

    def simulate(
        self, periods: int | None = None, start: Start | None = None, samples_per_period: int = 2000
    ) -> xr.Dataset:
        """The time courses, as of `stickslip.simulate`.

        `start` is the orbit ('stationary') or the state in which the point began ('initial'); left
        out, the orbit where there is one. `periods` left out: until the orbit closes, 20 of one
        that does not, 6 where none was found.

        Raises IntegrationError if the motion cannot be followed.
        """
        orbit = self.orbit()
        start = start or ("stationary" if orbit.status.is_result else "initial")
        shown = {"periods": periods or periods_of(orbit), "samples_per_period": samples_per_period}
        simulation = self.config.simulation.model_copy(update={**shown, "start": start})
        noise = self.config.noise
        if noise.realizations is not None:  # one path of a stochastic film
            noise = noise.model_copy(update={"realizations": 1})
        update = {"simulation": simulation, "title": self.where, "noise": noise}
        initial = None if np.isnan(self._start[:-1]).all() else self._start[:-1].tolist()
        state = orbit.state if start == "stationary" else initial
        course = trajectory(self.config.model_copy(update=update), start=state)
        return course.isel({REALIZATION: 0}) if REALIZATION in course.dims else course

    def stroboscopic(self, periods: int = 200) -> xr.Dataset:
        """The states of the lower block at the beginnings of drive periods, from the start on.

        Variables of `variables.STROBOSCOPIC` along `period`. Raises IntegrationError.
        """
        course = self.simulate(periods, "initial", samples_per_period=1)
        names = {"lower_displacement": "displacement", "lower_velocity": "velocity"}
        data = {
            f"stroboscopic_{short}": ("period", course[name].values)
            for name, short in names.items()
        }
        ds = xr.Dataset(data, {"period": np.arange(periods + 1, dtype=np.int32)})
        for name, variable in STROBOSCOPIC.items():
            ds[name].attrs.update(variable.attributes)
        return ds

    def replay(self, periods: int | None = None, start: Start | None = None) -> xr.Dataset:
        """The time courses as of `simulate`, with the stroboscopic map of the way there."""
        return self.simulate(periods, start).merge(self.stroboscopic(), combine_attrs="override")

    def portrait(self, periods: int | None = None, *, ax: Axes | None = None) -> Figure | Axes:
        """The phase portrait of the orbit: velocity of the lower block against its displacement.

        It is drawn into `ax` where axes are given, which then are returned.
        """
        from sweeps.figures import Look, PlotOptions, draw
        from sweeps.figures.save import displayed

        options = PlotOptions(look=Look(axes=ax))
        drawn = draw(self.simulate(periods), "phase_portraits", options)
        return displayed(drawn) if ax is None else ax


@dataclass(frozen=True)
class Motion:
    """The time courses at a point: over its orbit or, where it has none, from its start.

    `courses` is None where they cannot be computed; `obstacle` says why.
    """

    point: Point
    courses: xr.Dataset | None
    obstacle: str = ""


def motions(
    ds: xr.Dataset,
    places: Sequence[Mapping[str, int]],
    *,
    workers: int | None = None,
    on_motion: Callable[[], None] = lambda: None,
) -> list[Motion]:
    """Return the motion at some points of a result, computed in threads, in their order.

    `places` say where the points are along the dimensions of `ds`. `on_motion` is called, in any
    thread, whenever one is finished. The first is computed alone: the others find the kernels
    compiled.

    Raises PointError if `ds` is no result of a sweep, or of one that cannot be computed here.
    """

    def computed(point: Point) -> Motion:
        try:
            motion = Motion(point, point.simulate())
        except _OBSTACLES as error:
            motion = Motion(point, None, str(error))
        on_motion()
        return motion

    points = [point_of(ds.isel(place)) for place in places]
    _remember_lines(points)
    with ThreadPoolExecutor(workers or Execution().slots) as pool:
        return [*map(computed, points[:1]), *pool.map(computed, points[1:])]


def _remember_lines(points: Sequence[Point]) -> None:
    """Follow each line once, however many of its points there are, and many lines at a time."""
    lines: dict[bytes, NDArray[np.float64]] = {}
    for point in points:
        first = point.before[:1].tobytes()
        if len(point.before) > len(lines.get(first, ())):
            lines[first] = point.before
    if lines:
        remember_starts(list(lines.values()), options_of(points[0].config))


def point_of(ds: xr.Dataset, at: Iterable[str] = (), **where: Any) -> Point:
    """The point of a result that names and values choose, each the nearest of its axis.

    Parameters
    ----------
    ds
        The result of a sweep, whole or a part of it that `sel` or `isel` chose.
    at
        Texts such as `temperature=228`, by name or symbol, in SI units.
    where
        The same as keywords; `case` and `direction` choose as well.

    Raises
    ------
    PointError
        The dataset is no result of a sweep; an axis is unknown, or left to be chosen; a value is
        far off its axis.
    """
    if "config" not in ds.attrs or "status" not in ds.variables:
        raise PointError("this is no result of a sweep: it lacks a config, or a status")
    texts = [*at, *(f"{name}={value}" for name, value in where.items())]
    try:
        place = places_at(ds, texts)
    except ValueError as error:
        raise PointError(str(error)) from None
    _refuse_open_axes(ds, place)
    point = _point(ds.isel(place).squeeze().compute())  # of arrays of dask, this point alone
    if stacked := [dim for dim in map(str, ds["status"].dims) if dim not in _OWN_DIMS]:
        _refuse_unknown_stack(ds, point, stacked[0])
    return replace(point, loose=bool(stacked))


def _refuse_unknown_stack(ds: xr.Dataset, point: Point, dim: str) -> None:
    """Raise PointError where nothing tells whether a stack of results has the config of all."""
    lost = [name for name in PARAMETERS if name not in ds.variables and name in _IN_PAPER]
    if lost or point.versions:
        why = "parameters were dropped from it" if lost else "; ".join(point.versions)
        raise PointError(
            f"the results are stacked along {dim}, with the config of one of them, and nothing "
            f"tells whether it is the one of this point ({why}); take it from its own result"
        )


def curve_or_map(ds: xr.Dataset) -> xr.Dataset:
    """Return the part of a result that lies along the axes of its points.

    That of a fit is the fitted curve; its data and parameters have dimensions of their own.
    """
    other = set(ds.dims) - set(ds["status"].dims) if "status" in ds.variables else set()
    return with_numbers(ds.drop_dims(other) if other else ds)


def _refuse_open_axes(ds: xr.Dataset, place: Mapping[str, int]) -> None:
    sizes = ds["status"].sizes  # a fit has other dimensions beside
    left = [str(dim) for dim, size in sizes.items() if size > 1 and dim not in place]
    if left:
        examples = ", ".join(f"{dim}={_plain(ds[dim].values[0])}" for dim in left)
        raise PointError(f"several points remain; choose one, for example by {examples}")


def _point(chosen: xr.Dataset) -> Point:
    """The point that is left of a result."""
    try:
        written = config_without_axes(str(chosen.attrs["config"]))
        values = {name: chosen[name].item() for name in PARAMETERS if name in chosen.variables}
        config = config_of(written, values)
        return Point(
            config=config,
            where=_in_words(chosen, written.get("model") or {}),
            stored={n: chosen[n].item() for n in RESULT_COLUMNS if n in chosen.variables},
            before=_line_before(chosen, config.parameters(), written.get("follow")),
            versions=version_differences(chosen.attrs),
        )
    except ConfigError as error:
        raise PointError(f"the config of this result cannot be read:\n{error}") from None


def config_of(written: Mapping[str, Any], values: Mapping[str, float]) -> Config:
    """The config of a point alone; `written` is that of the result without its axes."""
    kept = {key: value for key, value in written.items() if key not in ("follow", "refine")}
    return from_mapping(kept | {"model": values}, SOURCE)


def _line_before(
    chosen: xr.Dataset, parameters: Parameters, followed: str | None
) -> NDArray[np.float64]:
    """The points (n, parameters) of a followed line that lead to a point; none without `follow`."""
    point = np.array([parameters])
    if followed is None:
        return point[:0]
    whole = from_mapping(read_mapping(str(chosen.attrs["config"]), SOURCE), SOURCE)
    grid = Grid.from_config(whole)
    way = chosen[DIRECTION].item()
    if way not in DIRECTIONS:
        raise PointError(f"the direction {way!r} is none of {', '.join(DIRECTIONS)}")
    upward = PointKeys(grid, {}, alone=True).numbers_of(point)[0]
    number = upward + DIRECTIONS.index(way)
    (line,) = (line.tolist() for line in grid.lines() if number in line)
    return grid.rows(np.array(line[: line.index(number)], dtype=np.int64))


def version_differences(attributes: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the differences between the file's versions and ours, a sentence each."""
    from stickslip.compiled.cache import processor

    reasons = []
    version, ours = str(attributes.get("numerics_version", "0")), str(NUMERICS_VERSION)
    if version != ours:
        reasons.append(f"it was computed by numerics version {version}, this is {ours}")
    if processor() not in str(attributes.get("processor", processor())):
        reasons.append(f"it was computed on {attributes['processor']}, this is {processor()}")
    compilers, own = (_compilers(text) for text in (attributes.get("software", ""), software()))
    if compilers not in ("", own):
        reasons.append(f"it was compiled by {compilers}, this is {own}")
    return tuple(reasons)


def _compilers(text: str) -> str:
    """Return the versions of the compilers among those of all packages, which `software` names."""
    return " and ".join(re.findall(r"\b(?:numba|llvmlite) [^,]+", text))


def _in_words(chosen: xr.Dataset, fixed: Mapping[str, float]) -> str:
    """The values that vary over a result, such as `temperature = 228 K`."""
    varied = [
        name
        for name in PARAMETERS
        if name in chosen.variables
        and not np.isclose(chosen[name].item(), fixed.get(name, np.nan), rtol=_ROUNDED, atol=0.0)
    ]
    words = [f"{n} = {_plain(chosen[n].item())} {PARAMETERS[n].unit}".rstrip() for n in varied]
    others = [str(n) for n, c in chosen.coords.items() if n not in PARAMETERS and not c.ndim]
    words += [f"{name} = {_plain(chosen[name].item())}" for name in others]
    return ", ".join(words) or "the only point"


def periods_of(orbit: Orbit) -> int:
    """The drive periods over which an orbit is shown."""
    if not orbit.status.is_result:
        return _FAILED_PERIODS
    return orbit.orbit_periods or _APERIODIC_PERIODS  # 0: it never closes


def _plain(value: Any) -> str:
    return f"{value:g}" if np.issubdtype(type(value), np.number) else str(value)
