"""The points that an address names, and what names a point.

A point is written as the `--set` that make it of the paper's, or as `at.NAME` of its place in the
file. What else the end of an address says (what is chosen, kept and zoomed) the script of the page
writes and reads.
"""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr

from stickslip.variables import canonical_name
from sweeps.charts.at import places_at
from sweeps.config.load import from_mapping
from sweeps.page.beginning import Opened, lone, open_point, with_parameters
from sweeps.page.ranges import exact_text
from sweeps.page.texts import SECTIONS, changes_text
from sweeps.points import PointError

_AT = "at."


def within(parts: Mapping[str, str], prefix: str) -> dict[str, str]:
    """Return the parts with a prefix, without it."""
    return {k.removeprefix(prefix): part for k, part in parts.items() if k.startswith(prefix)}


def changes_of(opened: Opened) -> dict[str, str]:
    """Return what makes the paper's point this one; at least its temperature."""
    usual = {"temperature": exact_text(opened.point.parameters.temperature)}
    return usual | changes_text(opened)


def place_of(opened: Opened, result: xr.Dataset | None) -> dict[str, str] | None:
    """Return where a point of the file is, as `at.NAME` and values; None for any other point."""
    if opened.place is None or result is None:
        return None
    return {_AT + dim: value_text(result, dim, at) for dim, at in opened.place.items()}


def opened_by(parts: Mapping[str, str], result: xr.Dataset | None) -> Opened:
    """Return the point that is asked for.

    Raises ConfigError for what is no parameter, setting or value of one, and PointError for what
    the file does not have.
    """
    if place := within(parts, _AT):
        if result is None:
            raise PointError("this page has no result file to open a point of")
        try:
            at = places_at(result, [f"{name}={value}" for name, value in place.items()])
        except ValueError as error:
            raise PointError(str(error)) from None
        if left := [d for d, size in result.sizes.items() if size > 1 and d not in at]:
            raise PointError(f"several points are left: at.{left[0]} is missing")
        return open_point(result, at)
    _refuse_further_keys(parts)
    config = from_mapping({}, overrides=[f"{key}={part}" for key, part in parts.items()])
    if config.sweep or config.cases:
        raise PointError("an address has one value of each parameter")
    return lone(with_parameters(config, config.parameters()))


def _refuse_further_keys(parts: Mapping[str, str]) -> None:
    """Raise PointError for what is neither a parameter nor a setting of the page.

    Above all for keys that name a file to read.
    """
    for key in parts:
        section, dot, _ = key.partition(".")
        if not (section in SECTIONS if dot else canonical_name(key)):
            raise PointError(f"{key} is neither a parameter nor a setting")


def value_text(result: xr.Dataset, dim: str, at: int) -> str:
    """Return where a place along an axis is, as `places_at` reads it."""
    value = result[dim].values[at]
    return exact_text(float(value)) if value.dtype.kind in "fiu" else str(value)
