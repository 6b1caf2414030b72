"""Every failure of the command line ends with one message and its exit code, and writes nothing."""

from __future__ import annotations

import logging
import os
import re
import resource
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support import messages
from support.sweeps.bad_configs import ALL
from support.sweeps.commands import Command, entries, process
from support.sweeps.writing import write_dataset

from sweeps.cli import sweeps
from sweeps.files import atomic
from sweeps.files.netcdf import open_result

A_YAML = """\
sweep: {temperature: [200, 250]}
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4}
"""


# --- impossible commands, their exit codes and messages ---

FIGURES = "choose from 2, 3, 4, 5, 6, 7, 8, 9, all"

_OF_OTHERS = {".csv": "export", ".PNG": "plot", ".html": "report", ".yml": "new"}

REFUSALS = [
    *(
        (line, 2, "Usage: stickslip .*\nError: ")
        for line in (
            "nonsense",
            "sweep",
            "sweep a.yaml b.yaml",
            "sweep a.yaml --nonsense",
            "sweep a.yaml --workers 0",
            "sweep a.yaml --workers many",
            "simulate a.yaml --periods 0",
            "figure",
            "plot",
        )
    ),
    ("sweep no.yaml", 2, r"no\.yaml: cannot be read: No such file"),
    ("sweep a.yaml --set T", 2, "--set T: must be KEY=VALUE"),
    ("sweep a.yaml --set Tempe=3", 2, "Tempe: unknown key"),
    ("sweep a.yaml --set model.K=-1", 2, "model.K: must be at least 0"),
    ("sweep a.yaml --backend carrier-pigeon", 2, "--backend carrier-pigeon: .* 'threads', 'loky'"),
    ("sweep a.yaml --backend dask", 2, "--backend dask: execution.backend: `dask` needs the"),
    ("plan a.yaml --workers 5000", 2, "--workers 5000: execution.workers: must be at most"),
    ("sweep a.yaml --set execution.workers=1 --workers 2", 2, "--workers 2: .* first by --set"),
    ("simulate --periods 999999999", 2, "--periods 999999999: simulation.periods: must be at"),
    (
        "simulate --set simulation.drive.velocity=2e-6 --set simulation.duration=0.1 --periods 2",
        2,
        "--periods: .*leave out --periods, .*--set simulation.duration=",
    ),
    ("check a.yaml --set noise.seed=3", 2, "belongs to `treatment: stochastic`"),
    ("check a.yaml --set noise.treatment=none", 2, "could never solidify"),
    (
        "sweep a.yaml --scheduler tcp://10.0.0.1:8786 --workers 4",
        2,
        "--workers: a scheduler has its own workers; give only one of the two",
    ),
    *(
        (f"sweep a.yaml --scheduler {address}", 2, "must be an address such as tcp://")
        for address in (
            "host",
            "tcp://host",
            "tcp://host:port",
            "tcp://host:99999",
            "tcp://[127.0.0.1]:8786",
            "tcp://localhost/x.example.org:8786",
            "carrier-pigeon://host:8786",
            "tcp://:8786",
        )
    ),
    ("sweep a.yaml --max-runtime soon", 2, "--max-runtime: 'soon' is not a duration"),
    ("sweep a.yaml --max-runtime 0", 2, "--max-runtime: .* longer than 0"),
    ("sweep a.yaml --partial --retry-failed", 2, "--partial computes nothing, .*leave one of the"),
    ("sweep a.yaml --part 3/2", 2, "--part: '3/2' is not a part"),
    ("merge no.nc -o m.nc", 5, "no.nc does not exist"),
    ("replay no.nc", 5, "no.nc does not exist"),
    ("sweep .", 2, r"\.: cannot be read"),
    ("export a.yaml -o a.csv", 5, "a.yaml"),
    ("export no.nc", 5, "no.nc does not exist"),
    *(
        (f"{line} -o a{ending}", 2, rf"a\{ending}: -o names a NetCDF file.*`stickslip {other}`")
        for line in ("sweep a.yaml", "simulate a.yaml --set T=200", "merge no.nc", "check a.yaml")
        for ending, other in _OF_OTHERS.items()
    ),
    ("sensitivity a.yaml -o a.nc4", 2, "a.nc4: -o names a NetCDF file"),
    ("export no.nc -o a.xlsx", 2, "a.xlsx: the name of a table must end in .csv or .parquet"),
    ("export no.nc -o a.yaml/a.csv", 5, "a.yaml is not a folder"),
    ("figure 1", 2, f"no figure 1; {FIGURES}"),
    ("figure 3 10 x", 2, f"no figure 10, x; {FIGURES}"),
    ("info --hash", 2, "--hash needs a FILE"),
    *(
        (f"{verb} {name}", 5, f"^{name} {words}")
        for verb in ("info", "info --hash", "plot", "status")
        for name, words in {
            "no.nc": "does not exist",
            "bad.nc": f".*{messages.NOT_NETCDF}",
            "folder": "",  # each verb in its own words
            "pipe": ".*not an ordinary file",
        }.items()
    ),
    *(
        (f"simulate a.yaml --set T=200 -o {output} {option}", 5, output)
        for output in ("folder", "pipe", "a.yaml/b.nc")
        for option in ("", "--overwrite")
    ),
]


@pytest.mark.parametrize(("line", "code", "message"), REFUSALS, ids=lambda x: str(x)[:40])
def test_impossible_commands_are_refused(
    command: Command, line: str, code: int, message: str
) -> None:
    Path("folder").mkdir()
    os.mkfifo("pipe")
    Path("bad.nc").write_bytes(b"nonsense" * 1000)
    done = command(*line.split())
    assert (done.code, done.out) == (code, "")
    assert re.search(message, done.err, re.DOTALL), done.err
    assert done.err.count("\n") == 1 or done.err.startswith("Usage: ")
    assert entries() == ["a.yaml", "bad.nc", "folder", "pipe"]
    assert Path("a.yaml").read_text() == A_YAML


def test_no_verb_shows_the_help(command: Command) -> None:
    code, out, err = command()
    assert code == 2
    assert "Commands:" in out + err


@pytest.mark.parametrize("verb", ["sweep", "check", "simulate"])
def test_a_step_that_is_unstable_everywhere_names_its_line(command: Command, verb: str) -> None:
    Path("e.yaml").write_text("integrator:\n  method: euler-cromer\n  dt: 1e-3\n")
    code, out, err = command(verb, "e.yaml")
    assert (code, out) == (2, "")
    assert re.fullmatch(
        r"e\.yaml:3: integrator\.dt: the step of 0\.001 s is unstable .* is 1\.3e-8 s\n", err
    )
    assert entries() == ["a.yaml", "e.yaml"]


@pytest.mark.parametrize("verb", ["sweep", "check", "simulate"])
def test_bad_configs_are_refused_in_lines(command: Command, verb: str) -> None:
    for name, content, outcome in [row for row in ALL if row[2].kind == "refused"][::5]:
        Path("bad.yaml").write_bytes(content.encode() if isinstance(content, str) else content)
        code, out, err = command(verb, "bad.yaml")
        assert (code, out) == (2, ""), name
        lines = err.splitlines()
        place = "bad.yaml" if outcome.line is None else f"bad.yaml:{outcome.line}"
        assert all(line.startswith(("bad.yaml:", "warning: ")) for line in lines), name
        assert any(line.startswith(f"{place}: ") for line in lines), name
        assert err.isascii() or err.replace("\n", "").isprintable(), name
        assert entries() == ["a.yaml", "bad.yaml"], name


# --- 5: files ---


def test_a_write_that_fails_at_the_end_keeps_the_old_file(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    command("sweep", "a.yaml", "-o", "a.nc")
    before = {path: path.read_bytes() for path in Path().iterdir()}
    again = ("sweep", "a.yaml", "--set", "T=[300]", "-o", "a.nc")

    flush = atomic.flush

    def full(path: Path) -> None:
        if path.name == "result.nc":
            raise OSError(28, "No space left on device")
        flush(path)

    with monkeypatch.context() as patch:
        patch.setattr(atomic, "flush", full)
        code, out, err = command(*again, "--overwrite")
    assert (code, out) == (5, "")
    assert "cannot write a.nc: No space left on device" in err
    assert {path: path.read_bytes() for path in Path().iterdir() if path.is_file()} == before
    assert entries("a.nc.run") == ["heartbeat.json", "journal", "journal.json", "lock"]
    code, _, err = command(*again)
    assert (code, err) == (0, "1 point: 1 in its journal; 0 to compute\n")
    assert open_result(Path("a.nc")).temperature == [300.0]
    assert not Path("a.nc.run").exists()


@pytest.mark.slow
def test_a_really_full_disk_keeps_the_old_file(tmp_path: Path) -> None:
    """A limit on file sizes stands in for a small disk: the library reports both alike."""
    path = tmp_path / "a.nc"
    write_dataset(xr.Dataset({"old": 1.0}), path)
    old = path.read_bytes()
    (tmp_path / "a.yaml").write_text(A_YAML)
    limit = resource.RLIMIT_FSIZE, (20_000, 20_000)
    command = ("sweep", "a.yaml", "-o", "a.nc", "--overwrite")
    code, out, err = process(*command, cwd=tmp_path, preexec_fn=lambda: resource.setrlimit(*limit))
    assert (code, out) == (5, ""), err
    assert "cannot write " in err
    assert "a.nc" in err
    assert path.read_bytes() == old
    assert "result.nc" not in [file.name for file in tmp_path.rglob("*")]


def test_a_full_disk_behind_the_standard_output(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full here")
    with Path("/dev/full").open("w") as full:
        code, _, err = process("schema", stdout=full)
    assert code == 5
    assert err == "Input/output error: [Errno 28] No space left on device\n"


def test_a_timing_that_cannot_be_written_costs_nothing_else(command: Command) -> None:
    Path("a.nc.timing.json").mkdir()
    code, out, err = command("sweep", "a.yaml", "-o", "a.nc")
    assert code == 0
    assert out.startswith("a.nc\n")
    assert "warning: the timing was not written: " in err


@pytest.mark.parametrize("output", ["a.yaml/x.png", "a.yaml/x"])
def test_a_picture_that_cannot_be_written(command: Command, output: str) -> None:
    command("sweep", "a.yaml", "-o", "a.nc")
    code, out, err = command("plot", "a.nc", "-o", output)
    assert (code, out) == (5, "")
    assert err.startswith(f"cannot write {output}")


def test_a_file_without_anything_to_draw(command: Command) -> None:
    write_dataset(xr.Dataset({"a": ("x", np.array([1.0, 2.0]))}), Path("a.nc"))
    code, out, err = command("plot", "a.nc")
    assert (code, out) == (2, "")
    assert "needs elastic_stress_amplitude, friction_force_amplitude, which this file lacks" in err
    code, out, err = command("info", "a.nc")
    assert (code, err) == (0, "")
    assert "source: unknown" in out


# --- 3 and 1: exceptions ---


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (ValueError("never seen"), 1, "Unexpected ValueError: never seen\n"),
        (MemoryError(), 1, "Out of memory; a smaller grid or fewer samples may fit.\n"),
        (OSError(5, "Input/output error"), 5, "Input/output error: [Errno 5] Input/output error\n"),
        (KeyboardInterrupt(), 130, "Interrupted; only files named above were kept.\n"),
    ],
)
def test_an_unexpected_error_is_one_line(
    command: Command,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    error: BaseException,
    code: int,
    message: str,
) -> None:
    def broken(*args: Any) -> None:
        raise error

    monkeypatch.setattr(sweeps, "checked_config", broken)
    with caplog.at_level(logging.DEBUG):
        assert command("check", "a.yaml") == (code, "", message)
    if isinstance(error, ValueError):
        (record,) = [r for r in caplog.records if r.name == "sweeps.cli.app"]
        assert record.exc_info
        assert record.levelno == logging.DEBUG


def test_verbose_shows_details(command: Command) -> None:
    root = logging.getLogger()
    level = root.level
    try:
        command.ok("--verbose", "check", "a.yaml")
        assert root.level == logging.DEBUG
    finally:
        root.setLevel(level)
