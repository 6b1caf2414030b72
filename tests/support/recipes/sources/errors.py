"""The stated error of the amplitudes, along the first axis."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure


def errors(ds: xr.Dataset) -> Figure:
    """The amplitude errors of a sweep."""
    figure = Figure()
    axes = figure.add_subplot()
    axes.semilogy(ds.amplitude_error.values.ravel())
    return figure
