"""The names on which scripts, configs and files rely, one per line with its details.

`PYTHONPATH=tests python -m support.public_names` prints the names of this version.
"""

from __future__ import annotations

import importlib
import inspect
import re
import sys
from collections.abc import Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import Any

import typer.main

from stickslip.variables import PARAMETERS, RESULTS, TRAJECTORY
from sweeps import StickslipAccessor
from sweeps.cli.app import app
from sweeps.config.json_schema import json_schema
from sweeps.config.load import from_mapping
from sweeps.exits import Exit
from sweeps.points import Point

API = Path(__file__).parents[2] / "docs" / "api.md"
GIVEN = (StickslipAccessor, Point)
"""Classes whose objects scripts use but do not make."""


def public_names() -> list[str]:
    """Return all names."""
    return [*_python(), *_commands(), *_config(), *_files()]


def _python() -> Iterator[str]:
    for name in re.findall(r"^\.\. auto\w+:: (\S+)$", API.read_text("utf-8"), re.MULTILINE):
        module, _, own = name.rpartition(".")
        yield from _callable(name, getattr(importlib.import_module(module), own))
    for kind in GIVEN:
        for name, method in inspect.getmembers(kind, callable):
            if not name.startswith("_"):
                yield from _callable(f"{kind.__name__}.{name}", method)


def _callable(name: str, found: Any) -> Iterator[str]:
    yield f"python: {name}"
    if isinstance(found, type) and issubclass(found, Enum):
        yield from (f"python: {name}.{member.name} = {member.value}" for member in found)
    elif found not in GIVEN and not (isinstance(found, type) and issubclass(found, Exception)):
        keywords = inspect.signature(found).parameters.keys() - {"self"}
        yield from (f"python: {name}({keyword}=)" for keyword in sorted(keywords))


def _commands() -> Iterator[str]:
    commands: Any = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    for name, command in commands.items():
        yield f"command: {name}"
        for parameter in command.params:
            flags = [flag for flag in parameter.opts if flag.startswith("-")]
            yield from (f"command: {name} {flag}" for flag in flags)
    yield from (f"exit code: {code.value} {code.name.lower()}" for code in Exit)


def _config() -> Iterator[str]:
    schema = json_schema()
    yield from _keys("config", schema)
    for name, part in schema["$defs"].items():
        yield from _keys(f"config: {name}", part)
    for path, value in _leaves(from_mapping({}).resolved()):
        if not path.startswith("model."):
            yield f"default: {path} = {value}"


def _keys(owner: str, schema: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of a section, and the named values of a key, from its schema."""
    for name, part in schema.get("properties", {}).items():
        yield f"{owner}: {name}"
        for choice in _choices(part):
            yield f"{owner}: {name}: {choice}"


def _choices(part: Any) -> Iterator[str]:
    if isinstance(part, Mapping):
        yield from map(str, part.get("enum", ()))
        yield from _choices(list(part.values()))
    elif isinstance(part, list):
        for each in part:
            yield from _choices(each)


def _leaves(settings: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def _files() -> Iterator[str]:
    for name, parameter in PARAMETERS.items():
        yield f"parameter: {name} {parameter.symbol} [{parameter.units}] {parameter.default!r}"
    for name, result in RESULTS.items():
        yield f"result: {name} [{result.units}] {result.dtype}"
    for name, sampled in TRAJECTORY.items():
        yield f"trajectory: {name} [{sampled.units}]"


if __name__ == "__main__":
    sys.stdout.write("\n".join([*public_names(), ""]))
