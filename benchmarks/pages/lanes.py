"""Steps in lanes against the machine: a line for each fluid."""

from __future__ import annotations

from pages.lines import Lines, Results, listed, shown


def machine(results: Results) -> Lines:
    """What the machine can do, by kind of operation."""
    can = listed(list(results["rates"].values()))
    what = "the machine: multiply-adds, additions, divisions, roots, any"
    return {what: f"{can} vector operations a ns"}


def lines(results: Results) -> Lines:
    """Operations, nanoseconds and parts of the peak, of the loops and in a search; one point."""
    found, width = machine(results), results["lanes"]
    for gamma, row in results["fluids"].items():
        for name, what in (("attempt", "an attempted step"), ("see", "a look that measures")):
            loop = row[name]
            every = sum(loop[kind] for kind in ("multiply", "add", "divide", "root", "other"))
            found[f"gamma = {gamma}: {what} of {width} lanes"] = (
                f"{every:.0f} vector operations and {loop['move']:.0f} moves in "
                f"{shown(loop['ns'])} ns: {loop['part_of_peak']:.0%} of the peak"
            )
        search = row["search"]
        found[f"gamma = {gamma}: an attempted step in a search, {search['points']} points"] = (
            f"{shown(search['ns'])} ns: {search['part_of_peak']:.0%} of the peak"
        )
        single = row["single"]
        found[f"gamma = {gamma}: a drive period of one point, scalar drive, one lane"] = (
            f"{shown(single['scalar_ns'])} ns, {single['ratio']:.2f} times as long"
        )
    return found
