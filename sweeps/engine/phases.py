"""The free energy and the phases that a config describes, at the temperatures of its only axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.phases import PAPER_STRAIN, phase_diagram
from sweeps.config.load import Config
from sweeps.files.attributes import add_provenance

if TYPE_CHECKING:
    import xarray as xr

_SUMMARY = "Free energy of a boundary lubricant film, and where it melts and solidifies"


def phases(config: Config) -> xr.Dataset:
    """The phase diagram of a config that sweeps the temperature; see `stickslip.phase_diagram`."""
    strain = config.plot.elastic_strain
    ds = phase_diagram(
        config.parameters(),
        temperatures=config.sweep["temperature"],
        strain=PAPER_STRAIN if strain is None else strain,
    )
    return add_provenance(ds, config, config.title or "Phases of a film", _SUMMARY)
