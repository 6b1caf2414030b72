"""The summary of a point: amplitudes with their error, regime, status, other results."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping

from stickslip.orbit import Orbit
from stickslip.parameters import Parameters
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.symbols import as_html
from stickslip.variables import RESULTS
from sweeps.charts.colours import code_name, kind_colour
from sweeps.charts.labels import shown_number
from sweeps.figure_table import AMPLITUDES
from sweeps.page.motion import Motion

_SMALL_PART = 0.01  # of the full force: errors of smaller amplitudes are relative to it
_FEWEST, _MOST = 2, 7  # digits of an amplitude
_DIGITS = 3  # of everything else
_TIMES = "\u00a0×\u00a0"  # a line does not break within a number

# What is shown where it says something.
_FURTHER = {
    "amplitude_error": "stated relative error",
    "orbit_periods": "closes after (periods)",
    "periods_integrated": "periods integrated",
    "floquet_multiplier": "Floquet multiplier |μ|",
    "lyapunov_exponent": "Lyapunov exponent",
    "melting_count": "meltings over the orbit",
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
    """The summary of a motion."""
    orbit = motion.orbit
    if orbit is None:
        return _paragraph("trouble", motion.trouble)
    errors = absolute_errors(orbit, motion.opened.point.parameters)
    parts = [_amplitudes(orbit, errors), _kind(orbit), _status(orbit)]
    if motion.trouble:
        parts.append(_paragraph("trouble", motion.trouble))
    elif not orbit.status.is_result:
        parts.append(_paragraph("note", "Drawn is the motion from its start."))
    notes = [*_comparison(motion), f"Computed in {1e3 * motion.seconds:.0f} ms."]
    return "".join([*parts, _table(orbit), _paragraph("note", " ".join(notes))])


def kept_html(motion: Motion) -> str:
    """A motion that is kept for comparison, in a few words."""
    opened, orbit = motion.opened, motion.orbit
    parts = [f"Kept: {html.escape(opened.label)}"]
    if orbit is not None:
        errors = absolute_errors(orbit, opened.point.parameters)
        parts += [
            f"{as_html(shown_number(name, 0.0).symbol)} "
            f"{amplitude_text(name, getattr(orbit, name), error)}"
            for name, error in errors.items()
        ]
        parts.append(code_name("regime", Regime(orbit.regime)))
    return f'<p class="kept">{"; ".join(parts)}.</p>'


def amplitude_text(name: str, value: float, error: float) -> str:
    """An amplitude in the unit in which it is shown, with no more digits than its error allows.

    `error` is absolute, in the unit of the value. What is not above it is unknown but for that.
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
    """The stated error of both amplitudes; the comment of `amplitude_error` has the yardsticks."""
    full = max(2 * p.spring_stiffness, p.block_mass * p.angular_frequency**2)
    force = _SMALL_PART * full * abs(p.drive_amplitude)
    yardsticks = dict(zip(AMPLITUDES, (force / p.contact_area, force), strict=True))
    return {
        name: orbit.amplitude_error * max(getattr(orbit, name), least)
        for name, least in yardsticks.items()
    }


def _amplitudes(orbit: Orbit, errors: Mapping[str, float]) -> str:
    cells = [
        f'<div><span class="symbol">{as_html(shown_number(name, 0.0).symbol)}</span> '
        f'<span class="value" data-name="{name}">'
        f"{amplitude_text(name, getattr(orbit, name), error)}</span></div>"
        for name, error in errors.items()
    ]
    return f'<div class="amplitudes">{"".join(cells)}</div>'


def _kind(orbit: Orbit) -> str:
    regime = Regime(orbit.regime)
    square = f'<span class="square" style="background:{kind_colour("regime", regime)}">'
    name = code_name("regime", regime)
    return f'<p>{square}</span><b data-name="regime">{name}</b>. {regime.sentence}</p>'


def _status(orbit: Orbit) -> str:
    status = Status(orbit.status)
    kind = "note" if status.is_result else "trouble"
    name = code_name("status", status)
    sentence = html.escape(status.sentence).replace("`", "")
    return f'<p class="{kind}"><b data-name="status">{name}</b>. {sentence}</p>'


def _table(orbit: Orbit) -> str:
    rows = [
        f'<div>{text}</div><div class="value" data-name="{name}">'
        f"{_value(name, getattr(orbit, name), getattr(orbit, f'{name}_error', 0.0))}</div>"
        for name, text in _FURTHER.items()
        if _says_something(name, getattr(orbit, name))
    ]
    return f'<div class="table">{"".join(rows)}</div>'


def _says_something(name: str, value: float) -> bool:
    return math.isfinite(value) and value != RESULTS[name].missing


def _value(name: str, value: float, error: float = 0.0) -> str:
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
    """Return the comparison with the file, for a point of a file."""
    point = motion.opened.point
    if not point.stored or motion.trouble:
        return []
    if point.status is Status.PENDING:
        return ["The file has not computed this point yet."]
    if point.status is Status.INTERPOLATED:
        return ["The file has interpolated this point; here it is computed."]
    differences = point.differences()
    if not differences:
        return ["The same numbers as in the file, to the last bit."]
    values = [f"{name} is {stored:.7g} in the file" for name, (stored, _) in differences.items()]
    more = f" and {len(values) - 3} more" if len(values) > 3 else ""
    return [f"Not as in the file: {'; '.join(values[:3])}{more}.", *map(_capital, point.versions)]


def _capital(sentence: str) -> str:
    return f"{sentence[:1].upper()}{sentence[1:]}."


def _paragraph(kind: str, text: str) -> str:
    return f'<p class="{kind}">{html.escape(text)}</p>'
