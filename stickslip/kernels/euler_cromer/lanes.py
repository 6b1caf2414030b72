"""Many points on their way through drive periods by Euler-Cromer, side by side."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.kernels.euler_cromer.layout import clear_records, row_kernels, row_length
from stickslip.kernels.euler_cromer.march import march_kernel
from stickslip.kernels.families import KIND, Family, families
from stickslip.measure.accumulate import RECORD
from stickslip.numerics.adaptive import OK, STEP_LIMIT
from stickslip.numerics.euler_cromer_lanes import PENDING, Tasks
from stickslip.options import Physics
from stickslip.parameters import Parameters

_KIND = [Parameters._fields.index(name) for name in KIND]
_NOISE = Parameters._fields.index("noise_intensity")

# Steps of all lanes together between two looks at the interpreter: a tenth of a second.
_AT_A_TIME = 2**20

_UNLIMITED = 2**62


class March:
    """Points on their way: a `motions.March` that can also go a part of a period.

    Parameters
    ----------
    points
        (n, parameters) in SI units, in the order of `Parameters._fields`.
    steps
        (n,) steps a drive period.
    states
        (n, 3) states (x, v, phi) at phase 0, in SI units.
    physics
        The equations; the strain follows at once.
    """

    def __init__(
        self, points: np.ndarray, steps: np.ndarray, states: np.ndarray, physics: Physics
    ) -> None:
        self.points, self.steps, self.physics = points, steps, physics
        count = len(points)
        self.tasks = Tasks(
            rows=np.zeros((count, row_length(physics))),
            done=np.zeros(count, np.int64),
            total=np.zeros(count, np.int64),
            status=np.zeros(count, np.int64),
        )
        row_kernels(physics.typical).fill(points, steps, states, self.tasks.rows)

    def start(self, which: np.ndarray, limits: np.ndarray | None = None) -> None:
        """Put the points with the indices `which` (m,) to the beginning of a period.

        They are to go to its end, or for as many steps as `limits` (m,) allows.
        """
        tasks, total = self.tasks, self.steps[which]
        tasks.total[which] = total if limits is None else np.minimum(total, limits)
        tasks.done[which], tasks.status[which] = 0, PENDING

    def period(self, which: np.ndarray, limits: np.ndarray, *, measured: bool) -> np.ndarray:
        """As `motions.March`."""
        self.start(which, limits)
        self.march(measured)
        outcome = self.tasks.status[which]
        outcome[(outcome == OK) & (limits < self.steps[which])] = STEP_LIMIT
        return outcome

    def clear_records(self, which: np.ndarray) -> None:
        """Forget what was measured of the points with the indices `which` (m,)."""
        clear_records(self.tasks.rows, which)

    def march(self, measured: bool = False, budget: int | None = None) -> int:
        """Let the points that were started go on, for at most `budget` steps of all lanes.

        Returns what is left of the budget, 0 where there is more to do: call it again. The
        statuses are in `tasks.status`: PENDING, OK at the end, DIVERGED.
        """
        left = _UNLIMITED if budget is None else budget
        for family, noisy, queue in self._families():
            march = march_kernel(family, noisy, measured)
            while left > 0 and np.any(self.tasks.status[queue] == PENDING):
                given = min(left, _AT_A_TIME)
                left -= given - march(self.tasks, queue, given)
        return left

    def _families(self) -> Iterator[tuple[Family, bool, np.ndarray]]:
        """Points that share a kernel: their family, whether there is noise, their indices."""
        pending = np.flatnonzero(self.tasks.status == PENDING)
        for family, members in families(self.physics, self.points[:, _KIND][pending]):
            rows = pending[members]
            with_noise = self.points[rows, _NOISE] > 0.0
            for noisy in (False, True):
                yield family, noisy, rows[with_noise == noisy]

    def states(self) -> np.ndarray:
        """The states (x, v, phi) in SI units, (n, 3)."""
        states = np.empty((len(self.points), 3))
        read = row_kernels(self.physics.typical).read_states
        read(self.points, self.steps, self.tasks.rows, states)
        return states

    def records(self, closed: bool = True) -> np.ndarray:
        """What was measured, in SI units, (n, RECORD): of orbits if `closed`, or of stretches."""
        records = np.empty((len(self.points), RECORD))
        read = row_kernels(self.physics.typical).read_records
        read(self.points, self.steps, self.tasks.rows, closed, records)
        return records
