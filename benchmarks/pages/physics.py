"""What optional physics cost and change: lines, and the picture of Eq. 23 against Eq. 24."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from pages.lines import Lines, Results, listed, shown

_CURVES = (
    ("elastic_stress_amplitude", r"$\sigma_\mathrm{el,max}$", "o", "#D55E00"),
    ("friction_force_amplitude", r"$F_\mathrm{max}$", "s", "#0072B2"),
)


def lines(results: Results) -> Lines:
    """Prices a point, and the changes by a strain that relaxes."""
    found: Lines = {}
    for row in results["prices"]:
        prices = row["microseconds"]
        rest = [f"{name} {value / prices['default']:.2f}" for name, value in prices.items()]
        what = f"a point at gamma {shown(row['gamma'])}: default in us; times as much"
        found[what] = f"{shown(prices['default'])}; {', '.join(rest[1:])}"
    times = results["relaxation"]
    found["relaxation time of the strain [s]"] = listed([row["tau"] for row in times])
    for name, _, _, _ in _CURVES:
        what = f"change of {name.replace('_', ' ')} by Eq. 23"
        found[what] = listed([row[name] for row in times])
    return found


def draw_relaxation(results: Results, note: str, path: Path) -> Path:
    """How far the amplitudes of Eq. 23 are from those of the adiabatic limit, over tau."""
    figure, ax = plt.subplots(figsize=(5.2, 3.9), layout="constrained")
    rows = results["relaxation"]
    times = [row["tau"] for row in rows]
    for name, label, marker, colour in _CURVES:
        changes = [row[name] for row in rows]
        ax.loglog(times, [abs(change) for change in changes], marker, color=colour, ls="-",
                  label=f"{label}, {'smaller' if changes[0] < 0 else 'larger'}")  # fmt: skip
    first = abs(rows[0]["elastic_stress_amplitude"])
    line = [first * tau / times[0] for tau in times]
    ax.loglog(times, line, ":", color="0.5", label=r"in proportion to $\tau_\varepsilon$")
    ax.axvline(1e-8, color="0.8", linewidth=0.8, zorder=0)
    ax.text(1.15e-8, line[-1], "the paper", fontsize=8, color="0.4", va="top")
    ax.set_xlabel(r"$\tau_\varepsilon$ (s), $h \propto \tau_\varepsilon$")
    ax.set_ylabel("relative change of the amplitude by Eq. 23")
    ax.legend(frameon=False, fontsize=8)
    ax.set_title(note, fontsize=5, loc="left", color="0.4")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    plt.close(figure)
    return path
