"""Files of other versions: what an older one lacks, and what only a newer one knows."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from importlib import metadata
from typing import Any

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.config.load import KEYS
from sweeps.config.parameter_space import PARAMETER_SECTIONS
from sweeps.config.schema import SECTIONS
from sweeps.files.columns import lacking
from sweeps.grid import CASE, DIRECTION


def unknown_variables(names: Iterable[str]) -> list[str]:
    """The variables of a result file that this version does not know."""
    return [name for name in names if name not in {*RESULTS, *PARAMETERS, CASE, DIRECTION}]


def is_newer(attributes: Mapping[str, Any]) -> bool:
    """Whether a newer version wrote the file with these global attributes.

    A variable that this version does not know is then one of that version, else one of the user.
    """
    here = f"stickslip {metadata.version('stickslip')}"
    return int(attributes.get("numerics_version", 0)) > NUMERICS_VERSION or _release(
        attributes.get("source", "")
    ) > _release(here)


def _release(source: str) -> list[int]:
    """The numbers of a version, from a text that begins as `stickslip 0.1.0`."""
    found = re.match(r"stickslip (\d+(?:\.\d+)*)", source)
    return [int(number) for number in found[1].split(".")] if found else []


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


def version_note(names: Iterable[str], attributes: Mapping[str, Any]) -> str:
    """What the variables of a result file tell of its version; empty for a file of this one."""
    names = list(names)
    if (newer := unknown_variables(names)) and is_newer(attributes):
        return f"written by a newer version: this one does not know {', '.join(newer)}"
    if older := lacking(names):
        return f"written by an older version: lacks {', '.join(older)}"
    return ""
