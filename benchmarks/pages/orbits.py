"""Random points and their orbits: accuracy, honesty, and time against another solver."""

from __future__ import annotations

from pages.lines import Lines, Results, listed


def lines(results: Results) -> Lines:
    """Periods, orbits, errors and times."""
    periods, errors = results["periods"]["all"], results["errors"]
    plain, attempts = results["plain_iteration"], results["attempts"]["parts"]
    found = {
        "points (not ok)": f"{results['points']} ({len(results['not_ok'])})",
        "periods integrated: median, 95 %, max": listed(list(periods.values())),
        "same orbit as plain iteration": (
            f"{plain['same_orbit']} of {results['points']} ({plain['settled']} settle plainly)"
        ),
    }
    for name, values in errors["at_default"].items():
        what = f"error of {name} at default: median, max"
        found[what] = f"{values['median']:.1e}, {values['max']:.1e}"
    found["slope of error against tolerance: median, 95 %"] = (
        f"{errors['slope_median']:.2f}, {errors['slope_95']:.2f}"
    )
    for row in results["estimate"]:
        found[f"amplitude_error at rtol {row['rtol']:.0e}: bounds, overestimates by"] = (
            f"{row['bounded']:.1%}, {row['overestimate_median']:.2g}"
        )
    part = attempts.get("measurement", 0.0)
    return (
        found
        | {"part of the attempts for the error estimate": f"{part:.1%}"}
        | _random_times(results["time"])
    )


def _random_times(taken: Results) -> Lines:
    found = {"all points on one core, ours": f"{taken['seconds']['all']:.3g} s"}
    if "ratios" not in taken:
        return found
    peer, loose = taken["numbalsoda"], taken["at_its_error"]
    found["median error, ours and numbalsoda"] = (
        f"{taken['error_median']:.1e}, {peer['error_median']:.1e} (its rtol {peer['rtol']:.0e})"
    )
    failed = "numbalsoda with plain iteration: failed points, left out on both sides"
    found[failed] = str(peer["failed"])
    found["times faster at default: in total, gamma < 0"] = listed(list(taken["ratios"].values()))
    found[f"times faster at its error (our rtol {loose['rtol']:.0e}): in total, gamma < 0"] = (
        listed(list(loose["ratios"].values()))
    )
    if "in_company" in taken:
        many = taken["in_company"]
        for what in ("default", "at_its_error"):
            row = many[what]
            with_all = row["seconds_with_failures"]
            found[f"a point among {many['points']} at rtol {row['rtol']:.0e}, times faster"] = (
                f"{row['seconds'] * 1e6:.3g} us, {row['ratio']:.0f}; without "
                f"{row['failed']} that are not ok, with them {with_all * 1e6:.3g} us"
            )
    return found
