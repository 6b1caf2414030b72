"""The models, and the only place where a model is chosen.

A model is composed of a friction law, a strain that follows or relaxes, the typical path of the
noise or stochastic noise, and a motion of the upper block. Code that integrates, searches, measures
or writes takes components, equations, units and start from a `Model`, and ignores these choices.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import NamedTuple

import numpy as np

from stickslip.model import drive, noise, relaxing, scaling
from stickslip.model.laws import friction_law
from stickslip.model.rhs import FOLLOWING, Equations, StrainModel
from stickslip.model.scaling import Scaling, Units
from stickslip.model.state import Component, State
from stickslip.options import ADIABATIC, COSINE, RELAXING, Physics
from stickslip.parameters import Parameters, ParameterValues

_STRAINS: Mapping[str, StrainModel] = {
    ADIABATIC: FOLLOWING,
    RELAXING: relaxing.RELAXING,
}
"""The models of `options.STRAINS`."""


class Model(NamedTuple):
    """A model; its functions are inline and take parameters `p` in any units."""

    physics: Physics
    """The choice of each part."""

    components: tuple[Component, ...]
    """The state variables, in the order of the state."""

    equations: Equations

    scaling: Scaling
    """The nondimensional form."""

    write_reduced: Callable[[Parameters, np.ndarray], None]
    """(p, row): write the parameters in the units of the point, `scaling.Reduced`, into a row."""

    start: Callable[[Parameters], State]
    """(p): the state (x, v, ln(phi), ...) in which a motion begins."""

    state_units: Callable[[Units], State]
    """(units): the units of the components, from `scaling.Units`."""

    @property
    def width(self) -> int:
        """Number of state variables."""
        return len(self.components)

    def values(self, index: float | None, *, higher: bool) -> Callable[..., ParameterValues]:
        """Return the inline function from reduced parameters to the parameters of the equations."""
        one_tone = self.physics.drive == COSINE
        return scaling.model_values(index, higher=higher, one_tone=one_tone, scaling=self.scaling)


@cache
def model_of(physics: Physics) -> Model:
    """Return the model that combines these choices."""
    law, strain = friction_law(physics.friction), _STRAINS[physics.strain]
    upper = drive.UPPER[physics.drive]
    path = noise.no_path if physics.chance else noise.typical_path
    return Model(
        physics=physics,
        components=strain.components,
        equations=strain.make_equations(law, path, upper),
        scaling=strain.scaling,
        write_reduced=_reduction(physics.friction, physics.strain),
        start=strain.start,
        state_units=strain.state_units,
    )


@cache
def _reduction(friction: str, strain: str) -> Callable[[Parameters, np.ndarray], None]:
    return scaling.reduction(friction_law(friction), _STRAINS[strain].scaling)
