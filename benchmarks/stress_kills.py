"""Does a sweep survive kills? SIGKILL at random times, the same command again, and a close look.

    python benchmarks/stress_kills.py [--kills 100] [--seed 1]

How it is done, and what `lost`, `repeated` and `recomputed` mean, stands in tests/support/kills.py.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
from pathlib import Path

from sweeps.engine.in_memory import run
from sweeps.files.datasets import content_hash

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.kills import CONFIG, Survival, kill_until_done


def main() -> None:
    """Kill sweep after sweep, until there have been as many kills as were asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    rng, total = random.Random(asked.seed), Survival()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "k.yaml").write_text(CONFIG)
        expected = content_hash(run(folder / "k.yaml"))
        while total.kills < asked.kills and not total.complaints:
            one = kill_until_done(folder / "sweep", rng, asked.kills - total.kills)
            shutil.rmtree(folder / "sweep")
            total.lost += one.lost
            total.repeated += one.repeated
            total.recomputed += one.recomputed
            total.hashes += one.hashes
            total.complaints += one.complaints
            print(f"{total.kills} kills, {total.lost} lost, {len(total.hashes)} sweeps", flush=True)
    mean = sum(total.recomputed) / max(total.kills, 1)
    print(f"kills: {total.kills}")
    print(f"points lost: {total.lost}")
    print(f"points computed again though they were journaled: {total.repeated}")
    print(f"points recomputed per kill: mean {mean:.1f}, most {max(total.recomputed, default=0)}")
    same = sum(found == expected for found in total.hashes)
    print(f"sweeps with the hash of an uninterrupted one: {same} of {len(total.hashes)}")
    for complaint in total.complaints:
        print(complaint)
    sound = total.lost == total.repeated == 0 and same == len(total.hashes) > 0
    sys.exit(not (sound and not total.complaints))


if __name__ == "__main__":
    main()
