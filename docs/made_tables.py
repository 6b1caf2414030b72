"""Tables that are made when the site is built: commands, and the contents of registries.

A page has them between `<!-- made: NAME -->` and `<!-- end of made -->`; what stands there is for
those who read the page without the site.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from enum import IntEnum
from html import escape
from typing import Any

from configuration import table

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PHASES, RESULTS, TRAJECTORY, Variable

_PLACE = re.compile(r"<!-- made: (\w+) -->\n.*?<!-- end of made -->", re.DOTALL)


def with_made_tables(page: str) -> str:
    """Return the page with each of its tables filled in."""
    return _PLACE.sub(lambda place: _MAKERS[place[1]](), page)


def _commands() -> str:
    """Return usage, help, arguments and options of every command, as in `--help`."""
    import typer.main

    from sweeps.cli.app import app

    group: Any = typer.main.get_command(app)
    return "\n\n".join(_command(name, command) for name, command in group.commands.items())


def _command(name: str, command: Any) -> str:
    context = command.context_class(command, info_name=f"stickslip {name}")
    usage = command.get_usage(context).removeprefix("Usage: ")
    records = [parameter.get_help_record(context) for parameter in command.get_params(context)]
    rows = [(f"`{_cell(first)}`", _cell(_plain(does))) for first, does in filter(None, records)]
    options = table("| argument or option | does |", rows)
    return f"## {name}\n\n```text\n{usage}\n```\n\n{_plain(command.help or '')}\n\n{options}"


def _plain(text: str) -> str:
    """Return a text that is not interpreted as HTML."""
    return escape(text, quote=False)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _variables(registry: Mapping[str, Variable]) -> str:
    rows = ((f"`{v.name}`", f"${v.tex}$", v.unit, _cell(_meaning(v))) for v in registry.values())
    return table("| name | symbol | unit | meaning |", rows)


def _meaning(variable: Variable) -> str:
    return "; ".join(filter(None, [variable.meaning, variable.comment]))


def _codes(kinds: Iterable[IntEnum]) -> str:
    rows = ((str(kind.value), f"`{kind.name.lower()}`", _cell(kind.sentence)) for kind in kinds)  # type: ignore[attr-defined]
    return table("| value | name | meaning |", rows)


_MAKERS = {
    "commands": _commands,
    "results": lambda: _variables(RESULTS),
    "trajectory": lambda: _variables(TRAJECTORY),
    "phases": lambda: _variables(PHASES),
    "statuses": lambda: _codes(Status),
    "regimes": lambda: _codes(Regime),
}
