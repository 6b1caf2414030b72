"""What the page and its script in the browser tell each other."""

from __future__ import annotations

from collections.abc import Callable

from bokeh.core.properties import Float, String
from bokeh.model import DataModel
from bokeh.models import CustomJS

from sweeps.views.explore.pictures import OrbitPictures

_BEGIN = "page.begin({state, motion, portrait, courses})"


class PageState(DataModel):  # type: ignore[misc]
    """The end of the address that the page has and one that is asked for, keys, and the time."""

    address = String()
    asked = String()
    key = String()
    """An arrow key and the number of the keystroke, so that the same key is heard twice."""
    periods = Float(1.0)
    """Periods of the drive that the motion lasts."""

    def on_asked(self, told: Callable[[str], None]) -> None:
        """Have an end of the address told that somebody gave the page."""

        def heard(_attribute: str, _old: str, new: str) -> None:
            if new:
                self.asked = ""  # so that the same one is heard again
                told(new)

        self.on_change("asked", heard)

    def on_step(self, told: Callable[[int, int], None]) -> None:
        """Have the steps to the right and upward told that arrow keys ask for."""
        steps = {"Left": (-1, 0), "Right": (1, 0), "Down": (0, -1), "Up": (0, 1)}

        def heard(_attribute: str, _old: str, new: str) -> None:
            if step := steps.get(new.partition(" ")[0].removeprefix("Arrow")):
                told(*step)

        self.on_change("key", heard)

    def beginning(self, pictures: OrbitPictures) -> CustomJS:
        """Return what hands all that the script works with to it."""
        return CustomJS(
            args={
                "state": self,
                "motion": pictures.source,
                "portrait": pictures.portrait,
                "courses": pictures.courses,
            },
            code=_BEGIN,
        )
