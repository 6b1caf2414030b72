"""What the site is made of: its menu, its tables, its gallery, and the check of its links.

The site itself is built by `make docs`, which fails on any warning and any broken link.
"""

from __future__ import annotations

import importlib
import re
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import typer.main

import stickslip
import sweeps
from sweeps.cli.app import app
from sweeps.config.load import load
from sweeps.executor_table import EXECUTORS

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GALLERY = (DOCS / "gallery.md").read_text("utf-8")
COMMANDS: Any = typer.main.get_command(app).commands  # type: ignore[attr-defined]


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """Modules that lie beside the pages."""
    monkeypatch.syspath_prepend(str(DOCS))
    return importlib.import_module


# --- menu ---


def test_every_page_is_listed_once(module: Callable[[str], ModuleType]) -> None:
    contents = module("contents")
    listed = [DOCS / "README.md"]
    for name in contents.LISTINGS:
        page = ROOT / f"{name}.md"
        menus = re.findall(r"\n\n([^`]*)\n```\n", contents.with_contents(page.read_text("utf-8")))
        entries = [entry for menu in menus for entry in menu.splitlines()]
        listed += [(page.parent / f"{entry}.md").resolve() for entry in entries]
    pages = {*ROOT.glob("*.md"), *DOCS.glob("*.md"), *DOCS.glob("*/*.md")}
    assert set(listed) == pages | {ROOT / "benchmarks" / "README.md"}, "a row in a README.md"
    assert len(listed) == len(set(listed))


# --- tables and functions ---


def test_the_page_of_functions_has_all_that_is_public() -> None:
    page = (DOCS / "api.md").read_text("utf-8")
    documented = set(re.findall(r"^\.\. auto\w+:: (\S+)$", page, re.MULTILINE))
    public = {f"{p.__name__}.{name}" for p in (stickslip, sweeps) for name in p.__all__}
    assert public - documented == set()


def test_every_table_that_a_page_asks_for_is_made(module: Callable[[str], ModuleType]) -> None:
    made_tables = module("made_tables")
    for page in DOCS.glob("*.md"):
        made = made_tables.with_made_tables(page.read_text("utf-8"))
        assert "<!-- made:" not in made, page


def test_the_commands_are_all_there_with_their_options(
    module: Callable[[str], ModuleType],
) -> None:
    page = (DOCS / "command-line.md").read_text("utf-8")
    made = module("made_tables").with_made_tables(page)
    sections = re.split(r"^## ", made, flags=re.MULTILINE)[1:]
    assert [section.split("\n")[0] for section in sections] == list(COMMANDS)
    for section, command in zip(sections, COMMANDS.values(), strict=True):
        options = [flag for parameter in command.params for flag in parameter.opts if "-" in flag]
        assert [flag for flag in options if flag not in section] == []
    names = "\\|".join(EXECUTORS)  # a bar would end the cell
    assert f"`--backend {names}`" in made
    assert "results/&lt;name of the config&gt;-trajectory.nc" in made  # no element of HTML


def test_the_readme_has_a_row_for_every_command() -> None:
    readme = (ROOT / "README.md").read_text("utf-8")
    rows = re.findall(r"^\| `stickslip (\w+)", readme, re.MULTILINE)
    assert sorted(rows) == sorted(COMMANDS)


# --- gallery ---


def test_the_gallery_has_pictures_of_every_kind(module: Callable[[str], ModuleType]) -> None:
    entries = module("gallery").entries(GALLERY)
    assert len(entries) >= 12
    assert len({entry.picture for entry in entries}) == len(entries)
    assert {f"fig{n}.png" for n in range(2, 10)} <= {entry.picture for entry in entries}


def test_each_picture_stands_with_the_config_that_it_is_made_of(
    module: Callable[[str], ModuleType],
) -> None:
    gallery = module("gallery")
    sections = re.split(r"^## ", gallery.with_configs(GALLERY), flags=re.MULTILINE)[1:]
    for entry, section in zip(gallery.entries(GALLERY), sections, strict=True):
        shown = re.findall(r"^```\{literalinclude\} (\S+)$", section, re.MULTILINE)
        assert shown or entry.configs, entry.title
        assert all((DOCS / name).is_file() for name in shown)


def test_the_commands_of_the_gallery_can_be_given(
    module: Callable[[str], ModuleType], tmp_path: Path
) -> None:
    for entry in module("gallery").entries(GALLERY):
        for name, text in entry.configs:
            (tmp_path / name).write_text(text)
        for command in entry.commands:
            program, verb, *arguments = shlex.split(command)
            assert program == "stickslip"
            given = COMMANDS[verb].make_context(verb, arguments).params
            if verb == "sweep":
                folder = ROOT if str(given["file"]).startswith("configs/") else tmp_path
                load(folder / given["file"], given["set_"] or [])


STUB = """#!/bin/sh
echo "$*" >> {runs}
case "$1" in
    sweep) mkdir -p results; cp "$2" results/data ;;
    plot) cp results/data "$3" ;;
    *) echo "no such verb" >&2; exit 2 ;;
esac
"""
"""A command line that notes what it was asked and draws a config by copying it."""


@pytest.fixture
def runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What the stub, which takes the place of the command line, was asked to do."""
    stub = tmp_path / "bin" / "stickslip"
    stub.parent.mkdir()
    stub.write_text(STUB.format(runs=tmp_path / "runs"))
    stub.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(stub.with_name("python")))
    return tmp_path / "runs"


def entry_of(gallery: ModuleType, config: str, *commands: str) -> Any:
    return gallery.Entry("A title", "mine.png", commands, (("own.yaml", config),))


def test_an_entry_is_run_once_and_in_part_when_part_of_it_changes(
    module: Callable[[str], ModuleType], tmp_path: Path, runs: Path
) -> None:
    gallery, made = module("gallery"), tmp_path / "made"
    sweep, plot, other_plot = "sweep own.yaml", "plot to mine.png", "plot to mine.png --log"
    asked = []
    for config, drawing in [("one", plot), ("one", plot), ("one", other_plot), ("two", plot)]:
        entry = entry_of(gallery, config, f"stickslip {sweep}", f"stickslip {drawing}")
        before = runs.read_text() if runs.exists() else ""
        said = gallery.make(entry, made)
        asked.append(runs.read_text().removeprefix(before).splitlines())
        assert (said == "kept") is (asked[-1] == [])
        assert (made / "mine.png").read_text() == config
    assert asked == [[sweep, plot], [], [other_plot], [sweep, plot]]


def test_data_of_another_numerics_version_are_not_kept(
    module: Callable[[str], ModuleType], monkeypatch: pytest.MonkeyPatch
) -> None:
    gallery = module("gallery")
    entry = entry_of(gallery, "", "stickslip sweep own.yaml")
    before = gallery.data_name(entry)
    monkeypatch.setattr("stickslip.kernels.version.NUMERICS_VERSION", 0)
    assert gallery.data_name(entry) != before


# --- links ---


def test_broken_links_are_found(module: Callable[[str], ModuleType], tmp_path: Path) -> None:
    check_links = module("check_links")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "a.html").write_text(
        '<p id="here"><a href="#here">1</a><a href="../b.html#there">2</a><a href="#gone">3</a>'
        '<img src="none.png"><a href="https://elsewhere.org/x#y">4</a><a href="mailto:me">5</a>'
    )
    (tmp_path / "b.html").write_text('<a name="there"></a><a href="docs/a.html?x=1#h%65re">6</a>')
    assert list(check_links.broken_links(tmp_path)) == [
        "docs/a.html: #gone: no such anchor",
        "docs/a.html: none.png: no such file",
    ]
    assert check_links.external_links(tmp_path) == {
        "https://elsewhere.org/x#y": "docs/a.html",
        "mailto:me": "docs/a.html",
    }
