"""The picture of a posterior: each free parameter, and each pair of them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from sweeps.charts.labels import shown, shown_number
from sweeps.figures.style import new_figure, palette, put_note

_BINS, _INCHES = 40, 1.7
_QUANTILES, _LEVELS = (0.025, 0.5, 0.975), (0.68, 0.95)


def posterior(ds: xr.Dataset) -> Figure:
    """Histograms of parameters on the diagonal, pairs of parameters below it.

    Lines mark the quantiles, and contours hold these parts of the draws, as the note says.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)  # of ArviZ, which corner imports if present
        from corner import corner

    names = list(map(str, ds.free_parameter.values))
    drawn = [ds.posterior_draws.sel(free_parameter=name).rename(name) for name in names]
    columns = np.array([shown(each).values.ravel() for each in drawn])
    best = [float(ds.parameter_value.sel(free_parameter=name)) for name in names]
    numbers = [shown_number(name, value) for name, value in zip(names, best, strict=True)]
    side = 0.8 + _INCHES * len(names)
    figure = new_figure((side, side))
    colours = palette().cycle
    corner(
        columns.T,
        bins=_BINS,
        labels=[number.label for number in numbers],
        quantiles=_QUANTILES,
        levels=_LEVELS,
        smooth=1.0,
        fig=figure,
        color=colours[0],
        plot_datapoints=False,
        hist_bin_factor=1,
    )
    for axes in figure.axes:
        if not axes.get_frame_on():  # the other half of the pairs, which has no panels
            axes.remove()
    figure.set_layout_engine("constrained")  # which leaves room for the note; corner's own does not
    draws = round(float(ds.attrs["posterior_independent_draws"]))
    put_note(
        figure,
        [
            f"{draws} independent draws. Contours enclose {_percent(_LEVELS)} of the probability; "
            f"dashed lines are the {_percent(_QUANTILES)} quantiles."
        ],
    )
    return figure


def _percent(parts: Sequence[float]) -> str:
    """Return parts of 1 as text: `68 and 95 %`."""
    *others, last = (f"{100.0 * part:g}" for part in parts)
    return f"{', '.join(others)} and {last}\u00a0%"
