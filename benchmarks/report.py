"""One table of the results in `results/*.json`: written to `results/report.md` and printed.

A script chooses its lines by a dict `headline` (what: value) in its results; for others every
plain number at the top of the results, or one level below, is a line.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"

Line = tuple[str, str]


def main() -> None:
    files = sorted(RESULTS.glob("*.json"))
    if not files:
        print("no results yet: run the bench_*.py scripts first")
        return
    text = report(files)
    (RESULTS / "report.md").write_text(text)
    print(text)


def report(files: list[Path]) -> str:
    """The table of all files, in markdown."""
    rows, machines = [], set()
    for path in files:
        try:
            content = json.loads(path.read_text())
            environment, results = content["environment"], content["results"]
        except (OSError, ValueError, KeyError, TypeError):
            rows.append((path.stem, "", "not readable", ""))
            continue
        commit = environment.get("commit", "unknown")
        machines.add(environment.get("processor", "unknown"))
        rows += [(path.stem, what, value, commit) for what, value in _lines(results)]
    table = ["| benchmark | what | value | commit |", "|---|---|---|---|"]
    table += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([*table, "", "Measured on: " + "; ".join(sorted(machines)) + ".", ""])


def _lines(results: Any) -> Iterator[Line]:
    if not isinstance(results, dict):
        return
    if isinstance(results.get("headline"), dict):
        yield from ((what, _shown(value)) for what, value in results["headline"].items())
    elif "regimes" in results:
        yield from _work_precision(results)
    else:
        yield from _plain(results)


def _work_precision(results: dict[str, Any]) -> Iterator[Line]:
    """The ratios of each fluid, Euler-Cromer, and the failures."""
    for name, regime in results["regimes"].items():
        for row in regime["ratios"]["times_faster"]:
            error = "its own error" if row["error"] is None else f"error {row['error']:.0e}"
            value = "not reached" if row["ratio"] is None else f"{row['ratio']:.3g} times faster"
            yield f"{name}: {row['what']}, {error}", value
        reference = regime["reference"]
        if "tightest_peer" in reference:
            peer = f"{reference['tightest_peer']} at {reference['its_rtol']:g}"
            yield f"{name}: reference against {peer}", f"{reference['disagreement']:.1e}"
        for curve in regime["curves"]:
            if curve["failures"]:
                yield f"{name}: {curve['solver']} fails", _failures(curve["failures"])
    for row in results["random"]["rows"]:
        yield f"random points: {row['solver']}, rtol {row['rtol']:.0e}", _random(row)


def _failures(failures: list[dict[str, Any]]) -> str:
    reasons: dict[str, list[str]] = {}
    for failure in failures:
        reasons.setdefault(failure["reason"], []).append(f"{failure['rtol']:.0e}")
    return "; ".join(f"rtol {', '.join(at)}: {why}" for why, at in reasons.items())


def _random(row: dict[str, Any]) -> str:
    parts = [f"{row['failed']} failed"] if row["failed"] else []
    if "error_median" in row:
        parts.append(f"error {row['error_median']:.1e} (95 %: {row['error_95']:.1e})")
        parts.append(f"{1e3 * row['seconds_per_period_mean']:.3g} ms per period in the mean")
    if "seconds_per_period_median" in row:
        median, late = row["seconds_per_period_median"], row["seconds_per_period_95"]
        parts.append(f"median {1e3 * median:.3g} ms (95 %: {1e3 * late:.3g} ms)")
    return "; ".join(parts)


def _plain(results: dict[str, Any]) -> Iterator[Line]:
    for key, value in results.items():
        if isinstance(value, dict):
            inner = {k: v for k, v in value.items() if isinstance(v, (int, float, str))}
            yield from ((f"{key}: {k}", _shown(v)) for k, v in inner.items())
        elif isinstance(value, (int, float, str)) or _short(value):
            yield key, _shown(value)


def _short(value: Any) -> bool:
    return (
        isinstance(value, list)
        and len(value) <= 4
        and all(isinstance(item, (int, float)) for item in value)
    )


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(_shown(item) for item in value) or "none"
    return f"{value:.3g}" if isinstance(value, float) else str(value).replace("|", "\\|")


if __name__ == "__main__":
    main()
