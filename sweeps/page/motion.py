"""The computation of a point: its stationary orbit, and the motion along it."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.kernels.families import KIND
from stickslip.options import NoiseError
from stickslip.orbit import Orbit, prepare_kernels
from stickslip.parameters import Parameters
from stickslip.status import IntegrationError
from stickslip.trajectory import simulate
from sweeps.engine.settings import options_of
from sweeps.page.beginning import Opened
from sweeps.page.turns import Void
from sweeps.points import periods_of

if TYPE_CHECKING:
    import xarray as xr

_SAMPLES = 2000  # of a drive period
_MOST_SAMPLES = 8000  # of all periods: more than a picture has pixels

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Motion:
    """A point that was computed: its orbit and the time courses, or why there are none."""

    opened: Opened
    orbit: Orbit | None = None
    courses: xr.Dataset | None = None
    trouble: str = ""
    seconds: float = 0.0

    @property
    def drive_periods(self) -> float:
        """How many periods of the drive the courses last."""
        if self.courses is None:
            return 1.0
        rate = self.opened.point.parameters.angular_frequency
        return rate * float(self.courses["elapsed_time"].values[-1]) / (2.0 * np.pi)


def prepare(opened: Opened) -> None:
    """Compile or load the kernels that a point needs: on the first run of a version, a minute."""
    options = options_of(opened.config)
    prepare_kernels(options, np.array([[getattr(opened.point.parameters, name) for name in KIND]]))
    # Any motion, to have the kernels of trajectories.
    simulate(
        Parameters(),
        periods=1,
        samples_per_period=1,
        noise=options.noise,
        friction=options.friction,
        strain=options.strain,
    )


def compute(opened: Opened) -> Motion:
    """Return the motion of a point; what goes wrong is its `trouble`, in a sentence.

    Raises Void, which the check of this thread may raise between two kernels.
    """
    point, orbit = opened.point, None
    try:
        begun = time.perf_counter()
        orbit = point.orbit()
        samples = min(_SAMPLES, _MOST_SAMPLES // periods_of(orbit))
        courses = point.simulate(samples_per_period=max(samples, 1))
    except Void:
        raise
    except Exception as error:  # noqa: BLE001 - a sentence on the page says it
        return failed(opened, error, orbit)
    return Motion(opened, orbit, courses, seconds=time.perf_counter() - begun)


def failed(opened: Opened, error: Exception, orbit: Orbit | None = None) -> Motion:
    """Return the motion of a point that could not be computed, with the reason."""
    if isinstance(error, NoiseError | IntegrationError):
        return Motion(opened, orbit, trouble=_sentence(error))
    log.debug("unexpected", exc_info=error)
    return Motion(opened, orbit, trouble=f"Unexpected {type(error).__name__}: {error}")


def _sentence(error: Exception) -> str:
    text = str(error)
    return text[:1].upper() + text[1:]
