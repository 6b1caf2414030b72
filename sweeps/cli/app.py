"""The command line: `stickslip VERB`.

Slow imports are inside the commands, so that `--help` answers at once. The exit codes are in
`sweeps.exits`.
"""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import wraps
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, Any

import typer
import typer.main
from typer.core import TyperGroup

from sweeps.cli.fit import fit
from sweeps.cli.pages import explore, report
from sweeps.cli.pictures import figure, plot, replay, simulate
from sweeps.cli.result_files import boundary, cite, export, info
from sweeps.cli.shared import discard, stop_with, usage_errors
from sweeps.cli.sweeps import check, merge, new, plan, schema, sensitivity, status, sweep
from sweeps.exits import EXPECTED, Exit, code_of
from sweeps.human import Messages, printable
from sweeps.paths import path_of

_SWEEPS = (new, sweep, plan, status, check)
_MOTIONS = (simulate, replay, boundary, fit, sensitivity, explore)
_FILES = (figure, plot, report, export, merge, schema, info, cite)
_VERBS = {verb.__name__: verb for verb in (*_SWEEPS, *_MOTIONS, *_FILES)}


class _Commands(Mapping[str, Any]):
    """The commands by verb, made on demand: `--help` needs none of them."""

    def __getitem__(self, name: str) -> Any:
        """Return the command of a verb; raises KeyError for an unknown verb."""
        verb, alone = _VERBS[name], typer.Typer(add_completion=False, rich_markup_mode=None)
        alone.command(name, short_help=_sentence(verb))(_with_paths(verb))
        return typer.main.get_command(alone)

    def __iter__(self) -> Iterator[str]:
        return iter(_VERBS)

    def __len__(self) -> int:
        return len(_VERBS)


def _with_paths(verb: Callable[..., None]) -> Callable[..., None]:
    """Return a verb that expands `~` and `$NAME` in paths, as a config does."""

    @wraps(verb)
    def with_paths(**arguments: Any) -> None:
        verb(**{name: _expanded(value) for name, value in arguments.items()})

    return with_paths


def _expanded(value: Any) -> Any:
    if isinstance(value, list):
        return [_expanded(each) for each in value]
    with usage_errors():
        return path_of(value) if isinstance(value, Path) else value


class _Program(TyperGroup):
    """The program; its help lists the verbs with the first sentence of their help texts."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes | {"commands": _Commands()})

    def format_commands(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002 - its shape
        """Write the list of verbs."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, _sentence(verb)) for name, verb in _VERBS.items()])


def _sentence(verb: Callable[..., None]) -> str:
    """Return the first sentence of a verb's help, which typer's own list would cut at one line."""
    return (verb.__doc__ or "").partition("\n\n")[0]


app = typer.Typer(
    name="stickslip",
    cls=_Program,
    help="Boundary friction with a first-order phase transition: orbits, sweeps, figures.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={
        "help_option_names": ["-h", "--help"],
        "max_content_width": 160,  # longer lines are hard to read
    },
)


def main() -> None:
    """Run the command line; every failure ends in one message and an exit code."""
    with lasting_streams(), plain_warnings():
        _run()


def _run() -> None:
    logging.basicConfig(format="%(levelname)s: %(message)s", stream=sys.stderr)
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        stop_with(
            "NUMBA_DISABLE_JIT is set, but the kernels only run as compiled code: unset it",
            Exit.USAGE,
        )
    _refuse_odd_names()
    os.environ["MPLBACKEND"] = "agg"  # no window; an unknown backend would make the import fail
    try:
        app(prog_name="stickslip")
    except SystemExit as end:
        if end.code == Exit.INTERRUPTED:  # typer's silent answer to Ctrl-C
            print("Interrupted; only files named above were kept.", file=sys.stderr)
        raise
    except KeyboardInterrupt:  # outside the code that typer guards
        stop_with("Interrupted; only files named above were kept.", Exit.INTERRUPTED)
    except EXPECTED as error:
        stop_with(str(error), code_of(error))
    except BrokenPipeError:
        discard(sys.stdout)  # nobody reads our output any more: end quietly
        sys.exit(Exit.DONE)
    except OSError as error:  # such as a full disk under standard output
        stop_with(f"Input/output error: {error}", Exit.STORAGE)
    except MemoryError:
        stop_with("Out of memory; a smaller grid or fewer samples may fit.", Exit.UNEXPECTED)
    except Exception as error:  # the last resort: one line; --verbose logs the traceback
        logging.getLogger(__name__).debug("unexpected", exc_info=True)
        stop_with(f"Unexpected {type(error).__name__}: {error}", Exit.UNEXPECTED)


def _refuse_odd_names() -> None:
    """End the command if a file name is not UTF-8, which neither NetCDF nor YAML can hold."""
    for argument in sys.argv[1:]:
        try:
            argument.encode()
        except UnicodeEncodeError:
            stop_with(
                f"{argument}: names must be UTF-8, but this one is not; rename it", Exit.USAGE
            )


@app.callback(invoke_without_command=True)
def _version(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", help="Log details and tracebacks.")] = False,
) -> None:
    if verbose:
        logging.getLogger().setLevel(logging.DEBUG)
        for noisy in ("numba", "matplotlib"):
            logging.getLogger(noisy).setLevel(logging.WARNING)
    if version:
        from importlib import metadata

        print(f"stickslip {metadata.version('stickslip')}")
        raise typer.Exit


# --- the standard streams; losing them never affects a computation ---


@contextlib.contextmanager
def lasting_streams() -> Iterator[None]:
    """Provide the three standard streams for the duration of a command.

    A closed stream is opened on the null device: otherwise the next file to be opened would take
    its number, and messages would be written into that file. Messages that cannot be written are
    lost.
    """
    for number in (0, 1, 2):
        _open_if_closed(number)
    sys.stdin = sys.stdin or os.fdopen(0)
    sys.stdout = sys.stdout or os.fdopen(1, "w")
    stderr = sys.stderr or os.fdopen(2, "w")
    if isinstance(sys.stdout, TextIOWrapper):  # file names need not be valid text
        sys.stdout.reconfigure(errors="backslashreplace")
    sys.stderr = Messages(stderr)
    try:
        yield
    finally:
        sys.stderr.flush()
        sys.stderr = stderr


@contextlib.contextmanager
def plain_warnings() -> Iterator[None]:
    """Print each of Python's warnings once, as a sentence, without file and line."""
    printed: set[str] = set()

    def show(message: Warning | str, *_: object) -> None:
        text = " ".join(str(message).split())
        if text not in printed:
            printed.add(text)
            print(printable(f"warning: {text}"), file=sys.stderr)

    with warnings.catch_warnings():
        warnings.showwarning = show  # type: ignore[assignment] # it is called by position
        yield


def _open_if_closed(number: int) -> None:
    """Open a closed standard stream on the null device."""
    try:
        os.fstat(number)
    except OSError:
        null = os.open(os.devnull, os.O_RDWR)
        if null != number:
            os.dup2(null, number)
            os.close(null)
