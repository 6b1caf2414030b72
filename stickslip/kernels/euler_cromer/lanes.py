"""The march of Euler-Cromer, which takes many points through drive periods at the same time."""

from __future__ import annotations

import numpy as np

from stickslip.kernels.euler_cromer.layout import clear_records, row_kernels, row_length
from stickslip.kernels.euler_cromer.march import march_kernel
from stickslip.kernels.families import KIND, families
from stickslip.measure.accumulate import RECORD
from stickslip.numerics.adaptive import OK, STEP_LIMIT
from stickslip.numerics.euler_cromer_lanes import PENDING, Tasks
from stickslip.options import Physics
from stickslip.parameters import Parameters

_KIND = [Parameters._fields.index(name) for name in KIND]
_NOISE = Parameters._fields.index("noise_intensity")

# Steps of all lanes together between two returns to the interpreter, about a tenth of a second.
_AT_A_TIME = 2**20


class March:
    """The motions of points, a `plain_iteration.march.March` that can also cover part of a period.

    Parameters
    ----------
    points
        (n, parameters) in SI units, in the order of `Parameters._fields`.
    steps
        (n,) steps per drive period.
    states
        (n, 3) states (x, v, phi) at phase 0, in SI units.
    physics
        The equations, in which the strain follows instantly.
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
        """Put the points with the indices `which` (m,) at the beginning of a period.

        They will march to its end, or for `limits` (m,) steps.
        """
        tasks, total = self.tasks, self.steps[which]
        tasks.total[which] = total if limits is None else np.minimum(total, limits)
        tasks.done[which], tasks.status[which] = 0, PENDING

    def period(self, which: np.ndarray, limits: np.ndarray, *, measured: bool) -> np.ndarray:
        """Take the points with indices `which` (m,) through a period; return the Status (m,)."""
        self.start(which, limits)
        self.march(measured)
        outcome = self.tasks.status[which]
        # A task is also ok at its limit of steps, which may lie before the end of the period.
        outcome[(outcome == OK) & (limits < self.steps[which])] = STEP_LIMIT
        return outcome

    def clear_records(self, which: np.ndarray) -> None:
        """Clear the records of the points with the indices `which` (m,)."""
        clear_records(self.tasks.rows, which)

    def march(self, measured: bool = False) -> None:
        """March the started points to their ends; their status is then OK or DIVERGED."""
        status = self.tasks.status
        pending = np.flatnonzero(status == PENDING)
        for family, members in families(self.physics, self.points[:, _KIND][pending]):
            rows = pending[members]
            with_noise = self.points[rows, _NOISE] > 0.0
            for noisy in (False, True):
                march, queue = march_kernel(family, noisy, measured), rows[with_noise == noisy]
                while np.any(status[queue] == PENDING):
                    march(self.tasks, queue, _AT_A_TIME)

    def states(self) -> np.ndarray:
        """Return the states (x, v, phi) in SI units, (n, 3)."""
        states = np.empty((len(self.points), 3))
        read = row_kernels(self.physics.typical).read_states
        read(self.points, self.steps, self.tasks.rows, states)
        return states

    def records(self, closed: bool = True) -> np.ndarray:
        """Return the records (n, RECORD) in SI units, of orbits if `closed`, else of stretches."""
        records = np.empty((len(self.points), RECORD))
        read = row_kernels(self.physics.typical).read_records
        read(self.points, self.steps, self.tasks.rows, closed, records)
        return records
