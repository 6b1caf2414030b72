"""The picture of run time against error: a panel a fluid, a curve a solver."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, LogFormatterMathtext, NullLocator

TITLES = {"gamma=-2/3": "γ = −2/3", "gamma=0": "γ = 0", "gamma=2/3": "γ = 2/3"}

# Okabe and Ito: told apart with every kind of colour vision, and by markers in grey.
BLUE, SKY, GREEN, YELLOW = "#0072B2", "#56B4E9", "#009E73", "#E0C000"
ORANGE, VERMILION, BLACK = "#E69F00", "#D55E00", "#000000"

STYLES: dict[str, dict[str, Any]] = {
    "ours, ensemble": {"color": VERMILION, "marker": "o", "linewidth": 2.6, "zorder": 5},
    "ours, single trajectory": {"color": VERMILION, "marker": "s", "linewidth": 1.6, "zorder": 4}
    | {"linestyle": "--", "markerfacecolor": "white"},
    "numbalsoda LSODA, one at a time": {"color": BLUE, "marker": "o", "linewidth": 2.6},
    "numbalsoda LSODA": {"color": BLUE, "marker": "s", "linestyle": "--"}
    | {"markerfacecolor": "white"},
    "CyRK BDF": {"color": ORANGE, "marker": "h", "linestyle": "-."},
    "CyRK Radau": {"color": YELLOW, "marker": "H", "linestyle": "-."},
    "CyRK LSODA": {"color": SKY, "marker": "p", "linestyle": "-."},
    "casadi CVODES": {"color": GREEN, "marker": "^"},
    "SciPy LSODA": {"color": SKY, "marker": "<", "linestyle": ":"},
    "SciPy BDF": {"color": ORANGE, "marker": "P"},
    "SciPy Radau": {"color": YELLOW, "marker": "X"},
}
NOT_DRAWN = ("ours, one at a time",)  # beside the ensemble and the single trajectory one too many
LABELS = {
    "ours, ensemble": "stickslip, ensemble of 256 ¹",
    "ours, single trajectory": "stickslip, single ²",
    "numbalsoda LSODA, one at a time": "numbalsoda, same ensemble ¹",
    "numbalsoda LSODA": "numbalsoda, single ²",
}
NOTE = (
    "¹ 155–280 K on one core: median error, mean time (numbalsoda: a sample of the ensemble). "
    "² The scene of Fig. 3. Tolerances 1e-2 to 1e-9; failed runs are not drawn."
)


def draw_work_precision(found: dict[str, Any]) -> Figure:
    """Draw seconds per period against error, one panel a fluid."""
    regimes = found["regimes"]
    figure, axes = plt.subplots(1, len(regimes), figsize=(13, 5.6), sharex=True, sharey=True)
    for ax, (name, regime) in zip(axes, regimes.items(), strict=True):
        _draw_panel(ax, TITLES.get(name, name), regime)
    axes[0].set_ylabel("seconds per drive period, one processor core")
    error = "error of x after three periods, in units of X$_m$ (more accurate to the right)"
    figure.supxlabel(error, x=0.43, y=0.095, fontsize=11)
    place = {"loc": "center left", "bbox_to_anchor": (0.805, 0.56), "labelspacing": 0.75}
    figure.legend(handles=_legend(found), frameon=False, fontsize=9, **place)
    figure.text(0.012, 0.035, NOTE, fontsize=7.5, color="#444444", va="bottom")
    figure.subplots_adjust(left=0.06, right=0.8, top=0.93, bottom=0.2, wspace=0.06)
    return figure


def _draw_panel(ax: Axes, title: str, regime: dict[str, Any]) -> None:
    ax.set(xscale="log", yscale="log", title=title)
    for curve in regime["curves"]:
        if curve["solver"] not in NOT_DRAWN and curve["points"]:
            errors = [max(point["error"], 1e-13) for point in curve["points"]]
            seconds = [point["seconds_per_period"] for point in curve["points"]]
            ax.plot(errors, seconds, **{"markersize": 5.5} | STYLES[curve["solver"]])
    _draw_euler_cromer(ax, regime["euler_cromer"])
    ax.set_xlim(1e-1, 1e-13)
    ax.xaxis.set_major_locator(FixedLocator([10.0**-k for k in range(2, 13, 2)]))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_major_formatter(LogFormatterMathtext())
    ax.grid(visible=True, which="major", color="#e4e4e4", linewidth=0.7)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def _draw_euler_cromer(ax: Axes, run: dict[str, Any]) -> None:
    """Draw measured steps filled, and the paper's step hollow at the end of a broken line."""
    measured = [(point["error"], point["seconds_per_period"]) for point in run["points"]]
    if measured:
        ax.plot(*zip(*measured, strict=True), color=BLACK, marker="d", markersize=5.5)
    if run["error"]:
        end = max(run["error"], 1e-13), run["seconds_per_period"]
        ax.plot(*zip(measured[-1], end, strict=True), color=BLACK, linestyle=":", linewidth=1)
        ax.plot(*end, "d", color=BLACK, markersize=8, markerfacecolor="white", clip_on=False)
        aside = {"xytext": (-7, 2), "textcoords": "offset points", "ha": "right"}
        ax.annotate("extrapolated", end, fontsize=8, **aside)


def _legend(found: dict[str, Any]) -> list[Line2D]:
    """Return an entry a solver, slowest first as in the panels; those without a point say so."""
    curves = [curve for regime in found["regimes"].values() for curve in regime["curves"]]
    drawn = {curve["solver"] for curve in curves if curve["points"]}
    scheme = {"color": BLACK, "marker": "d"}
    extrapolated = "Euler–Cromer at the paper's\nΔt = 1e-10 s, extrapolated"
    handles = [
        Line2D([], [], label="Euler–Cromer, measured", **scheme),
        Line2D([], [], ls=":", markerfacecolor="white", label=extrapolated, **scheme),
    ]
    for solver, style in reversed(STYLES.items()):
        label = LABELS.get(solver, solver)
        if solver in drawn:
            handles.append(Line2D([], [], label=label, **style))
        elif solver in found["peers"]:
            installed = found["peers"][solver] != "not installed"
            why = "no run succeeded" if installed else "not installed"
            handles.append(Line2D([], [], linestyle="none", label=f"{label}:\n{why}"))
    return handles
