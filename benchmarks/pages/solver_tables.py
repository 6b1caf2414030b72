"""Run time against error, and steps in lanes."""

from __future__ import annotations

from pages.numbers import Results, Rows, digits, signed

FLUIDS = {"gamma=-2/3": "−2/3", "gamma=0": "0", "gamma=2/3": "2/3"}
ERRORS = (1e-4, 1e-6, 1e-8)


def against_peers(fluids: Results) -> Rows:
    """Return how many times faster the package is at equal error."""
    columns = {
        "ensemble against numbalsoda": "ensemble",
        "one at a time against numbalsoda": "one at a time",
        "single trajectory against numbalsoda": "single trajectory",
        "single trajectory against the fastest peer": "single, fastest of all",
    }
    return [
        ("γ", "error", *columns.values()),
        *(
            (shown, f"{error:.0e}", *(_ratio(fluids, fluid, what, error) for what in columns))
            for fluid, shown in FLUIDS.items()
            for error in ERRORS
        ),
    ]


def _ratio(fluids: Results, fluid: str, what: str, error: float) -> str:
    rows = fluids["regimes"][fluid]["ratios"]["times_faster"]
    (found,) = (row["ratio"] for row in rows if (row["what"], row["error"]) == (what, error))
    return digits(found)


def random_fluids(random: Results) -> Rows:
    """Return random points of five fluids: cost at one error, ratios of ensembles at three."""
    faster = [f"times faster at {error:.0e}" for error in ERRORS]
    rows: Rows = [("γ", "steps a period", "µs a period", *faster)]
    for name, fluid in random["fluids"].items():
        costs = {row["error"]: row for row in fluid["costs"]}
        steps, seconds = (costs[1e-6][key] for key in ("steps_per_period", "seconds_per_period"))
        ratios = [costs[error]["ratio"] for error in ERRORS]
        shown = map(digits, (steps, seconds and 1e6 * seconds, *ratios))
        rows.append((signed(name.removeprefix("gamma=")), *shown))
    return rows


def against_paper(fluids: Results) -> Rows:
    """Return the scheme of the paper at its step, which is too slow to be run to the end."""
    times = "ensemble, times faster at error 1e-06"
    rows: Rows = [("γ", "Euler–Cromer [s a period]", "its error", times)]
    for fluid, shown in FLUIDS.items():
        scheme = fluids["regimes"][fluid]["euler_cromer"]
        error = "not measured" if scheme["error"] is None else f"{scheme['error']:.0e}"
        ratio = _ratio(fluids, fluid, "ensemble against Euler-Cromer (extrapolated)", 1e-6)
        rows.append((shown, digits(scheme["seconds_per_period"]), error, ratio))
    return rows


def adaptive_steps(adaptive: Results) -> Rows:
    """Return the adaptive method: a step in lanes, and what a single point takes."""
    step = f"a step of {adaptive['lanes']} lanes in a search [ns]"
    one = "a period of one point, scalar [µs]"
    return [
        ("γ", step, one, "... in one of the lanes"),
        *(
            (
                signed(gamma),
                f"{row['search']['ns']:.0f}",
                digits(1e-3 * row["single"]["scalar_ns"]),
                f"{row['single']['ratio']:.2f} times as long",
            )
            for gamma, row in adaptive["fluids"].items()
        ),
    ]


def fixed_steps(fixed: Results) -> Rows:
    """Return a step of Euler-Cromer in lanes."""
    rows: Rows = [("γ", "plain loop [ns a step]", "lanes [ns a step]", "times faster, at most")]
    for gamma, plain in fixed["plain"].items():
        lanes = [row for row in fixed["lanes"] if f"{row['gamma']:.2f}" == gamma]
        times = [row["ns_per_step"] for row in lanes]
        faster = max(row["times_faster_than_plain"] for row in lanes)
        between = f"{min(times):.2g} to {max(times):.2g}"
        rows.append((signed(gamma), digits(plain), between, f"{faster:.0f}"))
    return rows
