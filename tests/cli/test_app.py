"""The program as a whole: version, help, and real processes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import warnings
from importlib import metadata
from pathlib import Path

import pytest
import typer.main
from support import messages
from support.sweeps.commands import Command, process
from support.sweeps.processes import default_signals

import stickslip
from sweeps.cli.app import app, plain_warnings

ROOT = Path(stickslip.__file__).parents[1]

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
    """The modules that a command has imported when it ends; it must print something."""
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


def test_completion_loads_no_more_than_help() -> None:
    line = {"COMP_WORDS": "stickslip\nsweep\n--", "COMP_CWORD": "2"}
    loaded = modules_after(_STICKSLIP_COMPLETE="complete_bash", **line)
    assert loaded.isdisjoint(HEAVY)


def test_the_installed_command_is_this_one(tmp_path: Path) -> None:
    script = shutil.which("stickslip", path=str(Path(sys.executable).parent))
    if script is None:
        pytest.skip("the command is not installed beside this Python")
    done = subprocess.run([script, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"stickslip {metadata.version('stickslip')}\n"


def test_a_closed_pipe_is_no_error(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sweeps.cli", "schema"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as child:
        child.stdout.close()
        assert child.stderr.read() == b""


# --- Ctrl-C while the command loads, and warnings of Python ---

INTERRUPTED = """
import os, signal, sys
{before}
class AtTyper:
    def find_spec(self, name, *_):
        if name == "typer":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, AtTyper())
from sweeps.cli import main
sys.argv = ["stickslip", "--version"]
main()
"""


@pytest.mark.parametrize(
    ("before", "code", "err"),
    [
        ("", 130, "Interrupted; nothing was begun.\n"),
        ("signal.signal(signal.SIGINT, signal.SIG_IGN)", 0, ""),  # as of a job in the background
    ],
)
def test_an_interruption_while_loading_prints_one_line(before: str, code: int, err: str) -> None:
    program = INTERRUPTED.format(before=before)
    with default_signals():
        done = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=False
        )
    assert (done.returncode, done.stderr) == (code, err)


def test_the_package_loads_without_slow_modules() -> None:
    """Until it is loaded, Ctrl-C prints a traceback."""
    code = "import sys; before = {*sys.modules}; import sweeps.cli; print(*{*sys.modules} - before)"
    alone = [sys.executable, "-S", "-c", f"import sys; sys.path.append({str(ROOT)!r}); {code}"]
    loaded = subprocess.run(alone, capture_output=True, text=True, check=True).stdout.split()
    assert {"sweeps", "sweeps.cli"} <= set(loaded)
    assert not {"typing", "re", "typer"} & set(loaded)


@pytest.mark.usefixtures("command")
def test_warnings_of_python_are_sentences_without_a_place_in_code() -> None:
    done = process("check", "a.yaml", environment={"NUMBA_CACHE_DIR": "/dev/null/nowhere"})
    assert done.code == 0
    assert done.err.startswith(f"warning: {messages.NOT_CACHED}")
    assert done.err.count("\n") == 1


def test_a_warning_is_printed_once(capsys: pytest.CaptureFixture[str]) -> None:
    with plain_warnings():
        warnings.simplefilter("always")
        for _ in range(2):
            warnings.warn("one\n  thing\x07", stacklevel=1)
    assert capsys.readouterr().err == "warning: one thing\\x07\n"
