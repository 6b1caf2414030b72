"""`export`, `merge` and `sweep --part` on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.sweeps.commands import Command

from sweeps.files.datasets import content_hash, open_result


def test_an_array_of_jobs_is_the_whole(command: Command) -> None:
    assert command("sweep", "a.yaml").code == 0
    for number in (1, 2, 3):
        done = command("sweep", "a.yaml", "--part", f"{number}/3")
        assert done.code == 0, done.err
        assert f"results/a.part-{number}-of-3.nc" in done.out
        assert "pending" in done.out
    parts = [f"results/a.part-{number}-of-3.nc" for number in (1, 2, 3)]
    done = command("merge", *parts, "-o", "merged.nc")
    assert done.code == 0, done.err
    assert done.out.startswith("merged.nc\n4 points, 0 failed")
    whole = content_hash(open_result(Path("results/a.nc")))
    assert content_hash(open_result(Path("merged.nc"))) == whole


def test_a_part_says_how_it_stands(command: Command) -> None:
    command("sweep", "a.yaml", "--part", "1/2")
    again = command("sweep", "a.yaml", "--part", "1/2")
    assert "is complete: 2 points, nothing to do" in again.err
    status = command("status", "results/a.part-1-of-2.nc")
    assert "2 of 4 points done" in status.out


def test_a_table_is_written_once(command: Command) -> None:
    command("sweep", "a.yaml", "-o", "a.nc")
    done = command("export", "a.nc")
    assert (done.code, done.out) == (0, "a.csv\na.columns.csv\n")
    assert "exists already; --overwrite" in command("export", "a.nc").err
    assert command("export", "a.nc", "--overwrite").code == 0
    assert command("export", "a.nc", "-o", "b.parquet").code == 0


@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        (("sweep", "a.yaml", "--part", "3/2"), 2, "--part: '3/2' is no part"),
        (("merge", "no.nc", "-o", "m.nc"), 5, "no.nc does not exist"),
        (("export", "a.yaml", "-o", "a.csv"), 5, "a.yaml"),
        (("export", "no.nc"), 5, "no.nc does not exist"),
    ],
)
def test_what_cannot_be_done_is_said(
    command: Command, arguments: tuple[str, ...], code: int, told: str
) -> None:
    done = command(*arguments)
    assert (done.code, told in done.err) == (code, True), done.err
