"""Draws the pictures of the pages from the records; one whose record is missing is left out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from shared.record import RESULTS, Results, read_record

from pages.work_precision_picture import draw_work_precision

PICTURES = Path(__file__).parents[2] / "docs" / "pictures"

# Okabe and Ito: told apart with every kind of colour vision.
BLUE, SKY, ORANGE, VERMILION, GREY = "#0072B2", "#56B4E9", "#E69F00", "#D55E00", "#777777"

CELLS = {
    "right": "#009e73",
    "refused, and right": "#b8e0d2",
    "refused, rightly": "#cccccc",
    "caught afterwards": ORANGE,
    "wrong": "#b2182b",
}
"""Kinds of the cells of the map of steps, and their colours."""

AMPLITUDES = {
    "elastic_stress_amplitude": (r"$\sigma_\mathrm{el,max}$", "MPa", 1e-6),
    "friction_force_amplitude": (r"$F_\mathrm{max}$", "mN", 1e3),
}


def main() -> None:
    for name, (script, part, draw) in DRAWINGS.items():
        record = read_record(RESULTS / f"{script}.json")
        if part not in record:
            print(f"no {part} in results/{script}.json: run bench_{script}.py first")
            continue
        figure, where = draw(record[part]["results"]), record[part]["environment"]
        note = f"{where['processor']}; commit {where['commit']}"
        figure.text(0.012, 0.004, note, fontsize=6.5, color="#444444", va="bottom")
        figure.savefig(PICTURES / name, dpi=150)
        plt.close(figure)
        print(PICTURES / name)


# --- stability ------------------------------------------------------------------------------------


def stated_errors(ladder: Results) -> Figure:
    """Draw stated against true error of every point at every tolerance."""
    pairs = np.array(ladder["pairs"])
    figure, ax = _panel(6.6, 5.6)
    for rtol in sorted(set(pairs[:, 0]), reverse=True):
        of = pairs[:, 0] == rtol
        shade = plt.get_cmap("viridis")((np.log10(rtol) + 10.0) / 8.0)
        true = np.maximum(pairs[of, 2], 1e-13)
        ax.plot(true, pairs[of, 1], ".", color=shade, markersize=4, label=f"{rtol:.0e}")
    ends = np.array([1e-13, 1.0])
    ax.plot(ends, ends, color=VERMILION, linewidth=1.4)
    ax.plot(ends, 10.0 * ends, color=GREY, linewidth=0.8, linestyle="--")
    ax.text(2e-3, 6e-4, "stated = true", color=VERMILION, rotation=38, fontsize=9)
    ax.text(3e-5, 8e-4, "ten times", color=GREY, rotation=38, fontsize=9)
    ax.set(xscale="log", yscale="log", xlim=(1e-13, 1.0), ylim=(1e-13, 1.0))
    ax.set(xlabel="true error of the worse amplitude", ylabel="stated error")
    ax.legend(title="rtol", frameon=False, fontsize=8, markerscale=2, loc="lower right")
    return figure


def step_map(found: Results) -> Figure:
    """Draw what is right and what the checks say, over step and scene."""
    from matplotlib.colors import ListedColormap

    cells, kinds = found["cells"], list(CELLS)
    ratios = sorted({cell["ratio"] for cell in cells})
    image = np.full((found["scenes"], len(ratios)), np.nan)
    for cell in cells:
        image[cell["scene"], ratios.index(cell["ratio"])] = kinds.index(cell["kind"])
    figure, ax = _panel(7.4, 5.6, top=0.88)
    ax.pcolormesh(
        np.arange(len(ratios) + 1), np.arange(found["scenes"] + 1), image,
        cmap=ListedColormap(list(CELLS.values())), vmin=-0.5, vmax=len(CELLS) - 0.5,
        edgecolors="white", linewidth=0.6,
    )  # fmt: skip
    shown = range(0, len(ratios), 4)
    ax.set_xticks([i + 0.5 for i in shown], [f"{ratios[i]:g}" for i in shown])
    ax.axvline(ratios.index(1.0) + 1, color="black", linewidth=1.4)
    ax.set(xlabel="step over the limit above which it is refused", ylabel="scene")
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour) for colour in CELLS.values()]
    labels = [f"{kind} ({found['counts'].get(kind, 0)})" for kind in CELLS]
    figure.legend(handles, labels, loc="upper center", ncols=3, frameon=False, fontsize=8.5)
    return figure


def stiff_problems(found: Results) -> Figure:
    """Draw error against tolerance of the generic integrator."""
    figure, ax = _panel(6.6, 4.8)
    colours = (BLUE, VERMILION, ORANGE)
    for (name, rows), colour in zip(found["problems"].items(), colours, strict=True):
        tolerances, errors = ([row[key] for row in rows] for key in ("rtol", "error"))
        ax.plot(tolerances, errors, "o-", color=colour, label=name)
    ax.plot(tolerances, tolerances, color=GREY, linestyle="--", linewidth=1, label="slope 1")
    ax.set(xscale="log", yscale="log", xlabel="tolerance rtol (more accurate to the right)")
    ax.set_ylabel("largest relative error of a component")
    ax.invert_xaxis()
    ax.legend(frameon=False, fontsize=9)
    return figure


def _panel(width: float, height: float, top: float = 0.97) -> tuple[Figure, Axes]:
    figure, ax = plt.subplots(figsize=(width, height))
    figure.subplots_adjust(left=0.12, right=0.97, top=top, bottom=0.14)
    ax.spines[["top", "right"]].set_visible(False)
    return figure, ax


# --- optional physics -----------------------------------------------------------------------------


def relaxation(found: Results) -> Figure:
    """Draw how far the amplitudes of Eq. 23 are from those of the adiabatic limit, over tau."""
    figure, ax = plt.subplots(figsize=(5.2, 3.9))
    figure.subplots_adjust(left=0.15, right=0.97, top=0.97, bottom=0.16)
    rows = found["rows"]
    times = [row["tau"] for row in rows]
    looks = (("o", VERMILION), ("s", BLUE))
    for (name, (label, _, _)), (marker, colour) in zip(AMPLITUDES.items(), looks, strict=True):
        changes = [row[name] for row in rows]
        label = f"{label}, {'smaller' if changes[0] < 0 else 'larger'}"
        ax.loglog(times, np.abs(changes), marker, color=colour, ls="-", label=label)
    line = abs(rows[0]["elastic_stress_amplitude"]) * np.array(times) / times[0]
    ax.loglog(times, line, ":", color="0.5", label=r"in proportion to $\tau_\varepsilon$")
    ax.axvline(1e-8, color="0.8", linewidth=0.8, zorder=0)
    ax.text(1.15e-8, line[-1], "the paper", fontsize=8, color="0.4", va="top")
    ax.set_xlabel(r"$\tau_\varepsilon$ (s), $h \propto \tau_\varepsilon$")
    ax.set_ylabel("relative change of the amplitude by Eq. 23")
    ax.legend(frameon=False, fontsize=8)
    return figure


def closure(found: Results) -> Figure:
    """Draw the amplitudes of the typical path and of the ensembles, and their differences."""
    rows = found["closure"]
    omega = np.array([row["omega"] for row in rows])
    figure, panels = plt.subplots(3, 1, figsize=(5.6, 6.4), sharex=True)
    figure.subplots_adjust(left=0.15, right=0.97, top=0.98, bottom=0.1, hspace=0.08)
    for ax, (name, (label, unit, scale)) in zip(panels, AMPLITUDES.items(), strict=False):
        mean, spread, typical = (
            scale * np.array([row[key] for row in rows])
            for key in (name, f"{name}_spread", f"typical_{name}")
        )
        ax.fill_between(omega, mean - spread, mean + spread, color=SKY, alpha=0.5, lw=0,
                        label="ensemble, spread of single periods")  # fmt: skip
        ax.plot(omega, mean, "o", ms=3.0, color=BLUE, label="ensemble, mean")
        ax.plot(omega, typical, "-", color=VERMILION, lw=1.1, label="typical path")
        ax.set_ylabel(f"{label} ({unit})")
    panels[0].legend(frameon=False, fontsize=8)
    stress = "elastic_stress_amplitude"
    changes = np.array([100.0 * (row[stress] / row[f"typical_{stress}"] - 1.0) for row in rows])
    errors = np.array([100.0 * row["amplitude_error"] for row in rows])
    panels[2].errorbar(omega, changes, errors, fmt="o", ms=3.0, color=BLUE, elinewidth=0.9)
    panels[2].axhline(0.0, color="0.7", lw=0.8, zorder=0)
    panels[2].set_ylabel(f"change of {AMPLITUDES[stress][0]} (%)")
    panels[2].set_xlabel(r"$\omega$ (rad/s)")
    return figure


Drawing = tuple[str, str, Callable[[Any], Figure]]

DRAWINGS: dict[str, Drawing] = {
    "work_precision.png": ("work_precision", "fluids", draw_work_precision),
    "stability_errors.png": ("stability", "ladder", stated_errors),
    "stability_steps.png": ("stability", "step_map", step_map),
    "stability_stiff.png": ("stability", "stiff_problems", stiff_problems),
    "relaxing_strain.png": ("physics", "relaxation", relaxation),
    "stochastic_closure.png": ("physics", "ensembles", closure),
}


if __name__ == "__main__":
    main()
