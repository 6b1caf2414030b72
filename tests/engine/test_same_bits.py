"""Every kind of sweep gives the same bits, however it is executed, killed and resumed."""

from __future__ import annotations

import pytest
from support.marks import one_then
from support.sweeps.processes import HANGS
from support.sweeps.sweeping import LOOSE, Mishap, Shell, child, hash_of, write

from sweeps import run
from sweeps.files.netcdf import content_hash

KINDS = {
    "followed": LOOSE
    + "sweep: {T: [200, 210], omega: [14, 14.5, 15, 15.5, 18, 18.5]}\nfollow: omega\n",
    "refined": LOOSE
    + "sweep: {T: {linspace: [180, 300], num: 17}, omega: {linspace: [10, 50], num: 17}}\n"
    + "refine: {axes: [T, omega], levels: 2, where: [regime]}\n",
    "stochastic": """\
model: {omega: 15}
sweep: {T: [190, 200, 210, 220, 300], gamma: [-2/3, 0]}
noise: {treatment: stochastic, realizations: 3, seed: 5}
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4, window: 20}
""",
}
# The number of points in a block, and the appends to the journal during which the sweep is killed.
KILLS = {"followed": (None, [1]), "refined": (16, [1, 7]), "stochastic": (1, [1, 2])}


@pytest.mark.parametrize("kind", one_then("faults", [*KINDS]))
def test_workers_blocks_processes_and_kills_change_nothing(shell: Shell, kind: str) -> None:
    write("a.yaml", KINDS[kind])
    hashes = {content_hash(run("a.yaml", workers=workers)) for workers in (1, 2, 8)}
    shell.ok("sweep", "a.yaml", "-o", "b.nc", "--backend", "loky")
    points, numbers = KILLS[kind]
    blocks = [] if points is None else ["--set", f"execution.block_points={points}"]
    command = ["sweep", "a.yaml", "-o", "a.nc", *blocks]
    for number in numbers:
        block = ("sweeps.files.journal:Journal", "append", number)
        process = child(command, Mishap("os", "pwrite", 1, "half", within=block))
        process.join(HANGS)
        assert process.exitcode == -9
    shell.ok(*command)
    assert hashes == {hash_of("a.nc")} == {hash_of("b.nc")}
