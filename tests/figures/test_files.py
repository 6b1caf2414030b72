"""Pictures as files: whole, reproducible, and made without needless imports."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
import xarray as xr
from support.marks import one_then
from support.pictures import GAMMAS, TEMPERATURES, drawn, panels, sweep, trajectory

import sweeps.accessor  # noqa: F401 - registers `stickslip`
from stickslip import phase_diagram
from stickslip.boxes import Design
from stickslip.distributions import Range
from stickslip.indices import indices_of
from stickslip.variables import RESULT_COLUMNS
from sweeps.charts.choice import obstacle
from sweeps.figure_table import FIGURES
from sweeps.figures import Look, PlotOptions, draw, save

# --- files --------------------------------------------------------------------------------------


def test_both_formats_are_written_whole(tmp_path):
    figure = draw(sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS)))
    png, pdf = save(figure, tmp_path / "new" / "fig7.5")
    assert [png.name, pdf.name] == ["fig7.5.png", "fig7.5.pdf"]
    assert png.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    assert pdf.read_bytes().startswith(b"%PDF-")
    assert pdf.read_bytes().rstrip().endswith(b"%%EOF")
    assert sorted(path.name for path in png.parent.iterdir()) == ["fig7.5.pdf", "fig7.5.png"]
    width = int.from_bytes(png.read_bytes()[16:20], "big")
    assert width == round(3.4 * 200)


def test_a_named_file_is_the_only_one_written(tmp_path):
    target = tmp_path / "one.pdf"
    assert save(draw(trajectory()), target) == [target]
    assert list(tmp_path.iterdir()) == [target]


def test_an_older_picture_survives_a_failure(tmp_path, monkeypatch):
    (old,) = save(draw(trajectory()), tmp_path / "a.png")
    before = old.read_bytes()

    def full_disk(path, content):
        with path.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError("no space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full_disk)
    with pytest.raises(OSError, match="no space"):
        save(draw(sweep(temperature=TEMPERATURES)), old)
    assert old.read_bytes() == before
    assert list(tmp_path.iterdir()) == [old]


@pytest.mark.parametrize(
    "ds",
    one_then(
        "stress",
        [sweep(viscosity_coefficient=TEMPERATURES, rheological_index=list(GAMMAS)), trajectory()],
    ),
)
def test_fonts_are_truetype_and_words_of_an_svg_stay_words(tmp_path, ds):
    figure = draw(ds)
    pdf = save(figure, tmp_path / "a.pdf")[0].read_bytes()
    assert b"/Type3" not in pdf
    assert b"/FontFile2" in pdf
    svg = save(figure, tmp_path / "a.svg")[0].read_text(encoding="utf-8")
    assert svg.startswith("<?xml")
    words = "".join("".join(ET.fromstring(svg).itertext()).split())
    assert "Newtonian" in words or "upperblock" in words


def test_no_style_file_brings_other_fonts_back(tmp_path):
    style = tmp_path / "mine.mplstyle"
    style.write_text("pdf.fonttype: 3\nsvg.fonttype: path\n")
    look = Look(style=style)
    figure = draw(sweep(temperature=TEMPERATURES), None, PlotOptions(look=look))
    assert b"/Type3" not in save(figure, tmp_path / "a.pdf", look)[0].read_bytes()
    assert "<text" in save(figure, tmp_path / "a.svg", look)[0].read_text(encoding="utf-8")


def test_a_figure_from_python_saves_with_the_settings_it_was_drawn_with(tmp_path):
    style = tmp_path / "mine.mplstyle"
    style.write_text("savefig.dpi: 50\n")
    figure = sweep(temperature=TEMPERATURES).stickslip.plot(style=style)
    figure.savefig(tmp_path / "a.pdf")
    pdf = (tmp_path / "a.pdf").read_bytes()
    assert b"/Type3" not in pdf
    assert b"/FontFile2" in pdf
    figure.savefig(tmp_path / "a.png")
    assert int.from_bytes((tmp_path / "a.png").read_bytes()[16:20], "big") == round(3.4 * 50)


_HASHED = """
import hashlib, sys
from pathlib import Path
sys.path.insert(0, "tests")
from support.pictures import TEMPERATURES, sweep
from sweeps.figures import draw, save
figure = draw(sweep(temperature=TEMPERATURES))
for name in ("a.png", "a.pdf", "a.svg"):
    print(hashlib.sha256(save(figure, Path(sys.argv[1]) / name)[0].read_bytes()).hexdigest())
"""


@pytest.mark.stress
def test_two_processes_give_the_same_bytes(tmp_path):
    digests = [
        subprocess.run(
            [sys.executable, "-c", _HASHED, str(tmp_path)],
            capture_output=True,
            text=True,
            check=True,
            cwd=Path(__file__).parents[2],
            env=os.environ | {"PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    ]
    assert digests[0] == digests[1]


def contents(ds: xr.Dataset, folder) -> list[bytes]:
    figure = draw(ds)
    pictures = [*save(figure, folder / "picture"), *save(figure, folder / "picture.svg")]
    return [path.read_bytes() for path in pictures]


@pytest.mark.parametrize("kind", one_then("stress", ["curves", "trajectory", "map"]))
def test_two_runs_give_the_same_bytes(tmp_path, monkeypatch, kind):
    k = np.geomspace(1e4, 2e5, 12)
    ds = {
        "curves": sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS)),
        "map": sweep(temperature=TEMPERATURES, viscosity_coefficient=k),
        "trajectory": trajectory(),
    }[kind]
    first = contents(ds, tmp_path / "a")
    # Matplotlib dates its files with this; a day later must make no difference.
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert contents(ds, tmp_path / "b") == first


@pytest.mark.stress
def test_drawing_in_threads_changes_nothing(tmp_path):
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    with ThreadPoolExecutor(3) as pool:
        results = list(pool.map(lambda i: contents(ds, tmp_path / str(i)), range(3)))
    assert all(result == results[0] for result in results)


def test_the_title_travels_in_the_file(tmp_path):
    ds = sweep(temperature=TEMPERATURES)
    (png,) = save(draw(ds), tmp_path / "a.png")
    assert "Three lubricants, γ ≠ 1".encode() in png.read_bytes()


def test_the_dataset_is_left_as_it_was():
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    before = ds.copy(deep=True)
    draw(ds)
    assert ds.identical(before)


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        ("sweeps.figures", ("numba", "matplotlib.pyplot", "stickslip.kernels")),
        ("sweeps.figure_table", ("matplotlib",)),
    ],
)
def test_an_import_leaves_out_heavy_modules(module, heavy):
    code = f"import sys, {module}; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def indices() -> xr.Dataset:
    """Return Sobol indices of two results, each equal to one of the two parameters of a box."""
    box = {"temperature": Range(200.0, 280.0), "spring_stiffness": Range(1e3, 5e3)}
    design = Design.of(box, 16, 0)
    amplitudes = ["elastic_stress_amplitude", "friction_force_amplitude"]
    rows = np.zeros((64, len(RESULT_COLUMNS)))
    for name, values in zip(amplitudes, design.points().values(), strict=True):
        rows[:, RESULT_COLUMNS.index(name)] = values
    return indices_of(design, rows, amplitudes)


def test_every_figure_of_the_table_is_drawn_by_a_function_that_has_its_data():
    for name, entry in FIGURES.items():
        if name == "pairs":
            continue  # of a sample: tests/figures/test_scatter.py
        ds = {
            "trajectory": trajectory,
            "sweep": lambda: sweep(temperature=TEMPERATURES),
            "phases": phase_diagram,
            "fit": drawn,
            "indices": indices,
        }[entry.data]()
        assert obstacle(ds, name) == ""
        assert panels(draw(ds, name))
        lacking = ds.drop_vars(entry.variables[0])
        assert obstacle(lacking, name) == (
            f"the figure '{name}' needs {entry.variables[0]}, which this file lacks"
        )


@pytest.mark.parametrize(
    ("figure", "made"),
    [
        ("free_energy", phase_diagram),
        ("landscape", lambda: phase_diagram(temperatures=[200.0, 240.0])),
        ("indices", indices),
        ("fit", drawn),
        ("sweep", lambda: sweep(temperature=TEMPERATURES, spring_stiffness=[1e3, 3e3])),
    ],
)
def test_a_transposed_dataset_has_the_same_picture(figure, made):
    def pixels(ds: xr.Dataset) -> bytes:
        picture = io.BytesIO()
        draw(ds, None if figure == "sweep" else figure).savefig(picture)
        return picture.getvalue()

    ds = made()
    assert pixels(ds) == pixels(ds.transpose())


def test_a_figure_of_phases_says_that_its_dimension_is_lost():
    with pytest.raises(ValueError, match=r"needs the dimension temperature: keep it.*isel\("):
        draw(phase_diagram().isel(temperature=0), "free_energy")
