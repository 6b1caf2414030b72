"""The jobs of an array: parts computed separately, and merged into one result."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
from support import messages
from support.marks import marked

from stickslip import Status
from stickslip.dispatch import task as worker
from stickslip.dispatch.task import Block
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS
from sweeps import run
from sweeps.config.load import Config, from_mapping
from sweeps.engine import merge as merging
from sweeps.engine.existing import Part, RefusalError
from sweeps.engine.merge import merge
from sweeps.engine.plan import plan
from sweeps.engine.resume import ExistingPolicy, state_of
from sweeps.engine.sweep import JournaledResult, Outcome, Recorder, sweep
from sweeps.exits import StorageError
from sweeps.files.journal import DamagedRecordError, Journal
from sweeps.files.netcdf import content_hash, open_result
from sweeps.files.run_folder import InUseError, RunFolder
from sweeps.files.sweep_file import Written
from sweeps.grid import Grid

LOOSE = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
MAP = LOOSE | {
    "sweep": {"T": {"linspace": [200, 300], "num": 9}, "gamma": [-2 / 3, 0]},
}
BLOCKS_OF_TWO = MAP | {"execution": {"workers": 1, "block_points": 2}}
CASES = LOOSE | {
    "cases": {"T": [200.0, 210.0, 220.0], "k": [5e4, 6e4, 7e4]},
    "sweep": {"K": [900, 3000]},
}
LINES = LOOSE | {"sweep": {"omega": [37.0, 38.0, 39.0], "T": [200, 210, 220]}, "follow": "omega"}
SAMPLE = LOOSE | {"sample": {"sobol": 8, "seed": 1, "temperature": [150, 320]}}
SOME_FAIL = MAP | {
    "integrator": {"method": "euler-cromer", "dt": 1.6e-7},
    "stationary": {"max_periods": 1},
    "sweep": {"h": [1e-9, 1e-5], "T": [290, 310]},
    "model": {"omega": 2e3, "phi_0": 0.1},
}


def computed(config: Config, path: Path, part: Part | None = None, **options: Any) -> Outcome:
    return sweep(config, path, say=lambda _: None, progress=False, part=part, **options)


def parts_of(config: Config, folder: Path, count: int) -> list[Path]:
    paths = [folder / f"part{number}.nc" for number in range(1, count + 1)]
    for number, path in enumerate(paths, start=1):
        computed(config, path, Part(number, count))
    return paths


@pytest.fixture(scope="module")
def whole() -> str:
    """The content hash of the whole map."""
    return content_hash(run(MAP))


@pytest.fixture(scope="module")
def halves(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return parts_of(from_mapping(MAP), tmp_path_factory.mktemp("halves"), 2)


@pytest.fixture
def parts(halves: list[Path], tmp_path: Path) -> list[Path]:
    """The two parts of the map, in the folder of the test."""
    return [Path(shutil.copy(path, tmp_path)) for path in halves]


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_part_computes_its_points_and_leaves_the_others(number: int, tmp_path: Path) -> None:
    config = from_mapping(MAP)
    outcome = computed(config, tmp_path / "a.nc", Part(number, 3))
    ds = open_result(tmp_path / "a.nc")
    there = ds.status.values.ravel() != Status.PENDING
    np.testing.assert_array_equal(there, np.arange(18) % 3 == number - 1)
    assert ds.attrs["part"] == f"{number}/3"
    assert (outcome.computed, outcome.failures, outcome.stopped) == (6, 0, None)


def test_all_points_belong_to_one_part_and_lines_stay_together() -> None:
    for mapping in (MAP, CASES, LINES):
        grid = Grid.from_config(from_mapping(mapping))
        chosen = np.stack([Part(number, 4).points(grid) for number in range(1, 5)])
        assert (chosen.sum(axis=0) == 1).all()
        if grid.followed:
            lines = chosen[:, grid.lines()]
            assert (lines.all(axis=2) == lines.any(axis=2)).all()


@pytest.mark.parametrize("mapping", [SOME_FAIL, *marked("faults", [SAMPLE, MAP, CASES, LINES])])
def test_parts_that_are_merged_are_the_whole(mapping: dict[str, Any], tmp_path: Path) -> None:
    config = from_mapping(mapping)
    computed(config, tmp_path / "whole.nc")
    merged = tmp_path / "merged.nc"
    written = merge(parts_of(config, tmp_path, 16), merged)
    whole = open_result(tmp_path / "whole.nc")
    assert content_hash(open_result(merged)) == content_hash(whole)
    assert written.statuses.sum() == whole.status.size
    assert not (tmp_path / "merged.nc.run").exists()


class CrashError(Exception):
    """The process ends suddenly."""


def crash(patch: pytest.MonkeyPatch, after: int, *args: Any, **options: Any) -> None:
    """Compute a sweep that ends suddenly after a number of blocks."""
    take_in, blocks = Recorder.take_in, []

    def end(self: Recorder, block: Block) -> None:
        take_in(self, block)
        blocks.append(block)
        if len(blocks) == after:
            raise CrashError

    patch.setattr(Recorder, "take_in", end)
    with pytest.raises(CrashError):
        computed(*args, **options)


def test_a_part_that_crashed_is_resumed(
    whole: str, parts: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = from_mapping(MAP | {"execution": {"workers": 1, "block_points": 1}})
    first, second = tmp_path / "first.nc", parts[1]
    with monkeypatch.context() as patch:
        crash(patch, 2, config, first, Part(1, 2))
    assert computed(config, first, Part(1, 2)).computed == 7
    merge([first, second], tmp_path / "m.nc")
    assert content_hash(open_result(tmp_path / "m.nc")) == whole


def test_a_complete_part_has_nothing_to_do_and_a_whole_sweep_completes_it(
    whole: str, parts: list[Path]
) -> None:
    config, path = from_mapping(MAP), parts[1]
    assert computed(config, path, Part(2, 2)).computed == 0
    assert computed(config, path).computed == 9
    assert content_hash(open_result(path)) == whole


def test_missing_parts_are_named(tmp_path: Path) -> None:
    first, _, third = parts_of(from_mapping(MAP), tmp_path, 3)
    with pytest.raises(RefusalError, match=r"6 of 18 points .* \(missing parts: 2/3\); --partial"):
        merge([first, third], tmp_path / "m.nc")
    assert not (tmp_path / "m.nc").exists()
    written = merge([first, third], tmp_path / "m.nc", partial=True)
    assert written.statuses[Status.PENDING] == 6


def test_a_merge_that_was_killed_at_its_end_leaves_nothing(
    parts: list[Path], tmp_path: Path
) -> None:
    merged = tmp_path / "m.nc"
    merge(parts, merged)
    folder = RunFolder(merged)
    folder.path.mkdir()
    folder.merged.write_bytes(b"left")
    assert merge(parts, merged).complete
    assert not folder.path.exists()


def test_a_file_with_an_invalid_part_is_merged_without_it(
    whole: str, parts: list[Path], tmp_path: Path
) -> None:
    with netCDF4.Dataset(parts[0], "a") as file:
        file.part = "x/y"
    with pytest.raises(RefusalError, match=r"9 of 18 points are in none of the files; --partial"):
        merge(parts[:1], tmp_path / "m.nc")
    merge(parts, tmp_path / "m.nc")
    assert content_hash(open_result(tmp_path / "m.nc")) == whole


def test_the_file_of_a_fit_is_no_part(parts: list[Path], tmp_path: Path) -> None:
    with netCDF4.Dataset(parts[0], "a") as file:
        file.createVariable("fitted_value", "f8")
    with pytest.raises(RefusalError, match=r"nc holds a fit, not a sweep$"):
        merge(parts, tmp_path / "m.nc")


def test_overlaps_must_be_equal(
    whole: str, parts: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = tmp_path / "both.nc"
    computed(from_mapping(MAP), both)
    merge([*parts, both], tmp_path / "equal.nc")
    assert content_hash(open_result(tmp_path / "equal.nc")) == whole

    def shifted(*arguments: Any, **how: Any) -> tuple[np.ndarray, np.ndarray]:
        results, finals = compute_orbits(*arguments, **how)
        results[-1, RESULT_COLUMNS.index("asymmetry")] += 1e-3
        return results, finals

    monkeypatch.setattr(worker, "compute_orbits", shifted)
    computed(from_mapping(MAP), both, Part(1, 2), policy=ExistingPolicy(overwrite=True))
    with pytest.raises(RefusalError, match="different numbers for points"):
        merge([*parts, both], tmp_path / "m.nc")
    assert not (tmp_path / "m.nc").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"integrator": {"rtol": 1e-5}}, "integrator.rtol: 0.0001 -> 1e-05|1e-05 -> 0.0001"),
        ({"model": {"K": 2000}}, "a different config"),
        ({"title": "Another"}, "a different config"),
    ],
)
def test_results_of_other_configs_are_refused(
    change: dict[str, Any], message: str, parts: list[Path], tmp_path: Path
) -> None:
    computed(from_mapping(MAP | change), tmp_path / "other.nc", Part(2, 2))
    with pytest.raises(RefusalError, match=message):
        merge([parts[0], tmp_path / "other.nc"], tmp_path / "m.nc")


def test_damaged_parts_are_refused(parts: list[Path], tmp_path: Path) -> None:
    with netCDF4.Dataset(parts[1], "a") as file:
        file["melting_count"][0, 1] = 55
    with pytest.raises(StorageError, match=rf"part2\.nc {messages.NOT_OURS}"):
        merge(parts, tmp_path / "m.nc")


def test_outputs_that_would_be_lost_are_refused(parts: list[Path], tmp_path: Path) -> None:
    with pytest.raises(RefusalError, match="is also an input"):
        merge(parts, parts[1])
    computed(from_mapping(MAP | {"title": "Mine"}), tmp_path / "m.nc")
    with pytest.raises(RefusalError, match=messages.EXISTS):
        merge(parts, tmp_path / "m.nc")
    assert open_result(tmp_path / "m.nc").title == "Mine"
    merge(parts, tmp_path / "m.nc", overwrite=True)


@pytest.mark.parametrize("text", ["", "3", "0/2", "3/2", "1/0", "-1/2", "a/b", "1/2/3"])
def test_other_texts_are_no_parts(text: str) -> None:
    with pytest.raises(ValueError, match="is not a part; write, for example, 1/16"):
        Part.parse(text)


def statuses_of(path: Path) -> Any:
    return open_result(path).status.values.ravel()


def test_a_part_does_not_end_what_was_begun_from_scratch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, path = from_mapping(BLOCKS_OF_TWO), tmp_path / "a.nc"
    computed(config, path)
    before = path.read_bytes()
    with monkeypatch.context() as patch:
        crash(patch, 2, config, path, policy=ExistingPolicy(overwrite=True))
    with pytest.raises(
        RefusalError, match=r"started from scratch \(all parts\) would replace it; finish"
    ):
        computed(config, path, Part(1, 2))
    assert path.read_bytes() == before
    assert 0 < computed(config, path).computed < 18
    assert (statuses_of(path) != Status.PENDING).all()


def test_retrying_a_part_keeps_the_failures_of_the_others(tmp_path: Path) -> None:
    config, path = from_mapping(SOME_FAIL), tmp_path / "a.nc"
    failures = computed(config, path).failures
    for number in (1, 2):
        share = Part(number, 2).points(Grid.from_config(config))
        mine = int(np.isin(statuses_of(path)[share], [Status.OK], invert=True).sum())
        ended = computed(config, path, Part(number, 2), policy=ExistingPolicy(retry_failed=True))
        assert (ended.computed, ended.failures) == (mine, failures)
    assert (statuses_of(path) != Status.PENDING).all()


def test_an_export_drops_no_failures(tmp_path: Path) -> None:
    config, path = from_mapping(SOME_FAIL), tmp_path / "a.nc"
    failures = computed(config, path).failures
    exported = computed(config, path, policy=ExistingPolicy(retry_failed=True), partial=True)
    assert exported.failures == failures > 0
    assert (statuses_of(path) != Status.PENDING).all()


def test_damaged_points_of_other_parts_are_computed_again(
    whole: str, parts: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = parts[0]
    write, torn = JournaledResult.write, []

    def tear(self: JournaledResult) -> Any:
        if not torn:
            torn.append(True)
            raise DamagedRecordError
        return write(self)

    def recover(self: Journal) -> int:
        lost = np.flatnonzero(self.done)[:3]
        self.done[lost] = False
        self.statuses[Status.OK] -= len(lost)
        return len(lost)

    monkeypatch.setattr(JournaledResult, "write", tear)
    monkeypatch.setattr(Journal, "recover", recover)
    assert computed(from_mapping(MAP), path, Part(2, 2)).computed == 9 + 3
    assert content_hash(open_result(path)) == whole


def test_a_killed_merge_is_repeated(
    whole: str, parts: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = tmp_path / "m.nc"

    def killed(_: JournaledResult, path: Path) -> Written:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(JournaledResult, "write", killed)
        patch.setattr(RunFolder, "remove", lambda *_, **__: None)
        with pytest.raises(KeyboardInterrupt):
            merge(parts, output)
    assert RunFolder(output).path.exists()
    assert state_of(output)["state"] == "absent"
    merge(parts, output)
    assert content_hash(open_result(output)) == whole
    assert not RunFolder(output).path.exists()


def test_a_sweep_cannot_begin_while_its_output_is_merged(
    parts: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output, common = tmp_path / "m.nc", merging.common_target

    def disturbed(*args: Any) -> Any:
        with pytest.raises(InUseError, match=messages.IN_USE):
            computed(from_mapping(MAP), output)
        return common(*args)

    monkeypatch.setattr(merging, "common_target", disturbed)
    merge(parts, output)
    assert computed(from_mapping(MAP), output).computed == 0


def test_a_merge_leaves_an_interrupted_sweep_alone(
    parts: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = tmp_path / "m.nc"
    with monkeypatch.context() as patch:
        crash(patch, 1, from_mapping(BLOCKS_OF_TWO), output)
    with pytest.raises(RefusalError, match=messages.RESUMABLE):
        merge(parts, output)
    assert RunFolder(output).journal.exists()
    assert computed(from_mapping(MAP), output).computed < 18


def test_results_of_refined_grids_are_not_merged(tmp_path: Path) -> None:
    axes = {"T": {"linspace": [200, 300], "num": 9}, "K": {"linspace": [900, 3000], "num": 9}}
    config = from_mapping(LOOSE | {"sweep": axes, "refine": {"axes": ["T", "K"], "levels": 2}})
    computed(config, tmp_path / "a.nc")
    with pytest.raises(RefusalError, match="refined grid, whose points depend on each other"):
        merge([tmp_path / "a.nc"], tmp_path / "m.nc", partial=True)


def test_the_state_of_a_part_counts_its_own_points(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, path = from_mapping(BLOCKS_OF_TWO), tmp_path / "a.nc"
    with monkeypatch.context() as patch:
        crash(patch, 2, config, path, Part(1, 2))
    state = state_of(path)
    assert (state["state"], state["part"], state["points"]) == ("interrupted", "1/2", 9)
    assert 0 < state["done"] < 9
    computed(config, path, Part(1, 2))
    state = state_of(path)
    assert (state["state"], state["part"], state["points"]) == ("complete", "1/2", 9)
    assert state["done"] == 9


def test_the_state_is_that_of_the_last_part_or_of_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, path = from_mapping(BLOCKS_OF_TWO), tmp_path / "a.nc"
    pending = {Part(1, 2): 7, Part(2, 4): 3, None: 12}  # each run adds a block of two points
    for part, left in pending.items():
        with monkeypatch.context() as patch:
            crash(patch, 1, config, path, part)
        state = state_of(path)
        assert (state["state"], state["pending"]) == ("interrupted", left)
        assert state.get("part") == (str(part) if part else None)
    assert state["points"] == 18


def test_the_plan_of_a_part_counts_its_points(tmp_path: Path) -> None:
    planned = plan(from_mapping(MAP), tmp_path / "a.nc", part=Part(1, 2))
    assert (planned.points, planned.there) == (9, 0)
    computed(from_mapping(MAP), tmp_path / "a.nc", Part(1, 2))
    assert plan(from_mapping(MAP), tmp_path / "a.nc", part=Part(1, 2)).there == 9
    assert plan(from_mapping(MAP), tmp_path / "a.nc").there == 9
