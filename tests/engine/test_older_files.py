"""Results and journals of other versions are recognised, told, and used as far as they reach."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from support.sweeping import LOOSE, ONE_BY_ONE, Shell, hash_at_once, hash_of, write

from stickslip.variables import PARAMETERS, RESULT_COLUMNS
from sweeps.config.load import Config
from sweeps.engine.existing import Target, found_in_file, found_in_journal
from sweeps.engine.in_memory import read_config
from sweeps.files.attributes import data_sha256
from sweeps.files.chunks import Chunks
from sweeps.files.columns import FIRST_COLUMNS
from sweeps.files.datasets import open_result, write_dataset
from sweeps.files.journal import Journal, readable_manifest
from sweeps.files.record_log import RecordLog
from sweeps.files.run_folder import RunFolder
from sweeps.grid import Grid
from sweeps.identity import Settings, key_of, seal_key

FOUR = "sweep: {temperature: [200, 225, 250, 275]}\n"
FIVE = "sweep: {temperature: [200, 225, 250, 275, 300]}\n"
ADDED = ("melting_count", "asymmetry")  # variables that the older version did not know
KNOWN = [name for name in RESULT_COLUMNS if name not in ADDED]
OLDER = "written by an older version and lacks the variables melting_count, asymmetry"
WAYS = (
    "--recompute does so, --accept-mixed keeps them (the new variables stay missing in them), "
    "-o writes elsewhere\n"
)


def make_older(path: Path) -> None:
    """Make of a result what a version without the added variables would have written."""
    ds = open_result(path).drop_vars(ADDED)
    target = Target.of(found_in_file(path).config)
    digests = [hashlib.sha256(ds[name].values.tobytes()).hexdigest() for name in KNOWN]
    ds.attrs["data_sha256"] = data_sha256(seal_key(target.settings, target.grid), digests)
    write_dataset(ds, path)


def make_older_journal(
    path: Path, config: str, known: Sequence[str] = KNOWN, named: bool = True
) -> int:
    """The same of a journal, `named` where it names its columns; the number of its points."""
    target, manifest = Target.of(read_config(config)), readable_manifest(path)
    assert manifest is not None
    size, there = target.grid.size, [RESULT_COLUMNS.index(name) for name in known]
    new = Journal.open(path, manifest, target.chunks, size, readonly=True)
    rows = [(indices, results[:, there]) for indices, results in new.records()]
    new.close()
    log = RecordLog.create(path)
    old = Journal(log, manifest | {"columns": known}, target.chunks, size)
    if named:
        old.note(old.manifest)
    else:
        del manifest["columns"]
        append_manifest(log, manifest)
    for indices, results in rows:
        old.append(indices, results)
    old.close()
    return int(old.done.sum())


def note(log: RecordLog, manifest: dict[str, object]) -> None:
    """Append a manifest that is not of this version, and close."""
    append_manifest(log, manifest)
    log.close()


def append_manifest(log: RecordLog, manifest: dict[str, object]) -> None:
    text = np.frombuffer(json.dumps(manifest).encode(), dtype=np.uint8)
    log.append(b"M", bytes.fromhex(str(manifest["key"])), text)


def everything() -> dict[str, bytes]:
    names = ("heartbeat.json", "lock")
    return {
        str(p): p.read_bytes() for p in Path().rglob("*") if p.is_file() and p.name not in names
    }


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


# --- parameters that were added later ---

ADDED_PARAMETER, NEUTRAL = "block_mass", 0.3  # stands for one; its default is another value
OF_THEN = f"model: {{{ADDED_PARAMETER}: {NEUTRAL}}}\n"


@pytest.fixture
def added_parameter(shell: Shell) -> Iterator[Shell]:
    """`a.nc` and the interrupted `b.nc` know nothing of a parameter that has a neutral value."""
    variable = PARAMETERS[ADDED_PARAMETER]
    object.__setattr__(variable, "neutral", NEUTRAL)
    try:
        write("a.yaml", FOUR, LOOSE, OF_THEN)
        assert shell("sweep", "a.yaml", "-o", "a.nc", "--overwrite").code == 0
        forget_parameter(Path("a.nc"))
        assert ADDED_PARAMETER not in open_result(Path("a.nc")).coords
        write("b.yaml", FOUR, LOOSE, ONE_BY_ONE, OF_THEN)
        assert shell.interrupted("sweep", "b.yaml", "-o", "b.nc", after=2).code == 4
        forget_parameter_of_journal(RunFolder(Path("b.nc")).journal)
        yield shell
    finally:
        object.__setattr__(variable, "neutral", None)


def without_parameter(config: Config) -> tuple[Settings, Grid]:
    """What a version without the parameter would have made keys of."""
    target = Target.of(config)
    known = {name: v for name, v in target.grid.fixed.items() if name != ADDED_PARAMETER}
    return target.settings, replace(target.grid, fixed=known)


def forget_parameter(path: Path) -> None:
    key = seal_key(*without_parameter(found_in_file(path).config))
    ds = open_result(path).drop_vars(ADDED_PARAMETER)
    lines = ds.attrs["config"].splitlines(keepends=True)
    ds.attrs["config"] = "".join(line for line in lines if ADDED_PARAMETER not in line)
    digests = [hashlib.sha256(ds[name].values.tobytes()).hexdigest() for name in ds.data_vars]
    ds.attrs["data_sha256"] = data_sha256(key, digests)
    write_dataset(ds, path)


def forget_parameter_of_journal(path: Path) -> None:
    manifest = readable_manifest(path)
    assert manifest is not None
    found = found_in_journal(path, manifest)
    key, size = key_of(*without_parameter(found.config)), found.grid.size
    points = list(found.points())
    del manifest["config"]["model"][ADDED_PARAMETER]
    manifest |= {"key": key.hex()}
    Journal.create(path, manifest, Chunks(found.grid.shape), size, points).close()


def test_a_file_from_before_a_parameter_is_complete_described_and_drawn(
    added_parameter: Shell,
) -> None:
    before = everything()
    code, _, err = added_parameter("sweep", "a.yaml", "-o", "a.nc")
    assert (code, err) == (0, "a.nc is complete: 4 points, nothing to do\n")
    assert added_parameter("info", "a.nc").code == 0
    assert everything() == before
    assert added_parameter("plot", "a.nc", "-o", "a.png").code == 0


@pytest.mark.parametrize("values", ["[0.3, 0.5]", "[0.5, 0.3]"])
def test_a_file_from_before_a_parameter_grows_along_it(added_parameter: Shell, values: str) -> None:
    shell = added_parameter
    grown = write(
        "c.yaml", f"sweep: {{{ADDED_PARAMETER}: {values}, T: [200, 225, 250, 275, 300]}}\n", LOOSE
    )
    code, _, err = shell("sweep", grown, "-o", "a.nc")
    assert (code, err) == (0, "10 points (2 x 5): 4 in a.nc; 6 to compute\n")
    assert shell.values(ADDED_PARAMETER) == [0.3, *[0.5] * 5]
    assert hash_of("a.nc") == hash_at_once(grown)


def test_another_value_of_the_new_parameter_makes_other_points(added_parameter: Shell) -> None:
    code, _, err = added_parameter(
        "sweep", "a.yaml", "-o", "a.nc", "--set", f"{ADDED_PARAMETER}=0.5"
    )
    assert code == 2
    assert err.startswith("a.nc has 4 finished points that the config no longer names")


def test_an_interrupted_sweep_from_before_a_parameter_is_resumed(added_parameter: Shell) -> None:
    shell, kept = added_parameter, added_parameter.values("temperature")
    code, _, err = shell("sweep", "b.yaml", "-o", "b.nc")
    assert code == 0
    assert err.startswith(f"4 points: {len(kept)} in its journal; {4 - len(kept)} to compute\n")
    assert len(shell.computed) == 4 - len(kept)
    assert not set(kept) & set(shell.values("temperature"))
    assert hash_of("b.nc") == hash_at_once("b.yaml")


def test_an_interrupted_sweep_from_before_a_parameter_grows(added_parameter: Shell) -> None:
    shell, kept = added_parameter, added_parameter.values("temperature")
    grown = write("c.yaml", FIVE, LOOSE, OF_THEN)
    assert shell("sweep", grown, "-o", "b.nc").code == 0
    assert not set(kept) & set(shell.values("temperature"))
    assert hash_of("b.nc") == hash_at_once(grown)


def test_a_number_changed_in_a_file_from_before_a_parameter_is_noticed(
    added_parameter: Shell,
) -> None:
    with netCDF4.Dataset("a.nc", "a") as file:
        file["friction_force_amplitude"][0] += 1
    code, _, err = added_parameter("sweep", write("c.yaml", FIVE, LOOSE, OF_THEN), "-o", "a.nc")
    assert (code, "is damaged, or was changed" in err) == (5, True)


def test_a_file_without_a_parameter_that_has_no_neutral_value_is_refused(shell: Shell) -> None:
    forget_parameter(Path("a.nc"))
    before = everything()
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc", "--accept-mixed")
    assert (code, err) == (
        2,
        f"a.nc was written by an older version and lacks the parameters "
        f"{ADDED_PARAMETER}, whose values "
        "for its points are not known; --overwrite replaces it, -o writes elsewhere\n",
    )
    assert everything() == before


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
