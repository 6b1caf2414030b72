"""Existing results that do not fit are reported and left alone until an option decides."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from support import messages
from support.sweeps.sweeping import (
    LOOSE,
    ONE_BY_ONE,
    Shell,
    entries,
    everything,
    hash_at_once,
    hash_of,
    write,
)
from support.sweeps.writing import write_dataset

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import load
from sweeps.engine.existing import Target
from sweeps.files.journal import Journal, manifest_path, readable_manifest
from sweeps.files.netcdf import open_result

FOUR = "sweep: {temperature: [200, 225, 250, 275]}\n"
FIVE = "sweep: {temperature: [200, 225, 250, 275, 300]}\noutput: a.nc\n"
A_YAML = FOUR + LOOSE
OTHER = LOOSE.replace("integrator: {rtol: 1e-4}", "integrator: {rtol: 1e-5}")
ALL = [200.0, 225.0, 250.0, 275.0]
FOLLOWED = (
    "sweep: {omega: {linspace: [8, 40], num: 9}, T: [200, 240]}\n"
    "follow: omega\nstationary: {max_periods: 6}\n"
)
STOPPED_RETRY = ("--retry-failed", "--max-runtime", "0.001s")
REFINED = "sweep: {T: {linspace: [200, 300], num: 5}}\nrefine: {axes: [T], levels: 2}\n"


@pytest.fixture
def shell(shell: Shell) -> Shell:
    """A folder with a complete result, `a.nc`, of `a.yaml`."""
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    return shell


# --- files that do not belong to this sweep ---

A = Path("a.nc")


def edited(change: Callable[[netCDF4.Dataset], None]) -> None:
    with netCDF4.Dataset(A, "a") as file:
        change(file)


def shifted(name: str) -> Callable[[netCDF4.Dataset], None]:
    def shift(file: netCDF4.Dataset) -> None:
        file[name][...] = file[name][...] + 1

    return shift


def cut(length: int) -> None:
    A.write_bytes(A.read_bytes()[:length])


DAMAGED = f"a.nc {messages.NOT_OURS}: cut down, edited or damaged"
UNREADABLE = f"a.nc exists, but {messages.NOT_NETCDF}"
UNFIT: dict[str, tuple[Callable[[], object], int, str]] = {
    **{
        f"of numerics version {other}": (
            lambda n=other: edited(lambda file: file.setncattr("numerics_version", str(n))),
            2,
            f"a.nc was {messages.OTHER_VERSION}{other}; this is {NUMERICS_VERSION}, which "
            "gives different numbers",
        )
        for other in (NUMERICS_VERSION - 1, NUMERICS_VERSION + 1)
    },
    "without a variable": (
        lambda: write_dataset(open_result(A).drop_vars("asymmetry"), A),
        2,
        "a.nc lacks asymmetry, which this version computes for every point; it can still be "
        "drawn and replayed; --overwrite",
    ),
    "without its seal": (
        lambda: edited(lambda file: file.delncattr("data_sha256")),
        2,
        "a.nc carries no seal",
    ),
    "with a config that cannot be read": (
        lambda: edited(lambda file: file.setncattr("config", "model: {nonsense: 1}\n")),
        2,
        "a.nc carries a config that this version cannot read",
    ),
    # A damaged value of an axis, which is now one that the larger config names.
    "another point": (lambda: edited(lambda f: f["temperature"].__setitem__(3, 300.0)), 5, DAMAGED),
    **{
        f"another {name}": (lambda name=name: edited(shifted(name)), 5, DAMAGED)
        for name in ("friction_force_amplitude", "status", "block_mass")
    },
    "of somebody else": (
        lambda: xr.Dataset({"mine": 1.0}).to_netcdf(A),
        2,
        "a.nc exists but is not the result of a sweep",
    ),
    "of a fit": (
        lambda: edited(lambda file: file.createVariable("fitted_value", "f8")),
        2,
        "a.nc holds a fit, not a sweep",
    ),
    "a text": (lambda: A.write_text("mine"), 5, UNREADABLE),
    **{
        f"cut at {length}": (lambda length=length: cut(length), 5, UNREADABLE)
        for length in (0, 1, 8, 100, 10_000, -1)
    },
}


ALIKE = [
    f"of numerics version {NUMERICS_VERSION + 1}",
    *(f"another {name}" for name in ("status", "block_mass")),
    *(f"cut at {length}" for length in (1, 8, 100, -1)),
]
"""They are refused like others; `make faults` has them."""


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        pytest.param(*case, id=name, marks=[pytest.mark.faults] if name in ALIKE else [])
        for name, case in UNFIT.items()
    ],
)
def test_a_file_that_does_not_fit_is_left_alone_until_overwrite(
    shell: Shell, change: Callable[[], object], code: int, words: str
) -> None:
    config = write("b.yaml", FIVE, LOOSE)
    change()
    before = everything()
    for verb in ("check", "plan", "status", "sweep"):
        found = shell(verb, config)
        assert (found.code, found.out) == (code, ""), verb
        assert found.err.startswith(words), verb
        assert found.err.endswith("--overwrite replaces it, -o writes elsewhere\n"), verb
        assert (everything(), shell.computed, "a.nc.run" in entries()) == (before, [], False)
    shell.ok("sweep", config, "--overwrite")
    assert hash_of("a.nc") == hash_at_once(config)


JOURNAL = Path("b.nc.run/journal")


def noting(config: str, change: dict[str, object]) -> None:
    target = Target.of(load(config))
    journal = Journal.open(JOURNAL, {}, target.keys, target.chunks)
    journal.note(readable_manifest(JOURNAL) | change)
    journal.close()


def damage_manifest(_: str) -> None:
    text = manifest_path(JOURNAL).read_text()
    manifest_path(JOURNAL).write_text(text.replace("processors", "processorz"))


def put_a_pipe(_: str) -> None:
    JOURNAL.unlink()
    os.mkfifo(JOURNAL)


ANOTHER = "b.nc.run/journal was begun by another version of stickslip"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: noting(c, {"numerics_version": NUMERICS_VERSION + 1}), ANOTHER),
        (lambda c: noting(c, {"columns": [*RESULT_COLUMNS, "verdict"]}), ANOTHER),
        (
            damage_manifest,
            "b.nc.run/journal.json is damaged or missing, so it is unknown which points",
        ),
        (put_a_pipe, "b.nc.run/journal is not an ordinary file; move it away"),
    ],
)
def test_an_unreadable_journal_is_reported_and_kept_until_overwrite(
    shell: Shell, change: Callable[[str], None], words: str
) -> None:
    config = write("b.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.interrupted("sweep", config, "-o", "b.nc", after=2)
    change(config)
    before, sweep = everything(but="heartbeat.json"), ["sweep", config, "-o", "b.nc"]
    sweeps = [sweep, [*sweep, "--partial"], [*sweep, "--retry-failed"]]
    others = [["check", *sweep[1:]], ["plan", *sweep[1:]], ["status", "b.nc"]]
    for command in (*sweeps, *others):
        code, out, err = shell(*command)
        assert (code, out) == (5, "")
        assert err.startswith(words)
        assert "--overwrite" in err or change is put_a_pipe
        assert everything(but="heartbeat.json") == before
    shell.ok(*sweep, "--overwrite")
    assert hash_of("b.nc") == hash_of("a.nc")


# --- other settings ---


@pytest.mark.parametrize("points", [FOUR, FIVE])
def test_other_settings_are_refused_and_change_nothing(shell: Shell, points: str) -> None:
    write("b.yaml", points, OTHER)
    before = everything(but="heartbeat.json")
    code, out, err = shell("sweep", "b.yaml", "-o", "a.nc")
    assert (code, out) == (2, "")
    assert err.splitlines() == [
        f"a.nc was computed {messages.OTHER_SETTINGS}:",
        "  integrator.rtol: 0.0001 -> 1e-05",
        "--overwrite replaces it, -o writes elsewhere",
    ]
    assert shell.computed == []
    assert everything(but="heartbeat.json") == before


def test_overwrite_computes_all_points_again(shell: Shell) -> None:
    config = write("b.yaml", FIVE, OTHER)
    code, _, err = shell("sweep", config, "-o", "a.nc", "--overwrite")
    assert (code, err) == (0, "5 points; 5 to compute\n")
    assert shell.values("temperature") == [*ALL, 300.0]
    assert hash_of("a.nc") == hash_at_once(config)
    shell.ok("sweep", config, "-o", "a.nc", "--overwrite")
    assert shell.values("temperature") == [*ALL, 300.0]  # even if nothing differs


# --- other versions ---


def test_a_file_of_another_numerics_version_is_shown_and_drawn(shell: Shell) -> None:
    assert "numerics version" not in shell("info", "a.nc").out
    other = NUMERICS_VERSION - 1
    edited(lambda file: file.setncattr("numerics_version", str(other)))
    before = everything()
    code, out, err = shell("info", "a.nc")
    assert (code, err) == (0, "")
    assert f"computed with numerics version {other}; this program has {NUMERICS_VERSION}\n" in out
    assert everything() == before
    shell.ok("plot", "a.nc", "-o", "a.png")


def test_a_variable_that_a_user_added_is_not_carried_over(shell: Shell) -> None:
    with netCDF4.Dataset("a.nc", "a") as file:
        file.createVariable("verdict", "i1", ("temperature",))[...] = 2
    assert shell("sweep", "a.yaml", "-o", "a.nc").err == (f"a.nc {messages.COMPLETE_POINTS}\n")
    code, _, err = shell("sweep", write("b.yaml", FIVE, LOOSE), "-o", "a.nc")
    assert code == 0
    assert err == (
        "warning: a.nc has variables that stickslip did not write and that are not carried over: "
        "verdict\n5 points: 4 in a.nc; 1 to compute\n"
    )
    assert "verdict" not in open_result(Path("a.nc"))


# --- other points ---


def test_points_that_the_config_no_longer_names_are_refused_until_overwrite(shell: Shell) -> None:
    config = write("b.yaml", "sweep: {temperature: [225, 300]}\n", LOOSE)
    before = everything(but="heartbeat.json")
    for option in ("", "--retry-failed"):
        code, out, err = shell("sweep", config, "-o", "a.nc", *filter(None, [option]))
        assert (code, out) == (2, "")
        assert err == (
            "a.nc has 3 finished points that the config no longer has, such as temperature = "
            "200. They would be lost: --overwrite starts afresh and drops them, -o writes "
            "elsewhere\n"
        )
        assert everything(but="heartbeat.json") == before
    code, _, err = shell("sweep", config, "-o", "a.nc", "--overwrite")
    assert (code, err) == (0, "2 points; 2 to compute\n")
    assert hash_of("a.nc") == hash_at_once(config)


def test_an_interrupted_overwrite_is_resumed_with_and_without_the_option(
    shell: Shell,
) -> None:
    old = Path("a.nc").read_bytes()
    config = write("b.yaml", "sweep: {temperature: [210, 220, 230, 240, 250]}\n", ONE_BY_ONE, LOOSE)
    overwrite = ("sweep", config, "-o", "a.nc", "--overwrite")
    assert shell.interrupted(*overwrite, after=1).code == 4
    seen = shell.values("temperature")
    assert Path("a.nc").read_bytes() == old
    assert shell.interrupted(*overwrite, after=1).code == 4
    assert not set(seen) & set(shell.values("temperature"))
    seen += shell.values("temperature")
    code, _, err = shell(*overwrite[:-1])
    assert (code, err) == (0, f"5 points: {len(seen)} in its journal; {5 - len(seen)} to compute\n")
    assert sorted(seen + shell.values("temperature")) == [210.0, 220.0, 230.0, 240.0, 250.0]
    assert hash_of("a.nc") == hash_at_once(config)
    assert "a.nc.run" not in entries()


def test_an_interrupted_overwrite_stays_one_when_its_config_grows(shell: Shell) -> None:
    small, large = (
        "sweep: {temperature: [300, 310, 320]}\n",
        "sweep: {temperature: [300, 310, 320, 330]}\n",
    )
    config = write("b.yaml", small, ONE_BY_ONE, LOOSE)
    shell.interrupted("sweep", config, "-o", "a.nc", "--overwrite", after=1)
    grown = write("c.yaml", large, ONE_BY_ONE, LOOSE)
    assert shell.interrupted("sweep", grown, "-o", "a.nc", after=1).code == 4
    again = write("d.yaml", large.replace("330", "330, 340"), LOOSE)
    shell.ok("sweep", again, "-o", "a.nc")
    assert hash_of("a.nc") == hash_at_once(again)


# --- failed points ---


def test_retry_failed_computes_exactly_the_failed_points(shell: Shell) -> None:
    def poison(rows: np.ndarray) -> None:
        if np.any(rows[:, 0] == 225.0) or np.any(rows[:, 0] == 275.0):
            raise ValueError("poison")

    shell.disturb = poison
    assert shell("sweep", "a.yaml", "-o", "b.nc").code == 3
    shell.disturb = None
    code, out, err = shell("sweep", "a.yaml", "-o", "b.nc")
    assert (code, shell.computed) == (3, [])
    assert f"b.nc {messages.COMPLETE_POINTS}\n" in err
    assert "4 points, 2 failed" in out
    code, _, err = shell("sweep", "a.yaml", "-o", "b.nc", "--retry-failed")
    assert (code, err) == (0, "4 points: 2 in b.nc; 2 to compute\n")
    assert shell.values("temperature") == [225.0, 275.0]
    assert hash_of("b.nc") == hash_of("a.nc")


@pytest.mark.parametrize("text", [FOUR, FIVE])
def test_an_interrupted_retry_is_resumed_without_the_option(shell: Shell, text: str) -> None:
    def poison(rows: np.ndarray) -> None:
        if len(shell.computed) != 0:
            raise ValueError("poison")

    config = write("b.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.disturb = poison
    assert "3 failed" in shell("sweep", config, "-o", "b.nc").out
    shell.interrupted("sweep", config, "-o", "b.nc", "--retry-failed", after=2)
    done = {point.temperature for point in shell.computed}
    assert len(done) == 2
    write("b.yaml", text, LOOSE, ONE_BY_ONE)
    status = json.loads(shell("status", "b.nc", "--json").out)
    assert (status["state"], status["failed"], status["done"]) == ("interrupted", 0, 1 + len(done))
    shell.ok("sweep", config, "-o", "b.nc")
    assert not done & set(shell.values("temperature"))
    assert hash_of("b.nc") == hash_at_once(config)


@pytest.mark.parametrize("text", [FOUR, REFINED])
def test_partial_keeps_the_points_that_an_interrupted_retry_has_not_reached(
    shell: Shell, text: str
) -> None:
    def poison(rows: np.ndarray) -> None:
        if shell.computed:
            raise ValueError("poison")

    config = write("b.yaml", text, LOOSE, ONE_BY_ONE)
    shell.disturb = poison
    assert shell("sweep", config, "-o", "b.nc").code == 3
    before, shell.disturb = hash_of("b.nc"), None
    assert shell("sweep", config, "-o", "b.nc", *STOPPED_RETRY).code == 4
    shell("sweep", config, "-o", "b.nc", "--partial")
    assert hash_of("b.nc") == before
    assert json.loads(shell("status", "b.nc", "--json").out)["state"] == "interrupted"
    shell.ok("sweep", config, "-o", "b.nc")
    assert hash_of("b.nc") == hash_at_once(config)


def test_partial_keeps_whole_lines_of_which_one_point_is_to_be_retried(shell: Shell) -> None:
    config = write("b.yaml", FOLLOWED)
    assert shell("sweep", config, "-o", "b.nc").code == 3
    before = hash_of("b.nc")
    assert shell("sweep", config, "-o", "b.nc", *STOPPED_RETRY).code == 4
    shell("sweep", config, "-o", "b.nc", "--partial")
    assert hash_of("b.nc") == before


def test_retry_failed_of_an_interrupted_sweep_keeps_points_with_a_result(shell: Shell) -> None:
    def poison(rows: np.ndarray) -> None:
        if len(shell.computed) != 0:
            raise ValueError("poison")

    config = write("b.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.disturb = poison
    assert shell("sweep", config, "-o", "b.nc", "--keep-journal").code == 3
    (ok,) = shell.values("temperature")
    shell.disturb = None
    Path("b.nc").unlink()
    shell.ok("sweep", config, "-o", "b.nc", "--retry-failed")
    assert shell.values("temperature") == sorted(set(ALL) - {ok})
    assert hash_of("b.nc") == hash_of("a.nc")


def test_a_sweep_stops_if_its_first_block_fails(shell: Shell) -> None:
    def fail(_: np.ndarray) -> None:
        time.sleep(0.2)  # the next block begins before the first is looked at
        raise ValueError("poison")

    config = write("b.yaml", FOUR, LOOSE, "execution: {workers: 1, block_points: 1}\n")
    shell.disturb = fail
    code, out, err = shell("sweep", config, "-o", "b.nc")
    assert (code, out) == (3, "")
    assert f"Stopped: {messages.ALL_FAILED} (1 point)" in err
    assert "  stickslip sweep b.yaml -o b.nc\n" in err
    assert not Path("b.nc").exists()
    code, out, _ = shell("sweep", config, "-o", "b.nc")
    assert code == 3
    assert "4 points" in out
    assert "4 failed" in out
    assert np.all(open_result(Path("b.nc")).status == 5)


# --- the points finished so far ---


@pytest.mark.parametrize("alone", [False, True], ids=["with its journal", "alone"])
def test_partial_writes_finished_points_and_the_sweep_is_resumed(shell: Shell, alone: bool) -> None:
    config = write("b.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.interrupted("sweep", config, "-o", "b.nc", after=2)
    first = shell.values("temperature")
    code, out, _ = shell("sweep", config, "-o", "b.nc", "--partial")
    assert (code, shell.computed) == (0, [])
    path, summary = out.splitlines()
    assert path == "b.nc"
    assert summary.startswith(f"4 points, 0 failed, {4 - len(first)} pending, largest amplitude")
    part = open_result(Path("b.nc"))
    there = np.isin(part.temperature, first)
    assert np.array_equal(part.status, np.where(there, 0, 127))
    assert np.array_equal(np.isnan(part.friction_force_amplitude), ~there)
    if alone:
        JOURNAL.unlink()
    shell.ok("sweep", config, "-o", "b.nc")
    assert sorted(first + shell.values("temperature")) == ALL
    assert hash_of("b.nc") == hash_of("a.nc")
    assert "b.nc.run" not in entries()


def test_partial_keeps_the_journal_of_a_complete_sweep_if_asked(shell: Shell) -> None:
    sweep = ("sweep", "a.yaml", "-o", "b.nc")
    shell.ok(*sweep, "--keep-journal")
    kept = sorted(Path("b.nc.run").iterdir())
    shell.ok(*sweep, "--partial", "--keep-journal")
    assert sorted(Path("b.nc.run").iterdir()) == kept
    shell.ok(*sweep, "--partial")
    assert not Path("b.nc.run").exists()


def test_partial_of_nothing_is_refused(shell: Shell) -> None:
    code, _, err = shell("sweep", "a.yaml", "-o", "b.nc", "--partial")
    assert code == 2
    assert err == "b.nc has no points yet; leave out --partial to compute them\n"
    assert entries() == ["a.nc", "a.nc.timing.json", "a.yaml"]


def test_a_kept_journal_shows_the_next_run_that_all_is_done(shell: Shell) -> None:
    for again in range(2):
        shell.ok("sweep", "a.yaml", "-o", "b.nc", "--keep-journal")
        assert len(shell.computed) == (4 if again == 0 else 0)
        assert "journal" in entries("b.nc.run")
    assert hash_of("b.nc") == hash_of("a.nc")
    shell.ok("sweep", "a.yaml", "-o", "b.nc")
    assert shell.computed == []
    assert hash_of("b.nc") == hash_of("a.nc")


def test_overwrite_computes_all_points_despite_a_kept_journal(shell: Shell) -> None:
    for _ in range(2):
        shell.ok("sweep", "a.yaml", "-o", "b.nc", "--overwrite", "--keep-journal")
        assert shell.values("temperature") == ALL


def test_a_kept_journal_protects_its_output_until_a_sweep_removes_it(shell: Shell) -> None:
    sweep = ("sweep", "a.yaml", "-o", "b.nc")
    shell.ok(*sweep, "--keep-journal")
    merge = ("merge", "a.nc", "-o", "b.nc", "--overwrite")
    assert shell(*merge) == (
        2,
        "",
        f"a sweep to b.nc {messages.RESUMABLE}, or its journal was kept; finish it without "
        "--keep-journal, or choose another -o\n",
    )
    shell.ok(*sweep)
    shell.ok(*merge)


def test_a_journal_kept_by_overwrite_replaces_nothing_afterwards(shell: Shell) -> None:
    sweep = ("sweep", "a.yaml", "-o", "b.nc")
    shell.ok(*sweep, "--overwrite", "--keep-journal")
    shell.ok(*sweep, "--partial", "--keep-journal")
    shell.ok("sweep", write("b.yaml", FIVE, LOOSE), "-o", "c.nc")
    larger = Path("c.nc").read_bytes()
    Path("b.nc").write_bytes(larger)
    code, _, err = shell(*sweep)
    assert code == 2
    assert err.startswith("b.nc has 1 finished point that the config no longer has")
    assert Path("b.nc").read_bytes() == larger


# --- the granted time ---


def test_the_end_of_the_granted_time_prints_the_command_to_resume(shell: Shell) -> None:
    config = write("b b.yaml", FOUR, LOOSE, ONE_BY_ONE)
    code, out, err = shell("sweep", config, "-o", "b.nc", "--max-runtime", "0.001s")
    assert (code, out) == (4, "")
    assert f"Stopped: {messages.TIME_OVER}." in err
    assert err.endswith("\n  stickslip sweep 'b b.yaml' -o b.nc --max-runtime 0.001s\n")
    shell.ok("sweep", config, "-o", "b.nc", "--max-runtime", "1h")
    assert hash_of("b.nc") == hash_of("a.nc")
