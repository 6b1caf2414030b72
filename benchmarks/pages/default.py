"""The default tolerance: a line for each choice."""

from __future__ import annotations

from pages.lines import Lines, Results, shown


def lines(results: Results) -> Lines:
    """What each choice costs a point, how accurate it is, and what it gets wrong."""
    return {
        row["choice"]: (
            f"{shown(row['microseconds'])} us a point; error {shown(row['median'])} (median), "
            f"{shown(row['95'])} (95 %), {shown(row['largest'])} (largest), "
            f"held by {row['held']:.1%}; other orbits {row['other_orbit']}, "
            f"not ok {row['not_ok']}"
        )
        for row in results["rows"]
    }
