"""Sweeps of every kind, killed at a random time or before an operation on a file."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import NamedTuple

from faults.arena import CONFIG, OLDER, SWEEP, Arena, Tally, ended, sweep_afresh
from faults.workers import cluster

KILLS = 17

_LOOSE = "integrator: {rtol: 1e-4}\nstationary: {rtol: 1e-4}\n"
_SMALL = _LOOSE + "execution: {workers: 2, block_points: 2}\n"
_FOLLOWED = _SMALL + "sweep: {T: [200, 205, 210], omega: [14, 15, 16, 17]}\nfollow: omega\n"
_REFINED = """\
sweep: {T: {linspace: [180, 300], num: 9}, omega: {linspace: [10, 50], num: 9}}
refine: {axes: [T, omega], levels: 2, where: [regime]}
execution: {workers: 2, block_points: 16}
"""
_STOCHASTIC = """\
model: {omega: 15, gamma: 0}
sweep: {T: [190, 200, 210, 220, 300]}
noise: {treatment: stochastic, realizations: 3, seed: 5}
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4, window: 20}
execution: {workers: 2, block_points: 2}
"""
_FIXED_STEP = """\
model: {alpha: 0, gamma: 0}
sweep: {omega: [10, 20, 30], T: [200, 300]}
integrator: {method: euler-cromer, dt: 2e-6}
stationary: {rtol: 1e-4}
execution: {workers: 2, block_points: 2}
"""
_SAMPLE = "sample: {sobol: 32, seed: 3, T: [180, 300], k: {log: [1e4, 1e5]}}\n"
_CASES = "sweep: {T: [200, 250]}\ncases: {omega: [10, 20, 10], K: [3e3, 2e3, 1e3]}\n"


class Kind(NamedTuple):
    """A config, the words of its sweep, and those for an older result that is grown, if any."""

    config: str
    words: tuple[str, ...] = ()
    older: tuple[str, ...] = ()


KINDS = {
    "by two threads": Kind(CONFIG.replace("workers: 1", "workers: 2")),
    "that grow a result": Kind(CONFIG, older=("--set", OLDER)),
    "of a part": Kind(CONFIG, ("--part", "2/3")),
    "of followed lines": Kind(_FOLLOWED),
    "that grow followed lines": Kind(_FOLLOWED, older=("--set", "omega=[14, 15]")),
    "of a refined grid": Kind(_LOOSE + _REFINED),
    "of stochastic films": Kind(_STOCHASTIC),
    "of a sample": Kind(_SMALL + _SAMPLE),
    "of cases": Kind(_SMALL + _CASES),
    "by Euler-Cromer": Kind(_FIXED_STEP),
}


def run(quick: bool, folder: Path) -> dict[str, Tally]:
    """Kill sweeps of each kind, by processes and on a cluster too."""
    rng, count = random.Random(7), 2 if quick else KILLS
    tallies = {
        f"kills of sweeps {name}": _kills(folder / name, kind, rng, count)
        for name, kind in KINDS.items()
    }
    arena = Arena(folder / "afresh", older=())
    tallies["kills of sweeps by processes"] = _afresh(arena, rng, count, "--backend", "loky")
    with cluster(folder) as (address, _):
        tallies["kills of sweeps on a cluster"] = _afresh(arena, rng, count, "--scheduler", address)
    return tallies


def _kills(folder: Path, kind: Kind, rng: random.Random, count: int) -> Tally:
    """Kill half of them before an operation on their files, the others at any time."""
    arena, tally = Arena(folder, kind.config, (*SWEEP, *kind.words), kind.older), Tally()
    for attempt in range(count):
        if attempt % 2 and arena.whole.operations:
            arena.kill_before_operation(tally, rng)
        else:
            arena.kill(tally, rng)
    return tally


def _afresh(arena: Arena, rng: random.Random, count: int, *words: str) -> Tally:
    """Kill sweeps whose blocks other processes compute, as they start or at any time of theirs."""
    tally, begun = Tally(), time.monotonic()
    with arena.folder() as folder:
        if (end := ended(folder, sweep_afresh(folder, *words))).code != 0:
            raise RuntimeError(end.said)
    longest = 1.1 * (time.monotonic() - begun)
    for _ in range(count):
        with arena.folder() as folder:
            late, process = rng.uniform(0.0, longest), sweep_afresh(folder, *words)
            time.sleep(late)
            process.kill()
            arena.judge(tally, f"after {late:.3f} s", folder, ended(folder, process))
    return tally
