"""Phases of a film at rest or under a strain, with the curves of the paper's Fig. 2."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.datasets import parameter_scalars
from stickslip.model import film, solids
from stickslip.parameters import Parameters, given_or_default
from stickslip.variables import PARAMETERS, PHASES

if TYPE_CHECKING:
    import xarray as xr

PAPER_TEMPERATURES = (265.0, 286.0, 310.0)
PAPER_STRAIN = 2.1e-6
"""The temperatures [K] and the elastic strain of Fig. 2."""

_BEYOND = 1.15  # the largest order parameter of the diagram, relative to that of the solid
_RAMP = 1.05  # the largest strain of the slow ramp, relative to the melting strain
_FINER = 8  # the ramp has this many times as many samples, because its jumps are steep

_ROUNDING = 1e-12

# The order parameter that noise maintains in a liquid film, from which the film freezes.
_SEED = 1e-9

DIRECTIONS = ("rising", "falling")
"""Directions of a slow ramp of the strain."""


def phase_diagram(
    parameters: Parameters | None = None,
    *,
    temperatures: Sequence[float] = PAPER_TEMPERATURES,
    strain: float = PAPER_STRAIN,
    samples: int = 601,
) -> xr.Dataset:
    """Return the free energy of a film, and where the film melts and solidifies.

    >>> ds = phase_diagram(temperatures=[265, 310])
    >>> ds.melting_strain.values  # a film above T_c0 melts without strain
    array([3.9704793e-06, 0.0000000e+00])

    Parameters
    ----------
    parameters
        The model's parameters; the paper's by default. Their temperature affects only the range of
        strains.
    temperatures
        Temperatures [K] of the film.
    strain
        Elastic strain at which the free energy is given.
    samples
        Number of order parameters, and of strains.

    Returns
    -------
    xarray.Dataset
        `free_energy` (temperature, order_parameter) by Eq. 12 at the strain `applied_strain`, a
        scalar coordinate; `melting_strain` and `solidification_strain` (temperature,), Eqs. 19 and
        20; `melting_temperature` and `solidification_temperature` (elastic_strain,), Eqs. 17 and
        18. Between melting and solidification the film keeps its phase; elsewhere only one phase
        exists. `equilibrium_strain` (temperature, order_parameter) is the strain under which a film
        with this order parameter is stationary, NaN if there is none; `equilibrium_stability` is 1
        if the film is stable there, else 0. `ramped_order_parameter` (temperature, ramp_direction,
        ramped_strain) follows the film while the strain slowly rises, then falls again.

    Raises
    ------
    ValueError
        There is no temperature, or fewer than two samples. ParameterError if a temperature is out
        of range.
    """
    import xarray as xr

    if not len(temperatures) or samples < 2:
        raise ValueError("a phase diagram needs a temperature and at least two samples")
    p = given_or_default(parameters)
    films = [p._replace(temperature=T) for T in temperatures]
    rest = [solids.largest_order_parameter(at) for at in films]
    phi = np.linspace(0.0, _BEYOND * max(rest), samples)
    for at_rest in rest:  # a sample at each, so that equilibria begin at zero strain
        phi[np.abs(phi - at_rest).argmin()] = at_rest
    eps = np.linspace(0.0, solids.melting_strain(p), samples)
    last = _RAMP * max(map(solids.melting_strain, films))
    ramp = np.linspace(0.0, last, _FINER * (samples - 1) + 1)
    landscape = ("temperature", "order_parameter")
    data: dict[str, tuple[Any, Any]] = {
        "free_energy": (
            landscape,
            [[film.free_energy(at, x, strain) for x in phi] for at in films],
        ),
        "melting_strain": ("temperature", [solids.melting_strain(at) for at in films]),
        "solidification_strain": (
            "temperature",
            [solids.solidification_strain(at) for at in films],
        ),
        "melting_temperature": ("elastic_strain", [solids.melting_temperature(p, e) for e in eps]),
        "solidification_temperature": (
            "elastic_strain",
            [solids.solidification_temperature(p, e) for e in eps],
        ),
        "equilibrium_strain": (
            landscape,
            [[_equilibrium_strain(at, x) for x in phi] for at in films],
        ),
        # A stationary film is stable if it returns after a disturbance.
        "equilibrium_stability": (
            landscape,
            np.array([[film.log_force_slope(at, x) > 0.0 for x in phi] for at in films], np.int8),
        ),
        "ramped_order_parameter": (
            ("temperature", "ramp_direction", "ramped_strain"),
            [_ramped(at, ramp) for at in films],
        ),
    }
    axes = {
        "order_parameter": phi,
        "elastic_strain": eps,
        "ramped_strain": ramp,
        "ramp_direction": list(DIRECTIONS),
    }
    coords: dict[str, Any] = {
        name: (name, values, PHASES[name].attributes) for name, values in axes.items()
    }
    coords["applied_strain"] = ((), strain, PHASES["elastic_strain"].attributes)
    coords |= parameter_scalars(p._asdict())
    coords["temperature"] = (
        "temperature", list(temperatures), PARAMETERS["temperature"].attributes
    )  # fmt: skip
    variables = {name: (*values, PHASES[name].attributes) for name, values in data.items()}
    return xr.Dataset(variables, coords)


def _equilibrium_strain(p: Parameters, phi: float) -> float:
    """Return the strain under which a film with order parameter `phi` is stationary, or NaN."""
    if p.elastic_coefficient <= 0.0 or phi <= 0.0:
        return math.nan
    B, heating = solids.balance(p, phi), film.heating(p)
    if heating - _ROUNDING * (abs(B) + abs(heating)) > B:
        return math.nan
    return math.sqrt(max(B - heating, 0.0) / p.elastic_coefficient)


def _ramped(p: Parameters, strains: np.ndarray) -> np.ndarray:
    """Return the order parameters (2, n) of a film while the strain slowly rises, then falls."""
    phi, followed = solids.largest_order_parameter(p), np.empty((2, len(strains)))
    for row, order in enumerate((strains, strains[::-1])):
        for i, eps in enumerate(order):
            B = film.melting_function(p, float(eps))
            phi = solids.next_phase(p, max(phi, _SEED), B)
            followed[row, i] = phi
    followed[1] = followed[1, ::-1]
    return followed
