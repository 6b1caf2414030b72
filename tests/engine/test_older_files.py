"""Results and journals of other versions are recognised, told, and used as far as they reach."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from support.sweeps.older import (
    FIVE,
    FOUR,
    KNOWN,
    OLDER,
    WAYS,
    everything,
    make_older,
    make_older_journal,
    note,
)
from support.sweeps.sweeping import LOOSE, ONE_BY_ONE, Shell, hash_at_once, hash_of, write

from stickslip.variables import RESULT_COLUMNS
from sweeps.files.columns import FIRST_COLUMNS
from sweeps.files.datasets import open_result
from sweeps.files.journal import readable_manifest
from sweeps.files.record_log import RecordLog
from sweeps.files.run_folder import RunFolder


@pytest.fixture
def shell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Shell:
    """A folder with a complete result of an older version, `a.nc`, of `a.yaml`."""
    shell = Shell(tmp_path, monkeypatch, capsys)
    assert shell("sweep", write("a.yaml", FOUR, LOOSE), "-o", "a.nc").code == 0
    make_older(Path("a.nc"))
    return shell


@pytest.fixture
def interrupted(shell: Shell) -> int:
    """... and with a journal of it, `b.nc.run`; the number of points in it."""
    Path("a.nc").unlink()
    assert shell.interrupted("sweep", write("b.yaml", FOUR, LOOSE, ONE_BY_ONE), after=2).code == 4
    return make_older_journal(RunFolder(Path("results/b.nc")).journal, "b.yaml")


# --- result variables that were added later ---


def test_an_older_file_is_described_as_one(shell: Shell) -> None:
    code, out, _ = shell("info", "a.nc")
    assert code == 0
    assert "written by an older version: lacks melting_count, asymmetry\n" in out


def test_a_file_of_this_version_is_described_without_a_word_about_versions(shell: Shell) -> None:
    shell("sweep", "a.yaml", "-o", "a.nc", "--recompute")
    assert "version:" not in shell("info", "a.nc").out


def test_an_older_file_is_drawn(shell: Shell) -> None:
    code, out, err = shell("plot", "a.nc", "-o", "a.png")
    assert (code, out, err) == (0, "a.png\n", "")


def test_status_reads_an_older_file(shell: Shell) -> None:
    assert shell("status", "a.nc").out.startswith("a.nc: complete\n4 of 4 points done")


@pytest.mark.parametrize("points", [FOUR, FIVE])
def test_a_sweep_says_what_it_would_compute_again_and_changes_nothing(
    shell: Shell, points: str
) -> None:
    config, before = write("b.yaml", points, LOOSE), everything()
    code, out, err = shell("sweep", config, "-o", "a.nc")
    assert (code, out) == (2, "")
    assert err == f"a.nc was {OLDER}: its 4 points would have to be computed again. {WAYS}"
    assert (everything(), shell.computed) == (before, [])


def test_other_settings_of_an_older_file_are_told_with_what_it_lacks(shell: Shell) -> None:
    err = shell("sweep", "a.yaml", "-o", "a.nc", "--set", "integrator.rtol=1e-5").err
    assert err.splitlines()[:3] == [
        "a.nc was computed with other settings:",
        "  integrator.rtol: 0.0001 -> 1e-05",
        "  variables: lacks melting_count, asymmetry",
    ]


def test_plan_counts_no_point_of_an_older_file(shell: Shell) -> None:
    assert shell("plan", "a.yaml", "-o", "a.nc").out.startswith("points: 4\n")


def test_recompute_makes_a_file_of_this_version(shell: Shell) -> None:
    assert shell("sweep", "a.yaml", "-o", "a.nc", "--recompute").code == 0
    assert len(shell.computed) == 4
    assert hash_of("a.nc") == hash_at_once("a.yaml")


def test_accept_mixed_keeps_the_points_and_leaves_the_new_variables_missing(shell: Shell) -> None:
    old, config = open_result(Path("a.nc")), write("b.yaml", FIVE, LOOSE)
    code, _, err = shell("sweep", config, "-o", "a.nc", "--accept-mixed")
    assert (code, err) == (0, "5 points: 4 in a.nc; 1 to compute\n")
    assert shell.values("temperature") == [300.0]
    mixed, fresh = open_result(Path("a.nc")), open_result_of(config, shell)
    for name in KNOWN:
        np.testing.assert_array_equal(mixed[name][:4], old[name])
    assert np.isnan(mixed.asymmetry[:4]).all()
    assert (mixed.melting_count[:4] == -1).all()
    assert mixed.isel(temperature=4).identical(fresh.isel(temperature=4).assign_attrs(mixed.attrs))
    assert mixed.attrs["mixed_with"] == "variables: lacks melting_count, asymmetry"


def open_result_of(config: str, shell: Shell) -> xr.Dataset:
    assert shell("sweep", config, "-o", "fresh.nc").code == 0
    return open_result(Path("fresh.nc"))


def test_a_mixed_file_is_complete_and_grows_without_asking_again(shell: Shell) -> None:
    shell("sweep", "a.yaml", "-o", "a.nc", "--accept-mixed")
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert (code, err) == (0, "a.nc is complete: 4 points, nothing to do\n")
    assert shell("sweep", write("b.yaml", FIVE, LOOSE), "-o", "a.nc").code == 0
    assert shell.values("temperature") == [300.0]
    assert "mixed_with" in open_result(Path("a.nc")).attrs


@pytest.mark.parametrize("name", ["friction_force_amplitude", "status", "temperature"])
def test_a_number_of_an_older_file_that_was_changed_is_noticed(shell: Shell, name: str) -> None:
    with netCDF4.Dataset("a.nc", "a") as file:
        file[name][0] += 1
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc", "--accept-mixed")
    assert code == 5
    assert err.startswith("a.nc is damaged, or was changed after stickslip wrote it")


def test_an_interrupted_sweep_of_an_older_version_is_told_and_kept(
    shell: Shell, interrupted: int
) -> None:
    before = everything()
    code, _, err = shell("sweep", "b.yaml")
    assert code == 2
    assert err == (
        f"the journal in results/b.nc.run was {OLDER}: its {interrupted} points would have to be "
        f"computed again. {WAYS}"
    )
    assert everything() == before
    assert f"{interrupted} of 4 points done" in shell("status", "results/b.nc").out


def test_an_interrupted_sweep_of_an_older_version_is_resumed_with_accept_mixed(
    shell: Shell, interrupted: int
) -> None:
    code, _, err = shell("sweep", "b.yaml", "--accept-mixed")
    assert code == 0
    left = 4 - interrupted
    assert err.startswith(f"4 points: {interrupted} in the journal in results/b.nc.run; {left} to ")
    assert len(shell.computed) == left
    found = open_result(Path("results/b.nc"))
    assert int(np.isnan(found.asymmetry).sum()) == interrupted
    assert not np.isnan(found.friction_force_amplitude).any()


def test_an_interrupted_sweep_of_an_older_version_is_computed_anew_with_recompute(
    shell: Shell, interrupted: int
) -> None:
    assert interrupted
    assert shell("sweep", "b.yaml", "--recompute").code == 0
    assert len(shell.computed) == 4
    assert hash_of("results/b.nc") == hash_at_once("b.yaml")


def test_a_journal_that_names_no_columns_has_those_of_the_first_version(shell: Shell) -> None:
    config = write("c.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.interrupted("sweep", config, after=2)
    path = RunFolder(Path("results/c.nc")).journal
    make_older_journal(path, config, FIRST_COLUMNS, named=False)
    code, _, err = shell("sweep", config)
    assert (code, "was written by an older version" in err) == (2, True)


# --- what only a newer version knows ---

NEWER = "was written by a newer version of stickslip: this one does not know"


def test_a_file_with_a_variable_of_a_newer_version_is_told_and_still_described_and_drawn(
    shell: Shell,
) -> None:
    with netCDF4.Dataset("a.nc", "a") as file:
        file.createVariable("verdict", "i1", ("temperature",))[...] = 2
        file.source = "stickslip 99.0.0, method adaptive"
    before = everything()
    for command in ("sweep", "plan"):
        code, _, err = shell(command, "a.yaml", "-o", "a.nc")
        assert (code, err) == (
            2,
            f"a.nc {NEWER} verdict. Update stickslip to use its points; --overwrite replaces it, "
            "-o writes elsewhere\n",
        )
    assert everything() == before
    assert (
        "written by a newer version: this one does not know verdict\n" in shell("info", "a.nc").out
    )
    assert shell("plot", "a.nc", "-o", "a.png").code == 0


def test_a_variable_that_a_user_added_is_no_newer_version_and_is_not_carried_over(
    shell: Shell,
) -> None:
    shell("sweep", "a.yaml", "-o", "a.nc", "--recompute")
    with netCDF4.Dataset("a.nc", "a") as file:
        file.createVariable("verdict", "i1", ("temperature",))[...] = 2
    assert "version:" not in shell("info", "a.nc").out
    assert shell("sweep", "a.yaml", "-o", "a.nc").err == (
        "a.nc is complete: 4 points, nothing to do\n"
    )
    code, _, err = shell("sweep", write("b.yaml", FIVE, LOOSE), "-o", "a.nc")
    assert code == 0
    assert err == (
        "warning: a.nc has variables that stickslip did not write and that are not carried over: "
        "verdict\n5 points: 4 in a.nc; 1 to compute\n"
    )
    assert "verdict" not in open_result(Path("a.nc"))


@pytest.mark.parametrize(
    ("old", "new", "unknown"),
    [
        ("integrator:\n", "integrator:\n  smallest_step: 0.01\n", "integrator.smallest_step"),
        ("model:\n", "model:\n  sextic_weight: 1.0\n", "model.sextic_weight"),
        ("model:\n", "climate:\n  humidity: 0.5\nmodel:\n", "climate"),
    ],
)
def test_a_file_with_a_config_key_of_a_newer_version_is_told(
    shell: Shell, old: str, new: str, unknown: str
) -> None:
    with netCDF4.Dataset("a.nc", "a") as file:
        assert old in file.config
        file.config = file.config.replace(old, new)
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert code == 2
    assert err.startswith(f"a.nc {NEWER} {unknown}. Update stickslip")
    assert shell("plot", "a.nc", "-o", "a.png").code == 0
    assert shell("info", "a.nc").code == 0


def test_a_journal_with_a_column_of_a_newer_version_is_told(shell: Shell) -> None:
    config = write("b.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.interrupted("sweep", config, after=2)
    path = RunFolder(Path("results/b.nc")).journal
    manifest = readable_manifest(path)
    assert manifest is not None
    log = RecordLog.create(path)
    note(log, manifest | {"columns": [*RESULT_COLUMNS, "verdict"]})
    before = everything()
    code, _, err = shell("sweep", config)
    assert code == 2
    assert err.startswith(f"results/b.nc.run/journal {NEWER} verdict. Update stickslip")
    assert everything() == before
