"""The figures that a config can name, the function that draws each, and the data it needs.

To add a figure, write the function and add a line here. The schema of configs takes the names from
this table, and `plot` refuses a file that lacks the data. The table names the functions and does
not import them, so that reading a config needs no matplotlib.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

Data = Literal["sweep", "trajectory", "phases", "fit", "indices"]


@dataclass(frozen=True)
class FigureEntry:
    """A figure: `module.function` within `sweeps.figures`, and the data it shows.

    The file must have all `variables`. The first figure for each kind of data is its default.
    """

    function: str
    data: Data
    variables: tuple[str, ...]

    @property
    def drawn(self) -> str:
        """The data that it shows, in words."""
        return {"phases": "the phases of a film", "indices": "Sobol indices"}.get(
            self.data, f"a {self.data}"
        )


_POSITIONS = ("upper_displacement", "lower_displacement")
_VELOCITIES = ("upper_velocity", "lower_velocity")
_FORCES = ("elastic_stress", "friction_force")
AMPLITUDES = ("elastic_stress_amplitude", "friction_force_amplitude")

FIGURES: Mapping[str, FigureEntry] = MappingProxyType(
    {
        "amplitudes": FigureEntry("amplitudes.amplitudes", "sweep", AMPLITUDES),
        "pairs": FigureEntry("scatter.pairs", "sweep", ("regime",)),
        "time_courses": FigureEntry(
            "traces.time_courses", "trajectory", (*_POSITIONS, *_VELOCITIES, *_FORCES)
        ),
        "relative_motion": FigureEntry(
            "traces.relative_motion", "trajectory", (*_POSITIONS, *_VELOCITIES)
        ),
        "phase_portraits": FigureEntry(
            "traces.phase_portraits", "trajectory", ("lower_displacement", "lower_velocity")
        ),
        "force_loops": FigureEntry(
            "traces.force_loops", "trajectory", ("upper_displacement", "friction_force")
        ),
        "pull": FigureEntry(
            "traces.pull",
            "trajectory",
            ("upper_velocity", "spring_force", "friction_force", "order_parameter"),
        ),
        "orbit": FigureEntry("traces.orbit", "trajectory", (*_POSITIONS, *_VELOCITIES, *_FORCES)),
        "free_energy": FigureEntry(
            "free_energy.free_energy", "phases", ("free_energy", "melting_temperature")
        ),
        "landscape": FigureEntry(
            "free_energy.landscape", "phases", ("equilibrium_strain", "ramped_order_parameter")
        ),
        "fit": FigureEntry("curves.fit", "fit", ("measured_value", "fitted_value")),
        "posterior": FigureEntry("corner.posterior", "fit", ("posterior_draws",)),
        "indices": FigureEntry("bars.indices", "indices", ("first_order", "total_order")),
    }
)
