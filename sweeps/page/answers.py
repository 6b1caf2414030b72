"""The answer to a request of the page: the motion at a point, and its numbers.

It is a line of JSON for each thing that is to be told: what is waited for, then the motion.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from stickslip.kernels.interruption import checked_by
from stickslip.variables import PARAMETERS, RESULTS, canonical_name
from sweeps.charts.labels import Array, shown_number
from sweeps.exits import ExpectedError
from sweeps.page import address
from sweeps.page.beginning import Beginning, Opened
from sweeps.page.controls import complaint_of, settings_of
from sweeps.page.motion import Motion, compute, failed, prepare
from sweeps.page.orbit_figures import DRAWN, columns_of
from sweeps.page.ranges import short_text
from sweeps.page.summary import kept_html, summary_html
from sweeps.page.texts import command_text, config_text
from sweeps.page.turns import Turns, Void
from sweeps.points import periods_of

TAB, NUMBER = "tab", "number"
"""The keys by which a request names its tab and itself; all others are those of an address."""


def answer_lines(
    parts: Mapping[str, str], beginning: Beginning, turns: Turns
) -> Iterator[dict[str, Any]]:
    """Yield what a page is told that asks for a point: its state, and in the end what was found.

    The `state` is waiting, compiling or computing; then done, refused (with sentences), or void,
    where a later request of the same tab has arrived.
    """
    own = {key: text for key, text in parts.items() if key not in (TAB, NUMBER)}
    try:
        number = int(parts.get(NUMBER, "0"))
        opened = address.opened_by(own, beginning.result) if own else beginning.first
    except (ExpectedError, ValueError) as error:
        yield {"state": "refused", "refused": _complaints(own), "sentence": str(error)}
        return
    try:
        yield {"state": "waiting"}
        with turns.take(parts.get(TAB, ""), number) as turn, checked_by(turn.check):
            yield {"state": "compiling"}
            prepare(opened)
            turn.check()
            yield {"state": "computing"}
            motion = compute(opened)
    except Void:
        yield {"state": "void"}
        return
    except Exception as error:  # noqa: BLE001 - a sentence on the page says it
        motion = failed(opened, error)
    yield {"state": "done", **point_data(opened, beginning.result), **motion_data(motion)}


def as_json(data: Mapping[str, Any]) -> bytes:
    """Return a line of JSON."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).encode() + b"\n"


def _complaints(parts: Mapping[str, str]) -> dict[str, str]:
    """Return what is wrong with the values of parameters, by their full names."""
    named = {canonical_name(key) or key: text for key, text in parts.items()}
    found = {name: complaint_of(name, text) for name, text in named.items() if name in PARAMETERS}
    return {name: why for name, why in found.items() if why}


def point_data(opened: Opened, result: xr.Dataset | None) -> dict[str, Any]:
    """Return what the controls and the address of the page say of a point."""
    parameters = opened.point.parameters._asdict()
    return {
        "label": opened.label,
        "parts": address.changes_of(opened),
        "at": address.place_of(opened, result),
        "texts": {name: short_text(value) for name, value in parameters.items()},
        "values": parameters,
        "settings": settings_of(opened.config),
    }


def motion_data(motion: Motion) -> dict[str, Any]:
    """Return what is drawn of a motion and said of it."""
    orbit, opened = motion.orbit, motion.opened
    found = orbit is not None and orbit.status.is_result
    periods = periods_of(orbit) if found and orbit else 1
    names = (*PARAMETERS, *(RESULTS if orbit else ()))
    values = opened.point.parameters._asdict()
    numbers = {name: values[name] if name in values else getattr(orbit, name) for name in names}
    columns = {} if motion.courses is None else columns_of(motion.courses, DRAWN)
    return {
        "courses": {name: _packed(column) for name, column in columns.items()} or None,
        "periods": motion.drive_periods,
        "shown": {name: _shown(name, value) for name, value in numbers.items()},
        "summary": summary_html(motion),
        "kept": kept_html(motion),
        "config": config_text(opened, periods),
        "command": command_text(opened, periods),
    }


def _packed(column: Array) -> str:
    """Return numbers in single precision, more than a picture shows, as base64."""
    return base64.b64encode(column.astype("<f4").tobytes()).decode()


def _shown(name: str, value: Any) -> float | None:
    """Return a value in the unit in which it is shown; None for none."""
    number = float(np.float64(shown_number(name, float(value)).values))
    return number if math.isfinite(number) else None
