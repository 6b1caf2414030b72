"""Results and journals from before a parameter are complete, grown and told."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import netCDF4
import pytest
from support.sweeps.older import (
    FIVE,
    FOUR,
    everything,
    make_older,
)
from support.sweeps.sweeping import LOOSE, ONE_BY_ONE, Shell, hash_at_once, hash_of, write

from stickslip.variables import PARAMETERS
from sweeps.config.load import Config
from sweeps.engine.existing import Target, found_in_file, found_in_journal
from sweeps.files.attributes import data_sha256
from sweeps.files.chunks import Chunks
from sweeps.files.datasets import open_result, write_dataset
from sweeps.files.journal import Journal, readable_manifest
from sweeps.files.run_folder import RunFolder
from sweeps.grid import Grid
from sweeps.identity import Settings, key_of, seal_key


@pytest.fixture
def shell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Shell:
    """A folder with a complete result of an older version, `a.nc`, of `a.yaml`."""
    shell = Shell(tmp_path, monkeypatch, capsys)
    assert shell("sweep", write("a.yaml", FOUR, LOOSE), "-o", "a.nc").code == 0
    make_older(Path("a.nc"))
    return shell


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


def test_a_point_of_a_file_from_before_a_parameter_is_computed_again(
    added_parameter: Shell,
) -> None:
    code, out, err = added_parameter("replay", "a.nc", "--at", "T=225")
    assert (code, err) == (0, "")
    assert "variables agree with the file bit for bit" in out


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
