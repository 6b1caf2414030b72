"""Orbits of random points, derivatives and fits."""

from __future__ import annotations

from pages.numbers import WHAT, Lines, Results, digits, power, powers


def accuracy(found: Results) -> Lines:
    """Yield which orbits random points end on, how accurate and how honest they are."""
    plain, points = found["plain_iteration"], found["points"]
    yield WHAT
    yield f"points that are ok | {found['statuses'].get('ok', 0)} of {points}"
    settled = f"({plain['settled']} of them settle plainly)"
    yield f"on the orbit of plain iteration | {plain['same_orbit']} of {points} {settled}"
    periods = ", ".join(map(digits, found["periods"].values()))
    yield f"periods integrated: median, 95 %, largest | {periods}"
    for name, errors in found["errors"].items():
        both = powers((errors["median"], errors["max"]))
        yield f"error of the {name.replace('_', ' ')}: median, largest | {both}"
    for row in found["stated"]:
        what = f"`amplitude_error` at rtol {power(row['rtol'])}: bounds the error of"
        yield f"{what}; too large, median | {row['held']:.1%}; {row['over_median']:.2g} times"


def orbit_times(found: Results) -> Lines:
    """Yield times for the orbits of all points, against plain iteration with another solver."""
    yield WHAT
    yield f"all points on one core | {found['seconds']:.2g} s"
    if "numbalsoda" not in found:
        return
    peer, many, ratios = found["numbalsoda"], found["in_company"], found["ratios"]
    errors = powers((found["error_median"], peer["error_median"]))
    yield f"median error, ours and numbalsoda's (at its rtol) | {errors} ({power(peer['rtol'])})"
    yield f"points that fail with numbalsoda, left out on both sides | {peer['failed']}"
    faster = f"{digits(ratios['all'])}, {digits(ratios['gamma<0'])}"
    yield f"times faster: all points, γ < 0 | {faster}"
    point = f"{1e6 * many['seconds']:.0f} µs, {many['ratio']:.0f}"
    yield f"a point among {many['points']}: time, times faster | {point}"


def derivatives(many: Results, found: Results) -> Lines:
    """Yield what one call saves, and how right derivatives are."""
    yield WHAT
    times = f"{many['together']:.3g} s and {many['singly']:.3g} s"
    same = "the same bits" if many["same"] else "OTHER NUMBERS"
    yield f"{many['points']} points in one call, and one by one | {times}, {same}"
    what = f"derivatives at {found['points']} points by {found['parameters']} parameters"
    yield f"{what} | {found['seconds']:.3g} s"
    errors = powers(found["relative_error"][name] for name in ("median", "95 %", "max"))
    yield f"error, of the largest derivative of the point: median, 95 %, largest | {errors}"
    yield f"above 1e-4 | {found['beyond_tolerated']} of {found['derivatives']}"
    bounds = f"{found['held']:.1%}; {found['over_median']:.2g} times"
    yield f"the stated error bounds the error of; too large, median | {bounds}"
    jumps = f"{found['jumps']}; {found['jumps_missed']}; {found['missing_without_jump']}"
    yield f"jumps within the step, by a scan; of these not NaN; NaN without a jump | {jumps}"


def fits(*parts: Results) -> Lines:
    """Yield how often fits of synthetic measurements are right, and what they take.

    `parts` are the quarters of the random sets, which may be fitted beside other work, those of
    four parameters, and the two that start from four places, whose times are told.
    """
    *quarters, four, starts, three = parts

    def total(name: str) -> int:
        return sum(each[name] for each in quarters)

    yield WHAT
    yield f"random sets; across a jump | {total('sets')}; {total('across_jumps')}"
    false = f"{total('exceptions')}; {total('false_minima')}"
    yield f"exceptions; chi2 above that of the true parameters | {false}"
    covered = total("covered") / total("parameters")
    yield f"true value within the interval of 95 % | {covered:.1%} of {total('parameters')}"
    yield f"parameters named as not determined | {total('undetermined')}"
    worst = f"{max(each['exact_worst'] for each in quarters):.1e}"
    beyond = f"{total('exact_beyond')} of {total('exact_parameters')}"
    yield f"without noise: largest error; above 1e-4 | {worst}; {beyond}"
    known = four["parameters"]
    held = sum(count * (four["covered"][name] or 0.0) for name, count in known.items())
    within = f"{held / sum(known.values()):.1%} of {sum(known.values())}"
    false = f"{four['exceptions']}; {four['false_minima']}"
    yield f"k, γ, T_c, A: exceptions; false minima; within the interval | {false}; {within}"
    for what, row in (("k, γ of ten forces", starts), ("k, γ, K of 42 values", three)):
        agreement = f"{row['differ']:.1e} standard errors; {row['seconds']['median']:.3g} s"
        yield f"{what} from four starts: largest difference; time | {agreement}"


_REFERENCE_ROWS = {
    "elastic_stress_max": "largest σ_el [Pa]",
    "elastic_stress_min": "smallest σ_el [Pa]",
    "friction_force_max": "largest F [N]",
    "friction_force_min": "smallest F [N]",
    "dissipated_energy": "work of the drive per period [J]",
    "lower_displacement": "x at t = 0 [m]",
    "lower_velocity": "v at t = 0 [m/s]",
    "order_parameter": "φ at t = 0",
    "elastic_strain": "ε_el at t = 0",
}


def reference_orbits(found: Results) -> Lines:
    """Yield the numbers of the benchmark orbits, and how well two solvers agree on them."""
    yield " | ".join(("what", *found))
    columns = list(found.values())
    values = [column["series"][-1]["values"] for column in columns]
    for name, what in _REFERENCE_ROWS.items():
        yield " | ".join((what, *(_twelve(each[name]) for each in values)))
    yield " | ".join(("meltings per period", *(str(column["meltings"]) for column in columns)))
    for name, what in (
        ("difference", "largest relative difference between the solvers"),
        ("between_series", "... between the two runs of the series"),
    ):
        yield " | ".join((what, *(f"{max(each[name].values()):.0e}" for each in columns)))
    returns = (f"{column['series'][-1]['returns_within']:.0e}" for column in columns)
    yield " | ".join(("the state returns after a period to within", *returns))


def _twelve(value: float) -> str:
    return f"{value:.11e}".replace("-", "−", 1) if value < 0 else f"{value:.11e}"
