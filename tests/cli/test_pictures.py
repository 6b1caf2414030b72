"""`stickslip simulate` and `plot`; `figure` has its tests among the figures."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from matplotlib.figure import Figure
from support import messages
from support.marks import one_then
from support.pictures import (
    GAMMAS,
    TEMPERATURES,
    curves,
    fitted,
    note,
    panels,
    random_cases,
    sweep,
)
from support.sweeps.commands import Command, entries, process

import stickslip
from stickslip import Parameters
from sweeps.cli.pictures import trajectory_path
from sweeps.exits import Exit
from sweeps.figures import PlotOptions
from sweeps.figures.amplitudes import draw_results
from sweeps.figures.save import pictures_of
from sweeps.files.netcdf import open_result


def test_simulate_equals_the_python_function(command: Command) -> None:
    code, out, err = command("simulate", "a.yaml", "--set", "T=250", "--set", "gamma=0")
    assert (code, out, err) == (0, "results/a-T=250-gamma=0-trajectory.nc\n", "")
    found = open_result(Path("results/a-T=250-gamma=0-trajectory.nc"))
    p = Parameters(temperature=250.0, rheological_index=0.0)
    expected = stickslip.simulate(p, periods=1, samples_per_period=50, rtol=1e-4)
    xr.testing.assert_identical(found.drop_attrs(deep=False), expected)
    assert found.attrs["title"] == "Four points"


def test_simulate_needs_no_config(command: Command) -> None:
    arguments = ("--periods", "1", "--set", "simulation.samples_per_period=20", "-o", "x/y.nc")
    code, out, _ = command("simulate", *arguments)
    assert (code, out) == (0, "x/y.nc\n")
    ds = open_result(Path("x/y.nc"))
    assert ds.sizes == {"elapsed_time": 21}
    expected = stickslip.simulate(periods=1, samples_per_period=20)
    xr.testing.assert_identical(ds.drop_attrs(deep=False), expected)
    again = command("simulate", *arguments)
    assert again == (0, "x/y.nc\n", f"x/y.nc {messages.COMPLETE}\n")
    code, _, err = command("simulate", *arguments, "--set", "T=250")
    assert code == 2
    assert "x/y.nc already exists" in err
    command.ok("simulate", *arguments, "--overwrite")


@pytest.mark.parametrize(
    ("file", "changes", "name"),
    [
        (None, [], "paper-trajectory.nc"),
        (None, ["T=250"], "paper-T=250-trajectory.nc"),
        (None, ["T=250.5", "gamma=-2/3"], "paper-T=250.5-gamma=-2_3-trajectory.nc"),
        (
            Path("a.yaml"),
            ["simulation.drive={velocity: 2e-6}"],
            "a-simulation.drive=_velocity_2e-6_-trajectory.nc",
        ),
    ],
)
def test_a_default_name_contains_the_changes(
    file: Path | None, changes: list[str], name: str
) -> None:
    assert trajectory_path(file, changes) == Path("results") / name
    long = [f"cases.T={list(range(500))}"]
    assert len(trajectory_path(file, long).name) < 200


def test_simulate_of_an_axis_prints_options_that_pick_a_point(command: Command) -> None:
    code, out, err = command("simulate", "a.yaml")
    assert (code, out) == (2, "")
    assert "--set temperature=200.0 --set rheological_index=-0.6666666666666666" in err
    assert entries() == ["a.yaml"]


def test_simulate_prints_why_it_failed(command: Command) -> None:
    pick = ("--set", "T=250", "--set", "gamma=0")
    code, out, err = command("simulate", "a.yaml", *pick, "--set", "integrator.max_steps=10")
    assert (code, out) == (3, "")
    assert err == f"{stickslip.Status.STEP_LIMIT.sentence}\n"
    assert not entries("results")


@pytest.mark.slow
def test_plot_draws_a_sweep_and_a_trajectory(command: Command) -> None:
    command("sweep", "a.yaml")
    command("simulate", "a.yaml", "--set", "T=250", "--set", "gamma=0", "-o", "results/t.nc")
    for name in ("a", "t"):
        code, out, err = command("plot", f"results/{name}.nc")
        assert (code, err) == (0, "")
        assert out.splitlines() == [f"results/{name}.png", f"results/{name}.pdf"]
        assert Path(f"results/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert Path(f"results/{name}.pdf").read_bytes().startswith(b"%PDF")
    code, out, _ = command("plot", "results/a.nc", "-o", "new/one.png")
    assert (code, out) == (0, "new/one.png\n")
    assert entries("new") == ["one.png"]
    assert Path("new/one.png").read_bytes() == Path("results/a.png").read_bytes()


@pytest.mark.stress
def test_plot_draws_the_figure_of_the_config(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sweeps import figures

    asked: list[str | None] = []
    draw = figures.draw

    def observed(ds: xr.Dataset, name: str | None, options: PlotOptions | None) -> object:
        asked.append(name)
        return draw(ds, name, options)

    monkeypatch.setattr(figures, "draw", observed)
    pick = ("--set", "T=250", "--set", "gamma=0", "-o", "t.nc")
    command("simulate", "a.yaml", *pick, "--set", "plot.figure=phase_portraits")
    command("plot", "t.nc", "-o", "t.png")
    command("simulate", "a.yaml", *pick, "--overwrite")
    command("plot", "t.nc", "-o", "t.png")
    command("sweep", "a.yaml", "--set", "plot.figure=phase_portraits")
    command("plot", "results/a.nc", "-o", "a.png")
    command("sweep", "a.yaml", "--overwrite")
    command("plot", "results/a.nc", "-o", "a.png")
    command("plot", "t.nc", "-o", "t.png", "--figure", "phase_portraits")
    # A figure that the file holds no data for gives way to the standard one.
    assert asked == ["phase_portraits", None, None, "amplitudes", "phase_portraits"]
    code, _, err = command("plot", "results/a.nc", "-o", "b.png", "--figure", "phase_portraits")
    assert (code, "draws a trajectory" in err, Path("b.png").exists()) == (Exit.USAGE, True, False)
    code, _, err = command("plot", "results/a.nc", "--figure", "amplitude")
    assert (code, "did you mean 'amplitudes'?" in err) == (Exit.USAGE, True)


@pytest.fixture
def result(command: Command) -> Path:
    """A result file that was made by hand."""
    file = Path("made.nc")
    sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS)).to_netcdf(file)
    return file


def test_plot_draws_as_the_options_say(
    command: Command, result: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sweeps import figures

    drawn: list[Figure] = []
    draw = figures.draw

    def observed(*arguments: Any) -> Figure:
        drawn.append(draw(*arguments))
        return drawn[-1]

    monkeypatch.setattr(figures, "draw", observed)
    Path("mine.mplstyle").write_text("font.size: 11")
    options = ("--variable", "elastic_stress_amplitude", "-x", "T", "--at", "gamma=0", "--log", "x")
    named = ("-o", "new/a.svg", "--style", "mine.mplstyle")
    code, out, _ = command("plot", str(result), *options, *named)
    assert (code, out) == (0, "new/a.svg\n")
    assert "<svg" in Path("new/a.svg").read_text(encoding="utf-8")
    (axes,) = drawn[0].axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")
    assert axes.yaxis.label.get_size() == 11.0
    assert len(curves(axes)) == 1
    assert note(drawn[0]) == r"At $\gamma = 0$."
    command("plot", str(result), "--hue", "T", "-x", "gamma", "-o", "b.png")
    command("plot", str(result), "-y", "T", "-x", "gamma", "-o", "b.png")
    command("plot", str(result), "--row", "gamma", "-o", "b.png")
    command("plot", str(result), "--col", "gamma", "-o", "b.png")
    assert [len(panels(figure)) for figure in drawn[1:]] == [2, 2, 6, 6]


@pytest.mark.stress
def test_plot_needs_no_window(result: Path) -> None:
    done = process("plot", str(result), "-o", "a.png", environment={"MPLBACKEND": "nosuch"})
    assert (done.code, done.err) == (0, "")


@pytest.mark.parametrize(
    ("options", "drawn"),
    [
        ((), ["melting_count"]),
        (("--at", "gamma=0"), ["melting_count"]),
        (("-x", "T", "--log", "x"), ["melting_count"]),
        (("--variable", "F_max", "-x", "T"), ["friction_force_amplitude"]),
    ],
)
def test_plot_keeps_the_variables_of_the_config(
    command: Command, result: Path, monkeypatch: pytest.MonkeyPatch, options: tuple, drawn: list
) -> None:
    from sweeps import figures

    save = importlib.import_module("sweeps.figures.save")  # `figures.save` is its function
    seen: list[list[str]] = []
    names = "sweeps.figures.amplitudes.draw_maps", "sweeps.figures.amplitudes.draw_curves"
    for name in names:
        monkeypatch.setattr(name, lambda _ds, _layout, variables, *_: seen.append([*variables]))
    monkeypatch.setattr("sweeps.figures.amplitudes.put_note", lambda *_: None)
    monkeypatch.setattr(figures, "draw", lambda ds, _, options: draw_results(ds, options))
    monkeypatch.setattr(
        save, "rendered", lambda _, path, *__: dict.fromkeys(pictures_of(path), b"")
    )
    ds = open_result(result).assign_attrs(config="plot: {variables: [melting_count]}")
    ds.to_netcdf("named.nc")
    command.ok("plot", "named.nc", *options)
    assert seen == [drawn]


@pytest.mark.parametrize(
    ("ds", "figure", "drawn"),
    [
        (fitted().assign_coords(datum_at_jump=("datum", [0, 1, 0, 0])), "amplitudes", 2),
        (random_cases(temperature=(150.0, 320.0), spring_stiffness=(5e2, 1e4)), "pairs", 1),
        (random_cases(temperature=(150.0, 320.0), spring_stiffness=(5e2, 1e4)), "orbit", 2),
    ],
)
def test_variables_of_the_config_are_those_of_amplitudes(
    command: Command, monkeypatch: pytest.MonkeyPatch, ds: xr.Dataset, figure: str, drawn: int
) -> None:
    from sweeps import figures

    pictures: list[Figure] = []
    draw = figures.draw

    def observed(*asked: Any) -> Figure:
        pictures.append(draw(*asked))
        return pictures[-1]

    monkeypatch.setattr(figures, "draw", observed)
    config = f"plot: {{figure: {figure}, variables: [elastic_stress_amplitude]}}"
    ds.assign_attrs(config=config).to_netcdf("a.nc")
    command.ok("plot", "a.nc", "-o", "a.png")
    assert len(panels(pictures[0])) == drawn


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--variable", "melting_cuont"), "did you mean 'melting_count'?"),
        (("--log", "u"), "there is no 'u'"),
        (("--style", "none"), "the style file none does not exist"),
        (("--figure", "amplitudes", "-x", "T"), "--figure draws a whole picture"),
        (("-o", "a.jpg"), "a picture's name must end in .png, .pdf or .svg"),
    ],
)
def test_plot_refuses_wrong_options(
    command: Command, result: Path, options: tuple[str, ...], words: str
) -> None:
    code, out, err = command("plot", str(result), *options)
    assert (code, out) == (Exit.USAGE, "")
    last = err.splitlines()[-1]
    assert words in last
    assert entries() == ["a.yaml", "made.nc"]


@pytest.mark.parametrize("name", one_then("stress", ["a.final.nc", "a.cdf", "a.nc"]))
def test_a_file_of_any_name_has_pictures_beside_it(command: Command, name: str) -> None:
    Path("a").mkdir()
    sweep(temperature=TEMPERATURES).to_netcdf(name)
    stem = name.rpartition(".")[0]
    assert command.ok("plot", name).out == f"{stem}.png\n{stem}.pdf\n"
