"""The accessor `ds.stickslip` of Datasets of this program: points, figures, masks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, canonical_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sweeps.views.points import Point


@xr.register_dataset_accessor("stickslip")  # type: ignore[no-untyped-call]
class StickslipAccessor:
    """Methods for the result of a sweep or a part of it; `plot` also works on a trajectory."""

    def __init__(self, ds: xr.Dataset) -> None:
        self._ds = ds

    def at(self, **where: Any) -> Point:
        """Return the point nearest to values such as `temperature=228`, by name or symbol, in SI.

        Its `.orbit()`, `.simulate()` and `.portrait()` compute it again. Raises PointError if the
        values do not single out one point.
        """
        from sweeps.views.points import point_of

        return point_of(self._ds, **where)

    def ok(self) -> xr.Dataset:
        """Return the Dataset with NaN in all result variables of failed and pending points.

        Counts and flags become floats, since integers have no NaN.
        """
        results = [status for status in Status if status.is_result]
        valid = self._ds["status"].isin(results)
        masked = {n: self._ds[n].where(valid) for n in RESULT_COLUMNS if n in self._ds.data_vars}
        return self._ds.assign(masked)

    def plot(
        self,
        variable: str | None = None,
        *,
        x: str | None = None,
        y: str | None = None,
        hue: str | None = None,
        row: str | None = None,
        col: str | None = None,
        at: dict[str, Any] | None = None,
        log: str = "",
        figure: str | None = None,
    ) -> Figure:
        """Return the picture that `stickslip plot` draws, with the same options.

        Without `variable` both amplitudes are drawn. `at` cuts axes, such as `{"temperature":
        228}`; `log` names logarithmic scales, such as 'x,z'; `figure` names a figure instead.
        Raises ValueError for a choice that the data do not have.
        """
        from sweeps.figures import PlotOptions, draw
        from sweeps.figures.save import displayed

        cuts = tuple(f"{name}={value}" for name, value in (at or {}).items())
        return displayed(
            draw(self._ds, figure, PlotOptions(variable, x, y, hue, row, col, cuts, log))
        )

    def map(self, variable: str, x: str | None = None, y: str | None = None, **at: Any) -> Figure:
        """Return a map of a variable over two axes, others cut by keyword: `map("regime", K=500)`.

        By default the axes are the two longest. Raises ValueError as `plot` does.
        """
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

    def report(self, path: str | Path) -> Path:
        """Write the page of `stickslip report`, which needs no network, and return its path.

        Raises ReportError if no page can be made, StorageError if it cannot be written.
        """
        from sweeps.views.report import write_report

        # The page shows commands with this name; a result in memory has no file yet.
        source = self._ds.encoding.get("source", "FILE")
        write_report(self._ds, Path(path), name=Path(source).name)
        return Path(path)


def _listed(ds: xr.Dataset) -> str:
    return ", ".join(str(dim) for dim, size in ds.sizes.items() if size > 1) or "none"
