"""The state variables of the models, each declared once.

Motions begin and are reported in the state (x, v, psi). The adaptive method integrates (x, u, psi)
with u = V - v (`rhs.relative_state`), which has the same mirror images and weights.

A model declares its variables (`models.py`); numerics, lanes and files take their number, mirror
images and weights from there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

State = tuple[float, ...]


class Component(NamedTuple):
    """A state variable.

    `mirror` is its sign under the odd half-period symmetry. `weight` applies to its differences in
    the test of repetition: ln(phi) need only repeat to within a thousand tolerances, because it is
    slaved to the motion and swings by hundreds. Values below `floor` count as equal: without noise
    the order parameter of a film that never freezes again sinks forever and becomes meaningless.
    `follows` is the index of the variable that it nearly equals in the lanes, or -1: the difference
    of the two is tested, and an extrapolation moves them together.
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
