"""The state of the model: one declaration for each of its variables.

These are the state (x, v, psi) in which motions begin and are reported. The adaptive method
integrates (x, u, psi) with u = V - v (`rhs.relative_state`), whose mirror images and weights are
the same.

A model declares which of them are its own (`models.py`); numerics, lanes and files take their
number, their mirror images and their weights from there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

State = tuple[float, ...]


class Component(NamedTuple):
    """A state variable.

    `mirror` is its sign under the odd half-period symmetry; `weight` tells how its repetition is
    judged: ln(phi) repeats to a thousand tolerances, since it is slaved to the motion and swings
    by hundreds. Values below `floor` are judged as equal: a film without noise that has melted for
    good has an order parameter that sinks for ever, and means nothing any more. `follows` is the
    number of the variable that it is nearly equal to in the lanes, -1 for none: their difference
    is judged, and where an orbit is extrapolated it moves along.
    """

    name: str
    symbol: str
    mirror: float
    weight: float
    floor: float
    follows: int = -1


STATE: tuple[Component, ...] = (
    Component("displacement", "x", mirror=-1.0, weight=1.0, floor=-math.inf),
    Component("velocity", "v", mirror=-1.0, weight=1.0, floor=-math.inf),
    Component("log_order_parameter", "ln phi", mirror=1.0, weight=1e-3, floor=-300.0),
)

FILM = [component.name for component in STATE].index("log_order_parameter")
"""Index of ln(phi)."""
