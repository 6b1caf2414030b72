"""`sample`: points drawn from a box of parameters, as linked values of `cases`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sweeps.config.axes import MAX_VALUES
from sweeps.config.diagnostics import UNREADABLE, Located, located, quoted
from sweeps.config.numbers import finite, whole
from sweeps.config.parameter_space import given_parameters, valid_values

_EXAMPLE = "{sobol: 1024, seed: 1, temperature: [150, 320], spring_stiffness: {log: [500, 1e4]}}"

Unit = NDArray[np.float64]  # (n, parameters), each number in [0, 1)


def _sobol(count: int, width: int, seed: int) -> Unit:
    from scipy.stats import qmc

    engine = qmc.Sobol(width, rng=np.random.default_rng(seed))
    # A longer sequence begins with the shorter one: a sweep that grows keeps its points.
    return np.asarray(engine.random_base2(max(math.ceil(math.log2(count)), 0))[:count])


def _latin_hypercube(count: int, width: int, seed: int) -> Unit:
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(width, rng=np.random.default_rng(seed)).random(count))


DRAWS: dict[str, Callable[[int, int, int], Unit]] = {
    "sobol": _sobol,
    "latin_hypercube": _latin_hypercube,
}
"""The ways to draw: (count, width, seed) to numbers in the unit cube."""


@dataclass(frozen=True)
class _Range:
    """The values between which a parameter is drawn, evenly or evenly in its logarithm."""

    low: float
    high: float
    logarithmic: bool

    def values(self, unit: NDArray[np.float64]) -> tuple[float, ...]:
        if self.logarithmic:
            drawn = self.low * (self.high / self.low) ** unit
        else:
            drawn = self.low + (self.high - self.low) * unit
        return tuple(drawn.tolist())


def settle_sample(root: Located) -> str:
    """Put the drawn values of `sample` in the place of `cases`; returns how they were drawn.

    What is refused is noted; then nothing is drawn.
    """
    node = root.value.get("sample")
    if node is None or node.value is None or node.value is UNREADABLE:
        return ""
    before = len(node.diagnostics.problems)
    if not isinstance(node.value, dict):
        node.refuse(f"must be {_EXAMPLE}, not {quoted(node.value)}")
        return ""
    ways = [name for name in DRAWS if name in node.value]
    given = given_parameters(node, others=(*DRAWS, "seed"))
    if len(ways) != 1 or not given:
        node.refuse(f"needs {' or '.join(DRAWS)}, and parameters; write {_EXAMPLE}")
    if "cases" in root.value and root.value["cases"].value:
        node.refuse("draws the cases, and `cases` lists them; keep one of the two")
    count = node.value[ways[0]].read(_count) if ways else None
    seed = node.value["seed"].read(_seed) if "seed" in node.value else 0
    ranges = {name: _read_range(child) for name, child in given}
    for name, child in given:
        drawn = ranges[name]
        if drawn:
            valid_values(name, child, (drawn.low, drawn.high))
    if len(node.diagnostics.problems) > before or count is None or seed is None:
        return ""
    known = {name: drawn for name, drawn in ranges.items() if drawn}
    unit = DRAWS[ways[0]](count, len(known), seed)
    cases = {name: drawn.values(unit[:, i]) for i, (name, drawn) in enumerate(known.items())}
    root.value["cases"] = located(cases, node.source, node.diagnostics, "sample")
    return ", ".join(_told(ways[0], count, seed, known))


def _told(way: str, count: int, seed: int, ranges: dict[str, _Range]) -> list[str]:
    """How the points were drawn, for the file."""
    drawn = [
        f"{name} {'log ' if r.logarithmic else ''}[{r.low:.17g}, {r.high:.17g}]"
        for name, r in ranges.items()
    ]
    return [f"{way} {count}", f"seed {seed}", *drawn]


def _read_range(node: Located) -> _Range | None:
    """The range of a parameter; None where it is refused."""
    return node.read(lambda _: _range(node))


def _range(node: Located) -> _Range | None:
    """The range of a parameter; None where something below is refused."""
    ends, logarithmic = node, isinstance(node.value, dict)
    if logarithmic:
        if list(node.value) != ["log"]:
            raise ValueError("must be [low, high], or {log: [low, high]}")
        ends = node.value["log"]
    if not isinstance(ends.value, list) or len(ends.value) != 2:
        raise ValueError("must be [low, high], or {log: [low, high]}")
    low, high = (end.read(finite) for end in ends.value)
    if low is None or high is None:
        return None
    if not low < high:
        raise ValueError(f"must rise from low to high, not from {low:g} to {high:g}")
    if logarithmic and low <= 0:
        raise ValueError(f"no logarithm leads from {low:g} to {high:g}: both must be above 0")
    return _Range(low, high, logarithmic)


def _count(value: object) -> int:
    count = whole(value)
    if not 1 <= count <= MAX_VALUES:
        raise ValueError(f"must be 1 to {MAX_VALUES} points, not {count}")
    return count


def _seed(value: object) -> int:
    seed = whole(value)
    if seed < 0:
        raise ValueError(f"must be at least 0, not {seed}")
    return seed
