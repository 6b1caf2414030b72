"""Boundary friction with a first-order phase transition: parameters in, orbits out.

The model of Lyashenko & Zaskoka (2013). A name is imported when it is first used, so that the
command line can answer `--help` without loading a compiler.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str

    from stickslip.derivatives import propagated, sensitivities
    from stickslip.indices import sensitivity_indices
    from stickslip.laws import LawError
    from stickslip.model.laws import FrictionLaw, register_law
    from stickslip.options import NoiseError, OptionError, Options
    from stickslip.orbit import Orbit, stationary_orbit
    from stickslip.parameters import ParameterError, Parameters
    from stickslip.phases import phase_diagram
    from stickslip.points import stationary_orbits
    from stickslip.regime import Regime
    from stickslip.status import IntegrationError, Status
    from stickslip.trajectory import simulate

_HOMES = {
    "FrictionLaw": "stickslip.model.laws",
    "IntegrationError": "stickslip.status",
    "LawError": "stickslip.laws",
    "NoiseError": "stickslip.options",
    "OptionError": "stickslip.options",
    "Options": "stickslip.options",
    "Orbit": "stickslip.orbit",
    "ParameterError": "stickslip.parameters",
    "Parameters": "stickslip.parameters",
    "Regime": "stickslip.regime",
    "Status": "stickslip.status",
    "phase_diagram": "stickslip.phases",
    "propagated": "stickslip.derivatives",
    "register_law": "stickslip.model.laws",
    "sensitivities": "stickslip.derivatives",
    "sensitivity_indices": "stickslip.indices",
    "simulate": "stickslip.trajectory",
    "stationary_orbit": "stickslip.orbit",
    "stationary_orbits": "stickslip.points",
}

__all__ = [
    "FrictionLaw",
    "IntegrationError",
    "LawError",
    "NoiseError",
    "OptionError",
    "Options",
    "Orbit",
    "ParameterError",
    "Parameters",
    "Regime",
    "Status",
    "phase_diagram",
    "propagated",
    "register_law",
    "sensitivities",
    "sensitivity_indices",
    "simulate",
    "stationary_orbit",
    "stationary_orbits",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("stickslip")
    if name not in _HOMES:
        raise AttributeError(f"module 'stickslip' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
