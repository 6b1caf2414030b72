"""What pages show can be done: their configs, commands and scripts, in an empty folder."""

from __future__ import annotations

import math
import re
import shlex
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from support import messages

from stickslip import laws
from sweeps.cli.app import main

DOCS = Path(__file__).parents[2] / "docs"
FOLDER = DOCS / "how-to"

CONFIG = re.compile(
    r"^```\{code-block\} (?:yaml|text|python|toml)\n:caption: (\S+)\n\n(.*?)^```",
    re.MULTILINE | re.DOTALL,
)
COMMANDS = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
Page = Callable[[str], dict[str, Any]]
SCRIPT = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.fixture
def run_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Page:
    """Do what a page says, in an empty folder; return the names that its scripts define."""
    monkeypatch.chdir(tmp_path)
    Path("configs").symlink_to(DOCS.parent / "configs")
    return lambda name: names_left_by(name, monkeypatch)


def names_left_by(name: str, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    page, names = page_of(name), {}
    for config, text in CONFIG.findall(page):
        Path(config).write_text(text)
    for line in "".join(COMMANDS.findall(page)).splitlines():
        monkeypatch.setattr(sys, "argv", shlex.split(line))
        with pytest.raises(SystemExit) as ended:
            main()
        assert not ended.value.code, line
    exec("".join(SCRIPT.findall(page)), names)
    plt.close("all")
    return names


def page_of(name: str) -> str:
    path = FOLDER / f"{name}.md"
    return (path if path.exists() else DOCS / f"{name}.md").read_text("utf-8")


def shown_output(name: str) -> list[str]:
    """The lines that a page says are printed."""
    blocks = re.findall(r"^```text\n(.*?)^```", page_of(name), re.MULTILINE | re.DOTALL)
    return "".join(blocks).splitlines()


def numbers_in(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"\d+(?:\.\d+)?", text)]


@pytest.mark.slow
def test_critical_velocity(run_page: Page, capsys: pytest.CaptureFixture[str]) -> None:
    critical = run_page("critical-velocity")["critical"]
    assert "one melting event every 0.31283" in capsys.readouterr().err
    assert (critical[:5] > 5.9e-6).all()
    assert (critical[:5] < 7.4e-6).all()
    assert critical[4] > 2 * critical[5]
    assert np.isnan(critical[6])


@pytest.mark.stress
def test_my_own_lubricant(run_page: Page, capsys: pytest.CaptureFixture[str]) -> None:
    names = run_page("my-own-lubricant")
    printed = re.findall(r"^(\w+_coefficient): (\S+)$", capsys.readouterr().out, re.MULTILINE)
    config = Path("lubricant.yaml").read_text()
    written = dict(re.findall(r"(\w+_coefficient): (\S+)", config))
    assert [(name, float(value)) for name, value in printed] == [
        (name, float(written[name])) for name, _ in printed
    ]
    assert len(printed) == 4
    assert names["film"].melting_temperature.values[0] == pytest.approx(names["T_m"])
    assert names["film"].solidification_temperature.values[0] == pytest.approx(names["T_c"])
    assert {path.name for path in Path("results").glob("*.png")} == {"lubricant.png", "regimes.png"}
    lubricant = result("lubricant")
    slow = lubricant.sel(temperature=names["T"], angular_frequency=5)
    assert slow.elastic_stress_amplitude == pytest.approx(names["stress"], rel=0.02)
    assert (lubricant.sel(temperature=slice(names["T_m"], None)).regime == 0).all()


@pytest.mark.stress
def test_a_map_that_grows(
    run_page: Page, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    names = run_page("map")
    assert names["ds"].equals(result("map"))
    assert (names["ds"].status == 0).all()
    config = Path("map.yaml").read_text()
    Path("map.yaml").write_text(config.replace("num: 65", "num: 129"))
    monkeypatch.setattr(sys, "argv", ["stickslip", "sweep", "map.yaml"])
    capsys.readouterr()
    with pytest.raises(SystemExit):
        main()
    assert f"{65 * 65} in results/map.nc; " in capsys.readouterr().err


@pytest.mark.slow
def test_the_error_bar(run_page: Page) -> None:
    names = run_page("error-bar")
    assert (names["force_error"] < 1e-4 * names["ds"].friction_force_amplitude.max()).all()
    assert abs(names["change"]) <= names["coarse"].amplitude_error


@pytest.mark.stress
def test_orbits_of_a_table(run_page: Page) -> None:
    names = run_page("many-orbits")
    slopes = names["ds"].friction_force_amplitude_sensitivity[1].values  # at 250 K
    assert slopes[:2] == pytest.approx([0.157, -5.08], abs=0.005)
    k, gamma = np.exp(names["found"].x[0]), names["found"].x[1]
    errors = np.sqrt(np.diag(names["covariance"]))
    assert abs(np.log(k / 7e4)) < 4 * errors[0]
    assert abs(gamma + 0.55) < 4 * errors[1]


@pytest.mark.stress
def test_loss_and_storage(run_page: Page) -> None:
    names = run_page("loss-and-storage")
    assert (names["ds"].status == 0).all()
    assert (names["loss"] > 0).all()
    np.testing.assert_allclose(names["ds"].dissipated_energy, names["cosine"], rtol=1e-12)
    p, locked = names["p"], names["locked"]
    springs = 2 * p.spring_stiffness - p.block_mass * p.angular_frequency**2
    found = locked.friction_force_in_phase / p.drive_amplitude
    assert found == pytest.approx(springs, rel=1e-4)
    assert {"loss.png", "loss.csv", "loss-and-storage.png"} <= {
        path.name for path in Path().iterdir()
    }
    assert Path("results/loop.png").is_file()


@pytest.mark.stress
def test_which_parameter_matters(run_page: Page, capsys: pytest.CaptureFixture[str]) -> None:
    ds = run_page("which-parameter-matters")["ds"]
    assert (ds.total_order[0] > 0.3).all()
    assert (ds.total_order[0] < 0.9).all()
    assert "64 of 64 base points used" in capsys.readouterr().out
    assert Path("results/box-sensitivity.png").is_file()


@pytest.mark.stress
def test_the_tutorial_for_experimenters(run_page: Page, capsys: pytest.CaptureFixture[str]) -> None:
    run_page("tutorial-experimenter")
    printed = "".join(capsys.readouterr())
    for shown in shown_output("tutorial-experimenter"):
        (line,) = re.findall(rf"^{shown.split()[0]} .*$", printed, re.MULTILINE)
        assert numbers_in(line) == pytest.approx(numbers_in(shown), rel=1e-3)
    # The error of the page depends on the last digits of the fitted value.
    (error,) = re.findall(r"725 points .* 0 failed, largest amplitude error (\S+)", printed)
    assert float(error) < 1e-4
    made = {path.name for path in Path().iterdir()}
    assert {"fit.png", "regimes.png", "forces.png", "map.html", "map.csv"} <= made
    assert any("replay" in name for name in made)


@pytest.mark.slow
def test_which_tool(run_page: Page, capsys: pytest.CaptureFixture[str]) -> None:
    orbit = run_page("which-tool")["orbit"]
    (nan, by_hand, own), shown = capsys.readouterr().out.splitlines(), shown_output("which-tool")
    assert [nan, own] == [shown[0], shown[2]]
    # The sixth digit of LSODA's depends on roundings.
    assert float(by_hand.split()[1]) == pytest.approx(float(shown[1].split()[1]), rel=5e-5)
    (exact,) = re.findall(r"gives (\S+) N", page_of("which-tool"))
    off = abs(orbit.friction_force_amplitude / float(exact) - 1)
    assert off < orbit.amplitude_error


@pytest.mark.stress
def test_the_orbits_for_other_codes(run_page: Page) -> None:
    names = run_page("benchmark-orbits")
    table = dict(re.findall(r"^\| (.+?) \| (.*) \|$", page_of("benchmark-orbits"), re.MULTILINE))
    rows = {"elastic_stress_max": "largest σ_el [Pa]", "friction_force_max": "largest F [N]"}
    for name, row in rows.items():
        stick_slip, _, relaxing = map(float, table[row].split(" | "))
        assert getattr(names["orbit"], name) == pytest.approx(stick_slip, rel=3e-12)
        assert getattr(names["relaxing"], name) == pytest.approx(relaxing, rel=3e-12)


@pytest.mark.stress  # it compiles the kernels of orbits for a law
def test_a_friction_law(run_page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(laws, "REGISTERED", {})
    monkeypatch.syspath_prepend("")
    orbit = run_page("friction-law")["orbit"]
    # Stiff springs hold the block, so the liquid film shears at the speed of the drive.
    expected = 0.6e-9 * 1e6 * math.atan(0.8e-6 * 10 / 1e-9 / 1e3)
    assert orbit.friction_force_amplitude == pytest.approx(expected, rel=0.02)
    project = tomllib.loads(Path("pyproject.toml").read_text())["project"]
    (law,) = project["entry-points"][laws.GROUP].values()
    assert law == "limited:LIMITED"


@pytest.mark.stress
def test_a_fit(run_page: Page) -> None:
    names = run_page("fit")
    k, gamma = names["ds"].parameter_value.values
    assert (k, gamma) == (pytest.approx(7e4, rel=0.15), pytest.approx(-0.55, abs=0.02))
    assert names["ds"].parameter_correlation[0, 1] == pytest.approx(-0.998, abs=0.001)
    assert names["profile"].parameter_profile_lower[0] == pytest.approx(62500, rel=0.01)
    assert names["locked"].parameter_determination.values.tolist() == [1]
    assert names["locked"].datum_regime.values.tolist() == [1, 1, 1, 1]
    jump, truth = names["jump"], names["truth"]
    assert jump.datum_regime.values.tolist() == truth.regime.values.tolist()
    assert float(jump.parameter_value[0]) == pytest.approx(5e4, rel=0.05)
    assert Path("forces-fit.png").is_file()
    assert Path("forces-fit.yaml").is_file()
    predicted = xr.open_dataset("predicted.nc")
    assert predicted.sizes == {"temperature": 61, "case": 64}
    assert (predicted.status == 0).all()
    assert Path("predicted.png").is_file()


@pytest.mark.stress
def test_a_phase_diagram(run_page: Page) -> None:
    names = run_page("phase-diagram")
    numbers = re.findall(r"\b\d\d\.\d{4}\b", page_of("phase-diagram"))
    jumps = [float(number) for number in numbers]
    assert names["jumps"].angular_frequency.values == pytest.approx(jumps, abs=2e-4)
    assert names["jumps"].type.values.tolist() == [0, 1, 0, 0, 0]
    table = Path("borders.csv").read_text().splitlines()
    assert len(table) == 1 + names["borders"].sizes["boundary_point"]
    assert {"regimes.pdf", "lines.png", "borders.columns.csv"} <= {p.name for p in Path().iterdir()}


@pytest.mark.stress
def test_from_pixel_to_orbit(run_page: Page, capsys: pytest.CaptureFixture[str]) -> None:
    names = run_page("from-pixel-to-orbit")
    said = capsys.readouterr().out
    assert messages.SAME_BITS in said
    assert "3 meltings per period" in said
    assert names["point"].differences() == {}
    assert Path("results/fig7-replay.png").is_file()


def result(name: str) -> Any:
    import xarray as xr

    return xr.open_dataset(f"results/{name}.nc")
