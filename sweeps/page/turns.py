"""The computation of a point for a page, in turn: its stationary orbit and the motion along it.

Few requests compute at a time, and only the latest one of each tab. Compiled code cannot be
stopped, so a computation calls `check` between its parts.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.kernels.families import KIND
from stickslip.options import NoiseError
from stickslip.orbit import Orbit, prepare_kernels
from stickslip.parameters import Parameters
from stickslip.status import IntegrationError
from stickslip.trajectory import simulate
from sweeps.charts.courses import TIME_COURSES
from sweeps.charts.labels import Array, shown
from sweeps.engine.settings import options_of
from sweeps.exits import ExpectedError
from sweeps.page.subject import ShownPoint
from sweeps.points import periods_of

if TYPE_CHECKING:
    import xarray as xr

MOST_TABS = 1000  # beyond this number, the tab silent for longest is forgotten
_SAMPLES = 2000  # of a drive period
_MOST_SAMPLES = 8000  # of all periods: more than a picture has pixels

COURSES = (TIME_COURSES[0], *TIME_COURSES[2:])
"""The panels of a motion; the phase portrait shows its velocity."""

DRAWN = (
    *("elapsed_time", "lower_velocity"),
    *(trace.name for traces in COURSES for trace in traces),
    "order_parameter",
)
"""The variables drawn of a motion, first the time; the film shows the order parameter."""

log = logging.getLogger(__name__)


class Void(Exception):  # noqa: N818 - an outcome of a request, not an error of it
    """A later request of the same tab has arrived, and nobody waits for this answer any more."""


class Turns:
    """Lets as many threads compute at a time as there are `slots`."""

    def __init__(self, slots: int = 2) -> None:
        self._free = slots
        self._changed = threading.Condition()
        self._latest: dict[str, int] = {}  # the number of the latest request of each tab
        self._waiting: list[Callable[[], None]] = []  # the checks, the longest waiting first

    @property
    def waiting(self) -> int:
        """The number of requests that wait for a slot."""
        return len(self._waiting)

    @contextmanager
    def take(self, tab: str, number: int) -> Iterator[Callable[[], None]]:
        """Wait for a slot, and hold it in the context.

        Both this wait and the check that the context gets raise `Void` if a later request of the
        tab has arrived.
        """

        def check() -> None:
            with self._changed:
                if self._latest.get(tab, number) > number:
                    raise Void

        def may_begin() -> bool:
            check()
            return self._free > 0 and self._waiting[0] is check

        with self._changed:
            self._latest[tab] = max(number, self._latest.pop(tab, number))  # at the end now
            if len(self._latest) > MOST_TABS:
                del self._latest[next(iter(self._latest))]
            self._waiting.append(check)
            self._changed.notify_all()  # earlier requests of the tab are void
            try:
                self._changed.wait_for(may_begin)
                self._free -= 1
            finally:
                self._waiting.remove(check)
                self._changed.notify_all()
        try:
            yield check
        finally:
            with self._changed:
                self._free += 1
                self._changed.notify_all()


@dataclass(frozen=True)
class Motion:
    """The result of computing a point: its orbit and time courses, or why there are none."""

    shown_point: ShownPoint
    orbit: Orbit | None = None
    courses: xr.Dataset | None = None
    trouble: str = ""
    seconds: float = 0.0


def drive_periods(courses: xr.Dataset | None) -> float:
    """Return the number of drive periods that the courses of a motion last."""
    if courses is None:
        return 1.0
    rate = float(courses["angular_frequency"])
    return rate * float(courses["elapsed_time"][-1]) / (2.0 * np.pi)


def columns_of(courses: xr.Dataset) -> dict[str, Array]:
    """Return the time courses of a motion as they are drawn."""
    return {name: shown(courses[name]).values for name in DRAWN}


def prepare(shown_point: ShownPoint) -> None:
    """Compile or load the kernels that a point needs; the first run of a version takes a minute."""
    options, parameters = options_of(shown_point.config), shown_point.point.parameters
    prepare_kernels(options, np.array([[getattr(parameters, name) for name in KIND]]))
    # Simulate anything that every noise allows, to compile the kernels of trajectories.
    simulate(
        Parameters(initial_order_parameter=0.5),
        periods=1,
        samples_per_period=1,
        noise=options.noise,
        friction=options.friction,
        strain=options.strain,
    )


def compute(shown_point: ShownPoint) -> Motion:
    """Return the motion of a point; its `trouble` describes any failure in a sentence.

    Raises Void if the check of this thread does so between two kernels.
    """
    point, orbit = shown_point.point, None
    try:
        begun = time.perf_counter()
        orbit = point.orbit()
        samples = min(_SAMPLES, _MOST_SAMPLES // periods_of(orbit))
        courses = point.simulate(samples_per_period=max(samples, 1))
    except Void:
        raise
    except Exception as error:  # noqa: BLE001 - the page reports it in a sentence
        return failed(shown_point, error, orbit)
    return Motion(shown_point, orbit, courses, seconds=time.perf_counter() - begun)


def failed(shown_point: ShownPoint, error: Exception, orbit: Orbit | None = None) -> Motion:
    """Return the motion of a point that cannot be computed, with the reason."""
    if isinstance(error, NoiseError | IntegrationError | ExpectedError):
        return Motion(shown_point, orbit, trouble=capitalised(str(error)))
    log.debug("unexpected", exc_info=error)
    return Motion(shown_point, orbit, trouble=f"Unexpected {type(error).__name__}: {error}")


def capitalised(text: str) -> str:
    """Return a text with a capital, as the beginning of a sentence."""
    return text[:1].upper() + text[1:]
