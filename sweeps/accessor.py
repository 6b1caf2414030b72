"""The accessor `ds.stickslip` for Datasets that this program makes: points, figures, masks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from stickslip.variables import RESULT_COLUMNS
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

    `ds.stickslip` returns it. Write `StickslipAccessor(ds)` to let your editor know the methods.

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
        """Return the point nearest to values such as `temperature=228`, in SI units.

        Axes go by name or symbol. The methods `.orbit()`, `.simulate()` and `.portrait()` of the
        point compute it again. They raise PointError if the numbers were computed with another
        config than the Dataset holds, which may happen in a stack of results. Raises PointError if
        the values do not single out one point.

        >>> ds = run({"sweep": {"T": [200, 250]}})
        >>> ds.stickslip.at(T=251).parameters.temperature
        250.0
        """
        from sweeps.points import point_of

        return replace(point_of(self._ds, **where), loose=True)

    def ok(self) -> xr.Dataset:
        """Return the Dataset with NaN in all result variables of failed and pending points.

        Counts and flags become floats, since integers have no NaN. Raises ValueError for a Dataset
        without a status.

        >>> ds = run({"sweep": {"T": [200, 250]}})
        >>> ds.stickslip.ok().melting_count.values
        array([4., 2.])
        """
        from sweeps.charts.missing import with_result

        valid = with_result(self._ds)
        masked = {n: self._ds[n].where(valid) for n in RESULT_COLUMNS if n in self._ds.data_vars}
        return self._ds.assign(masked)

    def quantiles(self, levels: Sequence[float] | None = None) -> xr.Dataset:
        """Return quantiles of the measured variables over the cases of a sample, along `quantile`.

        Only cases that have a result count; their number is in `cases_with_result`. The default
        levels give the median and the intervals that hold 68 % and 95 % of the cases. A plot of the
        returned Dataset has bands. Raises ValueError for a result without cases, and for an empty
        selection.

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

        `variable` is a name or several; by default both amplitudes are drawn. A variable that you
        added, such as `mu`, is labelled with its attributes long_name and units. Variables of a
        trajectory choose the panels of its time courses. `at` cuts axes, as in
        `{"temperature": 228}`. `log` names logarithmic scales, as in 'x,z'. `figure` names a whole
        figure instead of variables. `boundaries` takes the lines that the method `boundaries`
        returns, and draws them on a map. `data` takes measurements, as `sweeps.fit` does, and draws
        them over the curves. `size` is in inches. Limits are in the units shown; `vmin` and `vmax`
        are the limits of the colours. `letters` may be the letter of the first panel, such as 'b'.

        The figure is not pyplot's current one: save it with its method `savefig`. If you pass `ax`,
        a picture of one panel is drawn into it, with your settings of matplotlib and without small
        print, and `ax` is returned. Raises ValueError for a choice that the data do not offer.

        >>> ds = run({"sweep": {"T": [200, 250, 300], "omega": [10, 12]}})
        >>> figure = ds.stickslip.plot("F_max", x="T", hue="omega")
        """
        from sweeps.charts.choice import text_of
        from sweeps.figures import Look, PlotOptions, draw
        from sweeps.figures.save import displayed
        from sweeps.measurements import read_data

        variables = variable if variable is None or isinstance(variable, str) else tuple(variable)
        cuts = tuple(f"{name}={text_of(value)}" for name, value in (at or {}).items())
        file = None if style is None else path_of(style)
        look = Look(size, xlim, ylim, (vmin, vmax), letters, note, title, file, ax)
        options = PlotOptions(
            *(variables, x, y, hue, row, col, cuts, log),
            boundaries=boundaries,
            data=None if data is None else read_data(data),
            look=look,
        )
        drawn = draw(self._ds, figure, options)
        return displayed(drawn, look) if ax is None else ax

    def map(
        self, variable: str, x: str | None = None, y: str | None = None, **at: Any
    ) -> Figure | Axes:
        """Return a map of a variable over two axes, by default the two longest.

        Keywords cut the other axes: `map("regime", K=500)`. Raises ValueError as `plot` does.

        >>> ds = run({"sweep": {"T": [200, 250, 300], "omega": [10, 12]}})
        >>> figure = ds.stickslip.map("regime")
        """
        if others := [name for name in at if name in signature(self.plot).parameters]:
            raise ValueError(
                f"map takes values of axes only; for {others[0]} call "
                f"plot({variable!r}, x=..., y=..., {others[0]}=...)"
            )
        chosen = {self._dim(name) for name in (*at, x, y) if name is not None}
        free = sorted(
            (str(dim) for dim, size in self._ds.sizes.items() if size > 1 and dim not in chosen),
            key=lambda dim: -self._ds.sizes[dim],
        )
        if len(free) < (x, y).count(None):
            axes = ", ".join(str(dim) for dim, size in self._ds.sizes.items() if size > 1)
            raise ValueError(f"a map needs two axes, and this result has {axes or 'none'}")
        x = x or free.pop(0)
        y = y or free.pop(0)
        return self.plot(variable, x=x, y=y, at=at)

    def _dim(self, name: str) -> str:
        """Return the dimension of an axis; an unknown name is refused when the picture is drawn."""
        from sweeps.charts.choice import axis_named

        try:
            return axis_named(self._ds, name)[0]
        except ValueError:
            return name

    def boundaries(
        self, accuracy: float = 1e-6, kind: Kind = "regime", *, workers: int | None = None
    ) -> xr.Dataset:
        """Return the borders between kinds of motion, as lines on a map or points on an axis.

        Bisects each edge between neighbouring points of different kinds, with the parameters and
        options of the sweep, and joins the crossings of a cell that belong together.

        >>> ds = run({"sweep": {"T": [200, 220, 240, 260, 280, 300]}})
        >>> ds.stickslip.boundaries(1e-3).temperature.round(0).values
        array([285.])

        Parameters
        ----------
        accuracy
            Width of the last bracket, as a fraction of the length of the axis. On an axis whose
            values have a common ratio, the length is logarithmic. Some brackets stay wider.
        kind
            What must change at a border: the 'regime', or for 'orbit' also `melting_count` or
            `orbit_periods`, which mean nothing for aperiodic motions.
        workers
            Number of threads; by default one for each core that the process may use.

        Returns
        -------
        Dataset
            Along `boundary_point`, line by line: the coordinates `line`, a number, and the axes, in
            SI units; `kind_left`, `kind_right` (with 'orbit' `melting_count_left` and so on);
            `multiplier_left`, `multiplier_right`, the Floquet multipliers at the ends of the last
            bracket, NaN where a motion has none; `type`, 0 grazing, 1 fold, 2 a point where three
            or more kinds meet, in the middle of their crossings; and for each axis
            `<axis>_bracket`, the width of the last bracket. Left and right are as seen by someone
            who walks along the line, with the first axis pointing right and the second up. On a
            single axis, left is the side of the smaller values. A border is a fold if a multiplier
            lies within 0.2 of 1: an orbit is then about to lose its stability, although it may in
            fact end in another way. To distinguish folds from grazing, use an accuracy of 1e-5 or
            better and an `rtol` of 1e-6.

            There are no borders at points without a result. A bisection ends early, with a wide
            bracket, at a point without a result or, once the bracket is narrower than a thousandth
            of the axis, at a point that has not reached its orbit after 128 periods. The attribute
            `wide_brackets` counts the brackets wider than the accuracy.

        Raises
        ------
        BoundaryError
            A ValueError: an argument is wrong, or the result has no borders because it is
            stochastic, follows an axis, does not have one or two axes of single parameters, or is a
            stack of results with different settings.
        """
        from sweeps.borders import boundaries

        return boundaries(self._ds, accuracy, kind, workers=workers)

    def summary(self) -> str:
        """Return the summary of a fit, as printed by `stickslip fit`.

        >>> ds = fit({"T": [160, 200, 240], "F_max": [4.67e-3, 3.25e-3, 2.38e-3]}, "k")
        >>> print(ds.stickslip.summary())
        viscosity_coefficient: ... Pa s^(gamma+1), 95 %: ...
        ...

        Raises FitError if the Dataset is not a fit or the package uncertainties is missing.
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

        `sweeps.explore` has the same arguments and errors.
        """
        from sweeps.page.explorer import explore

        return explore(self._ds, borders=borders, port=port)

    def report(self, path: str | Path, *, boundaries: xr.Dataset | None = None) -> Path:
        """Write the page of `stickslip report`, which needs no network, and return its path.

        `boundaries` takes the lines that the method `boundaries` returns, and draws them on the
        map.

        >>> ds = run({"sweep": {"T": [200, 250, 300], "omega": [10, 12]}})
        >>> page = ds.stickslip.report("regimes.html")

        Raises ReportError if no page can be made, StorageError if it cannot be written.
        """
        from sweeps.page import name_of, write_report

        page = path_of(path)
        write_report(self._ds.compute(), page, name=name_of(self._ds), borders=boundaries)
        return page
