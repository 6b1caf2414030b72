"""Small displacements of the first state of a measured motion, integrated with it in its lane.

Each component of the state has a column, the derivative of the present state with respect to that
component of the first one. Together the columns are the map of small displacements over the cycle,
whose largest eigenvalue is the Floquet multiplier. The slopes of an extremum, its derivatives with
respect to the first state, come from the columns at its place; its shift in time does not matter to
first order. The slopes of an integral are integrals of the derivatives of its integrand.

The columns describe infinitesimal displacements, but the observables are compared over a finite
distance. If a film locks a block, the slope of friction holds only for displacements so small
that it says nothing about the force.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.elementary import exponentials
from stickslip.compiled.fields import make_function, make_tuple_reader
from stickslip.compiled.simd import LANES, for_lanes
from stickslip.kernels.adaptive.recording import (
    FORCE,
    RECORD_BEGIN,
    SLOTS,
    STRESS,
    Node,
    Step,
    get,
    make_moment,
    put,
    step_reader,
    stream_begin,
)
from stickslip.kernels.orbits.motions import DAMPING, FASTEST, RESOLUTION
from stickslip.kernels.orbits.states import state_functions
from stickslip.kernels.problem import Problem, ProblemFunctions
from stickslip.kernels.streams import STREAM
from stickslip.measure.accumulate import (
    EXTREMA,
    FORCE_MAX,
    FORCE_MIN,
    INTEGRALS,
    RECORD_TABLE,
    SENSITIVE,
    STRESS_MAX,
    STRESS_MIN,
)
from stickslip.model.state import FILM, Component
from stickslip.numerics.lane_array import lane_vectors
from stickslip.numerics.linear import Matrix, Vector, algebra, larger
from stickslip.numerics.variational import DAMPING as DAMPING_OF_A_STEP
from stickslip.numerics.variational import NODES, make_variational_step, shift_of

# A step is near the cusp at u = 0 if u changes by more than this fraction of itself. The motion of
# u is genuine if its rates at both ends agree with its change to within this factor.
_NEAR, _UNLIKE = 0.2, 10.0

# The square of a rate, in units of the drive's rate, above which a motion is fast.
_FAST = 10.0

LEAST_WEIGHT = 0.01
"""The smallest weight of a component that counts. A displacement is larger if the weight is small,
but must not be so large that the film melts or freezes."""


def columns_begin(width: int) -> int:
    """Return the first slot of the columns of a lane; the slopes follow."""
    return stream_begin(width) + STREAM


def room_of(width: int) -> int:
    """Return the number of slots for columns, slopes, last changes of integrands, and resolution.

    The last are `DAMPING` and `FASTEST`.
    """
    return (width + len(SENSITIVE) + len(INTEGRALS)) * width + RESOLUTION


class Variations(NamedTuple):
    """Compiled operations on the columns and slopes of a lane."""

    begin: Callable[..., None]
    """(lanes, lane): set the columns of the first state, after its record has begun."""

    carry: Callable[..., None]
    """(lanes): integrate the columns over the last step of every lane if it was accepted."""

    note: Callable[..., None]
    """(lanes, lane, y, values): store the slopes of stress and force if their `values` in a state
    `y` inside the last step are the extrema. The columns are taken at the end of the step, where
    the fast transients of a stiff film have decayed."""

    mirror: Callable[..., None]
    """(lanes, lane): change to the mirror image of the motion."""

    store: Callable[..., None]
    """(lanes, lane, row): write columns and slopes into a row."""


def make_variations(
    problems: Callable[..., Problem],
    functions: ProblemFunctions,
    components: tuple[Component, ...],
) -> Variations:
    """Return the operations for problems that `problems(lanes, lane)` reads."""
    width, first = functions.width, columns_begin(functions.width)
    get_vector, slopes = lane_vectors(LANES, width).get, first + width * width
    end = first + room_of(width)

    aside, note_extrema = _make_aside(functions), _make_note_extrema(width, slopes)
    reaches = tuple(1.0 / max(c.weight, LEAST_WEIGHT) for c in components)
    across, rhs, step_of = _make_across(components), functions.rhs, step_reader(width)
    see_integrands = _make_see_integrands(functions, slopes)

    @jit
    def begin(lanes: np.ndarray, lane: int) -> None:
        problem, y = problems(lanes, lane), get_vector(lanes, SLOTS.state, lane)
        for slot in range(first, end):
            put(lanes, slot, lane, 0.0)
        for j in range(width):
            put(lanes, first + j * (width + 1), lane, 1.0)
            column = get_vector(lanes, first + j * width, lane)
            sides = aside(lanes, lane, reaches[j], problem, y, column)
            see_integrands(lanes, lane, j, problem, 0.0, 0.0, sides, True)

    @jit
    def note(lanes: np.ndarray, lane: int, y: Vector, values: tuple[float, float]) -> None:
        problem, found = problems(lanes, lane), _extrema(lanes, lane, values, True)
        last = step_of(lanes, lane)
        f1 = rhs(problem, last.t + last.used, last.y1)
        for j in range(width):
            column = get_vector(lanes, first + j * width, lane)
            sides = aside(lanes, lane, reaches[j], problem, y, across(column, f1))
            note_extrema(lanes, lane, j, sides, found)

    carry = _make_carry(
        problems, functions, first, reaches, aside, across, note_extrema, see_integrands
    )
    return Variations(
        begin,
        carry,
        note,
        _make_mirror(components, first, slopes),
        _make_store(width, first, slopes),
    )


def _make_mirror(components: tuple[Component, ...], first: int, slopes: int) -> Any:
    """Return `Variations.mirror` for columns and slopes that begin in these slots."""
    width, mirrored = len(components), state_functions(components).mirrored
    vectors = lane_vectors(LANES, width)
    get_vector, put_vector = vectors.get, vectors.put

    @jit
    def mirror(lanes: np.ndarray, lane: int) -> None:
        for j in range(width):
            column = first + j * width
            put_vector(lanes, column, lane, mirrored(get_vector(lanes, column, lane)))
            for k in range(0, len(EXTREMA), 2):  # a maximum is the minimum of the mirror image
                high, low = slopes + k * width + j, slopes + (k + 1) * width + j
                above = get(lanes, high, lane)
                put(lanes, high, lane, -get(lanes, low, lane))
                put(lanes, low, lane, -above)

    return mirror


def _make_store(width: int, first: int, slopes: int) -> Any:
    """Return `Variations.store` for columns and slopes that begin in these slots."""
    resolution = first + room_of(width) - RESOLUTION

    @jit
    def store(lanes: np.ndarray, lane: int, row: np.ndarray) -> None:
        for slot in range(width * width):
            row[slot] = get(lanes, first + slot, lane)
        for slot in range(len(SENSITIVE) * width):
            row[width * width + slot] = get(lanes, slopes + slot, lane)
        for slot in range(RESOLUTION):
            row[-RESOLUTION + slot] = get(lanes, resolution + slot, lane)

    return store


@inline
def _extrema(
    lanes: np.ndarray, lane: int, values: tuple[float, float], accepted: bool
) -> tuple[bool, bool, bool, bool]:
    """Return which extrema of the record equal these values of stress and force, just recorded."""
    sigma, F = values
    return (
        accepted & (get(lanes, RECORD_BEGIN + STRESS_MAX, lane) == sigma),
        accepted & (get(lanes, RECORD_BEGIN + STRESS_MIN, lane) == sigma),
        accepted & (get(lanes, RECORD_BEGIN + FORCE_MAX, lane) == F),
        accepted & (get(lanes, RECORD_BEGIN + FORCE_MIN, lane) == F),
    )


class Aside(NamedTuple):
    """Nodes displaced by a column to both sides, and the inverse of the distance between them."""

    above: Node
    below: Node
    per_column: float


def _make_aside(functions: ProblemFunctions) -> Any:
    """Return the inline function (lanes, lane, reach, problem, y, column) that makes an Aside.

    The largest displacement is `reach` times the root of the tolerance.
    """
    add, observables = algebra(functions.width).add, functions.equations.observables

    @inline
    def node(problem: Problem, y: Vector) -> Node:
        phi, _ = exponentials(y[FILM])
        sigma, F = observables(problem.p, y, phi, problem.u_s)
        return y, phi, sigma, F

    @inline
    def aside(
        lanes: np.ndarray, lane: int, reach: float, problem: Problem, y: Vector, column: Vector
    ) -> Aside:
        size = math.sqrt(get(lanes, SLOTS.rtol, lane)) * reach
        # The displacement is smaller if the column means that the film freezes earlier or later.
        size /= 1.0 + size * abs(column[FILM])
        above, below = node(problem, add(y, size, column)), node(problem, add(y, -size, column))
        return Aside(above, below, 0.5 / size)

    return aside


def _make_across(components: tuple[Component, ...]) -> Any:
    """Return the inline function (column, f) that removes from a column its part along the motion.

    At an extremum a displacement along the rate f of the motion changes nothing. But if a film
    melts within thousandths of a period, a column is mostly along f, since the film melts earlier
    or later. The rest of the column gives the change of the extremum more exactly. If the motion is
    no faster than its drive, the whole column remains, because at the turning points there is
    hardly a direction of the motion.
    """
    add, weights = algebra(len(components)).add, tuple(c.weight**2 for c in components)
    products = [f"{w!r} * {{0}}[{i}] * {{1}}[{i}]" for i, w in enumerate(weights)]
    along, size = (" + ".join(products).format(*names) for names in (("column", "f"), ("f", "f")))
    lines = [f"return add(column, -({along}) / ({_FAST!r} + {size}), f)"]
    return make_function(f"across{weights}", "column, f", lines, {"add": add})


def _make_note_extrema(width: int, slopes: int) -> Any:
    """Return the inline function (lanes, lane, j, aside, found) that stores slopes of extrema.

    The slopes are with respect to component j of the first state; `found` is as in `_extrema`.
    """

    @inline
    def note_one(lanes: np.ndarray, lane: int, k: int, j: int, found: bool, slope: float) -> None:
        slot = slopes + k * width + j
        put(lanes, slot, lane, slope if found else get(lanes, slot, lane))

    @inline
    def note_extrema(
        lanes: np.ndarray, lane: int, j: int, aside: Aside, found: tuple[bool, bool, bool, bool]
    ) -> None:
        _, _, high_sigma, high_F = aside.above
        _, _, low_sigma, low_F = aside.below
        sigma, F = aside.per_column * (high_sigma - low_sigma), aside.per_column * (high_F - low_F)
        note_one(lanes, lane, 0, j, found[0], sigma)
        note_one(lanes, lane, 1, j, found[1], sigma)
        note_one(lanes, lane, 2, j, found[2], F)
        note_one(lanes, lane, 3, j, found[3], F)

    return note_extrema


def _make_see_integrands(functions: ProblemFunctions, slopes: int) -> Any:
    """Return the inline function that adds a step to the slopes of integrals for one component.

    Its arguments are (lanes, lane, j, problem, t, used, aside, accepted), with the time t at which
    a step of length `used` ends, and the Aside of its end. The trapezium rule is enough, as only
    errors need these slopes. The change of an integrand at the end is kept for the next step.
    """
    width, moment = functions.width, make_moment(functions.equations)
    last = slopes + len(SENSITIVE) * width

    @inline
    def see_change(
        lanes: np.ndarray, lane: int, k: int, j: int, used: float, change: float, accepted: bool
    ) -> None:
        slope, kept = slopes + (len(EXTREMA) + k) * width + j, last + k * width + j
        before, total = get(lanes, kept, lane), get(lanes, slope, lane)
        put(lanes, slope, lane, total + 0.5 * used * (before + change) if accepted else total)
        put(lanes, kept, lane, change if accepted else before)

    lines, names = [], dict[str, Any](see_change=see_change)
    for k, slot in enumerate(INTEGRALS):
        names[f"integrand{k}"] = RECORD_TABLE[slot].integrand
        change = f"per_column * (integrand{k}(above) - integrand{k}(below))"
        lines.append(f"see_change(lanes, lane, {k}, j, used, {change}, accepted)")
    # Written out like the columns.
    arguments = "lanes, lane, j, used, above, below, per_column, accepted"
    see_changes: Any = make_function(f"see_changes[{width}]", arguments, lines, names)

    @inline
    def see_integrands(
        lanes: np.ndarray,
        lane: int,
        j: int,
        problem: Problem,
        t: float,
        used: float,
        aside: Aside,
        accepted: bool,
    ) -> None:
        above, below = moment(problem, t, aside.above), moment(problem, t, aside.below)
        see_changes(lanes, lane, j, used, above, below, aside.per_column, accepted)

    return see_integrands


@inline
def _crosses(u0: float, u1: float, at_first: float, at_last: float) -> bool:
    """Return whether a step crosses u = 0, or comes near to it, in a genuine motion.

    The slip of a locked block crosses it too, but at a rate that is mostly integration error.
    `at_first` and `at_last` are the changes of u by its rates before and after the step.
    """
    change = u1 - u0
    near = abs(change) > _NEAR * larger(abs(u0), abs(u1))
    first = (change * at_first > 0.0) & (abs(at_first) < _UNLIKE * abs(change))
    last = (change * at_last > 0.0) & (abs(at_last) < _UNLIKE * abs(change))
    unlike = (abs(change) < _UNLIKE * abs(at_first)) & (abs(change) < _UNLIKE * abs(at_last))
    return near & first & last & unlike


@inline
def _oscillation(J: Matrix) -> float:
    """Return the rate of free motions of the block on its springs; 0 if friction damps them away.

    A damped oscillator is overdamped if its damping rate is above twice its own rate. If friction
    decreases with velocity, the motion grows at that rate instead.
    """
    own, growth = math.sqrt(-J[0][1] * J[1][0]), J[1][1]
    return larger(own, growth) if growth > -2.0 * own else 0.0


def _make_carry(
    problems: Callable[..., Problem],
    functions: ProblemFunctions,
    first: int,
    reaches: tuple[float, ...],
    aside: Any,
    across: Any,
    note_extrema: Any,
    see_integrands: Any,
) -> Any:
    """Return `Variations.carry` for columns that begin in the slot `first`."""
    rhs, jacobian = functions.rhs, functions.jacobian
    width, step_of = functions.width, step_reader(functions.width)
    operations, vectors = algebra(width), lane_vectors(LANES, width)
    step, interpolate, factor = (
        make_variational_step(operations), operations.interpolate, operations.factor
    )  # fmt: skip
    rows_of = make_tuple_reader(width)
    resolution = first + room_of(width) - RESOLUTION

    @inline
    def sum_damping(lanes: np.ndarray, lane: int, w: float, used: float, accepted: bool) -> None:
        damping = get(lanes, resolution + DAMPING, lane)
        fastest = get(lanes, resolution + FASTEST, lane)
        square = (w * used) * (w * used)
        more = damping + DAMPING_OF_A_STEP * square * square
        put(lanes, resolution + DAMPING, lane, more if accepted else damping)
        put(lanes, resolution + FASTEST, lane, larger(w, fastest) if accepted else fastest)

    @inline
    def linearised(problem: Problem, last: Step, theta: float) -> Any:
        y = interpolate(theta, last.y0, last.y1, last.d1, last.d2)
        J = jacobian(problem, last.t + theta * last.used, y)
        return factor(rows_of(J), shift_of(last.used)), J[width], _oscillation(J)

    @inline
    def carry_column(
        lanes: np.ndarray, lane: int, j: int, last: Step, over: Any, accepted: bool
    ) -> None:
        old = vectors.get(lanes, first + j * width, lane)
        f0, f1, crosses, LUs, f_ts = over
        share = old[1] / f0[1] if crosses else 0.0
        new = step(old, share, f0, f1, shift_of(last.used), LUs, f_ts)
        vectors.put(lanes, first + j * width, lane, operations.choose(accepted, new, old))

    # Written out, since a loop inside the loop over lanes would prevent vectorisation.
    carry_columns: Any = make_function(
        f"carry_columns[{width}]",
        "lanes, lane, last, over, accepted",
        [f"carry_column(lanes, lane, {j}, last, over, accepted)" for j in range(width)],
        {"carry_column": carry_column},
    )

    @inline
    def lane_carry(lane: int, lanes: np.ndarray) -> None:
        problem, last = problems(lanes, lane), step_of(lanes, lane)
        f0, f1 = rhs(problem, last.t, last.y0), rhs(problem, last.t + last.used, last.y1)
        LU1, f_t1, _ = linearised(problem, last, NODES[0])
        LU2, f_t2, _ = linearised(problem, last, NODES[1])
        LU3, f_t3, w = linearised(problem, last, NODES[2])
        crosses = _crosses(last.y0[1], last.y1[1], last.used * f0[1], last.used * f1[1])
        over = f0, f1, crosses, (LU1, LU2, LU3), (f_t1, f_t2, f_t3)
        accepted = get(lanes, SLOTS.accepted, lane) > 0.0
        carry_columns(lanes, lane, last, over, accepted)
        sum_damping(lanes, lane, w, last.used, accepted)

    @inline
    def lane_note(lane: int, lanes: np.ndarray, j: int, reach: float) -> None:
        problem, last = problems(lanes, lane), step_of(lanes, lane)
        accepted, end = get(lanes, SLOTS.accepted, lane) > 0.0, last.t + last.used
        column = vectors.get(lanes, first + j * width, lane)
        values = get(lanes, STRESS, lane), get(lanes, FORCE, lane)
        across_column = across(column, rhs(problem, end, last.y1))
        turned = aside(lanes, lane, reach, problem, last.y1, across_column)
        note_extrema(lanes, lane, j, turned, _extrema(lanes, lane, values, accepted))
        sides = aside(lanes, lane, reach, problem, last.y1, column)
        see_integrands(lanes, lane, j, problem, end, last.used, sides, accepted)

    @jit
    def carry(lanes: np.ndarray) -> None:
        for_lanes(LANES, lane_carry, (lanes,))
        # One column after the other. Written out, this would take three times as long to compile.
        for j in range(width):
            for_lanes(LANES, lane_note, (lanes, j, reaches[j]))

    return carry
