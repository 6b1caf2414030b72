"""The state of the model: one declaration for each of its variables.

These are the state (x, v, psi) in which motions begin and are reported. The adaptive method
integrates (x, u, psi) with u = V - v (`rhs.relative_state`), whose mirror images and weights are
the same.

A new variable is a line here and its rate in rhs.py; numerics, lanes and files take the number of
variables, their mirror images and their weights from this table.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from stickslip.options import ADIABATIC

State = tuple[float, ...]


class Component(NamedTuple):
    """A state variable.

    `unit` names the field of `scaling.Units` that it is measured in ("" where it is its own);
    `mirror` is its sign under the odd half-period symmetry; `weight` tells how its repetition is
    judged: ln(phi) repeats to a thousand tolerances, since it is slaved to the motion and swings
    by hundreds. Values below `floor` are judged as equal: a film without noise that has melted for
    good has an order parameter that sinks for ever, and means nothing any more. `follows` is the
    number of the variable that it is nearly equal to in the lanes, -1 for none: their difference
    is judged, and where an orbit is extrapolated it moves along.
    """

    name: str
    unit: str
    mirror: float
    weight: float
    floor: float
    follows: int = -1


STATE: tuple[Component, ...] = (
    Component("displacement", unit="length", mirror=-1.0, weight=1.0, floor=-math.inf),
    Component("velocity", unit="speed", mirror=-1.0, weight=1.0, floor=-math.inf),
    Component("log_order_parameter", unit="", mirror=1.0, weight=1e-3, floor=-300.0),
)

FILM = [component.name for component in STATE].index("log_order_parameter")
"""Index of ln(phi)."""

STRAIN = Component(
    "elastic_strain", unit="strain", mirror=-1.0, weight=1.0, floor=-math.inf, follows=1
)
"""The elastic strain, where it is a variable of its own."""


def components_of(strain: str) -> tuple[Component, ...]:
    """The state variables of a model of the strain, one of `options.STRAINS`."""
    return STATE if strain == ADIABATIC else (*STATE, STRAIN)
