"""What every peer can do."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from importlib import metadata

import numpy as np

from peers.scaled import compile_all
from stickslip.parameters import Parameters

State = tuple[float, float, float]
"""(x, v, ln phi) in SI units."""

LADDER = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)

# Long enough for a solver to take its first steps and to have its own parts compiled.
_WARM_UP_PHASE = 1e-3


class PeerFailed(RuntimeError):  # noqa: N818 - an outcome of the benchmark, not an error of it
    """A solver gave up, or ended with something that is not a state."""


class Peer(ABC):
    """A solver of another package on the scaled equations of `peers.scaled`.

    `package` is the distribution that it comes from, `ladder` the tolerances it is measured at,
    `slow` whether quick runs leave it out.
    """

    package: str
    ladder: tuple[float, ...] = LADDER
    slow: bool = True

    def version(self) -> str | None:
        """Return version of the installed package; None where it is not installed."""
        try:
            return metadata.version(self.package)
        except metadata.PackageNotFoundError:
            return None

    def end_state(self, parameters: Parameters, start: State, periods: int, rtol: float) -> State:
        """Return the state (x, v, ln phi) after so many drive periods from `start` at phase 0.

        Raises PeerFailed where the solver does not get there.
        """
        row, X_m, V_m = _scales(parameters)
        begin = np.array([start[0] / X_m, -start[1] / V_m, start[2]])  # u = -v at phase 0
        end = self.integrate(row, begin, 2.0 * math.pi * periods, rtol)
        if not np.isfinite(end).all():
            raise PeerFailed("ends with NaN")
        return float(end[0]) * X_m, -float(end[1]) * V_m, float(end[2])

    def prepare(
        self,
        parameters: Parameters,
        start: State,
        periods: int,  # noqa: ARG002 - for solvers whose end is compiled in
        rtol: float,
    ) -> None:
        """Do what need not be timed: imports and compilation for this fluid and tolerance."""
        row, X_m, V_m = _scales(parameters)
        begin = np.array([start[0] / X_m, -start[1] / V_m, start[2]])  # u = -v at phase 0
        compile_all(row, begin)
        self.integrate(row, begin, _WARM_UP_PHASE, rtol)

    @abstractmethod
    def integrate(
        self, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
    ) -> np.ndarray:
        """Return the scaled state at `phase` from `begin` at 0; raises PeerFailed."""


def _scales(parameters: Parameters) -> tuple[np.ndarray, float, float]:
    X_m = abs(parameters.drive_amplitude)
    return np.array(parameters, dtype=float), X_m, X_m * parameters.angular_frequency
