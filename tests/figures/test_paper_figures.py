"""`stickslip figure N`: the figures of the paper from scratch, and reports of failures."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from support import messages

from sweeps.cli.app import main
from sweeps.config import paper
from sweeps.config.load import load
from sweeps.config.paper import PAPER, PaperFigure, shipped_config
from sweeps.figure_table import FIGURES
from sweeps.files.netcdf import open_result

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Command:
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["stickslip", "figure", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return int(ended.value.code or 0), out, err

    return call


def files(number: int, folder: str = "results") -> list[str]:
    return [f"{folder}/fig{number}.{kind}" for kind in ("nc", "png", "pdf")]


def whole(paths: list[str]) -> bool:
    starts = {".nc": b"\x89HDF", ".png": b"\x89PNG", ".pdf": b"%PDF"}
    return all(Path(p).read_bytes().startswith(starts[Path(p).suffix]) for p in paths)


def test_every_figure_of_the_table_has_its_config_and_its_picture() -> None:
    assert list(PAPER) == [2, 3, 4, 5, 6, 7, 8, 9]
    for number, plan in PAPER.items():
        config = load(shipped_config(plan.config), plan.changes)
        assert plan.figure in FIGURES
        assert config.title.startswith(f"Fig. {number} - ")
        assert config.warnings == ()
        if number != 4:
            assert config.plot.figure == plan.figure


def test_shipped_configs_are_found_by_name() -> None:
    assert shipped_config("fig7").name == "fig7.yaml"
    with pytest.raises(FileNotFoundError, match="no shipped config is called fig1"):
        shipped_config("fig1")


@pytest.mark.stress
def test_figures_3_and_4_are_made_together(command: Command) -> None:
    code, out, err = command("3", "4", "3")
    assert (code, err) == (0, "")
    assert out.splitlines() == files(3) + files(4)
    assert whole(files(3) + files(4))
    third, fourth = (open_result(Path(f"results/fig{n}.nc")) for n in (3, 4))
    assert third.attrs["title"].startswith("Fig. 3 - ")
    assert fourth.attrs["title"].startswith("Fig. 4 - ")
    assert third.sizes == {"elapsed_time": 8001}
    assert third.friction_force.equals(fourth.friction_force)
    assert Path("results/fig3.png").read_bytes() != Path("results/fig4.png").read_bytes()


@pytest.mark.stress
def test_all_figures_are_made(command: Command) -> None:
    code, out, err = command("all", "-o", "new/folder", "--no-progress")
    assert (code, err) == (0, "")
    named = [line for line in out.splitlines() if line.startswith("new/folder/")]
    expected = [path for number in PAPER for path in files(number, "new/folder")]
    assert named == expected
    assert whole(expected)
    assert out.count("513 points in ") == out.count(" 0 failed, largest amplitude error ") == 3
    assert sorted(path.name for path in Path("new/folder").iterdir()) == sorted(
        Path(path).name for path in expected
    )
    assert open_result(Path("new/folder/fig5.nc")).sizes["angular_frequency"] == 4
    for number in (7, 8, 9):
        assert (open_result(Path(f"new/folder/fig{number}.nc")).status == 0).all()


def small(monkeypatch: pytest.MonkeyPatch, *changes: str) -> None:
    axis = "temperature={linspace: [150, 320], num: 3}"
    monkeypatch.setitem(paper.PAPER, 7, PaperFigure("fig7", "amplitudes", [axis, *changes]))


def test_failed_points_of_a_figure_are_reported(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    small(monkeypatch, "stationary.max_periods=2")
    code, out, err = command("7", "--workers", "1")
    assert code == 3
    assert "9 points in " in out
    assert "9 failed" in out
    assert err.startswith("9 points (3 x 3); 9 to compute\n")
    assert "  9 not_stationary: " in err
    assert whole(files(7))  # the picture says what is missing


@pytest.mark.stress
def test_a_failed_figure_does_not_hide_behind_a_later_one(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    small(monkeypatch, "stationary.max_periods=2")
    axis = "viscosity_coefficient=[5e4]"
    monkeypatch.setitem(paper.PAPER, 8, PaperFigure("fig8", "amplitudes", [axis]))
    code, out, _ = command("7", "8", "--no-progress")
    assert code == 3
    assert "9 failed" in out
    assert "3 points in " in out


def test_a_figure_is_drawn_anew_and_its_data_are_kept(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    small(monkeypatch)
    assert command("7", "--no-progress")[0] == 0
    before = Path("results/fig7.nc").read_bytes()
    again = command("7")
    assert (again[0], again[2]) == (0, "results/fig7.nc is complete: 9 points, nothing to do\n")
    small(monkeypatch, "integrator.rtol=1e-5")
    code, _, err = command("7", "--no-progress")
    assert (code, Path("results/fig7.nc").read_bytes()) == (2, before)
    assert messages.OTHER_SETTINGS in err
    assert command("7", "--no-progress", "--overwrite")[0] == 0
    assert Path("results/fig7.nc").read_bytes() != before
    for path in files(7):
        Path(path).write_bytes(b"mine")
        assert command("7", "--no-progress")[0] in (2, 5)
        assert Path(path).read_bytes() == b"mine"
        assert command("7", "--no-progress", "--overwrite")[0] == 0
        assert whole(files(7))


def test_a_file_in_place_of_the_folder(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    small(monkeypatch)
    Path("results").write_text("mine")
    for number in ("7", "3"):
        code, out, err = command(number, "--no-progress")
        assert (code, out) == (5, "")
        assert err.startswith(f"cannot write results/fig{number}.")
        assert err.endswith(": results is not a folder\n")
    assert Path("results").read_text() == "mine"


@pytest.mark.parametrize(
    "axes",
    [
        "model: {T: 280}",
        "sweep: {a: [4e12, 8e12]}",
        "sweep: {T: [265, 286], a: [4e12, 8e12]}",
        "sweep: {T: [265, 286]}\ncases: {a: [4e12, 8e12]}",
    ],
)
def test_a_free_energy_at_other_axes_than_temperatures_is_refused(
    command: Command, axes: str
) -> None:
    Path("a.yaml").write_text(f"{axes}\nplot: {{figure: free_energy}}\n")
    code, out, err = command("a.yaml")
    assert (code, out) == (2, "")
    assert err == (
        "the figure free_energy needs `sweep: {temperature: [...]}`, and no other axis\n"
    )


def test_two_configs_with_the_files_of_one_are_refused(command: Command) -> None:
    code, out, err = command("a/x.yaml", "b/x.yaml")
    assert (code, out) == (2, "")
    assert err == "a/x.yaml and b/x.yaml would both be drawn as x; use a folder for each\n"
    assert command("3", "fig3.yaml")[0] == 2


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ("plot: {figure: posterior}", "shows a fit: `stickslip fit` computes and draws it"),
        ("plot: {figure: indices}", "`stickslip sensitivity` computes and draws it"),
        (
            "cases: {T: [200, 250]}\nplot: {figure: time_courses}",
            "exactly one axis, without `cases` and `follow`: fix the other parameters",
        ),
    ],
)
def test_a_config_without_the_data_of_its_figure_is_refused(
    command: Command, config: str, message: str
) -> None:
    Path("a.yaml").write_text(f"{config}\n")
    code, out, err = command("a.yaml")
    assert (code, out) == (2, "")
    assert message in err
