"""What the machine can do at most, and what a compiled loop over lanes asks of it.

Operations are counted in units of a vector of eight numbers: an instruction on a register of 512
bits is one of them, on a shorter one a part.
"""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Callable, Iterator

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.simd import VECTOR, for_lanes

REPEATS = 7


def fastest(run: Callable[[], object], count: float, repeats: int = REPEATS) -> float:
    """Nanoseconds of CPU time for each of `count` items: the least of several runs."""
    times = []
    for _ in range(repeats):
        begin = time.thread_time_ns()
        run()
        times.append(time.thread_time_ns() - begin)
    return min(times) / count


# --- what the machine can do ----------------------------------------------------------------------

_CHAIN, _LANES = 32, 128
_TIMES = 20_000


@inline
def _multiplied(x, y, a, b):
    return x * a + b, y


@inline
def _added(x, y, a, b):
    return x, y + b


@inline
def _both(x, y, a, b):
    return x * a + b, y + b


@inline
def _divided(x, y, a, b):
    return b / x, y


@inline
def _rooted(x, y, a, b):
    return np.sqrt(x), y


def _often(operation):
    @inline
    def chain(lane, lanes):
        a, b = lanes[2 * _LANES + lane], lanes[3 * _LANES + lane]
        x, y = lanes[lane], lanes[_LANES + lane]
        for _ in range(_CHAIN):
            x, y = operation(x, y, a, b)
        lanes[lane], lanes[_LANES + lane] = x, y

    @jit
    def often(lanes, times):
        for _ in range(times):
            for_lanes(_LANES, chain, (lanes,))

    return often


def _rate(operation, each: int) -> float:
    room = np.full(4 * _LANES + VECTOR, 0.5)
    lanes = room[-(room.ctypes.data // 8) % VECTOR :][: 4 * _LANES]
    often = _often(operation)
    often(lanes, 1)
    return 1.0 / fastest(lambda: often(lanes, _TIMES), _TIMES * _LANES / VECTOR * _CHAIN * each)


def rates() -> dict[str, float]:
    """Vector operations a nanosecond of independent chains, by kind; `any` of all together."""
    kinds = {"multiply": _multiplied, "add": _added, "divide": _divided, "root": _rooted}
    alone = {kind: _rate(operation, 1) for kind, operation in kinds.items()}
    return alone | {"any": max(_rate(_both, 2), *alone.values())}


# --- what a loop asks of it -----------------------------------------------------------------------

_INSTRUCTION = re.compile(r"^\t(v\w+)\t(.*[xyz]mm.*)$", re.MULTILINE)
_END_OF_FUNCTION = re.compile(r"^\.Lfunc_end\d+:", re.MULTILINE)
_PARTS = {"z": 1.0, "y": 0.5, "x": 0.25}

# The first that a name matches counts; what is none of these compares, blends, shifts or masks.
_KINDS = {
    "multiply": re.compile(r"v(fn?m|mul)"),
    "add": re.compile(r"v(add|sub)"),
    "divide": re.compile(r"vdiv"),
    "root": re.compile(r"vsqrt"),
    "move": re.compile(r"v\w*(mov|broadcast)"),
}


def counted(assembly: str) -> dict[str, float]:
    """Vector operations in the largest function of a machine code without inner loops, by kind.

    `move` are loads, stores and copies of registers.
    """
    functions = [_counted(part) for part in _END_OF_FUNCTION.split(assembly)]
    return dict(max(functions, key=lambda counts: counts["multiply"]))


def counted_in_loop(assembly: str) -> dict[str, float]:
    """Vector operations for eight numbers in the innermost loop that multiplies most, by kind."""
    loops = [(_counted(body), body) for body in _innermost_loops(assembly)]
    counts, body = max(loops, key=lambda loop: loop[0]["multiply"])
    times = 1.0 if "zmm" in body else 2.0  # of shorter registers the loop takes two rounds
    return {kind: times * count for kind, count in counts.items()}


def _innermost_loops(assembly: str) -> Iterator[str]:
    lines, labels = assembly.splitlines(), dict[str, int]()
    for i, line in enumerate(lines):
        if label := re.match(r"(\.LBB\w+):", line):
            labels[label[1]] = i
        elif (jump := re.match(r"\s+j\w+\s+(\.LBB\w+)", line)) and jump[1] in labels:
            body = lines[labels[jump[1]] + 1 : i]
            if not any(entry.startswith(".LBB") for entry in body):
                yield "\n".join(body)


def _counted(function: str) -> Counter[str]:
    counts: Counter[str] = Counter()
    for name, operands in _INSTRUCTION.findall(function):
        kind = next((kind for kind, pattern in _KINDS.items() if pattern.match(name)), "other")
        counts[kind] += _PARTS[max(re.findall(r"([xyz])mm", operands))]
    return counts


def least_time(counts: dict[str, float], rates: dict[str, float]) -> float:
    """Nanoseconds below which the machine cannot do so many operations, moves for nothing.

    What multiplies also divides and takes roots; everything shares the width of the machine.
    """
    busy = sum(counts.get(kind, 0.0) / rates[kind] for kind in ("multiply", "divide", "root"))
    every = sum(count for kind, count in counts.items() if kind != "move")
    return max(busy, counts.get("add", 0.0) / rates["add"], every / rates["any"])
