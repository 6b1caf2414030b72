"""Workers and schedulers that are killed or frozen, or give wrong answers."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

from faults import answers
from faults.arena import Arena, Tally, ended, sweep_afresh

MISHAPS = ("scheduler killed", "worker killed", "scheduler frozen")


def run(quick: bool, folder: Path) -> dict[str, Tally]:
    """Kill or freeze workers of this machine, and of a cluster, or let them damage blocks."""
    arena, rng = Arena(folder), random.Random(5)
    workers, clusters, liars = Tally(), Tally(), Tally()
    for _ in range(1 if quick else 10):
        _worker(arena, rng, workers)
    for number in range(1 if quick else 20):
        _cluster(arena, rng, clusters, MISHAPS[number % 3])
    for _ in range(1 if quick else 20):
        _cluster(arena, rng, liars, "wrong answers")
    return {
        "killed processes of a sweep": workers,
        "dead and frozen workers and schedulers": clusters,
        "damaged blocks of threads": answers.threads_lie(quick),
        "damaged blocks of a cluster": liars,
    }


def _worker(arena: Arena, rng: random.Random, tally: Tally) -> None:
    """Kill one of the processes that a sweep has started."""
    with arena.folder() as folder:
        process = sweep_afresh(folder, "--backend", "loky", "--workers", "2")
        late = rng.uniform(0.5, 6.0)
        time.sleep(late)
        workers = _workers(process)
        if workers:
            rng.choice(workers).kill()
        what = f"loky: one of {len(workers)} processes killed after {late:.1f} s"
        arena.judge(tally, what, folder, ended(folder, process))


def _workers(process: subprocess.Popen[bytes]) -> list[psutil.Process]:
    """Return the processes of a sweep, but for the one that counts their shared memory."""
    if process.poll() is not None:
        return []
    children = psutil.Process(process.pid).children(recursive=True)
    return [child for child in children if "resource_tracker" not in " ".join(child.cmdline())]


def _cluster(arena: Arena, rng: random.Random, tally: Tally, mishap: str) -> None:
    """Strike a scheduler or one of two workers: it dies, freezes or gives wrong answers."""
    lies = ("--preload", "faults.answers") if mishap == "wrong answers" else ()
    with arena.folder() as folder, cluster(folder.parent, *lies) as (address, processes):
        sweep = sweep_afresh(folder, "--scheduler", address, "--max-runtime", "12s")
        if not lies:
            time.sleep(rng.uniform(1.0, 5.0))
            struck = processes[1 if mishap.startswith("worker") else 0]
            struck.send_signal(signal.SIGSTOP if mishap.endswith("frozen") else signal.SIGKILL)
        arena.judge(tally, mishap, folder, ended(folder, sweep))


@contextmanager
def cluster(folder: Path, *first: str) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Start a scheduler and two workers, one with the arguments `first`; yield its address too."""
    file = folder / "scheduler.json"
    processes = [_dask("scheduler", "--port", "0", "--scheduler-file", str(file))]
    try:
        while not (file.exists() and file.read_text().endswith("}")):
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        worker = ("worker", address, "--nthreads", "1", "--no-nanny")
        processes += [_dask(*worker, *first), _dask(*worker)]
        yield address, processes
    finally:
        for process in processes:
            process.kill()
            process.wait()


def _dask(kind: str, *arguments: str) -> subprocess.Popen[bytes]:
    here = ("--host", "127.0.0.1", "--no-dashboard")
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{kind}", *arguments, *here],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])},
    )
