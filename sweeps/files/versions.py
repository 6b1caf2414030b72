"""Files of other versions: what an older one lacks, and what only a newer one knows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from stickslip.variables import PARAMETERS, RESULTS
from sweeps.config.load import KEYS
from sweeps.config.parameter_space import PARAMETER_SECTIONS
from sweeps.config.schema import SECTIONS
from sweeps.files.columns import lacking
from sweeps.grid import CASE


def unknown_variables(names: Iterable[str]) -> list[str]:
    """The variables of a result file that this version does not know."""
    return [name for name in names if name not in {*RESULTS, *PARAMETERS, CASE}]


def unknown_keys(config: Mapping[str, Any]) -> list[str]:
    """The keys of a resolved config, as `integrator.rtol`, that this version does not know."""
    unknown = [key for key in config if key not in KEYS]
    known = {name: tuple(PARAMETERS) for name in PARAMETER_SECTIONS}
    known |= {name: tuple(section.model_fields) for name, section in SECTIONS.items()}
    for name, keys in known.items():
        part = config.get(name)
        if isinstance(part, Mapping):
            unknown += [f"{name}.{key}" for key in part if key not in keys]
    return unknown


def version_note(names: Iterable[str]) -> str:
    """What the variables of a result file tell of its version; empty for a file of this one."""
    names = list(names)
    if newer := unknown_variables(names):
        return f"written by a newer version: this one does not know {', '.join(newer)}"
    if older := lacking(names):
        return f"written by an older version: lacks {', '.join(older)}"
    return ""
