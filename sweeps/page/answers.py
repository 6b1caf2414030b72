"""The answer to a request from the page: the motion of a point, its numbers and a summary.

The answer consists of lines of JSON: first what the page is waiting for, then the motion.
"""

from __future__ import annotations

import base64
import html
import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from stickslip.kernels.interruption import checked_by
from stickslip.model.drive import full_forces
from stickslip.orbit import Orbit
from stickslip.parameters import Parameters
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.symbols import as_html
from stickslip.variables import PARAMETERS, RESULTS, canonical_name
from sweeps.charts.colours import code_name, kind_colour
from sweeps.charts.labels import shown_number
from sweeps.exits import ExpectedError
from sweeps.figure_table import AMPLITUDES
from sweeps.page.controls import complaint_of, settings_of, short_text
from sweeps.page.subject import (
    ShownPoint,
    Subject,
    changes_of,
    command_text,
    config_text,
    place_of,
    point_of_address,
)
from sweeps.page.turns import (
    Motion,
    Turns,
    Void,
    capitalised,
    columns_of,
    compute,
    drive_periods,
    failed,
    prepare,
)
from sweeps.points import Start, periods_of

TAB, NUMBER = "tab", "number"
"""The keys for the tab and the number of a request; all other keys belong to an address."""


def answer_lines(
    parts: Mapping[str, str], subject: Subject, turns: Turns
) -> Iterator[dict[str, Any]]:
    """Yield the answers to a page that requests a point: the state and, at the end, the result.

    The `state` is waiting, compiling or computing, and finally done, refused (with sentences) or
    void, if a later request of the same tab has arrived.
    """
    own = {key: text for key, text in parts.items() if key not in (TAB, NUMBER)}
    try:
        number = int(parts.get(NUMBER, "0"))
        shown_point = point_of_address(own, subject.result) if own else subject.first
    except (ExpectedError, ValueError) as error:
        names = {canonical_name(key) or key: text for key, text in own.items()}
        complaints = {n: complaint_of(n, text) for n, text in names.items() if n in PARAMETERS}
        refused = {name: why for name, why in complaints.items() if why}
        yield {"state": "refused", "refused": refused, "sentence": str(error), "parts": names}
        return
    try:
        yield {"state": "waiting"}
        with turns.take(parts.get(TAB, ""), number) as check, checked_by(check):
            yield {"state": "compiling"}
            prepare(shown_point)
            check()
            yield {"state": "computing"}
            motion = compute(shown_point)
    except Void:
        yield {"state": "void"}
        return
    except Exception as error:  # noqa: BLE001 - the page reports it in a sentence
        motion = failed(shown_point, error)
    yield {"state": "done", **point_data(shown_point, subject.result), **_motion_data(motion)}


def as_json(data: Mapping[str, Any]) -> bytes:
    """Return data as a line of JSON."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).encode() + b"\n"


def point_data(shown_point: ShownPoint, result: xr.Dataset | None) -> dict[str, Any]:
    """Return what the controls and the address of the page show of a point."""
    parameters = shown_point.point.parameters._asdict()
    return {
        "label": shown_point.label,
        "parts": changes_of(shown_point),
        "at": place_of(shown_point, result),
        "texts": {name: short_text(value) for name, value in parameters.items()},
        "values": parameters,
        "settings": settings_of(shown_point.config),
    }


def _motion_data(motion: Motion) -> dict[str, Any]:
    """Return the courses of a motion, its numbers and the texts about it."""
    orbit, shown_point = motion.orbit, motion.shown_point
    periods = periods_of(orbit) if orbit else 1
    start: Start = "stationary" if orbit and orbit.status.is_result else "initial"
    numbers = shown_point.point.parameters._asdict()
    if orbit:
        numbers |= {name: getattr(orbit, name) for name in RESULTS}
    shown = {name: float(shown_number(name, float(v)).values) for name, v in numbers.items()}
    columns = {} if motion.courses is None else columns_of(motion.courses)
    # In single precision, which is more than a picture shows.
    packed = {name: base64.b64encode(c.astype("<f4").tobytes()) for name, c in columns.items()}
    return {
        "courses": {name: text.decode() for name, text in packed.items()} or None,
        "periods": drive_periods(motion.courses),
        "shown": {name: v if math.isfinite(v) else None for name, v in shown.items()},
        "summary": summary_html(motion),
        "kept": _kept_html(motion),
        "config": config_text(shown_point, periods, start),
        "command": command_text(shown_point, periods, start),
    }


# --- the summary of a point: amplitudes with their errors, regime, status, other results ----------

_SMALL_PART = 0.01  # of the full force; errors of smaller amplitudes are relative to it
_FEWEST, _MOST = 2, 7  # digits of an amplitude
_DIGITS = 3  # of everything else
_TIMES = "\u00a0×\u00a0"  # a line must not break within a number

# Shown only for orbits that have such a value.
_FURTHER = {
    "amplitude_error": "stated relative error",
    "orbit_periods": "closes after (periods)",
    "periods_integrated": "periods integrated",
    "floquet_multiplier": "Floquet multiplier |μ|",
    "lyapunov_exponent": "Lyapunov exponent",
    "melting_count": "melting events over the orbit",
    "dissipated_energy": "energy dissipated per period",
    "friction_force_in_phase": "force in phase with the drive F′",
    "friction_force_out_of_phase": "force in phase with its velocity F″",
    "friction_force_rms": "root mean square of the force",
    "friction_force_mean_abs": "mean of |F|",
    "solid_fraction": "solid fraction",
    "asymmetry": "asymmetry",
    "power_balance_error": "power balance error",
}


def summary_html(motion: Motion) -> str:
    """Return the summary of a motion."""
    orbit = motion.orbit
    if orbit is None:
        return _paragraph("trouble", motion.trouble)
    regime, status = Regime(orbit.regime), Status(orbit.status)
    square = f'<span class="square" style="background:{kind_colour("regime", regime)}">'
    name = code_name("regime", regime)
    sentence = html.escape(status.sentence).replace("`", "")
    parts = [
        _amplitudes(motion, orbit),
        f'<p>{square}</span><b data-name="regime">{name}</b>. {regime.sentence}</p>',
        f'<p class="{"note" if status.is_result else "trouble"}">'
        f'<b data-name="status">{code_name("status", status)}</b>. {sentence}</p>',
    ]
    if motion.trouble:
        parts.append(_paragraph("trouble", motion.trouble))
    elif not status.is_result:
        parts.append(_paragraph("note", "The motion is drawn from its start."))
    notes = [*_comparison(motion), f"Computed in {1e3 * motion.seconds:.0f} ms."]
    return "".join([*parts, _table(orbit), _paragraph("note", " ".join(notes))])


def _amplitudes(motion: Motion, orbit: Orbit) -> str:
    cells = [
        f'<div><span class="symbol">{symbol}</span> '
        f'<span class="value" data-name="{name}">{text}</span></div>'
        for name, symbol, text in _amplitude_texts(orbit, motion.shown_point)
    ]
    return f'<div class="amplitudes">{"".join(cells)}</div>'


def _kept_html(motion: Motion) -> str:
    """Return a short text on a motion kept for comparison."""
    shown_point, orbit = motion.shown_point, motion.orbit
    parts = [f"Kept: {html.escape(shown_point.label)}"]
    if orbit is not None:
        parts += [f"{symbol} {text}" for _, symbol, text in _amplitude_texts(orbit, shown_point)]
        parts.append(code_name("regime", Regime(orbit.regime)))
    return f'<p class="kept">{"; ".join(parts)}.</p>'


def _amplitude_texts(orbit: Orbit, shown_point: ShownPoint) -> Iterator[tuple[str, str, str]]:
    """Yield the name, symbol and text of each amplitude."""
    for name, error in absolute_errors(orbit, shown_point.point.parameters).items():
        symbol = as_html(shown_number(name, 0.0).symbol)
        yield name, symbol, amplitude_text(name, getattr(orbit, name), error)


def amplitude_text(name: str, value: float, error: float) -> str:
    """Return an amplitude in its shown unit, with no more digits than its error allows.

    `error` is absolute, in the unit of the value. A value not above its error is given as "below".
    """
    if not math.isfinite(value):
        return "—"
    quantity, bound = shown_number(name, value), shown_number(name, error)
    units = as_html(quantity.units)
    if value <= error:
        return f"below {_number(float(bound.values), _FEWEST)} {units}"
    known = _MOST
    if error > 0.0:
        known = min(max(math.floor(math.log10(value / error)), _FEWEST), _MOST)
    return f"{_number(float(quantity.values), known)} {units}"


def absolute_errors(orbit: Orbit, p: Parameters) -> dict[str, float]:
    """Return the stated errors of both amplitudes; `amplitude_error` documents the yardsticks."""
    force = _SMALL_PART * full_forces(np.array([p], dtype=float)).item()
    yardsticks = dict(zip(AMPLITUDES, (force / p.contact_area, force), strict=True))
    return {
        name: orbit.amplitude_error * max(getattr(orbit, name), least)
        for name, least in yardsticks.items()
    }


def _table(orbit: Orbit) -> str:
    """Return a table of the further results that exist for an orbit."""
    values = {name: getattr(orbit, name) for name in _FURTHER}
    rows = [
        f'<div>{_FURTHER[name]}</div><div class="value" data-name="{name}">'
        f"{_value(name, value, getattr(orbit, f'{name}_error', 0.0))}</div>"
        for name, value in values.items()
        if math.isfinite(value) and value != RESULTS[name].missing
    ]
    return f'<div class="table">{"".join(rows)}</div>'


def _value(name: str, value: float, error: float) -> str:
    if RESULTS[name].dtype == "i4":
        return code_name(name, int(value))
    quantity = shown_number(name, value)
    number = _number(float(quantity.values), _DIGITS)
    if error:
        number += f" ±\u00a0{_number(float(shown_number(name, error).values), _FEWEST)}"
    return f"{number} {as_html(quantity.units)}".rstrip()


def _number(value: float, digits: int) -> str:
    if value == 0.0:
        return "0"
    mantissa, _, exponent = f"{value:#.{digits}g}".partition("e")
    power = f"{_TIMES}10<sup>{int(exponent)}</sup>" if exponent else ""
    return f"{mantissa.rstrip('.')}{power}".replace("-", "−")


def _comparison(motion: Motion) -> list[str]:
    """Return sentences that compare a point of a file with the numbers there."""
    point = motion.shown_point.point
    if not point.stored or motion.trouble:
        return []
    if point.status is Status.PENDING:
        return ["This point has no result in the file yet."]
    if point.status is Status.INTERPOLATED:
        return ["This point is interpolated in the file, and computed here."]
    differences = point.differences()
    if not differences:
        return ["The same numbers as in the file, to the last bit."]
    values = [f"{name} = {stored:.7g}" for name, (stored, _) in differences.items()]
    more = f" and {len(values) - 3} more" if len(values) > 3 else ""
    versions = [f"{capitalised(text)}." for text in point.versions]
    return [f"The file has different numbers: {', '.join(values[:3])}{more}.", *versions]


def _paragraph(kind: str, text: str) -> str:
    return f'<p class="{kind}">{html.escape(text)}</p>'
