"""Ratios of contraction of a sequence, measured on displacements well above the noise."""

from __future__ import annotations

from typing import Any

from stickslip.compiled.decorators import inline, jit
from stickslip.numerics.periodic.convergence import displacement

# A ratio is measured if displacements are this many times the noise of the map, which is taken as
# the tolerance of the integrator. It is accepted if the noise blurs its distance from 1 by no more
# than the last fraction. Growth must be clearer, because false growth undoes jumps, and plain
# iteration takes hundreds of periods.
CLEARANCE = 30.0
_CLEARANCE_OF_GROWTH = 300.0
_BLUR = 0.3

# The largest deviation of two displacements from parallel, as a fraction of the newer one.
BEND = 0.3

# If the caller has known for this many applications that no motions separate, an alternation with a
# ratio between the next two has its limit in the middle. It must contract, however slowly, even if
# it does not seem to; its ratio then counts as the last number.
_KNOWN_FOR = 4
_FASTEST_KNOWN, _SLOWEST_KNOWN = -0.5, -1.05
_SLOWEST_ALTERNATION = -1.0 + 1e-6


@inline
def length_of(way: tuple[float, float]) -> float:
    """Length of a displacement, the larger of its two components."""
    return max(abs(way[0]), abs(way[1]))


@inline
def along(way: tuple[float, float], image: tuple[float, float]) -> float:
    """Component of `way` along the larger component of `image`.

    The map leaves only the slow mode, so that images differ along it. The state after a jump may
    deviate from it by a velocity, which decays at once and must not count.
    """
    return way[0] if abs(image[0]) >= abs(image[1]) else way[1]


@inline
def contraction(newer: tuple[float, float], older: tuple[float, float]) -> tuple[float, float]:
    """Signed ratio of two displacements along the newer one, and their deviation from parallel."""
    ratio = along(newer, newer) / along(older, newer)
    across = max(abs(newer[0] - ratio * older[0]), abs(newer[1] - ratio * older[1]))
    return ratio, across / length_of(newer)


@inline
def stands_out(ratio: float, length: float, noise: float) -> bool:
    """Return whether a ratio measured on displacements of this length clearly differs from 1."""
    clearance = CLEARANCE if abs(ratio) < 1.0 else _CLEARANCE_OF_GROWTH
    return noise <= min(_BLUR * abs(1.0 - abs(ratio)), 1.0 / clearance) * length


@inline
def known_to_contract(memory: Any) -> bool:
    """Return whether the caller has known for a while that no motions separate."""
    return bool(memory.contracting >= _KNOWN_FOR)


@inline
def alternates_inwards(memory: Any, ratio: float, bend: float, length: float, noise: float) -> bool:
    """Return whether an alternation is known to contract although the noise hides it."""
    near = _SLOWEST_KNOWN <= ratio <= _FASTEST_KNOWN and bend <= BEND
    return known_to_contract(memory) and memory.plain == 0 and near and noise <= length


@jit
def note_ratio(
    memory: Any,
    cycle: int,
    newer: tuple[float, float],
    older: tuple[float, float],
    noise: float,
) -> None:
    """Store the ratio of contraction over `cycle` applications if it is clear of the noise.

    Contraction, clear or not, replaces growth at once: the growth belonged to a bend of the map
    that the sequence has left behind.
    """
    ratio, bend = contraction(newer, older)
    length = abs(along(older, newer))
    if cycle == 1 and alternates_inwards(memory, ratio, bend, length, noise):
        memory.ratios[0] = max(ratio, _SLOWEST_ALTERNATION)
        return
    if abs(ratio) >= 1.0 and known_to_contract(memory):
        return
    better = abs(ratio) < 1.0 <= abs(memory.ratios[cycle - 1])
    if stands_out(ratio, length, noise) or (better and CLEARANCE * noise <= length):
        memory.ratios[cycle - 1] = ratio
        if cycle == memory.aim:
            length = length_of(newer)
            memory.slow[0], memory.slow[1] = newer[0] / length, newer[1] / length


@jit
def note_ratios(memory: Any, noise: float) -> None:
    """Store the ratios of contraction of all cycles that are clear of the noise."""
    newest = memory.newest
    for cycle in range(1, memory.longest_cycle + 1):
        if 2 * cycle <= newest:
            note_ratio(
                memory,
                cycle,
                displacement(memory, newest, newest - cycle),
                displacement(memory, newest - cycle, newest - 2 * cycle),
                noise,
            )
