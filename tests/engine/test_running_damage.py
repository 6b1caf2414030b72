"""A journal damaged, cut or deleted while its sweep runs: no wrong number, and nothing is lost."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.marks import one_then
from support.sweeps.sweeping import (
    LOOSE,
    ONE_BY_ONE,
    Shell,
    entries,
    hash_at_once,
    hash_of,
    write,
)

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS
from sweeps import run
from sweeps.engine.sweep import JournaledResult
from sweeps.files.journal import BYTES_PER_POINT, Journal

A_YAML = "sweep: {temperature: [200, 210, 230, 250, 270]}\n" + LOOSE + ONE_BY_ONE
RECORDS = 4 * BYTES_PER_POINT  # bytes of the first four blocks
RUN, JOURNAL = Path("a.nc.run"), Path("a.nc.run/journal")


def disturbed(shell: Shell, block: int, harm: Callable[[], None]) -> tuple[int, str, int]:
    """Call `harm` before block `block`, from 1, of a sweep; return code, messages, point count."""
    begun = 0

    def disturb(_: np.ndarray) -> None:
        nonlocal begun
        begun += 1
        if begun == block:
            harm()

    shell.disturb = disturb
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc", "--overwrite")
    shell.disturb = None
    return code, err, len(shell.computed)


def flip(path: Path, place: int, mask: int = 0x10) -> None:
    with path.open("r+b") as file:
        file.seek(place)
        byte = file.read(1)[0]
        file.seek(place)
        file.write(bytes([byte ^ mask]))


@pytest.mark.slow
@pytest.mark.parametrize("flips", one_then("faults", [3, 200]))
def test_a_byte_damaged_during_the_sweep_costs_only_its_block(shell: Shell, flips: int) -> None:
    expected, rng = hash_at_once("a.yaml"), np.random.default_rng(3)
    for _ in range(flips):
        place, mask = int(rng.integers(1, RECORDS)), int(rng.integers(1, 256))
        code, err, computed = disturbed(
            shell, 5, lambda p=place, m=mask: flip(JOURNAL, JOURNAL.stat().st_size - p, m)
        )
        assert (code, hash_of("a.nc")) == (0, expected), (place, mask, err)
        assert computed <= 6
        assert "damaged during the sweep" in err
        assert entries() == ["a.nc", "a.nc.timing.json", "a.yaml"]


@pytest.mark.parametrize("block", [3, 6], ids=["in the first round", "in the second"])
def test_a_byte_damaged_between_the_rounds_of_a_refined_grid_costs_its_point(
    shell: Shell, block: int
) -> None:
    axis = "sweep: {T: {linspace: [200, 280], num: 17}}\nrefine: {axes: [T], levels: 2}\n"
    write("a.yaml", axis, LOOSE, ONE_BY_ONE)
    expected = hash_at_once("a.yaml")
    needed = int(np.count_nonzero(run("a.yaml").status != Status.INTERPOLATED))
    assert needed > 9  # there is a second round
    code, err, computed = disturbed(shell, block, lambda: flip(JOURNAL, 40))
    assert (code, hash_of("a.nc")) == (0, expected), err
    assert computed == needed + 1
    assert "damaged during the sweep; 1 point to compute again\n" in err


HARMS: dict[str, Callable[[], None]] = {
    "emptied": lambda: os.truncate(JOURNAL, 0),
    "cut": lambda: os.truncate(JOURNAL, JOURNAL.stat().st_size // 2),
    "deleted": JOURNAL.unlink,
    "deleted with its folder": lambda: shutil.rmtree(RUN),
}


@pytest.mark.parametrize("harm", HARMS.values(), ids=HARMS)
def test_a_journal_cut_or_deleted_during_the_sweep_is_made_again(
    shell: Shell, harm: Callable[[], None]
) -> None:
    expected = hash_at_once("a.yaml")
    code, err, _ = disturbed(shell, 4, harm)
    assert (code, hash_of("a.nc")) == (0, expected), err


def test_a_journal_damaged_again_and_again_is_reported_and_kept(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = hash_at_once("a.yaml")
    result_of = JournaledResult.write

    def after_harm(result: JournaledResult) -> object:
        os.truncate(JOURNAL, JOURNAL.stat().st_size - 8)
        return result_of(result)

    with monkeypatch.context() as broken:
        broken.setattr(JournaledResult, "write", after_harm)
        code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert code == 5
    assert "a.nc.run/journal keeps being damaged" in err
    assert "a.nc.run" in entries()
    assert "a.nc" not in entries()
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    assert hash_of("a.nc") == expected


def test_a_result_without_all_points_replaces_nothing(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    before = Path("a.nc").read_bytes()
    nothing = np.full((5, len(RESULT_COLUMNS)), np.nan)
    monkeypatch.setattr(Journal, "chunk", lambda *_: nothing)
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc", "--overwrite")
    assert code == 5
    assert "does not hold the points that were written to it" in err
    assert Path("a.nc").read_bytes() == before
    assert "a.nc.run" in entries()
