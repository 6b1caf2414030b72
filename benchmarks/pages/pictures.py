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
BLUE, ORANGE, VERMILION, GREY = "#0072B2", "#E69F00", "#D55E00", "#777777"

CELLS = {
    "right": "#009e73",
    "refused, and right": "#b8e0d2",
    "refused, rightly": "#cccccc",
    "caught afterwards": ORANGE,
    "wrong": "#b2182b",
}
"""Kinds of the cells of the map of steps, and their colours."""


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


Drawing = tuple[str, str, Callable[[Any], Figure]]

DRAWINGS: dict[str, Drawing] = {
    "work_precision.png": ("work_precision", "fluids", draw_work_precision),
    "stability_errors.png": ("stability", "ladder", stated_errors),
    "stability_steps.png": ("stability", "step_map", step_map),
    "stability_stiff.png": ("stability", "stiff_problems", stiff_problems),
}


if __name__ == "__main__":
    main()
