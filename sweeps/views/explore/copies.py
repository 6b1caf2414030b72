"""The point that is shown as text to copy, in two boxes with a button each."""

from __future__ import annotations

from bokeh.layouts import column
from bokeh.models import Button, Column, CustomJS, TextAreaInput

from sweeps.views.explore.beginning import Opened
from sweeps.views.explore.texts import command_text, config_text

_WIDTH = 360  # pixels
_STYLE = "textarea { font: 12px monospace; }"
_TO_CLIPBOARD = "navigator.clipboard.writeText(box.value); this.origin.label = 'Copied'"


class Copies:
    """A config and a command line of the point that is shown."""

    def __init__(self) -> None:
        self.config = self._box("config", rows=11)
        self.command = self._box("command", rows=4)

    @property
    def column(self) -> Column:
        """The boxes, each with its button below."""
        parts = []
        for box in (self.config, self.command):
            button = Button(label="Copy", width=90, name="copy")
            # Whether a browser lets a page write to the clipboard, only the browser knows.
            button.js_on_click(CustomJS(args={"box": box}, code=_TO_CLIPBOARD))
            box.js_on_change(
                "value", CustomJS(args={"button": button}, code="button.label = 'Copy'")
            )
            parts += [box, button]
        return column(*parts, name="copy", sizing_mode="stretch_width")

    def show(self, opened: Opened, periods: int) -> None:
        """Take the texts of a point whose orbit closes after so many periods."""
        self.config.value = config_text(opened, periods)
        self.command.value = command_text(opened, periods)

    def _box(self, name: str, rows: int) -> TextAreaInput:
        titles = {"config": "a config of this point (YAML)", "command": "the command"}
        return TextAreaInput(
            css_classes=[name], title=titles[name], rows=rows, max_length=None,
            sizing_mode="stretch_width", max_width=_WIDTH,
            stylesheets=[_STYLE],
        )  # fmt: skip
