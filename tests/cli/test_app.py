"""The program as a whole: version, help, and real processes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
import typer.main
from support.sweeps.commands import Command

import stickslip
from sweeps.cli.app import app

HEAVY = {"numba", "numpy", "xarray", "netCDF4", "matplotlib", "joblib", "scipy", "dask", "ruamel"}

VERBS = tuple(typer.main.get_command(app).commands)


def test_version_and_help(command: Command) -> None:
    assert command("--version") == (0, f"stickslip {stickslip.__version__}\n", "")
    assert stickslip.__version__ == metadata.version("stickslip")
    code, out, err = command("--help")
    assert (code, err) == (0, "")
    assert all(f"\n  {verb} " in out for verb in VERBS)
    for verb in VERBS:
        code, long, err = command(verb, "--help")
        assert (code, err) == (0, "")
        assert f"Usage: stickslip {verb}" in long
        assert long == command(verb, "-h").out


@pytest.mark.parametrize("columns", [60, 160])
def test_help_has_whole_sentences_at_every_width(
    command: Command, monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    out = command("--help").out
    listed, width = " ".join(out.split()), max(map(len, out.splitlines()))
    assert min(columns, 130) - 30 < width <= columns
    for verb in VERBS:
        page = command(verb, "--help").out
        sentence = " ".join(page.partition("\n\n")[2].partition("\n\n")[0].split())
        assert sentence.endswith(".")
        assert f" {verb} {sentence}" in listed
        assert max(map(len, page.splitlines())) <= columns


# --- real processes ---


def modules_after(*arguments: str, **environment: str) -> set[str]:
    """What the command has imported in the end; it prints something."""
    code = (
        "import sys; from sweeps.cli import main; sys.argv = ['stickslip', *sys.argv[1:]]\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code\n"
        "sys.stderr.write(' '.join(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | environment,
    )
    assert done.stdout
    return set(done.stderr.split())


@pytest.mark.parametrize("arguments", [["--help"], ["sweep", "--help"], ["--version"], ["schema"]])
def test_help_and_schema_load_no_compiler_and_no_arrays(arguments: list[str]) -> None:
    loaded = modules_after(*arguments)
    assert "sweeps.cli.app" in loaded
    # pydantic is loaded by typer itself
    assert loaded.isdisjoint(HEAVY if arguments != ["schema"] else HEAVY - {"numpy", "ruamel"})


def test_completing_loads_no_more_than_help() -> None:
    line = {"COMP_WORDS": "stickslip\nsweep\n--", "COMP_CWORD": "2"}
    loaded = modules_after(_STICKSLIP_COMPLETE="complete_bash", **line)
    assert loaded.isdisjoint(HEAVY)


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
