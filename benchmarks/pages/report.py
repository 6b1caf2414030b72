"""One table of the records in `results/*.json`: written to `results/report.md` and printed."""

from __future__ import annotations

import json
from pathlib import Path

from pages.headlines import headline

RESULTS = Path(__file__).parents[1] / "results"


def main() -> None:
    files = sorted(RESULTS.glob("*.json"))
    if not files:
        print("no results yet: run the bench_*.py scripts first")
        return
    text = report(files)
    (RESULTS / "report.md").write_text(text, encoding="utf-8")
    print(text)


def report(files: list[Path]) -> str:
    """The table of all files, in markdown; it depends on nothing but their content."""
    rows, machines = [], set()
    for path in files:
        content = json.loads(path.read_text(encoding="utf-8"))
        environment = content["environment"]
        machines.add(environment["processor"])
        for what, value in headline(path.stem, content["results"]).items():
            rows.append((path.stem, what, value.replace("|", "\\|"), environment["commit"]))
    table = ["| benchmark | what | value | commit |", "|---|---|---|---|"]
    table += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([*table, "", "Measured on: " + "; ".join(sorted(machines)) + ".", ""])


if __name__ == "__main__":
    main()
