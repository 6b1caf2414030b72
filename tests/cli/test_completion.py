"""Shell completion: verbs and options by the program, names of files by the shell."""

from __future__ import annotations

import pytest
from support.sweeps.commands import Result, process


# The scripts are typer's; it finds out which shell it is called from, unless that is given.
def completed(line: str, shell: str, **more: str) -> Result:
    """What a shell is offered for the last word of a line when it asks as typer's script does."""
    words = line.split(" ")
    asked = {
        "_STICKSLIP_COMPLETE": f"complete_{shell}",
        "COMP_WORDS": "\n".join(words),
        "COMP_CWORD": str(len(words) - 1),
        "_TYPER_COMPLETE_ARGS": line,
    }
    return process(environment=asked | more)


def test_verbs_and_options_are_completed() -> None:
    assert completed("stickslip s", "bash").out.split() == [
        "sweep",
        "status",
        "simulate",
        "sensitivity",
        "schema",
    ]
    assert completed("stickslip sweep --over", "bash").out.split() == ["--overwrite"]
    assert "Compute the points of a config" in completed("stickslip sw", "zsh").out
    fish = completed("stickslip sw", "fish", _TYPER_COMPLETE_FISH_ACTION="get-args")
    assert fish.out.startswith("sweep\tCompute the points of a config")


@pytest.mark.parametrize("line", ["stickslip sweep con", "stickslip plot ", "stickslip sweep -o "])
def test_names_of_files_are_left_to_the_shell(line: str) -> None:
    assert completed(line, "bash").out.strip() == ""
    assert completed(line, "zsh").out == "_files\n"
    fish = completed(line, "fish", _TYPER_COMPLETE_FISH_ACTION="is-args")
    assert (fish.code, fish.out) == (1, "")
