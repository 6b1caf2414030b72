"""Settings of matplotlib while a picture is drawn: the house style, and style files."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import pytest
from support.pictures import TEMPERATURES, curves, panels, sweep

from sweeps.figures import Look, PlotOptions, draw, save


def test_settings_are_restored(tmp_path):
    style = tmp_path / "large.mplstyle"
    style.write_text("font.size: 12\naxes.grid: True\n")
    before = dict(mpl.rcParams)
    ds, look = sweep(temperature=TEMPERATURES), Look(style=style)
    save(draw(ds, None, PlotOptions(look=look)), tmp_path / "a", look)
    with pytest.raises(ValueError, match="unknown variable"):
        draw(ds, None, PlotOptions(variable="x", look=look))
    assert dict(mpl.rcParams) == before


def test_a_style_file_changes_fonts_and_colours(tmp_path):
    style = tmp_path / "large.mplstyle"
    style.write_text("# mine\nfont.size: 12  # points\naxes.prop_cycle: cycler(color=['red'])\n")
    ds = sweep(temperature=TEMPERATURES, rheological_index=[-0.5, 0.0])
    usual, large = (
        panels(draw(ds, None, PlotOptions(look=Look(style=s))))[0] for s in (None, style)
    )
    assert usual.yaxis.label.get_size() == 8.0
    assert large.yaxis.label.get_size() == 12.0
    assert {line.get_color() for line in curves(large)} == {"red"}


def test_a_style_of_matplotlib_goes_by_its_name():
    ds = sweep(temperature=TEMPERATURES)
    (axes, _) = panels(draw(ds, None, PlotOptions(look=Look(style=Path("ggplot")))))
    assert axes.get_facecolor() == mpl.colors.to_rgba("#E5E5E5")
    with pytest.raises(ValueError, match=r"ggplo does not exist, nor .*did you mean 'ggplot'"):
        draw(ds, None, PlotOptions(look=Look(style=Path("ggplo"))))


def test_settings_of_the_user_do_not_change_the_picture(tmp_path, monkeypatch):
    ds = sweep(temperature=TEMPERATURES)
    (usual,) = save(draw(ds), tmp_path / "a.png")
    monkeypatch.setitem(mpl.rcParams, "font.size", 20.0)
    monkeypatch.setitem(mpl.rcParams, "axes.grid", True)
    (again,) = save(draw(ds), tmp_path / "b.png")
    assert again.read_bytes() == usual.read_bytes()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "large.mplstyle does not exist"),
        (
            "font.sise: 9\n",
            r"line 1 does not name a matplotlib setting \(did you mean 'font.size'\?\)",
        ),
        ("font.size: 9\nhello\n", "line 2 does not name a matplotlib setting"),
        ("font.size: big and bold\n", "is not a matplotlib style file"),
    ],
)
def test_a_bad_style_file_is_refused(tmp_path, text, words):
    style = tmp_path / "large.mplstyle"
    if text is not None:
        style.write_text(text)
    with pytest.raises(ValueError, match=words):
        draw(sweep(temperature=TEMPERATURES), None, PlotOptions(look=Look(style=style)))


def test_a_style_does_not_set_windows_and_toolbars(tmp_path):
    style = tmp_path / "mine.mplstyle"
    style.write_text("backend: TkAgg\ninteractive: True\nfont.size: 9\n")
    draw(sweep(temperature=TEMPERATURES), None, PlotOptions(look=Look(style=style)))
    assert not mpl.rcParams["interactive"]
