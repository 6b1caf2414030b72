"""The stochastic film: lines, and the picture of the typical path beside the ensembles."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from pages.lines import Lines, Results, shown

_ROWS = (
    ("elastic_stress_amplitude", r"$\sigma_\mathrm{el,max}$ (MPa)", 1e-6),
    ("friction_force_amplitude", r"$F_\mathrm{max}$ (mN)", 1e3),
)


def lines(results: Results) -> Lines:
    """Means beside the independent ones, the largest change over omega, prices."""
    ours, plain = results["ensemble"], results["euler_maruyama"]
    rows = [row for row in results["closure"] if row["status"] == 0]
    changes = [_change(row, _ROWS[0][0]) for row in rows]
    beyond = sum(
        abs(change) > row["amplitude_error"] for row, change in zip(rows, changes, strict=True)
    )
    steady = results["steady"]
    found: Lines = {
        "largest stress at omega 15, ensemble [MPa]": _mean(ours),
        "the same by Euler-Maruyama": f"{_mean(plain)}; steps of {shown(plain['step'])} s",
        "the same, typical path [MPa]": f"{1e-6 * ours['typical_path']:.4f}",
        "omega 10: spread and change of the stress amplitude": (
            f"{shown(steady['spread'])}, {shown(steady['change'])} of itself"
        ),
        "largest change of the stress amplitude over omega": f"{max(map(abs, changes)):.2%}",
        "frequencies where it exceeds the stated error": f"{beyond} of {len(rows)}",
    }
    for row in results["prices"]:
        what = f"a point at omega 15, gamma {shown(row['gamma'])}: us a period of a realization"
        found[what] = f"{shown(row['microseconds'])}; {shown(row['seconds'])} s all of them"
    return found


def _mean(row: Results) -> str:
    mean, error, spread = (1e-6 * row[name] for name in ("mean", "standard_error", "spread"))
    return f"{mean:.4f} ± {error:.4f}, spread {spread:.4f}, {row['periods']} periods"


def _change(row: Results, name: str) -> float:
    return float(row[name] / row[f"typical_{name}"] - 1.0)


def draw_closure(results: Results, note: str, path: Path) -> Path:
    """The amplitudes of the typical path and of the ensembles, and how far they are apart."""
    rows = results["closure"]
    omega = np.array([row["omega"] for row in rows])
    figure, panels = plt.subplots(3, 1, figsize=(5.6, 6.4), sharex=True, layout="constrained")
    for ax, (name, label, scale) in zip(panels, _ROWS, strict=False):
        mean, spread, typical = (
            scale * np.array([row[key] for row in rows])
            for key in (name, f"{name}_spread", f"typical_{name}")
        )
        ax.fill_between(omega, mean - spread, mean + spread, color="#56B4E9", alpha=0.5, lw=0,
                        label="ensemble, spread of single periods")  # fmt: skip
        ax.plot(omega, mean, "o", ms=3.0, color="#0072B2", label="ensemble, mean")
        ax.plot(omega, typical, "-", color="#D55E00", lw=1.1, label="typical path")
        ax.set_ylabel(label)
    panels[0].legend(frameon=False, fontsize=8)
    ax = panels[2]
    changes = np.array([_change(row, _ROWS[0][0]) for row in rows])
    errors = np.array([row["amplitude_error"] for row in rows])
    ax.errorbar(omega, 100.0 * changes, 100.0 * errors, fmt="o", ms=3.0, color="#0072B2",
                elinewidth=0.9)  # fmt: skip
    ax.axhline(0.0, color="0.7", lw=0.8, zorder=0)
    ax.set_ylabel(r"change of $\sigma_\mathrm{el,max}$ (%)")
    ax.set_xlabel(r"$\omega$ (rad/s)")
    panels[0].set_title(note, fontsize=5, loc="left", color="0.4")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    plt.close(figure)
    return path
