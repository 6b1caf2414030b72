"""Free energy and phases of the film (Fig. 2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sweeps.figures.labels import Array, point_label, shown
from sweeps.figures.style import (
    BLUE,
    COLUMN,
    SKY,
    SMALL,
    TEXT,
    VERMILLION,
    CurveStyle,
    curve_style,
    new_panels,
)

_HEIGHT = 5.2
_FREEZING, _MELTING = CurveStyle(BLUE, 1.4), CurveStyle(VERMILLION, 1.4)
_THIN = {"linewidth": 1.2}  # these curves never coincide
_ROOM = 12.0  # kelvin beside the outermost states


def free_energy(ds: xr.Dataset) -> Figure:
    """The free energy at some temperatures above, the phases over temperature and strain below."""
    figure, panels = new_panels(2, 1, (COLUMN, _HEIGHT))
    above, below = panels[:, 0]
    _draw_energies(above, ds)
    _draw_phases(below, ds)
    strain = shown(ds["applied_strain"].rename("elastic_strain"))
    above.set_title(f"(a) {strain.equation}", fontsize=TEXT, loc="left")
    below.set_title("(b)", fontsize=TEXT, loc="left")
    figure.align_ylabels()
    return figure


# --- the free energy ------------------------------------------------------------------------------


def _draw_energies(axes: Axes, ds: xr.Dataset) -> None:
    phi, energy = shown(ds["order_parameter"]), shown(ds["free_energy"])
    axes.axhline(0.0, color="0.8", linewidth=0.5, gid="origin")
    for line in _energies(ds, phi.values, energy.values):
        axes.add_line(line)
    depth = max(-float(energy.values.min()), 1e-3 * float(energy.values.max()))
    axes.set_ylim(-1.3 * depth, 2.2 * depth)  # the deepest minimum, and what rises above it
    axes.set_xlim(0.0, float(phi.values[-1]))
    axes.set_xlabel(phi.label, fontsize=TEXT)
    axes.set_ylabel(energy.label, fontsize=TEXT)
    axes.legend(fontsize=SMALL, frameon=False, loc="lower left", handlelength=2.6)
    barriers = [index for index, values in enumerate(energy.values) if _has_barrier(values)]
    if barriers:
        index = barriers[0]
        line = _energies(ds, phi.values, energy.values)[index]
        _put_barrier(axes, line, phi.values, energy.values[index])


def _energies(ds: xr.Dataset, phi: Array, energy: Array) -> list[Line2D]:
    styles = [curve_style(i, len(energy)).line() | _THIN for i in range(len(energy))]
    names = [point_label(ds, "temperature", i) for i in range(len(energy))]
    return [
        Line2D(phi, f, **style, label=name)
        for f, style, name in zip(energy, styles, names, strict=True)
    ]


def _has_barrier(energy: Array) -> bool:
    """Whether the energy first rises, then falls: a maximum between two minima."""
    slopes = np.diff(energy)
    return bool(slopes[0] > 0 and (slopes < 0).any())


def _put_barrier(axes: Axes, line: Line2D, phi: Array, energy: Array) -> None:
    """Both minima and the maximum between them, enlarged: against the rest they are small."""
    falls = np.diff(energy) < 0
    top, bottom = int(np.argmax(falls)), len(falls) - int(np.argmax(falls[::-1]))
    low, high = min(float(energy[bottom]), 0.0), float(energy[top])
    inset = axes.inset_axes((0.12, 0.6, 0.34, 0.34))
    inset.axhline(0.0, color="0.8", linewidth=0.5, gid="origin")
    inset.add_line(line)
    inset.set_xlim(0.0, 1.3 * float(phi[bottom]))
    inset.set_ylim(low - 0.3 * (high - low), high + 0.5 * (high - low))
    inset.tick_params(labelsize=SMALL, direction="in", length=2.0)
    inset.locator_params(nbins=3)


# --- the phases -----------------------------------------------------------------------------------


def _draw_phases(axes: Axes, ds: xr.Dataset) -> None:
    eps, states = shown(ds["elastic_strain"]), shown(ds["temperature"])
    freezing, melting = (
        shown(ds[f"{name}_temperature"]).values for name in ("solidification", "melting")
    )
    axes.fill_betweenx(eps.values, freezing, melting, color=SKY, alpha=0.25, linewidth=0)
    axes.plot(freezing, eps.values, **_FREEZING.line())
    axes.plot(melting, eps.values, **_MELTING.line())
    for index, temperature in enumerate(states.values):
        colour = curve_style(index, len(states.values)).colour
        axes.plot(temperature, float(ds["applied_strain"]), "o", color=colour, markersize=3.5)
    axes.set_xlim(freezing.min(), max(states.values.max(), melting.max()) + _ROOM)
    axes.set_ylim(0.0, 1.02 * eps.values[-1])
    axes.set_xlabel(states.label, fontsize=TEXT)
    axes.set_ylabel(eps.label, fontsize=TEXT)
    _name_phases(axes, ds, eps.values, freezing, melting)


def _name_phases(axes: Axes, ds: xr.Dataset, eps: Array, freezing: Array, melting: Array) -> None:
    """The phases in their places, and at each border the temperature and the strain that it is."""
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
    middle = int(0.4 * len(eps))
    axes.text((freezing[middle] + melting[middle]) / 2.0, eps[middle], "both", rotation=-62, **text)
