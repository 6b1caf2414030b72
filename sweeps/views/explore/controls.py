"""A slider and a box for every parameter; what is typed and not valid is refused in a sentence."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from pathlib import Path

from bokeh.layouts import column, row
from bokeh.models import Column, Div, Row, Slider, TextInput

from stickslip.parameters import ParameterError, Parameters
from stickslip.symbols import as_html, plain
from stickslip.variables import PARAMETERS, ParameterVariable
from sweeps.charts.labels import typeset_units
from sweeps.config.numbers import number
from sweeps.views.explore.ranges import Scale, exact_text, short_text

GROUPS: dict[str, tuple[str, ...]] = {
    "main": (
        "temperature",
        "viscosity_coefficient",
        "spring_stiffness",
        "rheological_index",
        "angular_frequency",
        "drive_amplitude",
    ),
    "block": ("block_mass", "initial_displacement", "initial_velocity", "initial_order_parameter"),
    "film": ("film_thickness", "contact_area", "strain_relaxation_time"),
}
GROUPS["energy"] = tuple(
    name for name in PARAMETERS if not any(name in group for group in GROUPS.values())
)
"""The parameters by group; the last group has all that no other one names."""

_SYMBOL, _BOX, _UNIT = 34, 86, 58  # pixels; the slider has the rest
_STYLE = Path(__file__).with_name("controls.css").read_text(encoding="utf-8")


class ParameterControl:
    """The slider and the box of one parameter; `changed` is told a value, or a refused text."""

    def __init__(
        self, name: str, scale: Scale, value: float, changed: Callable[[str, float | str], None]
    ) -> None:
        self._name, self._scale, self._changed = name, scale, changed
        self._quiet = False
        words, unit = name.replace("_", " "), plain(_units(PARAMETERS[name]))
        start, end = scale.ends
        self.slider = Slider(
            css_classes=[f"slider-{name}"], start=start, end=end, step=scale.step,
            value=scale.position(value), show_value=False, title=None, tooltips=False,
            sizing_mode="stretch_width", stylesheets=[_STYLE], bar_color="#0072B2",
            html_attributes={"data-label": words},
        )  # fmt: skip
        self.box = TextInput(
            title=f"{words}{unit and ', '}{unit}", value=short_text(value), width=_BOX,
            stylesheets=[_STYLE],
        )  # fmt: skip
        self.mark(refused=False)
        self.slider.on_change("value", self._slid)
        self.box.on_change("value", self._typed)

    @property
    def row(self) -> Row:
        """Symbol, slider, box and unit in a line."""
        parameter = PARAMETERS[self._name]
        symbol = (
            f'<span class="symbol" title="{html.escape(_help(parameter))}">'
            f"{as_html(f'${parameter.tex}$')}</span>"
        )
        unit = f'<span class="unit">{as_html(_units(parameter))}</span>'
        texts = [
            Div(text=text, width=width, stylesheets=[_STYLE], disable_math=True)
            for text, width in ((symbol, _SYMBOL), (unit, _UNIT))
        ]
        parts = [texts[0], self.slider, self.box, texts[1]]
        look = {"align-items": "center", "height": "31px"}
        return row(*parts, spacing=8, styles=look, sizing_mode="stretch_width")

    def show(self, value: float) -> None:
        """Stand at a value without telling of it."""
        self._reach(value)
        self._quietly(self.slider, self._scale.position(value))
        self._quietly(self.box, short_text(value))
        self.mark(refused=False)

    def mark(self, *, refused: bool) -> None:
        """Show whether what stands in the box is refused."""
        self.box.css_classes = [f"box-{self._name}", *(["refused"] if refused else [])]

    def _slid(self, _attribute: str, _old: float, position: float) -> None:
        if self._quiet:
            return
        value = self._scale.value(position)
        self._quietly(self.box, short_text(value))
        self._changed(self._name, value)

    def _typed(self, _attribute: str, _old: str, text: str) -> None:
        if self._quiet:
            return
        try:
            value = read_number(text)
        except ValueError as error:
            self._changed(self._name, f"{self._name} {error}")
            return
        if PARAMETERS[self._name].complaint(value) is None:
            self._reach(value)
            self._quietly(self.slider, self._scale.position(value))
        self._changed(self._name, value)

    def _reach(self, value: float) -> None:
        """Make the slider longer where a value lies beyond its end."""
        self._scale = self._scale.reaching(value)
        start, end = self._scale.ends
        self.slider.update(start=start, end=end, step=self._scale.step)

    def _quietly(self, widget: Slider | TextInput, value: float | str) -> None:
        self._quiet = True
        widget.value = value
        self._quiet = False


class Controls:
    """All parameters. `changed` is told of valid ones, `refused` of sentences, none where all are.

    A value that is refused stays in its box; the parameters keep the valid one from before.
    """

    def __init__(
        self,
        scales: Mapping[str, Scale],
        parameters: Parameters,
        changed: Callable[[Parameters], None],
        refused: Callable[[list[str]], None],
    ) -> None:
        self._changed, self._refused = changed, refused
        self._parameters = parameters
        self._complaints: dict[str, str] = {}
        self.controls = {
            name: ParameterControl(name, scales[name], value, self._change)
            for name, value in parameters._asdict().items()
        }

    def column(self, group: str) -> Column:
        """The controls of a group, one below the other."""
        rows = [self.controls[name].row for name in GROUPS[group]]
        return column(*rows, name=group, spacing=2, sizing_mode="stretch_width")

    def show(self, parameters: Parameters) -> None:
        """Stand at these parameters without telling of them."""
        self._parameters = parameters
        self._complaints.clear()
        self._refused([])
        for name, value in parameters._asdict().items():
            self.controls[name].show(value)

    def _change(self, name: str, value: float | str) -> None:
        complaint = value if isinstance(value, str) else self._try(name, value)
        self.controls[name].mark(refused=complaint is not None)
        if complaint is None:
            self._complaints.pop(name, None)
        else:
            kept = (
                f"{exact_text(self._parameters._asdict()[name])} {plain(_units(PARAMETERS[name]))}"
            )
            self._complaints[name] = f"{complaint}. Shown is {kept.strip()}."
        self._refused(list(self._complaints.values()))
        if complaint is None:
            self._changed(self._parameters)

    def _try(self, name: str, value: float) -> str | None:
        """Take over a value; why it cannot be, where it cannot."""
        try:
            self._parameters = self._parameters._replace(**{name: value})
        except ParameterError as error:
            return str(error)
        return None


def read_number(text: str) -> float:
    """The number in a text as of `--set`; raises ValueError with the end of a sentence."""
    try:
        return float(text) + 0.0
    except ValueError:
        return number(text)


def _units(parameter: ParameterVariable) -> str:
    if parameter.name == "viscosity_coefficient":
        return r"Pa$\cdot$s$^{\gamma+1}$"  # Eq. 7
    return typeset_units(parameter.units)


def _help(parameter: ParameterVariable) -> str:
    default = f"{exact_text(parameter.default)} {plain(_units(parameter))}".strip()
    comment = f" ({parameter.comment})" if parameter.comment else ""
    return f"{parameter.name}: {parameter.meaning}{comment}; in the paper {default}"
