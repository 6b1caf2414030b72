"""Pictures of the results in `results/*.json`; a result that is not there is left out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, LogFormatterMathtext, NullLocator

from pages import physics, stability_plots, stochastic

HERE = Path(__file__).parents[1]
RESULTS = HERE / "results"
DOCS = HERE.parent / "docs" / "pictures"

PICTURES = {"work_precision": "work_precision.png", "random": "random_errors.png"}

TITLES = {"gamma=-2/3": "γ = −2/3", "gamma=0": "γ = 0", "gamma=2/3": "γ = 2/3"}

# Okabe and Ito: told apart with every kind of colour vision, and by markers in grey.
BLUE, SKY, GREEN, YELLOW = "#0072B2", "#56B4E9", "#009E73", "#E0C000"
ORANGE, VERMILION, PURPLE, BLACK, GREY = "#E69F00", "#D55E00", "#CC79A7", "#000000", "#777777"

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
    "SciPy odeint LSODA": {"color": SKY, "marker": "v"},
    "SciPy LSODA": {"color": SKY, "marker": "<", "linestyle": ":"},
    "scikit-sundae CVODE": {"color": PURPLE, "marker": "D"},
    "SciPy BDF": {"color": ORANGE, "marker": "P"},
    "SciPy Radau": {"color": YELLOW, "marker": "X"},
    "diffrax Kvaerno5": {"color": GREY, "marker": "*"},
    "heyoka Taylor": {"color": BLACK, "marker": "1", "linestyle": "--"},
}
NOT_DRAWN = ("ours, one at a time",)  # beside the ensemble and the single trajectory one too many
LABELS = {
    "ours, ensemble": "stickslip, ensemble of 256 ¹",
    "ours, single trajectory": "stickslip, single ²",
    "numbalsoda LSODA, one at a time": "numbalsoda, same ensemble ¹",
    "numbalsoda LSODA": "numbalsoda, single ²",
}


def main() -> None:
    pictures = {"work_precision": draw_work_precision, "random": draw_random_errors}
    for name, draw in pictures.items():
        content = load(name)
        if content is None:
            print(f"no results/{name}.json: run bench_{name}.py first")
        else:
            print(draw(content, DOCS / PICTURES[name]))
    if content := load("physics"):
        path = DOCS / "relaxing_strain.png"
        print(physics.draw_relaxation(content["results"], _where(content), path))
    if content := load("stochastic"):
        path = DOCS / "stochastic_closure.png"
        print(stochastic.draw_closure(content["results"], _where(content), path))
    if stability := load("stability"):
        for picture, draw_it in stability_plots.PICTURES.items():
            print(draw_it(stability["results"], _where(stability), DOCS / picture))


def load(name: str) -> dict[str, Any] | None:
    """A result file, or None where it is missing or not readable as one."""
    try:
        content = json.loads((RESULTS / f"{name}.json").read_text())
        return content if "results" in content else None
    except (OSError, ValueError):
        return None


def draw_work_precision(content: dict[str, Any], path: Path) -> Path:
    """Seconds per period against error, one panel a fluid."""
    regimes = content["results"]["regimes"]
    figure, axes = plt.subplots(1, len(regimes), figsize=(13, 5.6), sharex=True, sharey=True)
    for ax, (name, regime) in zip(axes, regimes.items(), strict=True):
        _draw_panel(ax, TITLES.get(name, name), regime)
    axes[0].set_ylabel("seconds per drive period, one processor core")
    figure.supxlabel(
        "error of x after three periods, in units of X$_m$ (more accurate to the right)",
        x=0.43,
        y=0.095,
        fontsize=11,
    )
    figure.legend(
        handles=_legend(regimes, content["results"]),
        loc="center left",
        bbox_to_anchor=(0.805, 0.56),
        frameon=False,
        fontsize=9,
        labelspacing=0.75,
    )
    figure.text(0.005, 0.012, _small_print(content), fontsize=7.5, color="#444444", va="bottom")
    figure.subplots_adjust(left=0.06, right=0.8, top=0.93, bottom=0.2, wspace=0.06)
    return _saved(figure, path)


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
    _tidy(ax)


def _draw_euler_cromer(ax: Axes, run: dict[str, Any]) -> None:
    """Measured steps filled; the paper's step hollow, with the line that leads there broken."""
    measured = [(point["error"], point["seconds_per_period"]) for point in run["points"]]
    if measured:
        ax.plot(*zip(*measured, strict=True), color=BLACK, marker="d", markersize=5.5)
    if run["error"]:
        there = max(run["error"], 1e-13), run["seconds_per_period"]
        ax.plot(*zip(measured[-1], there, strict=True), color=BLACK, linestyle=":", linewidth=1)
        ax.plot(*there, "d", color=BLACK, markersize=8, markerfacecolor="white", clip_on=False)
        ax.annotate(
            "extrapolated",
            there,
            xytext=(-7, 2),
            textcoords="offset points",
            ha="right",
            fontsize=8,
        )


def _legend(regimes: dict[str, Any], results: dict[str, Any]) -> list[Line2D]:
    """One entry a solver, slowest first as in the panels; solvers without a point say so."""
    drawn = {
        curve["solver"]
        for regime in regimes.values()
        for curve in regime["curves"]
        if curve["points"]
    }
    handles = [
        Line2D([], [], color=BLACK, marker="d", linestyle="-", label="Euler–Cromer, measured"),
        Line2D(
            [],
            [],
            color=BLACK,
            marker="d",
            linestyle=":",
            markerfacecolor="white",
            label="Euler–Cromer at the paper's\nΔt = 1e-10 s, extrapolated",
        ),
    ]
    for solver, style in reversed(STYLES.items()):
        label = LABELS.get(solver, solver)
        if solver in drawn:
            handles.append(Line2D([], [], label=label, **style))
        elif solver in results["peers"]:
            installed = results["peers"][solver] != "not installed"
            why = "no run succeeded" if installed else "not installed"
            handles.append(Line2D([], [], linestyle="none", label=f"{label}:\n{why}"))
    return handles


def draw_random_errors(content: dict[str, Any], path: Path) -> Path:
    """Error of the amplitudes against tolerance on the random points, and the slope of 1."""
    results = content["results"]
    rows = results["errors"]["ladder"]
    tolerances = [row["rtol"] for row in rows]
    figure, ax = plt.subplots(figsize=(6.6, 5.2))
    guide = rows[len(rows) // 2]
    ax.plot(
        tolerances,
        [guide["median"] * rtol / guide["rtol"] for rtol in tolerances],
        color=GREY,
        linestyle="--",
        linewidth=1,
        label="slope 1",
    )
    looks: dict[str, dict[str, Any]] = {
        "max": {"color": YELLOW, "marker": "x", "linestyle": "none", "label": "worst point"},
        "95": {"color": BLUE, "marker": "s", "markerfacecolor": "white", "label": "95 %"},
        "median": {"color": VERMILION, "marker": "o", "linewidth": 2.2, "label": "median"},
    }
    for name, look in looks.items():
        errors = [row[name] for row in rows]
        slope = results["errors"].get(f"slope_{name}")
        label = look["label"] + ("" if slope is None else f", slope {slope:.2f}")
        ax.plot(tolerances, errors, **(look | {"label": label}))
    for row in rows:
        if row["not_ok"]:
            ax.annotate(
                f"{len(row['not_ok'])} not ok",
                (row["rtol"], row["max"]),
                xytext=(0, 7),
                textcoords="offset points",
                ha="center",
                fontsize=8,
                color="#444444",
            )
    ax.set(xscale="log", yscale="log", xlabel="tolerance rtol (more accurate to the right)")
    ax.set_ylabel("error of the worse amplitude")
    ax.set_title(f"{results['points']} random points", fontsize=11)
    ax.invert_xaxis()
    ax.margins(y=0.1)
    _tidy(ax)
    ax.legend(frameon=False, fontsize=9)
    note = "Against a reference at rtol {rtol:.0e}, its orbit at {stationary_rtol:.0e}.\n"
    text = note.format(**results["reference"]) + _where(content)
    figure.text(0.012, 0.012, text, fontsize=7.5, color="#444444", va="bottom")
    figure.subplots_adjust(left=0.12, right=0.97, top=0.93, bottom=0.19)
    return _saved(figure, path)


def _tidy(ax: Axes) -> None:
    """What all panels have in common: a light grid, two spines."""
    ax.grid(visible=True, which="major", color="#e4e4e4", linewidth=0.7)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def _saved(figure: Figure, path: Path) -> Path:
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=150)
    plt.close(figure)
    return path


def _where(content: dict[str, Any]) -> str:
    """Machine and commit, and whether it was a quick run."""
    where = content["environment"]
    quick = " QUICK RUN, NOT A MEASUREMENT." if content["results"].get("quick") else ""
    return f"{where['processor']}; commit {where['commit']}.{quick}"


def _small_print(content: dict[str, Any]) -> str:
    return (
        "¹ 155–280 K on one core: median error, mean time (numbalsoda: a sample of the ensemble). "
        "² The scene of Fig. 3. Tolerances 1e-2 to 1e-9; failed runs are not drawn.\n"
        + _where(content)
    )


if __name__ == "__main__":
    main()
