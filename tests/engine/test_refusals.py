"""`check`, `plan` and `status` refuse in the same words what `sweep` refuses before it computes.

Each row of the table is a change to a folder with a result, and a refusal; no file is changed.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support import messages
from support.sweeps.sweeping import LOOSE, ONE_BY_ONE, Shell, everything, write

from sweeps.config.load import load
from sweeps.engine import resume
from sweeps.engine.existing import Target
from sweeps.files import run_folder
from sweeps.files.journal import Journal
from sweeps.files.run_folder import RunFolder

TWO = "sweep: {temperature: [200, 250]}\n"
OUTPUT = "output: a.nc\n" + LOOSE + ONE_BY_ONE
A_YAML = TWO + OUTPUT
A = Path("a.nc")


def config(*parts: str) -> None:
    write("a.yaml", *parts, OUTPUT)


def replaced(make: Callable[[], object]) -> None:
    A.unlink()
    make()


def journal_of(text: str) -> None:
    """Leave the journal of an unfinished sweep of another config."""
    write("other.yaml", text)
    target, folder = Target.of(load("other.yaml")), RunFolder(A)
    folder.path.mkdir()
    manifest = resume.manifest_of(target, Path("none.nc"), [], afresh=False)
    rows = Journal.create(folder.journal, manifest, target.keys, target.chunks)
    row = np.zeros((1, len(manifest["columns"])))
    rows.append(np.array([0]), row)
    rows.close()


def without_room(monkeypatch: pytest.MonkeyPatch) -> None:
    usage = shutil.disk_usage(".")._replace(free=1 << 16)
    monkeypatch.setattr(resume.shutil, "disk_usage", lambda _: usage)


def of_another_user(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("a.nc.run").mkdir()
    monkeypatch.setattr(run_folder.os, "geteuid", lambda: 12345)


PULL = "simulation: {drive: {velocity: 2e-6}, duration: 3}\n"
LOST = "a.nc has 1 finished point that the config no longer has"

REFUSED: dict[str, tuple[Callable[[pytest.MonkeyPatch], object], int, str]] = {
    # the config
    "a block that is pulled": (lambda _: config(TWO, PULL), 2, "simulation.drive: a sweep"),
    "an invalid config": (lambda _: config("sweep: {temperature: [-1]}\n"), 2, "a.yaml:1: sweep"),
    "an unstable step": (
        lambda _: write("a.yaml", TWO, "integrator: {method: euler-cromer, dt: 1}\noutput: a.nc"),
        2,
        f"integrator.dt: the step of 1 s is {messages.UNSTABLE}",
    ),
    "a cluster without address": (
        lambda _: write("a.yaml", TWO, "execution: {backend: dask}\noutput: a.nc"),
        2,
        "`dask` needs the address",
    ),
    # the name of the output
    "the config itself": (
        lambda _: write("a.yaml", TWO, "output: a.yaml\n"),
        2,
        "a.yaml is the config itself",
    ),
    "a folder": (lambda _: replaced(A.mkdir), 5, "a.nc is a folder; -o must name a file"),
    "a pipe": (lambda _: replaced(lambda: os.mkfifo(A)), 5, "a.nc is not an ordinary file"),
    "below a file": (
        lambda _: (write("other"), write("a.yaml", TWO, "output: other/a.nc\n")),
        5,
        "other is not a folder",
    ),
    "a link to itself": (lambda _: replaced(lambda: A.symlink_to("a.nc")), 5, "cannot write a.nc"),
    # existing results; test_existing.py has more
    "points that would be lost": (lambda _: config("sweep: {temperature: [200]}\n"), 2, LOST),
    "other settings": (
        lambda _: write("a.yaml", A_YAML.replace("integrator: {rtol: 1e-4}", "")),
        2,
        f"a.nc was computed {messages.OTHER_SETTINGS}",
    ),
    # what an unfinished sweep has left
    "a journal of lost points": (
        lambda _: replaced(lambda: journal_of(TWO.replace("200", "210") + OUTPUT)),
        2,
        "the journal in a.nc.run has 1 finished point that the config no longer has",
    ),
    "a journal of other settings": (
        lambda _: replaced(lambda: journal_of(TWO)),
        2,
        f"the journal in a.nc.run was computed {messages.OTHER_SETTINGS}",
    ),
    # the disk
    "no room": (
        lambda patch: (config("sweep: {T: {linspace: [1, 2], num: 10000}}\n"), A.unlink(),
                       without_room(patch)),
        5,
        "has 64.0 KiB left, but the sweep of 10000 points",
    ),
    "no memory": (
        lambda patch: (config("sweep: {T: {linspace: [1, 2], num: 10000}}\n"), A.unlink(),
                       patch.setattr(resume, "free_memory", lambda: 1e5)),
        5,
        "a sweep of 10000 points needs 156.2 KiB of memory, but this machine has 97.7 KiB",
    ),
    "no room for more": (
        lambda patch: (config("sweep: {T: {linspace: [200, 250], num: 1001}}\n"),
                       without_room(patch)),
        5,
        "has 64.0 KiB left, but the sweep of 1001 points",
    ),
    "a folder of another user": (of_another_user, 5, "belongs to another user"),
    "no folder": (lambda _: write("a.nc.run", ""), 5, "a.nc.run: it is not a folder"),
}  # fmt: skip


@pytest.fixture
def shell(shell: Shell) -> Shell:
    """A folder with a complete result, `a.nc`, of `a.yaml`."""
    shell.ok("sweep", "a.yaml")
    Path("a.nc.timing.json").unlink()
    return shell


@pytest.mark.parametrize(("befall", "code", "words"), REFUSED.values(), ids=REFUSED)
def test_all_verbs_refuse_alike(
    shell: Shell,
    monkeypatch: pytest.MonkeyPatch,
    befall: Callable[[pytest.MonkeyPatch], object],
    code: int,
    words: str,
) -> None:
    befall(monkeypatch)
    before = {} if A.is_fifo() else everything("a.nc.run/lock")
    told = {verb: shell(verb, "a.yaml") for verb in ("check", "plan", "status")}
    assert before == ({} if A.is_fifo() else everything("a.nc.run/lock"))
    told["sweep"] = shell("sweep", "a.yaml")
    assert words in told["sweep"].err
    for verb, result in told.items():
        assert result.code == code, verb
        assert "valid\n" not in result.out
        assert result.err, verb
        assert told["sweep"].err.endswith(result.err), verb  # after what it takes over, perhaps
    assert shell.computed == []
    kept = {} if A.is_fifo() else everything()
    assert {name: kept[name] for name in before if "journal" not in name} == {
        name: what for name, what in before.items() if "journal" not in name
    }


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_without_permission(shell: Shell) -> None:
    A.unlink()
    Path().chmod(0o500)
    try:
        told = {verb: shell(verb, "a.yaml") for verb in ("check", "plan", "status", "sweep")}
    finally:
        Path().chmod(0o700)
    assert {(code, err) for code, _, err in told.values()} == {
        (5, f"cannot write into a.nc.run: {os.strerror(13)}\n")
    }


def test_an_output_that_is_being_written(shell: Shell) -> None:
    with RunFolder(A).held():
        told = {verb: shell(verb, "a.yaml") for verb in ("check", "plan", "sweep")}
        shell.ok("status", "a.yaml")
    assert {code for code, _, _ in told.values()} == {4}
    assert len({err for _, _, err in told.values()}) == 1
    assert f"a.nc {messages.IN_USE} (process " in told["check"].err


def test_parts_of_a_refined_grid(shell: Shell) -> None:
    A.unlink()
    config("sweep: {T: {linspace: [200, 280], num: 9}}\nrefine: {axes: [T], levels: 2}\n")
    planned, swept = (shell(verb, "a.yaml", "--part", "1/2") for verb in ("plan", "sweep"))
    assert (planned.code, swept.code) == (2, 2)
    assert planned.err == swept.err
    assert "a refined grid cannot be split into parts" in swept.err


def test_a_part_that_would_end_a_sweep_from_scratch(shell: Shell) -> None:
    shell.interrupted("sweep", "a.yaml", "--overwrite", after=1)
    part = ("a.yaml", "-o", "a.nc", "--part", "1/2")
    planned, swept = (shell(verb, *part) for verb in ("plan", "sweep"))
    assert (planned.code, swept.code) == (2, 2)
    assert planned.err == swept.err
    assert "would lose points: an unfinished sweep" in swept.err


def test_all_verbs_count_existing_points_alike(shell: Shell) -> None:
    config("sweep: {temperature: [200, 225, 250]}\n")
    assert "points: 3 (temperature 3), 2 already computed\n" in shell("check", "a.yaml").out
    assert "points: 3, 2 already computed\n" in shell("plan", "a.yaml").out
    assert "1 more point of a.yaml to compute\n" in shell("status", "a.yaml").out
    assert json.loads(shell("status", "a.yaml", "--json").out)["to_compute"] == 1
    assert shell("sweep", "a.yaml").err == "3 points: 2 in a.nc; 1 to compute\n"
    assert "to_compute" not in json.loads(shell("status", "a.yaml", "--json").out)


def test_another_output_is_not_refused(shell: Shell) -> None:
    config("sweep: {temperature: [200]}\n")
    assert shell("check", "a.yaml").code == 2
    code, out, err = shell("check", "a.yaml", "-o", "b.nc")
    assert (code, err) == (0, "")
    assert out.splitlines()[-1] == "output: b.nc"


def test_the_json_of_status_has_its_refusal(shell: Shell) -> None:
    config("sweep: {temperature: [200]}\n")
    code, out, err = shell("status", "a.yaml", "--json")
    state = json.loads(out)
    assert (code, state["state"]) == (2, "complete")
    assert state["refused"] == err.rstrip("\n")
    assert state["refused"].startswith(LOST)
