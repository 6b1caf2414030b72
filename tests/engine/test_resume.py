"""Run, resume and grow are one command: exactly the missing points are computed, none is lost."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.sweeps.sweeping import LOOSE, ONE_BY_ONE, Shell, entries, hash_at_once, hash_of, write

from sweeps.engine.executors import worker
from sweeps.files.datasets import open_result

FOUR = "sweep: {temperature: [200, 225, 250, 275]}\n"


@pytest.fixture
def shell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Shell:
    return Shell(tmp_path, monkeypatch, capsys)


@pytest.fixture
def grown(shell: Shell) -> Callable[..., str]:
    """Sweeps the first config, then the second to the same file; returns what that said."""

    def grow(small: str, large: str) -> str:
        assert shell("sweep", write("small.yaml", small, LOOSE), "-o", "a.nc").code == 0
        code, _, err = shell("sweep", write("large.yaml", large, LOOSE), "-o", "a.nc")
        assert code == 0
        computed = list(shell.computed)
        assert hash_of("a.nc") == hash_at_once("large.yaml")
        assert entries() == ["a.nc", "a.nc.timing.json", "large.yaml", "small.yaml"]
        shell.computed[:] = computed
        return err

    return grow


# --- a finished result grows ---


def test_more_values_on_an_axis_compute_exactly_these(
    shell: Shell, grown: Callable[..., str]
) -> None:
    said = grown(
        "sweep: {temperature: {arange: [200, 219, 1]}}\n",
        "sweep: {temperature: {arange: [200, 229, 1]}}\n",
    )
    assert said == "30 points: 20 in a.nc; 10 to compute\n"
    assert shell.values("temperature") == [float(value) for value in range(220, 230)]


@pytest.mark.parametrize(
    ("name", "coarse", "fine", "missing"),
    [
        ("temperature", "linspace: [150, 320], num: 6", "linspace: [150, 320], num: 11", 5),
        ("temperature", "arange: [200, 200.9, 0.3]", "arange: [200, 200.9, 0.1]", 6),
        (
            "initial_order_parameter",
            "linspace: [.1, .7], num: 7",
            "linspace: [.1, .7], num: 25",
            18,
        ),
        (
            "viscosity_coefficient",
            "geomspace: [1e4, 1e6], num: 5",
            "geomspace: [1e4, 1e6], num: 9",
            4,
        ),
    ],
)
def test_a_finer_grid_computes_exactly_what_lies_between(
    shell: Shell, grown: Callable[..., str], name: str, coarse: str, fine: str, missing: int
) -> None:
    grown(f"sweep: {{{name}: {{{coarse}}}}}\n", f"sweep: {{{name}: {{{fine}}}}}\n")
    fresh = shell.values(name)
    assert len(fresh) == missing
    shell("sweep", "small.yaml", "-o", "coarse.nc")
    assert not set(fresh) & set(shell.values(name))


def test_a_finer_grid_of_two_axes_keeps_the_old_corners(
    shell: Shell, grown: Callable[..., str]
) -> None:
    said = grown(
        "sweep: {T: {linspace: [200, 280], num: 3}, gamma: [-2/3, 0]}\n",
        "sweep: {T: {linspace: [200, 280], num: 5}, gamma: [-2/3, 0, 2/3]}\n",
    )
    assert said == "15 points (5 x 3): 6 in a.nc; 9 to compute\n"
    fresh = {(point.temperature, point.rheological_index) for point in shell.computed}
    assert len(fresh) == len(shell.computed) == 9
    assert fresh.isdisjoint({(t, g) for t in (200.0, 240.0, 280.0) for g in (-2 / 3, 0.0)})


@pytest.mark.parametrize("place", ["temperature: [200, 250], gamma", "gamma"])
def test_a_new_axis_with_the_fixed_value_computes_the_other_values(
    shell: Shell, grown: Callable[..., str], place: str
) -> None:
    after = "" if place.startswith("temp") else ", temperature: [200, 250]"
    grown("sweep: {temperature: [200, 250]}\n", f"sweep: {{{place}: [1/3, -2/3, 2/3]{after}}}\n")
    assert shell.values("rheological_index") == [1 / 3, 1 / 3, 2 / 3, 2 / 3]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("sweep: {T: [200, 250], gamma: [0, 1/3]}\n", "sweep: {gamma: [0, 1/3], T: [200, 250]}\n"),
        ("sweep: {T: [200, 225, 250]}\n", "sweep: {T: [250, 200, 225]}\n"),
        ("sweep: {T: [200, 250]}\n", "cases: {T: [200, 250]}\n"),
        ("cases: {T: [200, 250], K: [3000, 3000]}\n", "sweep: {T: [200, 250]}\n"),
        ("sweep: {T: [200]}\n", "model: {T: 200}\n"),
        ("model: {T: 250}\n", "sweep: {T: [250], gamma: [-2/3]}\n"),
    ],
)
def test_another_arrangement_of_the_same_points_computes_nothing(
    shell: Shell, grown: Callable[..., str], before: str, after: str
) -> None:
    assert grown(before, after).endswith(" in a.nc; 0 to compute\n")
    assert shell.computed == []


def test_the_product_of_linked_values_computes_what_the_cases_left_out(
    shell: Shell, grown: Callable[..., str]
) -> None:
    grown("cases: {T: [200, 250], gamma: [0, 1/3]}\n", "sweep: {T: [200, 250], gamma: [0, 1/3]}\n")
    fresh = [(point.temperature, point.rheological_index) for point in shell.computed]
    assert sorted(fresh) == [(200.0, 1 / 3), (250.0, 0.0)]


def test_cases_keep_the_points_of_a_sweep_that_they_name(
    shell: Shell, grown: Callable[..., str]
) -> None:
    grown("sweep: {T: [200, 250]}\n", "cases: {T: [250, 200, 200], K: [3000, 3000, 4000]}\n")
    (point,) = shell.computed
    assert (point.temperature, point.spring_stiffness) == (200.0, 4000.0)


def test_a_config_that_is_only_written_otherwise_is_recognised(shell: Shell) -> None:
    shell("sweep", write("a.yaml", "model: {K: 3000, X_m: 0.8e-6}\n", FOUR, LOOSE), "-o", "a.nc")
    old = Path("a.nc").read_bytes(), Path("a.nc").stat().st_mtime_ns
    again = write(
        "b.yaml",
        "# the same, said otherwise\nstationary: {rtol: 1.0e-4}\nintegrator: {rtol: .0001}\n"
        "sweep:\n  T: {linspace: [200, 275], num: 4}  # four\n"
        "model: {drive_amplitude: 8e-7, spring_stiffness: 3e3}\nexecution: {workers: 1}\n",
    )
    code, _, err = shell("sweep", again, "-o", "a.nc")
    assert (code, err) == (0, "a.nc is complete: 4 points, nothing to do\n")
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


def test_history_keeps_the_lines_of_all_that_computed(shell: Shell) -> None:
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


# --- an interrupted sweep goes on, and grows ---


def test_an_interrupted_sweep_computes_what_is_missing_and_gives_the_same_bits(
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
    assert "warning: a new processor processor joins points computed on old processor" in err
    assert open_result(Path("a.nc")).attrs["processor"] == "new processor, old processor"


def test_values_that_nearly_are_those_of_the_file_are_told(shell: Shell) -> None:
    shell("sweep", write("a.yaml", "sweep: {K: [3000, 4000]}\n", LOOSE), "-o", "a.nc")
    near = np.nextafter(3000.0, 4000.0).item()
    large = write("b.yaml", f"sweep: {{K: [3000, {near!r}, 3000.01, 4000]}}\n", LOOSE)
    code, _, err = shell("sweep", large, "-o", "a.nc")
    assert code == 0
    *_, warning, rest = err.splitlines()
    assert warning == (
        "warning: values that differ by less than 1e-9 from those of a.nc are other points: "
        f"spring_stiffness 3000.0 and {near!r}"
    )
    assert rest == "4 points: 2 in a.nc; 2 to compute"
    assert shell.values("spring_stiffness") == [near, 3000.01]


@pytest.mark.parametrize("place", [0, 1])
def test_a_value_near_the_first_or_the_last_of_the_file_is_told_once(
    shell: Shell, place: int
) -> None:
    shell("sweep", write("a.yaml", "sweep: {K: [3000, 4000]}\n", LOOSE), "-o", "a.nc")
    near = np.nextafter([3000.0, 4000.0][place], [0.0, 5000.0][place]).item()
    large = write("b.yaml", f"sweep: {{K: [3000, 4000, {near!r}]}}\n", LOOSE)
    err = shell("sweep", large, "-o", "a.nc").err
    told = [line for line in err.splitlines() if "from those of a.nc" in line]
    assert len(told) == 1
    assert told[0].count(repr(near)) == 1
