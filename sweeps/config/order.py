"""`follow` and `refine`: in which order the points of a sweep are computed, and which."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from stickslip.variables import STARTING, canonical_name
from sweeps.config.diagnostics import UNREADABLE, Located, quoted
from sweeps.config.numbers import finite, text, whole
from sweeps.config.parameter_space import ParameterSpace
from sweeps.human import did_you_mean

_EXAMPLE = "{axes: [temperature, angular_frequency], levels: 3, where: [regime, 1e-2]}"
_KEYS = ("axes", "levels", "where")
MOST_LEVELS = 6
MOST_AXES = 3  # the cells of more have more corners than refinement saves points
_REGIME = "regime"


@dataclass(frozen=True)
class Refine:
    """Axes that are computed coarsely first, every 2^levels-th value, and refined where it matters.

    `miss` is the part of an amplitude by which the middle of a cell may miss interpolation; None
    asks for the same regime at its corners alone.
    """

    axes: tuple[str, ...]
    levels: int = 3
    miss: float | None = 1e-2

    def resolved(self) -> dict[str, Any]:
        """The same as a config has it."""
        where = [_REGIME] if self.miss is None else [_REGIME, self.miss]
        return {"axes": list(self.axes), "levels": self.levels, "where": where}


def read_follow(root: Located, space: ParameterSpace) -> str | None:
    """The followed axis by its full name; None where there is none, or it is refused."""
    node = root.value.get("follow")
    if node is None or node.value is None:
        return None
    name = _swept(node, space)
    if name is None:
        return None
    for other in ("refine", "sample", "cases"):
        if other in root.value and root.value[other].value:
            node.refuse(f"does not go together with `{other}`; leave one of them out")
    if name in STARTING:
        node.refuse(f"cannot be {name}: a followed line starts from where it has arrived")
    values = space.sweep[name]
    if any(b <= a for a, b in pairwise(values)):
        node.refuse(f"needs the values of {name} in increasing order: it goes up, then down")
    return name


def read_refine(root: Located, space: ParameterSpace) -> Refine | None:
    """How a grid is refined; None where it is not, or the section is refused."""
    node = root.value.get("refine")
    if node is None or node.value is None or node.value is UNREADABLE:
        return None
    before = len(node.diagnostics.problems)
    if not isinstance(node.value, dict):
        node.refuse(f"must be {_EXAMPLE}, not {quoted(node.value)}")
        return None
    for key in node.value:
        if key not in _KEYS:
            hint = did_you_mean(key, _KEYS) or f"; known are {', '.join(_KEYS)}"
            node.refuse(f"unknown key{hint}", key)
    axes = _axes(node, space)
    levels = node.value["levels"].read(_levels) if "levels" in node.value else Refine.levels
    miss = _miss(node.value["where"]) if "where" in node.value else Refine.miss
    if levels is not None:
        for name in axes:
            _judge_length(node, name, len(space.sweep[name]), levels)
    if len(node.diagnostics.problems) > before or levels is None:
        return None
    return Refine(axes, levels, miss)


def _axes(node: Located, space: ParameterSpace) -> tuple[str, ...]:
    given = node.value.get("axes")
    if given is None or not isinstance(given.value, list) or not given.value:
        node.refuse(f"must name the axes to refine; write {_EXAMPLE}", "axes")
        return ()
    names = [name for item in given.value if (name := _swept(item, space))]
    if len(set(names)) < len(names):
        given.refuse("names an axis twice")
    if len(names) > MOST_AXES:
        given.refuse(f"names {len(names)} axes; at most {MOST_AXES} are refined together")
    return tuple(names)


def _swept(node: Located, space: ParameterSpace) -> str | None:
    """The full name of a swept parameter; None where the value is none, noted."""
    written = node.read(text)
    if written is None:
        return None
    name = canonical_name(written)
    if name not in space.sweep:
        known = ", ".join(space.sweep) or "none"
        hint = did_you_mean(written, space.sweep)
        node.refuse(f"must name a swept axis, not {quoted(written)}; swept are {known}{hint}")
        return None
    return name


def _levels(value: object) -> int:
    levels = whole(value)
    if not 1 <= levels <= MOST_LEVELS:
        raise ValueError(f"must be 1 to {MOST_LEVELS}, not {levels}")
    return levels


def _miss(node: Located) -> float | None:
    """The number among the conditions; None where there is only the regime."""
    items = node.value if isinstance(node.value, list) else [node]
    numbers = [item for item in items if item.value != _REGIME]
    if len(numbers) > 1:
        node.refuse(f"takes {_REGIME} and one number, such as [{_REGIME}, 1e-2]")
        return None
    return numbers[0].read(_part) if numbers else None


def _part(value: object) -> float:
    try:
        part = finite(value)
    except ValueError:
        raise ValueError(f"must be {_REGIME} or a number, not {quoted(value)}") from None
    if not 0 < part < 1:
        raise ValueError(f"must be a part between 0 and 1, not {part:g}")
    return part


def _judge_length(node: Located, name: str, length: int, levels: int) -> None:
    """Refuse an axis whose cells do not come out even."""
    cell = 2**levels
    if (length - 1) % cell or length < cell + 1:
        below = max((length - 1) // cell, 1) * cell + 1
        others = f"{below} or {below + cell}" if below != length else str(below)
        node.refuse(
            f"{name} has {length} values; {levels} levels need a multiple of {cell} and one more, "
            f"such as {others}"
        )
