"""The point that is shown, as text to copy: a config, and a command line."""

from __future__ import annotations

import shlex
from typing import Any

from sweeps.config.load import Config, from_mapping
from sweeps.config.yaml_writer import block_yaml
from sweeps.page.beginning import Opened, changed_parameters
from sweeps.page.ranges import exact_text

SECTIONS = ("integrator", "stationary", "noise", "film")
"""The sections that a point is computed by; the others say what is drawn."""


def config_text(opened: Opened, periods: int = 1) -> str:
    """A config of the point alone, for `stickslip sweep` and `simulate`."""
    config = opened.config
    written: dict[str, Any] = {
        "model": changed_parameters(config.parameters()),
        **changed_settings(config),
    }
    written["simulation"] = {"periods": periods, "start": "stationary"}
    return _remark(opened) + block_yaml(written)


def command_text(opened: Opened, periods: int = 1) -> str:
    """The command that computes the time courses over the orbit of the point."""
    changes = changes_text(opened) | {"simulation.start": "stationary"}
    words = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    return shlex.join(["stickslip", "simulate", *words, "--periods", str(periods)])


def changes_text(opened: Opened) -> dict[str, str]:
    """What makes the paper's point this one: keys and values as of `--set`."""
    changed = changed_parameters(opened.point.parameters)
    changes = {name: exact_text(value) for name, value in changed.items()}
    for section, keys in changed_settings(opened.config).items():
        changes |= {f"{section}.{key}": _text(value) for key, value in keys.items()}
    return changes


def changed_settings(config: Config) -> dict[str, dict[str, Any]]:
    """The keys of the sections that are not at their defaults."""
    default = from_mapping({})
    changed = {}
    for section in SECTIONS:
        usual, values = (getattr(one, section).used() for one in (default, config))
        changed[section] = {k: v for k, v in values.items() if usual.get(k, ...) != v}
    return {section: keys for section, keys in changed.items() if keys}


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return exact_text(value) if isinstance(value, float) else str(value)


def _remark(opened: Opened) -> str:
    """Return a remark that a config cannot express: that the orbit started from a neighbour's."""
    if not len(opened.point.before):
        return ""
    return (
        "# In the file this point starts from the orbit of its neighbour. From its own initial\n"
        "# values, as below, it may come to another orbit.\n"
    )
