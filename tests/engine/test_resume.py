"""Run, resume and grow are one command: it computes exactly the missing points and loses none."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from support import messages
from support.marks import marked
from support.sweeps.sweeping import LOOSE, ONE_BY_ONE, Shell, entries, hash_at_once, hash_of, write

from stickslip import Parameters
from stickslip.dispatch import task as worker
from sweeps.config.load import load
from sweeps.files.netcdf import open_result
from sweeps.grid import Grid
from sweeps.human import counted

FOUR = "sweep: {temperature: [200, 225, 250, 275]}\n"
PRODUCT = "sweep: {T: [200, 250], gamma: [0, 2/3]}\n"


def points_of(config: str) -> set[Parameters]:
    grid = Grid.from_config(load(config))
    return {Parameters(*row) for row in grid.points(0, grid.size).tolist()}


# --- a finished result grows ---


def two_forms(name: str, form: str, coarse: str, fine: str) -> tuple[str, str]:
    return tuple(f"sweep: {{{name}: {{{form}: {axis}}}}}\n" for axis in (coarse, fine))


@pytest.mark.parametrize(
    ("before", "after", "missing"),
    [
        # more values on an axis
        (*two_forms("T", "arange", "[200, 219, 1]", "[200, 229, 1]"), 10),
        # a finer grid
        (*two_forms("T", "linspace", "[150, 320], num: 6", "[150, 320], num: 11"), 5),
        (
            "sweep: {T: {linspace: [200, 280], num: 3}, gamma: [-2/3, 0]}\n",
            "sweep: {T: {linspace: [200, 280], num: 5}, gamma: [-2/3, 0, 2/3]}\n",
            9,
        ),
        # a new axis, which holds the value that was fixed
        ("sweep: {T: [200, 250]}\n", "sweep: {T: [200, 250], gamma: [0, -2/3, 2/3]}\n", 4),
        # the same points in another arrangement
        (PRODUCT, "sweep: {gamma: [0, 2/3], T: [200, 250]}\n", 0),
        ("cases: {T: [200, 250], K: [3000, 3000]}\n", "sweep: {T: [200, 250]}\n", 0),
        ("model: {T: 250}\n", "sweep: {T: [250], gamma: [-2/3]}\n", 0),
        # linked values become a product, and some of a sweep linked ones
        (PRODUCT.replace("sweep", "cases"), PRODUCT, 2),
        ("sweep: {T: [200, 250]}\n", "cases: {T: [250, 200, 200], K: [3000, 3000, 4000]}\n", 1),
        *marked(
            "stress",
            [
                (*two_forms("T", "arange", "[200, 200.9, 0.3]", "[200, 200.9, 0.1]"), 6),
                (*two_forms("phi_0", "linspace", "[.1, .7], num: 7", "[.1, .7], num: 25"), 18),
                (*two_forms("k", "geomspace", "[1e4, 1e6], num: 5", "[1e4, 1e6], num: 9"), 4),
                (
                    "sweep: {T: [200, 250]}\n",
                    "sweep: {gamma: [1/3, -2/3, 2/3], T: [200, 250]}\n",
                    4,
                ),
                ("sweep: {T: [200, 225, 250]}\n", "sweep: {T: [250, 200, 225]}\n", 0),
                ("sweep: {T: [200, 250]}\n", "cases: {T: [200, 250]}\n", 0),
                ("sweep: {T: [200]}\n", "model: {T: 200}\n", 0),
            ],
        ),
    ],
)
def test_a_growing_result_computes_exactly_the_missing_points(
    shell: Shell, before: str, after: str, missing: int
) -> None:
    small, large = write("small.yaml", before, LOOSE), write("large.yaml", after, LOOSE)
    there, wanted = points_of(small), points_of(large)
    shell.ok("sweep", small, "-o", "a.nc")
    code, _, err = shell("sweep", large, "-o", "a.nc")
    told = rf"{counted(len(wanted), 'point')}.*: {len(there)} in a\.nc; {missing} to compute\n"
    assert (code, len(shell.computed)) == (0, missing)
    assert re.fullmatch(told, err)
    assert set(shell.computed) == wanted - there
    assert hash_of("a.nc") == hash_at_once(large)
    assert entries() == ["a.nc", "a.nc.timing.json", "large.yaml", "small.yaml"]


def test_the_same_config_in_other_words_is_recognised(shell: Shell) -> None:
    shell("sweep", write("a.yaml", "model: {K: 3000, X_m: 0.8e-6}\n", FOUR, LOOSE), "-o", "a.nc")
    old = Path("a.nc").read_bytes(), Path("a.nc").stat().st_mtime_ns
    again = write(
        "b.yaml",
        "# the same, said otherwise\nstationary: {rtol: 1.0e-4}\nintegrator: {rtol: .0001}\n"
        "sweep:\n  T: {linspace: [200, 275], num: 4}  # four\n"
        "model: {drive_amplitude: 8e-7, spring_stiffness: 3e3}\nexecution: {workers: 1}\n",
    )
    code, _, err = shell("sweep", again, "-o", "a.nc")
    assert (code, err) == (0, f"a.nc {messages.COMPLETE_POINTS}\n")
    assert shell.computed == []
    assert (Path("a.nc").read_bytes(), Path("a.nc").stat().st_mtime_ns) == old


def test_a_new_title_rewrites_the_file_without_computing(shell: Shell) -> None:
    shell("sweep", write("a.yaml", "title: old\n", FOUR, LOOSE), "-o", "a.nc")
    before = open_result(Path("a.nc"))
    code, _, err = shell("sweep", write("b.yaml", "title: new\n", FOUR, LOOSE), "-o", "a.nc")
    assert (code, shell.computed) == (0, [])
    assert err == "4 points: 4 in a.nc; 0 to compute\n"
    after = open_result(Path("a.nc"))
    assert after.attrs["title"] == "new"
    assert after.attrs["history"].splitlines()[1:] == before.attrs["history"].splitlines()
    assert after.equals(before)
    assert hash_of("a.nc") == hash_at_once("b.yaml")


def test_history_keeps_the_lines_of_all_commands(shell: Shell) -> None:
    for count in (1, 2, 3):
        shell(
            "sweep",
            write(f"{count}.yaml", LOOSE, f"sweep: {{T: [{'200, 250, 280'[: 5 * count - 2]}]}}\n"),
            "-o",
            "a.nc",
        )
    lines = open_result(Path("a.nc")).attrs["history"].splitlines()
    ends = [line.split(" ", 1)[1] for line in lines]
    assert ends == [f"stickslip sweep {count}.yaml -o a.nc" for count in (3, 2, 1)]


# --- an interrupted sweep is resumed, and grows ---


def test_an_interrupted_sweep_computes_the_missing_points_with_the_same_bits(
    shell: Shell,
) -> None:
    config = write("a.yaml", FOUR, LOOSE, ONE_BY_ONE)
    code, out, err = shell.interrupted("sweep", config, after=2)
    first = shell.values("temperature")
    assert (code, out) == (4, "")
    assert 2 <= len(first) < 4
    assert f"{len(first)} of 4 points are kept in results/a.nc.run. To resume:\n" in err
    assert err.endswith("\n  stickslip sweep a.yaml\n")
    code, _, err = shell("sweep", config)
    assert (code, err) == (
        0,
        f"4 points: {len(first)} in its journal; {4 - len(first)} to compute\n",
    )
    assert sorted(first + shell.values("temperature")) == [200.0, 225.0, 250.0, 275.0]
    assert hash_of("results/a.nc") == hash_at_once(config)
    assert entries("results") == ["a.nc", "a.nc.timing.json"]


@pytest.mark.parametrize("older", [False, True])
def test_an_interrupted_sweep_grows_with_its_config(shell: Shell, older: bool) -> None:
    kept: list[float] = []
    if older:
        shell("sweep", write("a.yaml", "sweep: {T: [150]}\n", LOOSE), "-o", "a.nc")
        kept += shell.values("temperature")
    medium = "sweep: {T: [150, 200, 225, 250, 275]}\n"
    shell.interrupted("sweep", write("b.yaml", medium, LOOSE, ONE_BY_ONE), "-o", "a.nc", after=2)
    kept += shell.values("temperature")
    large = "sweep: {gamma: [0, -2/3], T: [150, 200, 210, 225, 250, 275]}\n"
    code, _, err = shell("sweep", write("c.yaml", large, LOOSE), "-o", "a.nc")
    assert code == 0
    assert err.startswith(f"12 points (2 x 6): {len(kept)} in the journal in a.nc.run")
    assert len(shell.computed) == 12 - len(kept)
    assert {p.temperature for p in shell.computed if p.rheological_index < 0}.isdisjoint(kept)
    assert hash_of("a.nc") == hash_at_once("c.yaml")
    assert not Path("a.nc.run").exists()


def test_a_grown_journal_remembers_which_processors_computed_it(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "processor", lambda: "old processor")
    small = write("a.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.interrupted("sweep", small, "-o", "a.nc", after=2)
    monkeypatch.setattr(worker, "processor", lambda: "new processor")
    large = write("b.yaml", FOUR.replace("275", "275, 300"), LOOSE)
    code, _, err = shell("sweep", large, "-o", "a.nc")
    assert code == 0
    assert (
        "warning: some points were computed on old processor, others are computed on new processor:"
        in err
    )
    assert open_result(Path("a.nc")).attrs["processor"] == "new processor, old processor"


def test_values_almost_equal_to_those_in_the_file_are_reported(shell: Shell) -> None:
    shell("sweep", write("a.yaml", "sweep: {K: [3000, 4000]}\n", LOOSE), "-o", "a.nc")
    near = np.nextafter(3000.0, 4000.0).item()
    large = write("b.yaml", f"sweep: {{K: [3000, {near!r}, 3000.01, 4000]}}\n", LOOSE)
    code, _, err = shell("sweep", large, "-o", "a.nc")
    assert code == 0
    *_, warning, rest = err.splitlines()
    assert warning == (
        "warning: values within a relative 1e-9 of those of a.nc count as different points: "
        f"spring_stiffness 3000.0 and {near!r}"
    )
    assert rest == "4 points: 2 in a.nc; 2 to compute"
    assert shell.values("spring_stiffness") == [near, 3000.01]
