"""What becomes of parameters that are added to the registry, in a copy of the package."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from stickslip.parameters import Parameters
from support.package import copy_of_package, run_python

UNITS = (
    "1",
    "K",
    "kg",
    "N",
    "N m-1",
    "N s m-1",
    "Pa",
    "Pa s",
    "J m-3",
    "s-1",
    "rad s-1",
    "m s-1",
    "m",
    "s",
)
"""Units of parameters that need no scaling of their own."""

VALUE = 3.0  # of each extra parameter, in its unit

_DECLARATION = """
PARAMETERS = MappingProxyType(PARAMETERS | {{
    f"extra_{{i}}": ParameterVariable(
        f"extra_{{i}}", f"e_{{i}}", f"e_{{i}}", unit, "extra", default={value}
    )
    for i, unit in enumerate({units!r})
}})
"""

_SCRIPT = """
import json, sys
sys.path.append({tests!r})
from stickslip.parameters import Parameters
{imports}
p = Parameters({arguments})
print(json.dumps([float(getattr({expression}, f"extra_{{i}}")) for i in range({count})]))
"""


def extra_values(
    folder: Path,
    imports: str,
    expression: str,
    p: Parameters,
    units: tuple[str, ...] = UNITS,
) -> Mapping[str, float]:
    """unit -> the extra parameter of that unit in the tuple that `expression` makes of `p`."""
    package = copy_of_package(folder)
    registry = package / "variables.py"
    added = _DECLARATION.format(units=units, value=VALUE)
    registry.write_text(registry.read_text() + added)
    arguments = ", ".join(f"{name}={value!r}" for name, value in p._asdict().items())
    script = _SCRIPT.format(
        tests=str(Path(__file__).parents[1]),
        imports=imports,
        arguments=arguments,
        expression=expression,
        count=len(units),
    )
    out, _ = run_python(script, folder / "cache", package)
    return dict(zip(units, json.loads(out), strict=True))
