"""Every verb of the command line does what its help says, and says where it is."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import jsonschema
import numpy as np
import pytest
import xarray as xr

import stickslip
from stickslip import Parameters
from sweeps.cli.app import main
from sweeps.engine.in_memory import run
from sweeps.files.datasets import content_hash, open_result

CONFIGS = Path(__file__).parents[2] / "configs"

SWEEP = """\
title: Four points
sweep:
  temperature: [200, 250]
  rheological_index: [-2/3, 0]
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4}
simulation: {periods: 1, samples_per_period: 50}
"""


class Result(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Result]:
    """The real entry point, in this process and an empty folder that holds `a.yaml`."""
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text(SWEEP)

    def call(*arguments: str) -> Result:
        monkeypatch.setattr(sys, "argv", ["stickslip", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return Result(int(ended.value.code or 0), out, err)

    return call


Command = Callable[..., Result]


def entries(folder: Path | str = ".") -> list[str]:
    return sorted(path.name for path in Path(folder).iterdir())


# --- sweep ---


def test_sweep_writes_beside_the_config_s_name_and_says_so(command: Command) -> None:
    code, out, err = command("sweep", "a.yaml")
    assert code == 0
    path, summary = out.splitlines()
    assert path == "results/a.nc"
    assert summary.startswith("4 points in ")
    assert "points/s), 0 failed, largest amplitude error " in summary
    assert err == "4 points (2 x 2); 4 to compute\n"
    assert entries("results") == ["a.nc", "a.nc.timing.json"]
    ds = open_result(Path(path))
    assert f"{float(ds.amplitude_error.max()):.1e}" in summary
    assert content_hash(ds) == content_hash(run("a.yaml"))
    assert ds.attrs["history"].endswith(" stickslip sweep a.yaml")


def test_sweep_notes_its_timing_beside_the_result(command: Command) -> None:
    command("sweep", "a.yaml", "--workers", "3")
    timing = json.loads(Path("results/a.nc.timing.json").read_text())
    assert timing["points"] == 4
    assert timing["workers"] == 3
    assert timing["points_per_second"] == pytest.approx(4 / timing["seconds"], rel=0.5)
    assert timing["code_sha256"] == open_result(Path("results/a.nc")).attrs["code_sha256"]


def test_sweep_takes_its_output_from_option_or_config(command: Command) -> None:
    Path("b.yaml").write_text(SWEEP + "output: deep/er/b.nc\n")
    assert command("sweep", "b.yaml").out.startswith("deep/er/b.nc\n")
    assert command("sweep", "b.yaml", "-o", "c.nc").out.startswith("c.nc\n")
    assert command("sweep", "b.yaml", "--set", "output=d.nc").out.startswith("d.nc\n")
    hashes = {content_hash(open_result(Path(p))) for p in ("deep/er/b.nc", "c.nc", "d.nc")}
    assert len(hashes) == 1


@pytest.mark.parametrize("workers", ["1", "2", "8"])
def test_the_hash_is_the_same_for_any_number_of_workers_and_block_size(
    command: Command, workers: str
) -> None:
    expected = content_hash(run("a.yaml", workers=1))
    for points in ("1", "3", "null"):
        block = f"execution.block_points={points}"
        command("sweep", "a.yaml", "--workers", workers, "--set", block, "--overwrite")
        code, out, err = command("info", "--hash", "results/a.nc")
        assert (code, out, err) == (0, f"{expected}\n", "")


def test_set_changes_the_config(command: Command) -> None:
    code, out, _ = command("sweep", "a.yaml", "--set", "T=[210]", "--set", "gamma=1/3")
    assert code == 0
    assert "1 points" in out
    ds = open_result(Path("results/a.nc"))
    assert ds.sizes == {"temperature": 1}
    assert (ds.temperature[0], ds.rheological_index) == (210.0, 1 / 3)


def test_no_progress_says_nothing_on_the_way(command: Command) -> None:
    assert command("sweep", "a.yaml", "--no-progress").err == ""


def test_a_complete_output_is_recognised_untouched(command: Command) -> None:
    first = command("sweep", "a.yaml").out.splitlines()
    path = Path("results/a.nc")
    old = path.read_bytes(), path.stat().st_mtime_ns
    code, out, err = command("sweep", "a.yaml")
    assert (code, err) == (0, "results/a.nc is complete: 4 points, nothing to do\n")
    assert out.splitlines() == [first[0], re.sub(r" in .* points/s\)", "", first[1])]
    assert (path.read_bytes(), path.stat().st_mtime_ns) == old
    assert entries("results") == ["a.nc", "a.nc.timing.json"]


def test_an_existing_output_with_other_points_is_refused_untouched(command: Command) -> None:
    command("sweep", "a.yaml")
    path = Path("results/a.nc")
    old = path.read_bytes(), path.stat().st_mtime_ns
    code, out, err = command("sweep", "a.yaml", "--set", "T=[300]")
    assert (code, out) == (2, "")
    assert err.startswith("results/a.nc has 4 finished points that the config no longer names")
    assert err.endswith("--overwrite starts afresh and drops them, -o writes elsewhere\n")
    assert (path.read_bytes(), path.stat().st_mtime_ns) == old
    assert entries("results") == ["a.nc", "a.nc.timing.json"]
    assert command("sweep", "a.yaml", "--set", "T=[300]", "--overwrite").code == 0
    assert open_result(path).temperature == [300.0]


def test_an_existing_file_that_is_no_result_is_refused_untouched(command: Command) -> None:
    xr.Dataset({"mine": 1.0}).to_netcdf("mine.nc")
    Path("text.nc").write_text("mine")
    for name, expected in (("mine.nc", 2), ("text.nc", 5)):
        old = Path(name).read_bytes()
        code, out, err = command("sweep", "a.yaml", "-o", name)
        assert (code, out) == (expected, "")
        assert err.startswith(f"{name} exists")
        assert err.endswith("--overwrite replaces it, -o writes elsewhere\n")
        assert Path(name).read_bytes() == old
        assert entries() == ["a.yaml", "mine.nc", "text.nc"]
    for name in ("mine.nc", "text.nc"):
        assert command("sweep", "a.yaml", "-o", name, "--overwrite").code == 0
        assert "friction_force_amplitude" in open_result(Path(name))


def test_points_that_fail_are_counted_and_explained(command: Command) -> None:
    code, out, err = command("sweep", "a.yaml", "--set", "stationary.max_periods=2")
    assert code == 3
    assert "points/s), 4 failed\n" in out
    assert "  4 not_stationary: The orbit did not become stationary within" in err
    assert np.all(open_result(Path("results/a.nc")).status == 1)


def test_a_step_unstable_for_some_points_refuses_those(command: Command) -> None:
    Path("e.yaml").write_text(
        "sweep: {omega: [3e5, 3e6]}\nmodel: {X_m: 1e-9}\nstationary: {max_periods: 2}\n"
        "integrator: {method: euler-cromer, dt: 1e-10}\n"
    )
    code, out, err = command("sweep", "e.yaml")
    assert code == 3
    assert "2 failed" in out
    assert "  1 not_stationary: " in err
    assert "  1 refused: The fixed step is unstable" in err
    assert open_result(Path("results/e.nc")).status.values.tolist() == [1, 4]


def test_warnings_of_a_config_are_told(command: Command) -> None:
    code, _, err = command("check", "a.yaml", "--set", "k=3000", "--set", "K=5e4")
    assert code == 0
    assert err.startswith("warning: ")


# --- check, simulate, figure: test_paper_figures.py ---


def test_check_says_what_would_be_computed(command: Command) -> None:
    code, out, err = command("check", "a.yaml")
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        "a.yaml: valid",
        "points: 4 (temperature 2 x rheological_index 2)",
        "integrator: method adaptive, rtol 0.0001",
        "output: results/a.nc",
    ]
    Path("c.yaml").write_text("sweep: {T: [1, 2]}\ncases: {k: [1e4, 2e4, 3e4], X_m: [1, 2, 3]}\n")
    assert "points: 6 (temperature 2 x case 3)" in command("check", "c.yaml").out
    Path("d.yaml").write_text("{}\n")
    assert "points: 1\n" in command("check", "d.yaml").out
    assert entries() == ["a.yaml", "c.yaml", "d.yaml"]


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_shipped_config_is_valid(command: Command, path: Path) -> None:
    code, _, err = command("check", str(path))
    assert (code, err) == (0, "")


def test_simulate_computes_what_python_computes(command: Command) -> None:
    code, out, err = command("simulate", "a.yaml", "--set", "T=250", "--set", "gamma=0")
    assert (code, out, err) == (0, "results/a-trajectory.nc\n", "")
    found = open_result(Path("results/a-trajectory.nc"))
    p = Parameters(temperature=250.0, rheological_index=0.0)
    expected = stickslip.simulate(p, periods=1, samples_per_period=50, rtol=1e-4)
    xr.testing.assert_identical(found.drop_attrs(deep=False), expected)
    assert found.attrs["title"] == "Four points"


def test_simulate_needs_no_config(command: Command) -> None:
    arguments = ("--periods", "1", "--set", "simulation.samples_per_period=20", "-o", "x/y.nc")
    code, out, _ = command("simulate", *arguments)
    assert (code, out) == (0, "x/y.nc\n")
    ds = open_result(Path("x/y.nc"))
    assert ds.sizes == {"time": 21}
    expected = stickslip.simulate(periods=1, samples_per_period=20)
    xr.testing.assert_identical(ds.drop_attrs(deep=False), expected)
    code, _, err = command("simulate", *arguments)
    assert code == 2
    assert "x/y.nc exists already" in err
    assert command("simulate", *arguments, "--overwrite").code == 0


def test_simulate_of_an_axis_names_what_picks_a_point(command: Command) -> None:
    code, out, err = command("simulate", "a.yaml")
    assert (code, out) == (2, "")
    assert "--set temperature=200.0 --set rheological_index=-0.6666666666666666" in err
    assert entries() == ["a.yaml"]


def test_simulate_tells_why_it_failed(command: Command) -> None:
    pick = ("--set", "T=250", "--set", "gamma=0")
    code, out, err = command("simulate", "a.yaml", *pick, "--set", "integrator.max_steps=10")
    assert (code, out) == (3, "")
    assert err == f"{stickslip.Status.STEP_LIMIT.sentence}\n"
    assert not entries("results")


# --- plot ---


@pytest.mark.slow
def test_plot_draws_a_sweep_and_a_trajectory(command: Command) -> None:
    command("sweep", "a.yaml")
    command("simulate", "a.yaml", "--set", "T=250", "--set", "gamma=0")
    for name in ("a", "a-trajectory"):
        code, out, err = command("plot", f"results/{name}.nc")
        assert (code, err) == (0, "")
        assert out.splitlines() == [f"results/{name}.png", f"results/{name}.pdf"]
        assert Path(f"results/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert Path(f"results/{name}.pdf").read_bytes().startswith(b"%PDF")
    code, out, _ = command("plot", "results/a.nc", "-o", "new/one.png")
    assert (code, out) == (0, "new/one.png\n")
    assert entries("new") == ["one.png"]
    assert Path("new/one.png").read_bytes() == Path("results/a.png").read_bytes()


@pytest.mark.slow
def test_plot_draws_what_the_config_asks_for(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sweeps import figures

    asked: list[str | None] = []
    draw = figures.draw

    def observed(ds: xr.Dataset, name: str | None = None) -> object:
        asked.append(name)
        return draw(ds, name)

    monkeypatch.setattr(figures, "draw", observed)
    pick = ("--set", "T=250", "--set", "gamma=0")
    command("simulate", "a.yaml", *pick, "--set", "plot.figure=phase_portraits")
    command("plot", "results/a-trajectory.nc", "-o", "t.png")
    command("simulate", "a.yaml", *pick, "--overwrite")
    command("plot", "results/a-trajectory.nc", "-o", "t.png")
    command("sweep", "a.yaml", "--set", "plot.figure=phase_portraits")
    command("plot", "results/a.nc", "-o", "a.png")
    command("sweep", "a.yaml", "--overwrite")
    command("plot", "results/a.nc", "-o", "a.png")
    # A figure that the file holds no data for gives way to the standard one.
    assert asked == ["phase_portraits", None, None, "amplitudes"]


# --- schema, info, version, help ---


def test_schema_is_the_shipped_one(command: Command) -> None:
    code, out, err = command("schema")
    assert (code, err) == (0, "")
    assert out == (CONFIGS / "stickslip.schema.json").read_text()
    jsonschema.Draft202012Validator.check_schema(json.loads(out))


def test_info_describes_the_installation(command: Command) -> None:
    code, out, err = command("info")
    assert (code, err) == (0, "")
    assert f"stickslip {metadata.version('stickslip')}" in out
    assert "compiled code is cached in: " in out


def test_info_describes_a_file(command: Command) -> None:
    command("sweep", "a.yaml", "--set", "integrator.max_steps=100")
    code, out, err = command("info", "results/a.nc")
    assert (code, err) == (0, "")
    ds = open_result(Path("results/a.nc"))
    assert "title: Four points\n" in out
    assert "dimensions: temperature 2, rheological_index 2\n" in out
    assert "  step_limit: 4\n" in out
    assert "  ok: " not in out
    assert f"history: {ds.attrs['history']}\n" in out
    assert f"config_sha256: {ds.attrs['config_sha256']}\n" in out
    assert out.endswith(f"content_sha256: {content_hash(ds)}\n")


def test_info_describes_a_trajectory_and_a_single_point(command: Command) -> None:
    command("simulate", "--periods", "1", "-o", "t.nc")
    out = command("info", "t.nc").out
    assert "dimensions: time 2001\n" in out
    assert "friction_force" in out
    Path("p.yaml").write_text("integrator: {rtol: 1e-3}\nstationary: {rtol: 1e-3}\n")
    command("sweep", "p.yaml")
    out = command("info", "results/p.nc").out
    assert "dimensions: none\n" in out
    assert "  ok: 1\n" in out


def test_version_and_help(command: Command) -> None:
    assert command("--version") == (0, f"stickslip {metadata.version('stickslip')}\n", "")
    code, out, err = command("--help")
    assert (code, err) == (0, "")
    verbs = ("sweep", "check", "simulate", "figure", "plot", "schema", "info")
    assert all(f"\n  {verb} " in out for verb in verbs)
    for verb in verbs:
        code, long, err = command(verb, "--help")
        assert (code, err) == (0, "")
        assert f"Usage: stickslip {verb}" in long
        assert long == command(verb, "-h").out
        assert max(map(len, long.splitlines())) <= 80


# --- real processes ---


def process(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "sweeps.cli", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.mark.parametrize("arguments", [["--help"], ["sweep", "--help"], ["--version"], ["schema"]])
def test_help_and_schema_load_no_compiler_and_no_arrays(arguments: list[str]) -> None:
    code = (
        "import sys; from sweeps.cli import main; sys.argv = ['stickslip', *sys.argv[1:]]\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code\n"
        "sys.stderr.write(' '.join(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True
    )
    assert done.stdout
    loaded = set(done.stderr.split())
    assert "sweeps.cli.app" in loaded
    heavy = {"numba", "xarray", "netCDF4", "matplotlib", "joblib", "scipy", "dask"}
    if arguments != ["schema"]:
        heavy |= {"numpy", "ruamel"}  # pydantic is loaded by typer itself
    assert loaded.isdisjoint(heavy)


@pytest.mark.slow
def test_a_real_sweep_keeps_its_outputs_apart(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(SWEEP)
    done = process("sweep", "a.yaml", folder=tmp_path)
    assert done.returncode == 0
    assert done.stderr == "4 points (2 x 2); 4 to compute\n"
    assert done.stdout.startswith("results/a.nc\n4 points in ")
    assert done.stdout.isprintable() or done.stdout.replace("\n", "").isprintable()
    assert entries(tmp_path / "results") == ["a.nc", "a.nc.timing.json"]
    bad = process(
        "sweep", "a.yaml", "--set", "stationary.max_periods=2", "-o", "b.nc", folder=tmp_path
    )
    assert bad.returncode == 3
    assert "Traceback" not in bad.stderr


def test_the_installed_command_is_this_one(tmp_path: Path) -> None:
    script = shutil.which("stickslip", path=str(Path(sys.executable).parent))
    if script is None:
        pytest.skip("the command is not installed beside this Python")
    done = subprocess.run([script, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"stickslip {metadata.version('stickslip')}\n"


def test_a_reader_that_leaves_early_is_no_error(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sweeps.cli", "schema"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as child:
        child.stdout.close()
        assert child.stderr.read() == b""
