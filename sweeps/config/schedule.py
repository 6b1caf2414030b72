"""`simulation.schedule`: the parameters that change along one run, read and judged like axes."""

from __future__ import annotations

from stickslip.variables import STARTING
from sweeps.config.axes import parse_axis
from sweeps.config.diagnostics import Located, located
from sweeps.config.parameter_space import (
    ParameterSpace,
    given_parameters,
    unequal_lengths,
    valid_values,
)


def settle_schedule(root: Located, space: ParameterSpace) -> None:
    """Put the values of a schedule, by full names, in the place of what was written.

    What is refused is noted and left out.
    """
    simulation = root.value.get("simulation")
    node = simulation.children().get("schedule") if simulation else None
    if node is None or node.value is None:
        return
    settled = {}
    for name, child in given_parameters(node):
        axis = parse_axis(child)
        values = valid_values(name, child, axis.values()) if axis else ()
        if name in settled or name in space.sweep or name in space.cases:
            child.refuse(f"gives {name} a second time; keep one of the two")
        elif name in STARTING:
            child.refuse("cannot be scheduled: a run begins once")
        elif name in space.model:
            child.warn("counts for this run; the value under `model` is that of a sweep")
        settled[name] = list(values)
    if unequal := unequal_lengths("scheduled", {n: len(v) for n, v in settled.items() if v}):
        node.refuse(unequal)
    simulation.value["schedule"] = located(settled or None, node.source, node.diagnostics, node.key)
