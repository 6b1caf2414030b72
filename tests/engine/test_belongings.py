"""Files of other people are not touched, and their contents are not trusted."""

from __future__ import annotations

import os
from pathlib import Path

import netCDF4
import pytest
from support import messages
from support.marks import marked
from support.sweeps.sweeping import LOOSE, ONE_BY_ONE, Shell, entries, hash_at_once, hash_of

from sweeps.files.run_folder import RunFolder

A_YAML = "sweep: {temperature: [200, 250, 270]}\n" + LOOSE + ONE_BY_ONE
RUN = Path("a.nc.run")


# --- links, and files that appear ---


@pytest.mark.parametrize(
    "name", ["heartbeat.json.new", "result.nc", "journal.new", "../a.nc.timing.json"]
)
def test_a_planted_link_is_not_followed(shell: Shell, name: str) -> None:
    Path("precious").write_text("mine")
    RUN.mkdir()
    (RUN / name).symlink_to(Path("precious").absolute())
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    assert Path("precious").read_text() == "mine"
    assert hash_of("a.nc") == hash_at_once("a.yaml")


def test_a_file_that_appears_during_the_sweep_is_left_alone(shell: Shell) -> None:
    shell.disturb = lambda _: Path("a.nc").write_text("mine") and None
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    shell.disturb = None
    assert code == 5
    assert f"a.nc {messages.CHANGED_BY_OTHERS} the sweep, and" in err
    assert Path("a.nc").read_text() == "mine"
    Path("a.nc").rename("theirs")
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    assert shell.computed == []
    assert hash_of("a.nc") == hash_at_once("a.yaml")


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666])
def test_the_permissions_of_a_result_stay(shell: Shell, mode: int) -> None:
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    Path("a.nc").chmod(mode)
    shell.ok("sweep", "a.yaml", "-o", "a.nc", "--overwrite")
    assert Path("a.nc").stat().st_mode & 0o777 == mode


def test_an_output_that_is_a_link_stays_one(shell: Shell) -> None:
    Path("disk").mkdir()
    shell.ok("sweep", "a.yaml", "-o", "disk/real.nc")
    Path("a.nc").symlink_to("disk/real.nc")
    shell.ok("sweep", "a.yaml", "-o", "a.nc", "--overwrite")
    assert Path("a.nc").is_symlink()
    assert hash_of("disk/real.nc") == hash_at_once("a.yaml")
    assert entries("disk") == ["real.nc", "real.nc.timing.json"]


# --- seals ---


@pytest.mark.parametrize("verb", ["info", "export", *marked("stress", ["plot"])])
def test_a_file_edited_by_hand_is_reported(shell: Shell, verb: str) -> None:
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    assert "warning" not in shell(verb, "a.nc").err
    with netCDF4.Dataset("a.nc", "a") as file:
        file["elastic_stress_amplitude"][0] = 1.0
    code, _, err = shell(verb, "a.nc", *(["--overwrite"] if verb == "export" else []))
    assert code == 0
    assert f"a.nc {messages.NOT_OURS}: cut down, edited or damaged" in err


# --- what is printed ---


def test_texts_from_files_do_not_control_the_terminal(shell: Shell) -> None:
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    with netCDF4.Dataset("a.nc", "a") as file:
        file.title = "red \x1b[31m, \x9b2J and a bell \x07"
    out = shell("info", "a.nc").out
    assert r"red \x1b[31m, \x9b2J and a bell \x07" in out
    assert not set("\x1b\x9b\x07") & set(out)


@pytest.mark.parametrize("beat", ["[]", "(", None])
def test_an_invalid_heartbeat_is_ignored(
    shell: Shell, monkeypatch: pytest.MonkeyPatch, beat: str | None
) -> None:
    RUN.mkdir()
    if beat is None:
        os.mkfifo(RUN / "heartbeat.json")  # reading it would wait
    else:
        (RUN / "heartbeat.json").write_text(beat)
    with monkeypatch.context() as patch:
        patch.setattr(RunFolder, "is_held", lambda _: True)
        assert shell("status", "a.nc")[:2] == (0, "a.nc: running\n")
    shell.ok("sweep", "a.yaml", "-o", "a.nc")


def test_a_config_full_of_errors_is_refused_in_one_screen(shell: Shell) -> None:
    Path("a.yaml").write_text("".join(f"x{i}: {i}\n" for i in range(1900)))
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    lines = err.splitlines()
    assert (code, len(lines)) == (2, 51)
    assert lines[-1] == "... and 1850 more"


def test_without_compiled_code_nothing_begins(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert code == 2
    assert "NUMBA_DISABLE_JIT is set" in err
    assert entries() == ["a.yaml"]
