"""The phases of a film at rest or under constant strain: what Fig. 2 of the paper shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stickslip.model import film, solids
from stickslip.parameters import Parameters
from stickslip.trajectory import attributes
from stickslip.variables import PARAMETERS, PHASES

if TYPE_CHECKING:
    import xarray as xr

PAPER_TEMPERATURES = (265.0, 286.0, 310.0)
PAPER_STRAIN = 2.1e-6
"""Those of Fig. 2."""

_BEYOND = 1.15  # the largest order parameter that is shown, in parts of that of the solid


def phase_diagram(
    parameters: Parameters | None = None,
    *,
    temperatures: Sequence[float] = PAPER_TEMPERATURES,
    strain: float = PAPER_STRAIN,
    samples: int = 601,
) -> xr.Dataset:
    """The free energy of a film at some temperatures, and where it melts and solidifies.

    Parameters
    ----------
    parameters
        The model's parameters; the paper's by default. Their temperature does not enter but as
        the lowest one at which strains are shown.
    temperatures
        Temperatures [K] at which the free energy is shown.
    strain
        Elastic strain under which it is.
    samples
        Order parameters, and strains, that are shown.

    Returns
    -------
    xarray.Dataset
        `free_energy` (temperature, order_parameter) by Eq. 12 under the scalar coordinate
        `applied_strain`; `melting_strain` and `solidification_strain` (temperature,), Eqs. 19 and
        20; `melting_temperature` and `solidification_temperature` (elastic_strain,), Eqs. 17 and
        18. Between the two the film is what it was before; beyond, there is one phase.

    Raises
    ------
    ValueError
        No temperature, or fewer than two samples; ParameterError where one is out of range.
    """
    import xarray as xr

    if not len(temperatures) or samples < 2:
        raise ValueError("a phase diagram needs a temperature and at least two samples")
    p = parameters or Parameters()
    films = [p._replace(temperature=T) for T in temperatures]
    phi = np.linspace(0.0, _BEYOND * max(map(solids.largest_order_parameter, films)), samples)
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
    energy = [[film.free_energy(at, x, strain) for x in phi] for at in films]
    data = {
        "free_energy": (("temperature", "order_parameter"), energy, _of("free_energy")),
        **{name: (*values, _of(name)) for name, values in along.items()},
    }
    coords = {
        "order_parameter": ("order_parameter", phi, _of("order_parameter")),
        "elastic_strain": ("elastic_strain", eps, _of("elastic_strain")),
        "applied_strain": ((), strain, _of("elastic_strain")),
        **{name: ((), v, attributes(PARAMETERS[name])) for name, v in p._asdict().items()},
        "temperature": ("temperature", list(temperatures), attributes(PARAMETERS["temperature"])),
    }
    return xr.Dataset(data, coords)


def _of(name: str) -> dict[str, str]:
    return attributes(PHASES[name])
