"""The pictures of docs/stability.md, from the record `results/stability.json`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap

_GREY, _BLUE, _ORANGE, _VERMILION = "#777777", "#0072b2", "#e69f00", "#d55e00"

KINDS = {
    "right": "#009e73",
    "refused, and right": "#b8e0d2",
    "refused, rightly": "#cccccc",
    "caught afterwards": _ORANGE,
    "wrong": "#b2182b",
}
"""Kinds of the cells of the map of steps, and their colours."""


def draw_calibration(results: dict[str, Any], note: str, path: Path) -> Path:
    """Stated against true error of every point at every tolerance; below the line it is broken."""
    pairs = np.array(results["ladder"]["pairs"])
    figure, ax = plt.subplots(figsize=(6.6, 5.6))
    for rtol in sorted(set(pairs[:, 0]), reverse=True):
        of = pairs[:, 0] == rtol
        shade = plt.get_cmap("viridis")((np.log10(rtol) + 10.0) / 8.0)
        true = np.maximum(pairs[of, 2], 1e-13)
        ax.plot(true, pairs[of, 1], ".", color=shade, markersize=4, label=f"{rtol:.0e}")
    ends = np.array([1e-13, 1.0])
    ax.plot(ends, ends, color=_VERMILION, linewidth=1.4)
    ax.plot(ends, 10.0 * ends, color=_GREY, linewidth=0.8, linestyle="--")
    ax.text(2e-3, 6e-4, "stated = true", color=_VERMILION, rotation=38, fontsize=9)
    ax.text(3e-5, 8e-4, "ten times", color=_GREY, rotation=38, fontsize=9)
    ax.set(xscale="log", yscale="log", xlim=(1e-13, 1.0), ylim=(1e-13, 1.0))
    ax.set(xlabel="true error of the worse amplitude", ylabel="stated error")
    ax.legend(title="rtol", frameon=False, fontsize=8, markerscale=2, loc="lower right")
    return _saved(figure, ax, note, path)


def draw_step_map(results: dict[str, Any], note: str, path: Path) -> Path:
    """Step over limit against scene: what is right, and what the checks say."""
    found = results["step_map"]
    cells, names = found["cells"], list(KINDS)
    ratios = sorted({cell["ratio"] for cell in cells})
    image = np.full((found["scenes"], len(ratios)), np.nan)
    for cell in cells:
        image[cell["scene"], ratios.index(cell["ratio"])] = names.index(cell["kind"])
    figure, ax = plt.subplots(figsize=(7.4, 5.6))
    ax.pcolormesh(
        np.arange(len(ratios) + 1), np.arange(found["scenes"] + 1), image,
        cmap=ListedColormap(list(KINDS.values())), vmin=-0.5, vmax=len(KINDS) - 0.5,
        edgecolors="white", linewidth=0.6,
    )  # fmt: skip
    shown = [i for i, ratio in enumerate(ratios) if i % 4 == 0]
    ax.set_xticks([i + 0.5 for i in shown], [f"{ratios[i]:g}" for i in shown])
    ax.axvline(ratios.index(1.0) + 1, color="black", linewidth=1.4)
    ax.set(xlabel="step over the limit above which it is refused", ylabel="scene")
    counts = found["counts"]
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour) for colour in KINDS.values()]
    labels = [f"{kind} ({counts.get(kind, 0)})" for kind in KINDS]
    figure.legend(handles, labels, loc="upper center", ncols=3, frameon=False, fontsize=8.5)
    return _saved(figure, ax, note, path, top=0.88)


def draw_stiff_problems(results: dict[str, Any], note: str, path: Path) -> Path:
    """Error against tolerance of the generic integrator."""
    figure, ax = plt.subplots(figsize=(6.6, 4.8))
    colours = (_BLUE, _VERMILION, _ORANGE)
    problems = results["stiff_problems"]["problems"].items()
    for (name, rows), colour in zip(problems, colours, strict=True):
        tolerances, errors = ([row[key] for row in rows] for key in ("rtol", "error"))
        ax.plot(tolerances, errors, "o-", color=colour, label=name)
    ax.plot(tolerances, tolerances, color=_GREY, linestyle="--", linewidth=1, label="slope 1")
    ax.set(xscale="log", yscale="log", xlabel="tolerance rtol (more accurate to the right)")
    ax.set_ylabel("largest relative error of a component")
    ax.invert_xaxis()
    ax.legend(frameon=False, fontsize=9)
    return _saved(figure, ax, note, path)


PICTURES = {
    "stability_errors.png": draw_calibration,
    "stability_steps.png": draw_step_map,
    "stability_stiff.png": draw_stiff_problems,
}


def _saved(figure: Any, ax: Axes, note: str, path: Path, top: float = 0.97) -> Path:
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(which="both", direction="out")
    figure.text(0.012, 0.012, note, fontsize=7.5, color="#444444")
    figure.subplots_adjust(left=0.12, right=0.97, top=top, bottom=0.14)
    figure.savefig(path, dpi=150)
    plt.close(figure)
    return path
