"""The accessor `ds.stickslip` of Datasets of this program: points, figures, masks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, canonical_name
from sweeps.paths import path_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sweeps.borders import Kind
    from sweeps.figures.look import Range
    from sweeps.measurements import Table
    from sweeps.page.explorer import Explorer
    from sweeps.points import Point


@xr.register_dataset_accessor("stickslip")  # type: ignore[no-untyped-call]
class StickslipAccessor:
    """Methods for the result of a sweep or a part of it; `plot` also works on a trajectory.

    It is `ds.stickslip`; as `StickslipAccessor(ds)` editors know its methods.

    >>> ds = run({"sweep": {"T": [200, 250]}})
    >>> StickslipAccessor(ds).at(T=251).orbit().regime.name
    'STICK_SLIP_SYMMETRIC'
    """

    def __init__(self, ds: xr.Dataset) -> None:
        self._ds = ds

    def __repr__(self) -> str:
        from sweeps.charts.choice import default_figure
        from sweeps.figure_table import FIGURES

        held = FIGURES[default_figure(self._ds)].drawn
        sizes = ", ".join(f"{dim}: {size}" for dim, size in self._ds.sizes.items())
        return f"<stickslip accessor of {held} ({sizes or 'a single point'})>"

    def at(self, **where: Any) -> Point:
        """Return the point nearest to values such as `temperature=228`, by name or symbol, in SI.

        Its `.orbit()`, `.simulate()` and `.portrait()` compute it again, and raise PointError where
        the config of the Dataset is not the one of its numbers, as in a stack of results. Raises
        PointError if the values do not single out one point.

        >>> ds = run({"sweep": {"T": [200, 250]}})
        >>> ds.stickslip.at(T=251).parameters.temperature
        250.0
        """
        from sweeps.points import point_of

        return replace(point_of(self._ds, **where), loose=True)

    def ok(self) -> xr.Dataset:
        """Return the Dataset with NaN in all result variables of failed and pending points.

        Counts and flags become floats, since integers have no NaN.

        >>> ds = run({"sweep": {"T": [200, 250]}})
        >>> ds.stickslip.ok().melting_count.values
        array([4., 2.])
        """
        results = [status for status in Status if status.is_result]
        valid = self._ds["status"].isin(results)
        masked = {n: self._ds[n].where(valid) for n in RESULT_COLUMNS if n in self._ds.data_vars}
        return self._ds.assign(masked)

    def quantiles(self, levels: Sequence[float] | None = None) -> xr.Dataset:
        """Return quantiles of the measured variables over the cases of a sample, as `quantile`.

        Cases without a result do not count; `cases_with_result` says how many do. By default the
        levels are those of the median and of intervals that hold 68 % and 95 %. The plot of what is
        returned has bands. Raises ValueError for a result without cases.

        >>> sample = {"sobol": 8, "k": {"lognormal": [5e4, 0.1]}}
        >>> ds = run({"sweep": {"T": [200, 250]}, "sample": sample})
        >>> quantiles = ds.stickslip.quantiles()
        >>> quantiles.friction_force_amplitude.sel(quantile=0.5).dims
        ('temperature',)
        """
        from sweeps.charts.quantiles import quantiles_of

        return quantiles_of(self._ds, levels)

    def plot(
        self,
        variable: str | Sequence[str] | None = None,
        *,
        x: str | None = None,
        y: str | None = None,
        hue: str | None = None,
        row: str | None = None,
        col: str | None = None,
        at: dict[str, Any] | None = None,
        log: str = "",
        figure: str | None = None,
        boundaries: xr.Dataset | None = None,
        data: Table | None = None,
        ax: Axes | None = None,
        size: tuple[float, float] | None = None,
        xlim: Range = (None, None),
        ylim: Range = (None, None),
        vmin: float | None = None,
        vmax: float | None = None,
        letters: bool | str = False,
        note: bool = True,
        title: str | None = None,
        style: str | Path | None = None,
    ) -> Figure | Axes:
        """Return the picture that `stickslip plot` draws, with the same options.

        Without `variable`, a name or several, both amplitudes are drawn; one of your own, such as
        `mu`, is drawn with its attributes long_name and units; variables of a trajectory
        choose panels of its time courses. `at` cuts axes, such as `{"temperature": 228}`; `log`
        names logarithmic scales, such as 'x,z'; `figure` names a figure instead; `boundaries` are
        what the method of this name returns, drawn on maps; `data` are measured points over curves,
        as of `sweeps.fit`. `size` is in inches; limits are in the units shown, `vmin` and `vmax`
        those of colours; `letters` may be the first one, such as 'b'.

        The figure is returned, and not pyplot's current one: save it with its own `savefig`. Into
        `ax` a picture of one panel is drawn, without small print and with your own settings of
        matplotlib, and it is returned.
        Raises ValueError for a choice that the data do not have.

        >>> ds = run({"sweep": {"T": [200, 250, 300], "omega": [10, 12]}})
        >>> figure = ds.stickslip.plot("F_max", x="T", hue="omega")
        """
        from sweeps.figures import Look, PlotOptions, draw
        from sweeps.figures.save import displayed
        from sweeps.measurements import read_data

        cuts = tuple(f"{name}={_cut(value)}" for name, value in (at or {}).items())
        file = None if style is None else path_of(style)
        look = Look(size, xlim, ylim, (vmin, vmax), letters, note, title, file, ax)
        options = PlotOptions(
            *(_several(variable), x, y, hue, row, col, cuts, log),
            boundaries=boundaries,
            data=None if data is None else read_data(data),
            look=look,
        )
        drawn = draw(self._ds, figure, options)
        return displayed(drawn, look) if ax is None else ax

    def map(
        self, variable: str, x: str | None = None, y: str | None = None, **at: Any
    ) -> Figure | Axes:
        """Return a map of a variable over two axes, others cut by keyword: `map("regime", K=500)`.

        By default the axes are the two longest. Raises ValueError as `plot` does.

        >>> ds = run({"sweep": {"T": [200, 250, 300], "omega": [10, 12]}})
        >>> figure = ds.stickslip.map("regime")
        """
        if others := [name for name in at if name in signature(self.plot).parameters]:
            raise ValueError(
                f"map takes values of axes; with {others[0]} it is "
                f"plot({variable!r}, x=..., y=..., {others[0]}=...)"
            )
        chosen = {canonical_name(name) or name for name in (*at, x, y) if name is not None}
        free = sorted(
            (str(dim) for dim, size in self._ds.sizes.items() if size > 1 and dim not in chosen),
            key=lambda dim: -self._ds.sizes[dim],
        )
        if len(free) < (x, y).count(None):
            raise ValueError(f"a map needs two axes, and this result has {_listed(self._ds)}")
        x = x or free.pop(0)
        y = y or free.pop(0)
        return self.plot(variable, x=x, y=y, at=at)

    def boundaries(
        self, accuracy: float = 1e-6, kind: Kind = "regime", *, workers: int | None = None
    ) -> xr.Dataset:
        """Return the borders between kinds of motion, as lines on a map or points on an axis.

        Each edge between neighbouring points of unlike kinds is bisected, with the parameters and
        options of the sweep; where the crossings of a cell belong together they are joined.

        >>> ds = run({"sweep": {"T": [200, 220, 240, 260, 280, 300]}})
        >>> ds.stickslip.boundaries(1e-3).temperature.round(0).values
        array([285.])

        Parameters
        ----------
        accuracy
            Width of the last bracket, as a part of the length of its axis: of the difference of its
            ends, or of their logarithms where the values have a common ratio. Some stay wider.
        kind
            What must change at a border: the 'regime', or with 'orbit' also `melting_count` or
            `orbit_periods`, which of aperiodic motions mean nothing.
        workers
            Threads; by default one for each core that the process may use.

        Returns
        -------
        Dataset
            Along `boundary_point`, line by line: the coordinates `line`, a number, and the axes, in
            SI units; `kind_left`, `kind_right` (with 'orbit' `melting_count_left` and so on);
            `multiplier_left`, `multiplier_right`, the Floquet multipliers at the ends of the last
            bracket, NaN where a motion has none; `type`, 0 grazing, 1 fold, 2 the meeting of three
            kinds or more in the middle of their crossings; and for each axis `<axis>_bracket`, the
            width of the last bracket. Left and right are those of a walk along the line, with the
            first axis pointing right and the second up; on a single axis left is below. A border
            is a fold if a multiplier within 0.2 of 1 says that an orbit is about to lose its
            stability, which need not be how it ends; tell it apart with an accuracy of 1e-5 or
            better, and `rtol` 1e-6.

            Points without a result make no borders. A bisection ends early, with a wide bracket, at
            a point without a result, and below a thousandth of the axis at one that is not on its
            orbit after 128 periods. The attribute `wide_brackets` is how many are wider than asked.

        Raises
        ------
        BoundaryError
            A ValueError: there is no such border, since the result has not one or two axes of
            single parameters, follows an axis, or is stochastic; or an argument is wrong.
        """
        from sweeps.borders import boundaries

        return boundaries(self._ds, accuracy, kind, workers=workers)

    def summary(self) -> str:
        """Return a fit in words, as `stickslip fit` prints it.

        >>> ds = fit({"T": [160, 200, 240], "F_max": [4.67e-3, 3.25e-3, 2.38e-3]}, "k")
        >>> print(ds.stickslip.summary())
        viscosity_coefficient: ... Pa s^(gamma+1), 95 %: ...
        ...

        Raises FitError if the Dataset is no fit, or uncertainties is missing.
        """
        from sweeps.fitting.fitting import summary_of

        return summary_of(self._ds)

    def explore(self, borders: xr.Dataset | None = None, *, port: int = 0) -> Explorer:
        """Serve the page that `stickslip explore` opens, and show it in a notebook.

        >>> ds = run({"sweep": {"T": [200, 250]}})
        >>> page = ds.stickslip.explore()
        >>> page.address.startswith("http://127.0.0.1:")
        True
        >>> page.stop()

        The arguments and errors are those of `sweeps.explore`.
        """
        from sweeps.page.explorer import explore

        return explore(self._ds, borders=borders, port=port)

    def report(self, path: str | Path, *, boundaries: xr.Dataset | None = None) -> Path:
        """Write the page of `stickslip report`, which needs no network, and return its path.

        `boundaries` are what the method of this name returns, drawn on the map.

        >>> ds = run({"sweep": {"T": [200, 250, 300], "omega": [10, 12]}})
        >>> page = ds.stickslip.report("regimes.html")

        Raises ReportError if no page can be made, StorageError if it cannot be written.
        """
        from sweeps.page import name_of, write_report

        page = path_of(path)
        write_report(self._ds.compute(), page, name=name_of(self._ds), borders=boundaries)
        return page


def _several(variable: str | Sequence[str] | None) -> str | tuple[str, ...] | None:
    return variable if variable is None or isinstance(variable, str) else tuple(variable)


def _cut(value: Any) -> str:
    """Return a value, or several, as `--at` takes them."""
    return ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def _listed(ds: xr.Dataset) -> str:
    return ", ".join(str(dim) for dim, size in ds.sizes.items() if size > 1) or "none"
