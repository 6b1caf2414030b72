"""Free energy and phases of the film (Fig. 2), also of a film with several solid phases."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sweeps.charts.colours import BLUE, CURVES, SKY, VERMILLION, CurveStyle, Hue
from sweeps.charts.labels import Array, shown, slice_label
from sweeps.figures.style import COLUMN, SMALL, TEXT, line_at, line_of, new_panels

_HEIGHT, _TALL = 5.2, 7.4
_JUMP = 0.03  # of the largest order parameter: the least change of phase
_MARGIN = 0.5  # the part shown before the first change of phase, relative to the part after it
_ORIGIN: dict[str, Any] = {"color": "0.8", "linewidth": 0.5, "gid": "origin"}
_FREEZING, _MELTING = CurveStyle(BLUE, 1.4), CurveStyle(VERMILLION, 1.4)
_THIN: dict[str, Any] = {"linewidth": 1.2}  # these curves never coincide
_ROOM = 12.0  # kelvin beside the outermost states


def free_energy(ds: xr.Dataset) -> Figure:
    """Free energies at some temperatures above, the phases over temperature and strain below."""
    figure, panels = new_panels(2, 1, (COLUMN, _HEIGHT))
    above, below = panels[:, 0]
    _draw_energies(above, ds)
    _draw_phases(below, ds)
    above.set_title(_name_of_energies(ds), fontsize=TEXT, loc="left")
    below.set_title("(b)", fontsize=TEXT, loc="left")
    figure.align_ylabels()
    return figure


def landscape(ds: xr.Dataset) -> Figure:
    """The free energy, the equilibria over the strain, and the film under a slow ramp of strain.

    Raises ValueError if no strain changes the phase of the film.
    """
    _refuse_one_phase(ds)
    figure, panels = new_panels(3, 1, (COLUMN, _TALL))
    above, middle, below = panels[:, 0]
    _draw_energies(above, ds, enlarged=False)
    _draw_equilibria(middle, ds)
    _draw_ramps(below, ds)
    for panel in (middle, below):
        panel.set_xlim(*_strains(ds))
    above.set_title(_name_of_energies(ds), fontsize=TEXT, loc="left")
    middle.set_title("(b) equilibria, dashed: unstable", fontsize=TEXT, loc="left")
    below.set_title("(c) the strain slowly rises and falls", fontsize=TEXT, loc="left")
    figure.align_ylabels()
    return figure


def _refuse_one_phase(ds: xr.Dataset) -> None:
    if float(ds["ramped_strain"].values[-1]) > 0.0:
        return
    why = "no strain melts a film with elastic_coefficient = 0; use"
    if not ds["ramped_order_parameter"].values.any():
        limit = float(ds["melting_temperature"].values[0])
        why = f"above {limit:g} K a film is liquid at any strain; add a lower temperature, or use"
    raise ValueError(
        f"the figure 'landscape' shows how strain changes the phase, but {why} the figure "
        "'free_energy'"
    )


# --- the free energy ------------------------------------------------------------------------------


def _draw_energies(axes: Axes, ds: xr.Dataset, *, enlarged: bool = True) -> None:
    phi, energy = shown(ds["order_parameter"]), shown(ds["free_energy"])
    axes.axhline(0.0, **_ORIGIN)
    for line in _energies(ds, phi.values, energy.values):
        axes.add_line(line)
    depth = max(-float(energy.values.min()), 1e-3 * float(energy.values.max()))
    axes.set_ylim(-1.3 * depth, 2.2 * depth)  # the deepest minimum, and the barriers above it
    axes.set_xlim(0.0, float(phi.values[-1]))
    axes.set_xlabel(phi.label, fontsize=TEXT)
    axes.set_ylabel(energy.label, fontsize=TEXT)
    if len(energy.values) > 1:
        axes.legend(fontsize=SMALL, frameon=False, loc="lower left", handlelength=2.6)
    barriers = [index for index, values in enumerate(energy.values) if _has_barrier(values)]
    if barriers and enlarged:
        index = barriers[0]
        line = _energies(ds, phi.values, energy.values)[index]
        _put_barrier(axes, line, phi.values, energy.values[index])


def _name_of_energies(ds: xr.Dataset) -> str:
    """Return the strain; also the temperature if there is only one, and hence no legend."""
    strain = shown(ds["applied_strain"].rename("elastic_strain")).equation
    alone = f"{slice_label(ds, {'temperature': 0})}, " if ds.sizes["temperature"] == 1 else ""
    return f"(a) {alone}{strain}"


def _energies(ds: xr.Dataset, phi: Array, energy: Array) -> list[Line2D]:
    styles = [line_of(_style_at(i, len(energy))) | _THIN for i in range(len(energy))]
    return [
        Line2D(phi, energy[i], **style, label=slice_label(ds, {"temperature": i}))
        for i, style in enumerate(styles)
    ]


def _has_barrier(energy: Array) -> bool:
    """Return True if the energy rises, then falls: a maximum between two minima."""
    slopes = np.diff(energy)
    return bool(slopes[0] > 0 and (slopes < 0).any())


def _put_barrier(axes: Axes, line: Line2D, phi: Array, energy: Array) -> None:
    """Draw both minima and the maximum between them, enlarged, for they are small."""
    falls = np.diff(energy) < 0
    top, bottom = int(np.argmax(falls)), len(falls) - int(np.argmax(falls[::-1]))
    low, high = min(float(energy[bottom]), 0.0), float(energy[top])
    inset = axes.inset_axes((0.12, 0.6, 0.34, 0.34))
    inset.axhline(0.0, **_ORIGIN)
    inset.add_line(line)
    inset.set_xlim(0.0, 1.3 * float(phi[bottom]))
    inset.set_ylim(low - 0.3 * (high - low), high + 0.5 * (high - low))
    inset.tick_params(labelsize=SMALL, direction="in", length=2.0)
    inset.locator_params(nbins=3)


# --- equilibria -----------------------------------------------------------------------------------


def _draw_equilibria(axes: Axes, ds: xr.Dataset) -> None:
    """Draw the order parameters of stable and unstable equilibria of the film."""
    phi, strain = shown(ds["order_parameter"]), shown(ds["equilibrium_strain"])
    freezing = shown(ds["solidification_strain"]).values
    axes.axvline(float(shown(ds["applied_strain"]).values), **_ORIGIN)
    for index, colour in _coloured(ds):
        stable = ds["equilibrium_stability"].values[index] == 1
        for kept, dashes in ((stable, "-"), (~stable, "--")):
            # Each end is shared, so that the branches meet.
            near = kept | np.roll(kept, 1) | np.roll(kept, -1)
            eps = np.where(near, strain.values[index], np.nan)
            axes.plot(eps, phi.values, dashes, color=colour, **_THIN)
        axes.plot([freezing[index], _strains(ds)[1]], [0.0, 0.0], color=colour, **_THIN)
        axes.plot([0.0, freezing[index]], [0.0, 0.0], "--", color=colour, **_THIN)
    axes.set_ylim(-0.03 * phi.values[-1], phi.values[-1])
    axes.set_ylabel(phi.label, fontsize=TEXT)


def _draw_ramps(axes: Axes, ds: xr.Dataset) -> None:
    """Draw the film under a strain that slowly rises and falls, with arrows at changes of phase."""
    eps, phi = shown(ds["ramped_strain"]), shown(ds["ramped_order_parameter"])
    for index, colour in _coloured(ds):
        for direction, values in enumerate(phi.values[index]):
            axes.plot(eps.values, values, color=colour, alpha=1.0 - 0.45 * direction, **_THIN)
            for change in np.flatnonzero(np.abs(np.diff(values)) > _JUMP * values.max()):
                ends = values[change + direction], values[change + 1 - direction]
                _put_arrow(axes, eps.values[change], *ends, colour)
    axes.set_ylim(-0.03 * phi.values.max(), 1.15 * phi.values.max())
    axes.set_xlabel(eps.label, fontsize=TEXT)
    axes.set_ylabel(phi.label, fontsize=TEXT)


def _coloured(ds: xr.Dataset) -> list[tuple[int, str]]:
    """Return the index of each temperature, with its colour."""
    count = ds.sizes["temperature"]
    return [(index, _style_at(index, count).colour) for index in range(count)]


def _style_at(index: int, count: int) -> CurveStyle:
    """Return the style of a temperature; shades tell more of them apart than styles do."""
    return line_at(Hue(index, count, ordered=count > len(CURVES)))


def _put_arrow(axes: Axes, x: float, begin: float, end: float, colour: str) -> None:
    arrow = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0.0, "shrinkB": 0.0}
    middle = 0.5 * (begin + end)
    axes.annotate("", (x, middle + 0.1 * (end - begin)), (x, middle), arrowprops=arrow)


def _strains(ds: xr.Dataset) -> tuple[float, float]:
    """Return the limits: a little below the first change of phase, and the largest strain."""
    freezing, melting, ramp = (
        shown(ds[f"{name}_strain"]).values for name in ("solidification", "melting", "ramped")
    )
    first = float(np.where(freezing > 0.0, freezing, melting).min())
    last = float(ramp[-1])
    return max(0.0, first - _MARGIN * (last - first)), last


# --- the phases -----------------------------------------------------------------------------------


def _draw_phases(axes: Axes, ds: xr.Dataset) -> None:
    eps, states = shown(ds["elastic_strain"]), shown(ds["temperature"])
    freezing, melting = (
        shown(ds[f"{name}_temperature"]).values for name in ("solidification", "melting")
    )
    axes.fill_betweenx(eps.values, freezing, melting, color=SKY, alpha=0.25, linewidth=0)
    axes.plot(freezing, eps.values, **line_of(_FREEZING))
    axes.plot(melting, eps.values, **line_of(_MELTING))
    for index, temperature in enumerate(states.values):
        colour = _style_at(index, len(states.values)).colour
        axes.plot(temperature, float(ds["applied_strain"]), "o", color=colour, markersize=3.5)
    lowest = min(float(freezing.min()), states.values.min() - _ROOM)
    axes.set_xlim(lowest, max(states.values.max(), melting.max()) + _ROOM)
    # The borders do not end within the panel, unless the states lie farther up.
    axes.set_ylim(0.0, max(float(eps.values[-1]), 1.05 * float(ds["applied_strain"])))
    axes.set_xlabel(states.label, fontsize=TEXT)
    axes.set_ylabel(eps.label, fontsize=TEXT)
    _name_phases(axes, ds, eps.values, freezing, melting)


def _name_phases(axes: Axes, ds: xr.Dataset, eps: Array, freezing: Array, melting: Array) -> None:
    """Write the name of each phase into its region, and beside each border its symbols."""
    text: dict[str, Any] = {"fontsize": SMALL, "ha": "center", "va": "center"}
    low, right = 0.2 * eps[-1], axes.get_xlim()[1]
    axes.text((freezing.min() + freezing.max()) / 2.0, low, "solid", **text)
    axes.text((melting.max() + right) / 2.0, 0.75 * eps[-1], "liquid", **text)
    third = len(eps) * 2 // 3
    names = (("solidification", freezing, "right", "top"), ("melting", melting, "left", "bottom"))
    for name, temperature, ha, va in names:
        border = ", ".join(shown(ds[f"{name}_{of}"]).symbol for of in ("temperature", "strain"))
        place = (temperature[third], eps[third])
        axes.text(*place, f" {border} ", fontsize=SMALL, ha=ha, va=va)
    near = int(0.13 * len(eps))  # where the borders are steep, and a word fits between them
    axes.text((freezing[near] + melting[near]) / 2.0, eps[near], "both", rotation=90, **text)
