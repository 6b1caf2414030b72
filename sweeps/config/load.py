"""Read configs, strictly, from YAML or from a dict.

Nothing here computes physics; checks that do are passed to `load` as functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from stickslip.options import default_window
from sweeps.config.checks import judged
from sweeps.config.group import sound_parts
from sweeps.config.overrides import apply_overrides
from sweeps.config.pull import read_table
from sweeps.config.sample import read_fit
from sweeps.config.schema import KEYS, Config
from sweeps.config.written_config import ConfigError, Document, Problem, document_of, quoted
from sweeps.config.yaml_reader import read_file, read_text
from sweeps.paths import path_of

__all__ = ["KEYS", "Check", "Config", "ConfigError", "Problem", "from_mapping", "from_yaml", "load"]

# Takes an otherwise sound config, and yields the key and the message of each problem.
Check: TypeAlias = Callable[[Config], Iterable[tuple[str, str]]]


def load(
    path: str | Path, overrides: Sequence[str] = (), *, checks: Sequence[Check] = ()
) -> Config:
    """Return the config in a YAML file; the default output is `results/<stem of the file>.nc`.

    `overrides` are texts `KEY=VALUE` as for `--set`, see `sweeps.config.overrides`. `checks` look
    at an otherwise sound config, for example at its physics.

    Raises ConfigError with all problems at once.
    """
    path = path_of(path)
    return _config(read_file(path), overrides, checks, f"results/{path.stem}.nc", path.parent)


def from_mapping(
    mapping: Mapping[str, Any],
    source: str = "<dict>",
    overrides: Sequence[str] = (),
    *,
    checks: Sequence[Check] = (),
) -> Config:
    """Return the config in a dict with the keys of a file; see `load`.

    The default output is `results/sweep.nc`. Messages name `source` in place of the file.
    """
    return _config(document_of(mapping, source), overrides, checks)


def from_yaml(yaml: str, source: str = "<text>", overrides: Sequence[str] = ()) -> Config:
    """Return the config in a YAML text, such as the text in a result file; see `load`."""
    return _config(read_text(yaml, source), overrides)


def _config(
    document: Document,
    overrides: Sequence[str],
    checks: Sequence[Check] = (),
    output: str | None = None,
    folder: Path = Path(),
) -> Config:
    readable = isinstance(document.data, dict)
    if not readable:
        if document.data is not None or not document.problems:
            document.refuse(f"must consist of lines `key: value`, not {quoted(document.data)}")
        document.data = {}  # so that the overrides are checked all the same
    picked = apply_overrides(document, overrides)
    if not readable:
        document.raise_problems()
    read_table(document, folder)
    read_fit(document, folder)
    config = judged(document, *sound_parts(Config, document), picked)
    document.raise_problems()
    settled: dict[str, Any] = {}
    if "window" not in config.stationary.model_fields_set:
        window = default_window(config.noise.treatment)
        settled["stationary"] = config.stationary.model_copy(update={"window": window})
    if output and "output" not in config.model_fields_set:
        settled["output"] = output
    config = config.settled(map(str, document.warnings), **settled)
    for check in checks:
        for key, message in check(config):
            document.refuse(message, *key.split("."))
    document.raise_problems()
    return config
