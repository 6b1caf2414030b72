"""Run time against error, steps in lanes, and variants of the method."""

from __future__ import annotations

from pages.numbers import Lines, Results, digits, power, signed

FLUIDS = {"gamma=-2/3": "−2/3", "gamma=0": "0", "gamma=2/3": "2/3"}
ERRORS = (1e-4, 1e-6, 1e-8)


def against_peers(fluids: Results) -> Lines:
    """Yield how many times faster the package is at equal error."""
    columns = (
        "ensemble against numbalsoda",
        "one at a time against numbalsoda",
        "single trajectory against numbalsoda",
        "single trajectory against the fastest peer",
    )
    yield "γ | error | ensemble | one at a time | single trajectory | single, fastest of all"
    for fluid, shown in FLUIDS.items():
        for error in ERRORS:
            ratios = (_ratio(fluids, fluid, what, error) for what in columns)
            yield " | ".join((shown, power(error), *ratios))


def _ratio(fluids: Results, fluid: str, what: str, error: float) -> str:
    rows = fluids["regimes"][fluid]["ratios"]["times_faster"]
    (found,) = (row["ratio"] for row in rows if (row["what"], row["error"]) == (what, error))
    return digits(found)


def random_fluids(random: Results) -> Lines:
    """Yield random points of five fluids: cost at one error, ratios of ensembles at three."""
    faster = " | ".join(f"times faster at {power(error)}" for error in ERRORS)
    yield f"γ | steps a period | µs a period | {faster}"
    for name, fluid in random["fluids"].items():
        costs = {row["error"]: row for row in fluid["costs"]}
        steps, seconds = (costs[1e-6][key] for key in ("steps_per_period", "seconds_per_period"))
        ratios = [costs[error]["ratio"] for error in ERRORS]
        shown = map(digits, (steps, seconds and 1e6 * seconds, *ratios))
        yield " | ".join((signed(name.removeprefix("gamma=")), *shown))


def against_paper(fluids: Results) -> Lines:
    """Yield the scheme of the paper at its step, which is too slow to be run to the end."""
    yield "γ | Euler–Cromer [s a period] | its error | ensemble, times faster at error 1e-06"
    for fluid, shown in FLUIDS.items():
        scheme = fluids["regimes"][fluid]["euler_cromer"]
        error = "not measured" if scheme["error"] is None else power(scheme["error"])
        ratio = _ratio(fluids, fluid, "ensemble against Euler-Cromer (extrapolated)", 1e-6)
        yield f"{shown} | {digits(scheme['seconds_per_period'])} | {error} | {ratio}"


def adaptive_steps(adaptive: Results) -> Lines:
    """Yield the adaptive method: a step in lanes, and what a single point takes."""
    step = f"a step of {adaptive['lanes']} lanes in a search [ns]"
    yield f"γ | {step} | a period of one point, scalar [µs] | ... in one of the lanes"
    for gamma, row in adaptive["fluids"].items():
        ns, scalar = row["search"]["ns"], 1e-3 * row["single"]["scalar_ns"]
        longer = f"{row['single']['ratio']:.2f} times as long"
        yield f"{signed(gamma)} | {ns:.0f} | {digits(scalar)} | {longer}"


def fixed_steps(fixed: Results) -> Lines:
    """Yield a step of Euler-Cromer in lanes."""
    yield "γ | plain loop [ns a step] | lanes [ns a step] | times faster, at most"
    for gamma, plain in fixed["plain"].items():
        lanes = [row for row in fixed["lanes"] if f"{row['gamma']:.2f}" == gamma]
        times = [row["ns_per_step"] for row in lanes]
        faster = max(row["times_faster_than_plain"] for row in lanes)
        between = f"{min(times):.2g} to {max(times):.2g}"
        yield f"{signed(gamma)} | {digits(plain)} | {between} | {faster:.0f}"


def of_peak(peak: Results) -> Lines:
    """Yield how much of a core's peak a step and a search reach."""
    attempt = "an attempted step: operations, part of the peak"
    yield f"γ | {attempt} | a search | a fixed step: operations, part of the peak"
    for gamma, row in peak["fluids"].items():
        attempted = row["attempt"]["operations"] / peak["lanes"]
        yield (
            f"{signed(gamma)} | {attempted:.0f}, {row['attempt']['of_peak']:.0%} | "
            f"{row['search']['of_peak']:.0%} | {row['fixed']['operations']:.0f}, "
            f"{row['fixed']['of_peak']:.0%}"
        )
    yield f"the peak | {peak['operations_per_ns']:.0f} operations a nanosecond |  | "


def methods(variants: Results) -> Lines:
    """Yield steps at equal error of variants of the adaptive method, for both kinds of error."""
    fluids = variants["fluids"]
    yield f"variant | {' | '.join(f'γ = {signed(gamma)}' for gamma in fluids)}"
    (_, *names) = next(iter(fluids.values()))["variants"]
    for at, name, shown in (
        *(("1e-06", name, name) for name in names),
        ("1e-08", "RODAS4", "RODAS4, at the error of rtol = 1e-8"),
    ):
        pairs = (row["variants"][name]["steps_at_equal_error"][at] for row in fluids.values())
        cells = (", ".join(_hundredths(each["ratio"]) for each in pair) for pair in pairs)
        yield " | ".join((shown, *cells))


def _hundredths(value: float | None) -> str:
    return "not reached" if value is None else f"{value:.2f}"
