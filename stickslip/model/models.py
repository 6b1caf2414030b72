"""The models: the declaration of each, and the one place where a model is chosen.

A model is composed of parts: a law of friction, a strain that follows or relaxes, and the typical
path of the noise or stochastic noise. The code that integrates, searches, measures or writes asks a
`Model` for its components, equations, units and start, and never looks at the choices themselves.
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
    """The declaration of a model; functions are inline and take parameters `p` in any units."""

    physics: Physics
    """The choices of its parts."""

    components: tuple[Component, ...]
    """Its state variables, in the order of the state."""

    equations: Equations

    scaling: Scaling
    """Its nondimensional form."""

    write_reduced: Callable[[Parameters, np.ndarray], None]
    """(p, row): write the parameters in the point's own units, `scaling.Reduced`, into a row."""

    start: Callable[[Parameters], State]
    """(p): the state (x, v, ln(phi), ...) in which a motion begins."""

    state_units: Callable[[Units], State]
    """(units): the unit of each component, from `scaling.Units`."""

    @property
    def width(self) -> int:
        """Number of state variables."""
        return len(self.components)

    def values(self, index: float | None, *, higher: bool) -> Callable[..., ParameterValues]:
        """Return the inline function that turns reduced parameters into those of the equations."""
        one_tone = self.physics.drive == COSINE
        return scaling.model_values(index, higher=higher, one_tone=one_tone, scaling=self.scaling)


@cache
def model_of(physics: Physics) -> Model:
    """Return the model composed of these choices."""
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
