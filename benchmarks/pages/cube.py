"""A cube of a million points: its time, its statuses, and where the time goes."""

from __future__ import annotations

from pages.lines import Lines, Results, listed, shown


def lines(results: Results) -> Lines:
    """Seconds, statuses, errors, stages and late points."""
    statuses = ", ".join(f"{count} {name}" for name, count in results["statuses"].items())
    what = f"{results['points']} points at rtol {results['rtol']:.0e}"
    found = {
        f"{what} on {results['workers']} workers": (
            f"{results['seconds']:.0f} s, {results['points_per_second']:.0f} points/s"
        ),
        "statuses": statuses,
        "peak memory, file": f"{results['peak_mib']:.0f} MiB, {results['file_mib']:.0f} MiB",
    }
    if "stated_error_max" in results:
        ok, aperiodic = results["stated_error_max"], results["stated_error_max_aperiodic"]
        found["largest stated error, ok and aperiodic"] = f"{ok:.1e}, {aperiodic:.1e}"
    chosen = next(row for row in results["sample"]["rows"] if row["rtol"] == results["rtol"])
    found[f"errors on a sample of {results['sample']['points']}: median, 95 %"] = (
        f"{chosen['error_median']:.1e}, {chosen['error_95']:.1e}"
    )
    for gamma, row in results["stages"].items():
        parts = [f"{stage} {shown(row[stage])}" for stage in row if stage not in ("points", "all")]
        found[f"gamma = {gamma}: us a point on one core"] = (
            f"{shown(row['all'])}: {', '.join(parts)}"
        )
    for kind, row in results["kinds"].items():
        found[f"points that are {kind}, seconds of one core, lanes full"] = (
            f"{row['points']}: {row['seconds']:.1f} s, {100 * row['lanes_full']:.0f} %"
        )
    late = results["late"]
    sizes, seconds = ", ".join(late["seconds"]), listed(list(late["seconds"].values()))
    found[f"{late['points']} of {late['of_all']} late points in groups of {sizes}"] = f"{seconds} s"
    if "patience" in results:
        for patience, row in results["patience"].items():
            what = f"four temperatures of it, points left for later after {patience} periods"
            found[what] = f"{shown(row['seconds'])} s of one core"
    return found
