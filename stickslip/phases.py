"""Phases of a film at rest or under a strain: the curves of the paper's Fig. 2, and more."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stickslip.model import film, solids
from stickslip.parameters import Parameters, given_or_default
from stickslip.variables import PARAMETERS, PHASES

if TYPE_CHECKING:
    import xarray as xr

PAPER_TEMPERATURES = (265.0, 286.0, 310.0)
PAPER_STRAIN = 2.1e-6
"""Those of Fig. 2."""

_BEYOND = 1.15  # largest order parameter shown, relative to that of the solid
_RAMP = 1.05  # largest strain of the slow ramp, relative to the melting strain
_FINER = 8  # times as many samples along the ramp, whose jumps are steep

_ROUNDING = 1e-12

# Order parameter that noise maintains in a liquid film: the seed from which it freezes.
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
    """Return the free energy of a film at some temperatures, and where it melts and solidifies.

    >>> ds = phase_diagram(temperatures=[265, 310])
    >>> ds.melting_strain.values  # a film above T_c0 melts by itself
    array([3.9704793e-06, 0.0000000e+00])

    Parameters
    ----------
    parameters
        The model's parameters; the paper's by default. Their temperature only sets the range of
        strains.
    temperatures
        Temperatures [K] of the free energy.
    strain
        Elastic strain of the free energy.
    samples
        Number of order parameters, and of strains.

    Returns
    -------
    xarray.Dataset
        `free_energy` (temperature, order_parameter) by Eq. 12 under the scalar coordinate
        `applied_strain`; `melting_strain` and `solidification_strain` (temperature,), Eqs. 19 and
        20; `melting_temperature` and `solidification_temperature` (elastic_strain,), Eqs. 17 and
        18. Between the two the film keeps the phase that it had; elsewhere there is only one.
        `equilibrium_strain` (temperature, order_parameter) is the strain under which a film with
        that order parameter is stationary, NaN where there is none, and `equilibrium_stability`
        tells whether it is stable there; `ramped_order_parameter` (temperature, ramp_direction,
        ramped_strain) follows the film while the strain slowly rises and falls again.

    Raises
    ------
    ValueError
        No temperature, or fewer than two samples; ParameterError if a temperature is out of range.
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
    along: dict[str, tuple[str, list[float]]] = {
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
    }
    last = _RAMP * max(map(solids.melting_strain, films))
    ramp = np.linspace(0.0, last, _FINER * (samples - 1) + 1)
    energy = [[film.free_energy(at, x, strain) for x in phi] for at in films]
    data = {
        "free_energy": (("temperature", "order_parameter"), energy, _of("free_energy")),
        **{name: (*values, _of(name)) for name, values in along.items()},
        "equilibrium_strain": (
            ("temperature", "order_parameter"),
            [[_equilibrium_strain(at, x) for x in phi] for at in films],
            _of("equilibrium_strain"),
        ),
        "equilibrium_stability": (
            ("temperature", "order_parameter"),
            np.array([[_is_stable(at, x) for x in phi] for at in films], dtype=np.int8),
            _of("equilibrium_stability"),
        ),
        "ramped_order_parameter": (
            ("temperature", "ramp_direction", "ramped_strain"),
            [_ramped(at, ramp) for at in films],
            _of("ramped_order_parameter"),
        ),
    }
    coords = {
        "order_parameter": ("order_parameter", phi, _of("order_parameter")),
        "elastic_strain": ("elastic_strain", eps, _of("elastic_strain")),
        "ramped_strain": ("ramped_strain", ramp, _of("ramped_strain")),
        "ramp_direction": ("ramp_direction", list(DIRECTIONS), _of("ramp_direction")),
        "applied_strain": ((), strain, _of("elastic_strain")),
        **{name: ((), v, PARAMETERS[name].attributes) for name, v in p._asdict().items()},
        "temperature": ("temperature", list(temperatures), PARAMETERS["temperature"].attributes),
    }
    return xr.Dataset(data, coords)


def _equilibrium_strain(p: Parameters, phi: float) -> float:
    """The strain under which a film with order parameter `phi` is stationary; NaN if none is."""
    if p.elastic_coefficient <= 0.0 or phi <= 0.0:
        return math.nan
    B, heating = solids.balance(p, phi), film.heating(p)
    if heating - _ROUNDING * (abs(B) + abs(heating)) > B:
        return math.nan
    return math.sqrt(max(B - heating, 0.0) / p.elastic_coefficient)


def _is_stable(p: Parameters, phi: float) -> bool:
    """Tell whether a film that is stationary at `phi` returns there after a disturbance."""
    return bool(film.log_force_slope(p, phi) > 0.0)


def _ramped(p: Parameters, strains: np.ndarray) -> np.ndarray:
    """Order parameters (2, n) of a film while the strain slowly rises, and falls again."""
    phi, followed = solids.largest_order_parameter(p), np.empty((2, len(strains)))
    for row, order in enumerate((strains, strains[::-1])):
        for i, eps in enumerate(order):
            B = film.melting_function(p, float(eps))
            phi = solids.next_phase(p, max(phi, _SEED), B)
            followed[row, i] = phi
    followed[1] = followed[1, ::-1]
    return followed


def _of(name: str) -> dict[str, str]:
    return PHASES[name].attributes
