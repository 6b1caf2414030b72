"""How motions reach their orbits: a search, a watch over those that wander, and another search.

This is the same for all methods.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from stickslip.kernels.orbits.motions import HALVES, OUTCOME
from stickslip.kernels.orbits.settling import APERIODIC, March, Search, settle
from stickslip.kernels.orbits.watching import Watched, watch
from stickslip.numerics.adaptive import OK
from stickslip.status import Status

PENDING = int(Status.PENDING)


class WatchedMarch(March, Protocol):
    """A march whose motions can be watched on their way."""

    def walk(self, rows: np.ndarray) -> Any:
        """Return the `TangentWalk` of the motions in these rows (m,)."""

    def rejoin(self, rows: np.ndarray, walk: Any) -> None:
        """Let the motions in these rows (m,) go on from the states of a walk."""


def find_orbits(march: WatchedMarch, task: Search, window: int) -> list[tuple[np.ndarray, Watched]]:
    """Bring the motions that are ok to their orbits; return rows and records of the aperiodic ones.

    A motion that wanders is watched over a window of drive periods. If its neighbours approach it,
    the search goes on for longer cycles. If there is no such cycle either, the motion is aperiodic.
    """
    counts, aperiodic = march.motions.counts, []
    pending = np.flatnonzero(counts[:, OUTCOME] == OK)
    # The first search is for short cycles, the second for long ones if neighbours approach.
    for late in (False, True):
        settle(march, pending, task._replace(late=late))
        pending = pending[counts[pending, OUTCOME] == APERIODIC]
        if not len(pending):
            break
        walk = march.walk(pending)
        watched = watch(walk, window, decisive=late)
        march.rejoin(pending, walk)
        outcomes = walk.outcomes()
        outcomes[outcomes == PENDING] = OK  # these go on, since their neighbours approach them
        outcomes[watched.aperiodic] = APERIODIC
        counts[pending, OUTCOME] = outcomes
        counts[pending, HALVES] += 2 * watched.periods
        aperiodic.append((pending[watched.aperiodic], watched.part(watched.aperiodic)))
        pending = pending[outcomes == OK]
    return aperiodic
