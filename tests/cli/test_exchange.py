"""`export`, `merge` and `sweep --part` on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from support import messages
from support.sweeps.commands import Command, entries

from sweeps.files.netcdf import content_hash, open_result


@pytest.mark.stress
def test_a_file_without_an_ending_has_others_named_after_all_of_it(command: Command) -> None:
    command.ok("sweep", "a.yaml", "-o", "T=1.5")
    assert command.ok("export", "T=1.5").out == "T=1.5.csv\nT=1.5.columns.csv\n"
    said = command.ok("replay", "T=1.5", "--at", "T=200", "--at", "gamma=0").out
    assert said.endswith("T=1.5-replay.nc\nT=1.5-replay.png\nT=1.5-replay.pdf\n")
    assert command.ok("plot", "T=1.5").out == "T=1.5.png\nT=1.5.pdf\n"


@pytest.mark.parametrize("verb", ["export", "replay", "boundary", "report"])
def test_a_folder_in_place_of_a_file_is_refused(command: Command, verb: str) -> None:
    assert command(verb, ".") == (5, "", ". is a folder, not a file\n")


def test_merged_parts_equal_the_whole_sweep(command: Command) -> None:
    command.ok("sweep", "a.yaml")
    for number in (1, 2, 3):
        done = command.ok("sweep", "a.yaml", "--part", f"{number}/3")
        assert f"results/a.part-{number}-of-3.nc" in done.out
        assert f"part {number}/3: " in done.out
    parts = [f"results/a.part-{number}-of-3.nc" for number in (1, 2, 3)]
    assert "complete (part 1/3)\n" in command("status", parts[0]).out
    done = command.ok("merge", *parts, "-o", "merged.nc")
    assert done.out.startswith("merged.nc\n4 points, 0 failed")
    whole = content_hash(open_result(Path("results/a.nc")))
    assert content_hash(open_result(Path("merged.nc"))) == whole


def test_a_table_is_written_once(command: Command) -> None:
    command("sweep", "a.yaml", "-o", "a.nc")
    done = command("export", "a.nc")
    assert (done.code, done.out) == (0, "a.csv\na.columns.csv\n")
    again = command("export", "a.nc")
    assert (again.code, again.err) == (0, f"a.csv {messages.COMPLETE}\n")
    Path("a.csv").write_text("mine")
    assert messages.EXISTS in command("export", "a.nc").err
    assert Path("a.csv").read_text() == "mine"
    command.ok("export", "a.nc", "--overwrite")
    command.ok("export", "a.nc", "-o", "deep/er/b.csv")
    assert entries("deep/er") == ["b.columns.csv", "b.csv"]


def test_an_export_that_was_killed_is_repeated(command: Command) -> None:
    command("sweep", "a.yaml", "-o", "a.nc")
    command("export", "a.nc")
    whole = Path("a.csv").read_bytes()
    Path("a.csv").unlink()  # the columns get their name first
    command.ok("export", "a.nc")
    assert Path("a.csv").read_bytes() == whole


def test_other_files_are_not_replaced_by_tables(command: Command) -> None:
    command("sweep", "a.yaml", "-o", "a.nc")
    Path("b.columns.csv").write_text("mine")
    code, out, err = command("export", "a.nc", "-o", "b.csv")
    assert (code, out) == (2, "")
    assert err == f"b.columns.csv {messages.EXISTS} replaces it, -o writes elsewhere\n"
    assert not Path("b.csv").exists()
    result = Path("a.nc").rename("c.csv").read_bytes()
    for more in ([], ["--overwrite"]):
        code, _, err = command("export", "c.csv", *more)
        assert (code, err) == (2, "c.csv is also an input; choose another -o\n")
    assert Path("c.csv").read_bytes() == result
