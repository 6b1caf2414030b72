"""Linked cases in no order, such as random ones: points against each parameter that they vary."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from stickslip.variables import canonical_name
from sweeps.charts.axes import MANY, is_scattered
from sweeps.charts.choice import ROLES, Choice
from sweeps.charts.labels import Array, parameters_along
from sweeps.grid import CASE

_WIDE = 5.0  # largest over smallest value: from here on a logarithmic axis may fit better


def cases_to_scatter(ds: xr.Dataset, choice: Choice) -> bool:
    """Tell whether to draw points: for cases in no order that have no other role."""
    if ds.sizes.get(CASE, 1) == 1 or not is_scattered(ds, CASE):
        return False
    along = {CASE, *parameters_along(ds, CASE)}
    names = (getattr(choice, role) for role in ROLES)
    named = {canonical_name(name) or name for name in names if name}
    return named <= along and (ds.sizes[CASE] > MANY or len(ds.sizes) == 1)


def fits_log(values: Array) -> bool:
    """Tell whether the median of the values is nearer to their centre on a logarithmic scale."""
    low, middle, high = np.quantile(values, [0.0, 0.5, 1.0])
    if low <= 0 or high < _WIDE * low:
        return False
    return bool(abs(math.log(middle**2 / (low * high))) < abs(math.log(2 * middle / (low + high))))
