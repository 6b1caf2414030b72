"""The picture of a posterior: each free parameter, and each pair of them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from sweeps.charts.labels import shown, shown_number
from sweeps.figures.style import new_figure, palette, put_note

_BINS, _INCHES, _BESIDE = 40, 1.7, 0.8  # inches: of a panel, and of the labels beside the panels
_TICKS = 3.0  # per inch: as many slanting numbers as do not touch
_QUANTILES, _LEVELS = (0.025, 0.5, 0.975), (0.68, 0.95)


def posterior(ds: xr.Dataset) -> Figure:
    """Histograms of parameters on the diagonal, pairs of parameters below it.

    Lines mark quantiles, and contours hold parts of the draws; the note says which.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)  # of ArviZ, which corner imports if present
        from corner import corner

    names = list(map(str, ds.free_parameter.values))
    drawn = [ds.posterior_draws.sel(free_parameter=name).rename(name) for name in names]
    columns = np.array([shown(each).values.ravel() for each in drawn])
    best = [float(ds.parameter_value.sel(free_parameter=name)) for name in names]
    numbers = [shown_number(name, value) for name, value in zip(names, best, strict=True)]
    side = _BESIDE + _INCHES * len(names)
    figure = new_figure((side, side))
    panel = (min(figure.get_size_inches()) - _BESIDE) / len(names)
    colours = palette().cycle
    corner(
        columns.T,
        bins=_BINS,
        max_n_ticks=max(3, round(_TICKS * panel)),
        quantiles=_QUANTILES,
        levels=_LEVELS,
        smooth=1.0,
        fig=figure,
        color=colours[0],
        plot_datapoints=False,
        hist_bin_factor=1,
    )
    # Labels from corner lie at a fixed part of a panel's side, which is within the ticks of a small
    # panel; these move with the ticks.
    panels = np.array(figure.axes).reshape(len(names), len(names))
    for place, number in enumerate(numbers):
        panels[-1, place].set_xlabel(number.label)
        if place:  # the first row has no vertical axis
            panels[place, 0].set_ylabel(number.label)
    figure.align_labels()
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
