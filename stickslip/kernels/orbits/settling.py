"""The search for orbits, which advances motions by the map and judges them until all settle.

A march only advances the motions. A compiled loop then passes the states to the searches of
`numerics/periodic/search.py` and carries out their verdicts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np

from stickslip.compiled.decorators import inline, jit, kernel_factory, named_kernel
from stickslip.compiled.fields import make_row_reader
from stickslip.compiled.simd import LANES
from stickslip.kernels.families import Family, FamilyKernel, families
from stickslip.kernels.orbits.motions import (
    AHEAD,
    ATTEMPTED,
    CONTROL,
    CYCLE,
    DONE,
    FILM_COLUMNS,
    HALVES,
    HIGHEST,
    KINDS,
    LOWEST,
    MOST_AHEAD,
    OUTCOME,
    Motions,
    fresh_control,
    new_motions,
)
from stickslip.kernels.orbits.states import StateFunctions, state_functions
from stickslip.kernels.problem import rounding_speed
from stickslip.model import drive, solids
from stickslip.model.models import model_of
from stickslip.model.noise import clearance, freezes_late, in_between
from stickslip.model.rhs import Equations
from stickslip.model.scaling import Reduced
from stickslip.model.state import FILM, STATE
from stickslip.numerics.adaptive import OK
from stickslip.numerics.periodic import search
from stickslip.options import Physics
from stickslip.parameters import Parameters
from stickslip.status import Status

NOT_STATIONARY, APERIODIC = int(Status.NOT_STATIONARY), int(Status.APERIODIC)

REFINEMENT = 0.1
"""The finer tolerance of the search, and of the measurement, as a fraction of the coarser one."""

TIGHTEST = 1e-13
"""The smallest tolerance, below which rounding dominates."""

# The largest tolerance on the way to an orbit. With a larger one a film may miss the moment at
# which it freezes, and end on another orbit.
_SEARCH = 1e-5

# The longest jump, in units of the scaled position, of a film that may freeze late. It is so short
# that it does not skip the periods in which the film freezes.
_LATE_JUMP = 0.1

# The number of searches at a time, of 15 to 18 kB each. There are so many that no lane waits, and
# so few that a long search begins early, while there are others for the remaining lanes.
AT_A_TIME = 4 * LANES

# For each such number of applications since a verdict last moved the state, a search takes one more
# at a time, so that fewer than one in this number are dropped.
_UNDISTURBED = 8

_STAYS, _LEAVES = -1, -2

_reduced_of = make_row_reader(Reduced)


class March(Protocol):
    """The way in which a method advances motions; it neither judges nor measures them."""

    motions: Motions
    physics: Physics
    per_period: int
    """Applications of its map in a drive period: 2 with half periods and mirror images, else 1."""

    def advance(self, family: Family) -> Callable[[np.ndarray], np.ndarray]:
        """Return the function that advances motions of a family by applications of the map.

        It takes the rows (m,) of more motions, and returns the rows (k,) of some that have ended
        while others go on; no rows mean that all have ended. Each motion advances by AHEAD
        applications or fewer. The result of each application is in `Motions.ahead`, their number in
        DONE, and a failure of the next one in OUTCOME.
        """


class Search(NamedTuple):
    """The tolerance of a search, its distance to the limit, and its budget of half periods.

    A march without a tolerance has an `rtol` of 0, and its search never jumps.
    """

    rtol: float
    distance: float
    max_halves: int
    accelerate: bool
    per_period: int = 2
    late: bool = False
    """True for a search that follows one that found no cycle."""


@inline
def _finer(task: Search, cuts: int) -> float:
    """Tolerance of a search after so many cuts; the first puts the noise below the distance."""
    first = min(task.rtol * REFINEMENT, _SEARCH, max(task.distance, TIGHTEST))
    return first * REFINEMENT ** (cuts - 1)


@inline
def _first(task: Search) -> float:
    """Tolerance of a search that begins, or begins again."""
    return _finer(task, 1) if task.late else min(task.rtol, _SEARCH)


@inline
def _longest_jump(p: Parameters, phi: float, waits: bool) -> float:
    """Longest jump allowed, since a jump must not skip the periods in which a film freezes late.

    A film that `waits` may freeze, but was liquid throughout the last half period.
    """
    if not (freezes_late(p) or waits):
        return np.inf
    return 0.0 if in_between(p, phi) else _LATE_JUMP


def _make_limit_search(equations: Equations) -> Any:
    """Return the function that limits the jumps of a search after a half period.

    It takes (memory, p, u_s, phi, lowest, highest), with the speed below which a cusp is rounded,
    the order parameter at the end of the half period, and the extremes of ln(phi) during it. If a
    film may still freeze, a jump must not skip that moment (docs/decisions/late-freezing.md).
    """
    strain_amplitude, rounded = equations.strain_amplitude, equations.law.rounded
    upper_displacement = equations.upper.displacement

    @jit
    def out_of_reach(p: Parameters, u_s: float, phi: float) -> tuple[float, float]:
        """Gain and least distance of `search.keep_clear`, beyond which a liquid cannot freeze."""
        strain = strain_amplitude(p, 1.0)
        if drive.highest_harmonic(p) > 1.0 or not strain > 0.0:  # the bound holds for a sine
            return np.inf, np.inf
        critical = solids.solidification_strain(p) / strain
        gain, least = clearance(p, critical)
        # Friction makes a passage through rest longer, most of all with a cusp there.
        stress, slope, _ = rounded(p, critical, phi, u_s)
        return gain + slope * p.contact_area, least + stress * p.contact_area

    @jit
    def limit_search(
        memory: Any, p: Parameters, u_s: float, phi: float, lowest: float, highest: float
    ) -> None:
        least_phi, most_phi = math.exp(lowest), math.exp(highest)
        solid = solids.solid_threshold(p)
        contracting = solids.parts_never(p, least_phi, most_phi)
        # In a liquid that cannot freeze the peaks do not matter.
        may_freeze = p.temperature < solids.solidification_temperature(p, 0.0)
        peak = STATE[FILM].weight * max(highest, STATE[FILM].floor) if may_freeze else 0.0
        longest = _longest_jump(p, phi, may_freeze and most_phi < solid)
        search.limit_jumps(memory, longest, contracting, peak)
        if not may_freeze:
            return
        search.limit_spirals(memory)
        if least_phi < solid:
            gain, least = np.inf, np.inf
            if most_phi < solid:
                gain, least = out_of_reach(p, u_s, most_phi)
            centre, stiffness = upper_displacement(p, 0.0), 2.0 * p.spring_stiffness
            search.keep_clear(memory, centre, stiffness, gain, least)

    return limit_search


class _Kernels(NamedTuple):
    """The kernels of searches for one family.

    `rows` (m,) belong to the points to work on, and `places` (n,) is the index of each row's search
    among the `memories` (k,).
    """

    start: Any
    """(motions, rows, places, memories, task): begin searches at the states of the motions."""

    judge: Any
    """(motions, rows, waiting, places, memories, task): judge the applications of points, and move
    their states. In place of each search that has ended begin one of the points `waiting` (w,). Put
    the points that go on first in `rows`; return their number and how many began."""


def kernels_of(family: Family) -> _Kernels:
    """Return the kernels of a family; rheological index and kind of noise make no difference."""
    return _search_kernels(family._replace(physics=family.physics.typical, gamma=None))


def _make_limit(family: Family) -> Any:
    """Return the function (motions, row, memory) that limits the jumps of a search."""
    model = model_of(family.physics)
    values_of: Any = model.values(None, higher=family.higher)
    limit_search = _make_limit_search(model.equations)

    @jit
    def limit(motions: Motions, row: int, memory: Any) -> None:
        p, film = values_of(_reduced_of(motions.points[row])), motions.film[row]
        u_s, phi = rounding_speed(p, motions.rtols[row]), math.exp(motions.states[row, FILM])
        limit_search(memory, p, u_s, phi, film[LOWEST], film[HIGHEST])

    return limit


def _make_carry_out(state: StateFunctions, width: int) -> Any:
    """Return the function (motions, row, memory, task) that carries out the verdict of a search.

    It returns a Status, or _STAYS if the search goes on from this state, or _LEAVES if it goes on
    from another state or at another tolerance.
    """
    of_row, judged, unjudged, moved = state.of_row, state.judged, state.unjudged, state.moved

    @inline
    def put_state(row: np.ndarray, y: Any) -> None:
        for component in range(width):
            row[component] = y[component]

    @jit
    def carry_out(motions: Motions, row: int, memory: Any, task: Search) -> int:
        y, counts = of_row(motions.states[row]), motions.counts[row]
        # The search counts its own applications, but earlier ones have used the budget too.
        halves = 2 // task.per_period
        budget = (task.max_halves - counts[HALVES]) // halves + memory.applications
        counts[HALVES] += halves
        verdict, dx, dv = search.judge(memory, judged(y), task.distance, motions.rtols[row], budget)
        y = moved(y, dx, dv)
        put_state(motions.states[row], y)
        if verdict == search.SETTLED:
            # The remaining way to the limit is known, so the measurement begins nearer to it.
            dx, dv = search.last_correction(memory)
            put_state(motions.states[row], moved(y, dx, dv))
            counts[CYCLE], motions.ratios[row] = search.found(memory)
            return OK
        if verdict == search.EXHAUSTED:
            return NOT_STATIONARY
        if verdict == search.WANDERING:
            return APERIODIC
        if verdict == search.FINER:
            motions.rtols[row] = _finer(task, memory.fineness)
        elif verdict == search.RESTORE:
            # A jump went astray. Return to the state before it, as at the start of a search.
            put_state(motions.states[row], unjudged(memory.stored))
            motions.rtols[row] = _first(task)
        return _STAYS if verdict == search.GO_ON else _LEAVES

    return carry_out


@jit
def _take_over(motions: Motions, row: int, application: int) -> None:
    """Copy the result of an application, in the layout of `ahead_of`, into the motion."""
    ahead, width = motions.ahead, motions.states.shape[1] - 1
    control, film = width + 1, width + 1 + CONTROL
    for column in range(width + 1):
        motions.states[row, column] = ahead[row, application, column]
    for column in range(CONTROL):
        motions.control[row, column] = ahead[row, application, control + column]
    for column in range(FILM_COLUMNS):
        motions.film[row, column] = ahead[row, application, film + column]


def _make_judge_motion(limit: Any, carry_out: Any) -> Any:
    """Return the function (motions, row, memory, task) that judges the applications of a motion.

    It judges one after the other until a verdict moves the state, and drops the rest. It returns a
    Status, or a negative number if the search goes on.
    """

    @jit
    def judge_motion(motions: Motions, row: int, memory: Any, task: Search) -> int:
        counts, outcome, used = motions.counts[row], _STAYS, 0
        while outcome == _STAYS and used < counts[DONE]:
            _take_over(motions, row, used)
            used += 1
            if task.rtol > 0.0:
                limit(motions, row, memory)
            outcome = carry_out(motions, row, memory, task)
        if outcome == _STAYS and counts[OUTCOME] != OK:  # the next one failed
            _take_over(motions, row, used)
            used += 1
            outcome = counts[OUTCOME]
        counts[ATTEMPTED] += int(motions.ahead[row, used - 1, -1])
        counts[AHEAD] = min(max(memory.newest // _UNDISTURBED, 1), MOST_AHEAD)
        return outcome

    return judge_motion


@kernel_factory
def _search_kernels(family: Family) -> _Kernels:
    model = model_of(family.physics)
    state = state_functions(model.components)
    of_row, judged = state.of_row, state.judged
    judge_motion = _make_judge_motion(_make_limit(family), _make_carry_out(state, model.width))

    @jit
    def begin(motions: Motions, row: int, memory: Any, task: Search) -> None:
        motions.rtols[row], motions.counts[row, AHEAD] = _first(task), 1
        z, refinable = judged(of_row(motions.states[row])), task.rtol > 0.0
        search.start(memory, z, task.per_period, task.accelerate, refinable, task.late)

    def start(
        motions: Motions, rows: np.ndarray, places: np.ndarray, memories: np.ndarray, task: Search
    ) -> None:
        for row in rows:
            begin(motions, row, memories[places[row]], task)

    def judge(
        motions: Motions,
        rows: np.ndarray,
        waiting: np.ndarray,
        places: np.ndarray,
        memories: np.ndarray,
        task: Search,
    ) -> tuple[int, int]:
        going = 0
        for i in range(len(rows)):
            row = rows[i]
            outcome = judge_motion(motions, row, memories[places[row]], task)
            if outcome < 0:
                rows[i], rows[going] = rows[going], row
                going += 1
            motions.counts[row, OUTCOME] = max(outcome, OK)
        begun = min(len(rows) - going, len(waiting))
        for i in range(begun):
            row, place = waiting[i], places[rows[going + i]]
            rows[going + i], places[row] = row, place
            begin(motions, row, memories[place], task)
        return going + begun, begun

    named = (named_kernel(f"{each.__name__}_search[{family}]", each) for each in (start, judge))
    return _Kernels(*named)


def search_kernels(kinds: np.ndarray, physics: Physics) -> Iterator[FamilyKernel]:
    """Yield the kernels of searches for points of these kinds (n, k), as in `families.KIND`."""
    task, width = Search(1.0, 1.0, 0, True), model_of(physics).width
    nobody = new_motions(np.empty((0, len(Reduced._fields))), np.empty((0, width + 1)))
    rows, memories = np.empty(0, np.int64), np.empty(0, search.memory_of(width))
    for start, judge in dict.fromkeys(kernels_of(family) for family, _ in families(physics, kinds)):
        yield FamilyKernel(start, partial(start, nobody, rows, rows, memories, task))
        yield FamilyKernel(judge, partial(judge, nobody, rows, rows, rows, memories, task))


def settle(march: March, rows: np.ndarray, task: Search) -> None:
    """Bring the motions in these rows (m,) to their orbits, at phase 0.

    Their outcome is OK, with the cycle and its contraction, APERIODIC if a search wanders,
    NOT_STATIONARY if its budget is spent, or the Status of a failure.
    """
    march.motions.control[rows] = fresh_control(len(rows))
    for family, members in families(march.physics, march.motions.points[:, KINDS][rows]):
        _settle(march, rows[members], task, family)


def _settle(march: March, rows: np.ndarray, task: Search, family: Family) -> None:
    """Settle rows (m,) of one family; when a search ends, the next point gets its memory."""
    motions, advance, (start, judge) = march.motions, march.advance(family), kernels_of(family)
    memories = np.zeros(min(len(rows), AT_A_TIME), search.memory_of(motions.width))
    places = np.empty(len(motions.points), np.int64)  # index among the memories, by row
    first, waiting = rows[: len(memories)], rows[len(memories) :]
    places[first] = np.arange(len(memories))
    start(motions, first, places, memories, task)
    ended = advance(first)
    while len(ended):
        going, begun = judge(motions, ended, waiting, places, memories, task)
        waiting = waiting[begun:]
        ended = advance(ended[:going])
