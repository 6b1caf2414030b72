"""Orbits of random points; optional physics."""

from __future__ import annotations

from pages.numbers import Results, Rows, digits, seconds, signed


def accuracy(found: Results) -> Rows:
    """Return which orbits random points end on, how accurate and how honest they are."""
    plain, points = found["plain_iteration"], found["points"]
    rows = {
        "points that are ok": f"{found['statuses'].get('ok', 0)} of {points}",
        "on the orbit of plain iteration": (
            f"{plain['same_orbit']} of {points} ({plain['settled']} of them settle plainly)"
        ),
        "periods integrated: median, 95 %, largest": ", ".join(
            map(digits, found["periods"].values())
        ),
    }
    for name, errors in found["errors"].items():
        what = f"error of the {name.replace('_', ' ')}: median, largest"
        rows[what] = f"{errors['median']:.1e}, {errors['max']:.1e}"
    for row in found["stated"]:
        what = (
            f"`amplitude_error` at rtol {row['rtol']:.0e}: bounds the error of; too large, median"
        )
        rows[what] = f"{row['held']:.1%}; {row['over_median']:.2g} times"
    return [("what", "value"), *rows.items()]


def orbit_times(found: Results) -> Rows:
    """Return times for the orbits of all points, against plain iteration with another solver."""
    rows = {"all points on one core": f"{found['seconds']:.2g} s"}
    if "numbalsoda" in found:
        peer, many = found["numbalsoda"], found["in_company"]
        ratios = found["ratios"]
        rows |= {
            "median error, ours and numbalsoda's (at its rtol)": (
                f"{found['error_median']:.1e}, {peer['error_median']:.1e} ({peer['rtol']:.0e})"
            ),
            "points that fail with numbalsoda, left out on both sides": str(peer["failed"]),
            "times faster: all points, γ < 0": ", ".join(
                map(digits, (ratios["all"], ratios["gamma<0"]))
            ),
            f"a point among {many['points']}: time, times faster": (
                f"{1e6 * many['seconds']:.0f} µs, {many['ratio']:.0f}"
            ),
        }
    return [("what", "value"), *rows.items()]


def derivatives(many: Results, found: Results) -> Rows:
    """Return what one call saves, and how right derivatives are."""
    error = found["relative_error"]
    rows = {
        f"{many['points']} points in one call, and one by one": (
            f"{seconds(many['together'])} and {seconds(many['singly'])}, "
            f"{'the same bits' if many['same'] else 'OTHER NUMBERS'}"
        ),
        f"derivatives at {found['points']} points by {found['parameters']} parameters": seconds(
            found["seconds"]
        ),
        "error, of the largest derivative of the point: median, 95 %, largest": ", ".join(
            f"{error[name]:.1e}" for name in ("median", "95 %", "max")
        ),
        "above 1e-4": f"{found['beyond_tolerated']} of {found['derivatives']}",
        "the stated error bounds the error of; too large, median": (
            f"{found['held']:.1%}; {found['over_median']:.2g} times"
        ),
        "jumps within the step, by a scan; of these not NaN; NaN without a jump": (
            f"{found['jumps']}; {found['jumps_missed']}; {found['missing_without_jump']}"
        ),
    }
    return [("what", "value"), *rows.items()]


SUMS = (
    "sets", "across_jumps", "exceptions", "false_minima", "parameters", "covered", "undetermined",
    "exact_parameters", "exact_beyond",
)  # fmt: skip
"""What is added up over the parts of the random sets."""


def fits(*parts: Results) -> Rows:
    """Return how often fits of synthetic measurements are right, and what they take.

    `parts` are the quarters of the random sets, which may be fitted beside other work, those of
    four parameters and of what no parameters describe, and the two that start from four places,
    whose times are told.
    """
    *quarters, four, undescribed, starts, three = parts
    sums = {name: sum(each[name] for each in quarters) for name in SUMS}
    worst = max(each["exact_worst"] for each in quarters)
    rows = {
        "random sets; across a jump": f"{sums['sets']}; {sums['across_jumps']}",
        "exceptions; chi2 above that of the true parameters": (
            f"{sums['exceptions']}; {sums['false_minima']}"
        ),
        "true value within the interval of 95 %": (
            f"{sums['covered'] / sums['parameters']:.1%} of {sums['parameters']}"
        ),
        "parameters named as not determined": str(sums["undetermined"]),
        "without noise: largest error; above 1e-4": (
            f"{worst:.1e}; {sums['exact_beyond']} of {sums['exact_parameters']}"
        ),
        "k, γ, T_c, A: exceptions; false minima; within the interval": _four(four),
        "what nothing describes: chi2 from that of its own orbits, at most": (
            f"{undescribed['off_worst']:.1e}, of {undescribed['sets']} sets"
        ),
        "k, γ of ten forces from four starts: largest difference; time": _agreement(starts),
        "k, γ, K of 42 values from four starts: largest difference; time": _agreement(three),
    }
    return [("what", "value"), *rows.items()]


def _four(found: Results) -> str:
    known = found["parameters"]
    covered = sum(count * (found["covered"][name] or 0.0) for name, count in known.items())
    total = sum(known.values())
    return f"{found['exceptions']}; {found['false_minima']}; {covered / total:.1%} of {total}"


def _agreement(found: Results) -> str:
    return f"{found['differ']:.1e} standard errors; {seconds(found['seconds']['median'])}"


def prices(found: Results) -> Rows:
    """Return what sixth order and a relaxing strain cost a point."""
    models = list(found["fluids"][0]["microseconds"])
    rows: Rows = [("γ", "default [µs a point]", *(f"{m}, times as much" for m in models[1:]))]
    for row in found["fluids"]:
        default, *others = row["microseconds"].values()
        factors = (f"{value / default:.2f}" for value in others)
        rows.append((signed(f"{row['gamma']:.2f}"), digits(default), *factors))
    return rows


def ensembles(found: Results) -> Rows:
    """Return what a drive period of a stochastic film takes, and a point."""
    rows: Rows = [("what", "value")]
    for row in found["prices"]:
        what = signed(f"γ = {row['gamma']:.2f}: µs a period of a realization; a point")
        rows.append((what, f"{digits(row['microseconds'])}; {seconds(row['seconds'])}"))
    return rows
