"""Points of a result, computed again from the file or Dataset alone: orbits and motions."""

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
from sweeps.charts.choice import places_at, refuse_empty, text_of, with_numbers
from sweeps.config.load import Config, ConfigError, from_mapping
from sweeps.config.schema import Execution
from sweeps.config.yaml_reader import read_mapping
from sweeps.engine.settings import SOURCE, config_without_axes, options_of, varied_in
from sweeps.engine.trajectories import trajectory
from sweeps.exits import ExpectedError
from sweeps.files.attributes import software
from sweeps.grid import CASE, DIRECTION, DIRECTIONS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Start = Literal["initial", "stationary"]

# They reveal that a point was computed with other settings, and nobody converts their units.
_TELLTALE = ("status", "periods_integrated", "amplitude_error")
_ROUNDED = 1e-5  # relative; a Dataset in single precision counts as the same

# Drive periods to show of an orbit that does not close, and of a point without an orbit.
_APERIODIC_PERIODS, _FAILED_PERIODS = 20, 6

# Errors seen at points of files that another version wrote or somebody edited.
_OBSTACLES = (ExpectedError, IntegrationError, NoiseError, ArithmeticError, ValueError)


class PointError(ExpectedError, ValueError):
    """A point that is not unique or cannot be computed again; the message says why."""


@dataclass(frozen=True, repr=False)
class Point:
    """A point of a result that can be computed again; `point_of` makes it.

    `config` is the config of this point alone, and `where` describes the point in words. `stored`
    has the values of its result variables in the file, and `before` (n, parameters) the earlier
    points of a followed line. `versions` has a sentence for each version that differs here and that
    the numbers depend on. A `loose` point comes from a Dataset that may be made of several results,
    so that its config may belong to another one.
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
        flags = {"status": self.status, "regime": Regime(_code(self.stored.get("regime", np.nan)))}
        shown = {name: flags.get(name, value) for name, value in self.stored.items()}
        return f"<p>{self.where}</p>{value_table(shown, RESULTS)}"

    @property
    def parameters(self) -> Parameters:
        """All parameters of the point."""
        return self.config.parameters()

    @property
    def status(self) -> Status:
        """The status of the point in the file; `pending` if the file has none for it."""
        return Status(_code(self.stored["status"]))

    @property
    def is_comparable(self) -> bool:
        """Whether the numbers in the file were computed for this point."""
        return self.status not in (Status.INTERPOLATED, Status.PENDING)

    @cached_property
    def _start(self) -> NDArray[np.float64]:
        """The state (final columns,) at the start, NaN if the parameters give the start."""
        return start_after(self.before, options_of(self.config))

    @cached_property
    def _computed(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        point = np.array([self.parameters])
        rows, finals = compute_orbits(point, options_of(self.config), self._start[None])
        return rows[0], finals[0]

    def orbit(self) -> Orbit:
        """Compute the stationary orbit again; the same version gives the same bits as the file.

        Raises PointError if the numbers of the Dataset were computed with another config.
        """
        if self.loose and (why := self.other_settings()):
            raise PointError(f"{why}; take the point from its original result")
        return orbit_of_row(*self._computed)

    def other_settings(self) -> str:
        """Return how the numbers show that they were computed with another config; else nothing."""
        for name, (stored, computed) in ({} if self.versions else self.differences()).items():
            near = np.isclose(stored, computed, rtol=_ROUNDED, atol=0.0)
            if name in _TELLTALE and not near:
                return (
                    f"{self.where}: the Dataset has {name} {stored:g}, but its config gives "
                    f"{computed:g}: it was made from results with different settings, or edited"
                )
        return ""

    def differences(self) -> dict[str, tuple[float, float]]:
        """Return (stored, computed) of the result variables whose computed value differs.

        The result is empty for an interpolated point, which has nothing to compare.
        """
        if not self.is_comparable:
            return {}
        row, found = dict(zip(RESULT_COLUMNS, self._computed[0], strict=True)), {}
        for name, stored in self.stored.items():
            now = result_values(name, row[name][None]).item()
            if stored != now and not (np.isnan(stored) and np.isnan(now)):  # all NaNs are equal
                found[name] = stored, now
        return found

    def simulate(
        self, periods: int | None = None, start: Start | None = None, samples_per_period: int = 2000
    ) -> xr.Dataset:
        """Return the time courses, as `stickslip.simulate` does.

        `start` is 'stationary', on the orbit, or 'initial', in the state in which the sweep started
        this point. By default the motion starts on the orbit if there is one. `periods` is by
        default the number after which the orbit closes, 20 for an orbit that does not close, and 6
        without an orbit.

        Raises IntegrationError if the motion cannot be followed.
        """
        orbit = self.orbit()
        start = start or ("stationary" if orbit.status.is_result else "initial")
        if start == "stationary" and not orbit.status.is_result:
            raise IntegrationError(orbit.status, "No stationary start: ")
        shown = {
            "periods": periods_of(orbit) if periods is None else periods,
            "start": start,
            "samples_per_period": samples_per_period,
            "schedule": None,  # of a run whose parameters change, which no sweep computes
        }
        simulation = self.config.simulation.model_copy(update=shown)
        noise = self.config.noise
        if noise.realizations is not None:  # one path of a stochastic film
            noise = noise.model_copy(update={"realizations": 1})
        update = {"simulation": simulation, "title": self.where, "noise": noise}
        initial = None if np.isnan(self._start[:-1]).all() else self._start[:-1].tolist()
        state = orbit.state if start == "stationary" else initial
        course = trajectory(self.config.model_copy(update=update), start=state)
        return course.isel({REALIZATION: 0}) if REALIZATION in course.dims else course

    def stroboscopic(self, periods: int = 200) -> xr.Dataset:
        """Return the states of the lower block at the beginning of each drive period.

        The Dataset has the variables of `variables.STROBOSCOPIC` along `period`, from the start on.
        Raises IntegrationError.
        """
        course = self.simulate(periods, "initial", samples_per_period=1)
        data = {
            "stroboscopic_displacement": ("period", course["lower_displacement"].values),
            "stroboscopic_velocity": ("period", course["lower_velocity"].values),
        }
        ds = xr.Dataset(data, {"period": np.arange(periods + 1, dtype=np.int32)})
        for name, variable in STROBOSCOPIC.items():
            ds[name].attrs.update(variable.attributes)
        return ds

    def replay(self, periods: int | None = None, start: Start | None = None) -> xr.Dataset:
        """Return the time courses of `simulate`, and the stroboscopic map from the start on."""
        return self.simulate(periods, start).merge(self.stroboscopic(), combine_attrs="override")

    def portrait(self, periods: int | None = None, *, ax: Axes | None = None) -> Figure | Axes:
        """Return the phase portrait of the orbit: velocity of the lower block over displacement.

        If you pass axes `ax`, the portrait is drawn into them, and they are returned.
        """
        from sweeps.figures import Look, PlotOptions, draw
        from sweeps.figures.save import displayed

        options = PlotOptions(look=Look(axes=ax))
        drawn = draw(self.simulate(periods), "phase_portraits", options)
        return displayed(drawn) if ax is None else ax


@dataclass(frozen=True)
class Motion:
    """The time courses at a point: over its orbit or, without an orbit, from the start.

    If they cannot be computed, `courses` is None and `obstacle` gives the reason.
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
    """Return the motions at some points of a result, in their order, computed in threads.

    `places` are the positions of the points along the dimensions of `ds`. `on_motion` is called
    after each motion, in any thread. The first motion is computed alone, so that the others find
    the kernels compiled.

    Raises PointError if `ds` is not the result of a sweep, or cannot be computed here.
    """

    def computed(point: Point) -> Motion:
        try:
            motion = Motion(point, point.simulate())
        except _OBSTACLES as error:
            motion = Motion(point, None, str(error))
        on_motion()
        return motion

    points = [point_at(ds, place) for place in places]
    _remember_lines(points)
    with ThreadPoolExecutor(workers or Execution().slots) as pool:
        return [*map(computed, points[:1]), *pool.map(computed, points[1:])]


def _remember_lines(points: Sequence[Point]) -> None:
    """Follow each line once, whatever the number of its points, and many lines at a time."""
    lines: dict[bytes, NDArray[np.float64]] = {}
    for point in points:
        first = point.before[:1].tobytes()
        if len(point.before) > len(lines.get(first, ())):
            lines[first] = point.before
    if lines:
        remember_starts(list(lines.values()), options_of(points[0].config))


def point_of(ds: xr.Dataset, at: Iterable[str] = (), **where: Any) -> Point:
    """Return the point of a result that lies nearest to the given values of its axes.

    Parameters
    ----------
    ds
        The result of a sweep, or a part chosen with `sel` or `isel`.
    at
        Texts such as `temperature=228`, by name or symbol, in SI units.
    where
        The same as keywords; `case` and `direction` are axes too.

    Raises
    ------
    PointError
        The dataset is not the result of a sweep; an axis is unknown, or several of
        its points remain; a value is far off its axis.
    """
    if "config" not in ds.attrs or "status" not in ds.variables:
        raise PointError("this is not the result of a sweep: it lacks a config, or a status")
    texts = [*at, *(f"{name}={text_of(value)}" for name, value in where.items())]
    try:
        refuse_empty(ds)
        place = places_at(ds, texts)
    except ValueError as error:
        raise PointError(str(error)) from None
    # The Dataset of a fit has more dimensions than its points.
    open_axes = [d for d, size in ds["status"].sizes.items() if size > 1 and d not in place]
    if open_axes:
        examples = ", ".join(f"{dim}={_plain(ds[dim].values[0])}" for dim in open_axes)
        raise PointError(f"several points remain; choose one, for example with {examples}")
    point = _point(ds.isel(place).squeeze().compute())  # dask computes this point alone
    varied = {*varied_in(str(ds.attrs["config"])), CASE, DIRECTION}
    if stacked := [dim for dim in map(str, ds["status"].dims) if dim not in varied]:
        _refuse_unknown_stack(ds, point, stacked[0])
    return replace(point, loose=bool(stacked))


def point_at(ds: xr.Dataset, place: Mapping[str, int]) -> Point:
    """Return the point of a result at a place along its dimensions; raises PointError."""
    # The dimensions stay, since they show whether the result is a stack.
    return point_of(ds.isel({dim: [at] for dim, at in place.items()}))


def _refuse_unknown_stack(ds: xr.Dataset, point: Point, dim: str) -> None:
    """Raise PointError if nothing shows whether the config of a stack belongs to the point."""
    lost = any(p.in_paper and name not in ds.variables for name, p in PARAMETERS.items())
    if lost or point.versions:
        why = "parameters were dropped from it" if lost else "; ".join(point.versions)
        raise PointError(
            f"the results are stacked along {dim} with the config of one of them, and it is "
            f"unknown whether it belongs to this point ({why}); take the point from its own result"
        )


def curve_or_map(ds: xr.Dataset) -> xr.Dataset:
    """Return the part of a result along the axes of its points.

    For a fit this is the fitted curve; data and parameters of a fit have other dimensions. Raises
    PointError for an axis without values.
    """
    other = set(ds.dims) - set(ds["status"].dims) if "status" in ds.variables else set()
    try:
        return with_numbers(ds.drop_dims(other) if other else ds)
    except ValueError as error:
        raise PointError(str(error)) from None


def _point(chosen: xr.Dataset) -> Point:
    """Return the only point of a Dataset."""
    try:
        written = config_without_axes(str(chosen.attrs["config"]))
        values = {name: chosen[name].item() for name in PARAMETERS if name in chosen.variables}
        config = config_of(chosen, values)
        return Point(
            config=config,
            where=_in_words(chosen, written.get("model") or {}),
            stored={n: chosen[n].item() for n in RESULT_COLUMNS if n in chosen.variables},
            before=_line_before(chosen, config.parameters(), written.get("follow")),
            versions=version_differences(chosen.attrs),
        )
    except ConfigError as error:
        raise PointError(f"the config of this result cannot be read:\n{error}") from None


def config_of(ds: xr.Dataset, values: Mapping[str, float]) -> Config:
    """Return the config of a point of a result alone; `values` are the parameters in the Dataset.

    Fixed parameters that were dropped from the Dataset are those of its config. Raises ConfigError,
    and PointError if a parameter that varied was dropped.
    """
    text = str(ds.attrs["config"])
    if lost := [name for name in varied_in(text) if name not in values]:
        raise PointError(
            f"this result has lost {' and '.join(lost)}, which varied in it, so that the "
            "value here is unknown: choose with isel() or sel() without drop=True"
        )
    written = config_without_axes(text)
    kept = {key: value for key, value in written.items() if key not in ("follow", "refine")}
    return from_mapping(kept | {"model": {**(written.get("model") or {}), **values}}, SOURCE)


def _line_before(
    chosen: xr.Dataset, parameters: Parameters, followed: str | None
) -> NDArray[np.float64]:
    """Return the points (n, parameters) before a point on a followed line; none if not followed."""
    point = np.array([parameters])
    if followed is None:
        return point[:0]
    if DIRECTION not in chosen.variables:
        raise PointError(
            f"the direction along {followed} was dropped from this result, so that the line of the "
            "point is unknown: choose with isel() or sel() without drop=True"
        )
    whole = from_mapping(read_mapping(str(chosen.attrs["config"]), SOURCE), SOURCE)
    axis = np.array(whole.sweep[str(whole.follow)])
    way = chosen[DIRECTION].item()
    if way not in DIRECTIONS:
        raise PointError(f"the direction {way!r} is not one of {', '.join(DIRECTIONS)}")
    column = Parameters._fields.index(str(whole.follow))
    upward = np.flatnonzero(axis == parameters[column])
    if not len(upward):
        raise PointError(
            f"the config of this result follows {whole.follow} over values other than "
            f"{parameters[column]:g}, so that its line is unknown; take the point from its own "
            "result"
        )
    number = int(upward[0]) if way == DIRECTIONS[0] else 2 * len(axis) - 1 - int(upward[0])
    # All other parameters are the same along a line. In a stack of results they may differ from
    # those in the config, which belongs to one of them.
    before = np.repeat(point, number, axis=0)
    before[:, column] = np.concatenate([axis, axis[::-1]])[:number]
    return before


def version_differences(attributes: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the differences between the versions of a file and ours, a sentence for each."""
    from stickslip.compiled.cache import processor

    reasons = []
    version, ours = str(attributes.get("numerics_version", "0")), str(NUMERICS_VERSION)
    if version != ours:
        reasons.append(f"the file has numerics version {version}, this program {ours}")
    if processor() not in str(attributes.get("processor", processor())):
        before, here = attributes["processor"], processor()
        reasons.append(f"the file was computed on {before}, this machine has {here}")
    compilers, own = (_compilers(text) for text in (attributes.get("software", ""), software()))
    if compilers not in ("", own):
        reasons.append(f"the file was computed with {compilers}, this program uses {own}")
    return tuple(reasons)


def _compilers(text: str) -> str:
    """Return the versions of the compilers in the list of packages that `software` makes."""
    return " and ".join(re.findall(r"\b(?:numba|llvmlite) [^,]+", text))


def _in_words(chosen: xr.Dataset, fixed: Mapping[str, float]) -> str:
    """Return the values that vary over a result in words, such as `temperature = 228 K`."""
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
    """Return the number of drive periods to show of an orbit."""
    if not orbit.status.is_result:
        return _FAILED_PERIODS
    return orbit.orbit_periods or _APERIODIC_PERIODS  # 0: the orbit never closes


def _code(value: float) -> int:
    """Return a status or regime as a code; NaN, which masks a point, is the code of none."""
    return int(Status.PENDING) if np.isnan(value) else int(value)


def _plain(value: Any) -> str:
    return f"{value:g}" if np.issubdtype(type(value), np.number) else str(value)
