"""Seconds for the sweeps of Figs. 7, 8 and 9 with compiled code ready, on two threads.

Each sweep runs once as a warm-up and then RUNS times; the median is the result.
"""

from __future__ import annotations

import statistics
import time

from environment import write_results

from sweeps import run
from sweeps.shipped import shipped_config

RUNS = 5


def main() -> None:
    results = {}
    for name in ("fig7", "fig8", "fig9"):
        ds = run(shipped_config(name), workers=2)
        seconds = [_seconds(name) for _ in range(RUNS)]
        results[name] = {
            "points": int(ds.status.size),
            "failed": int((ds.status != 0).sum()),
            "seconds_median": round(statistics.median(seconds), 3),
            "seconds": [round(s, 3) for s in seconds],
            "periods_integrated_median": float(ds.periods_integrated.median()),
            "amplitude_error_median": float(ds.amplitude_error.median()),
            "amplitude_error_max": float(ds.amplitude_error.max()),
            "power_balance_error_max": float(ds.power_balance_error.max()),
        }
        print(name, results[name])
    print(write_results("figures", results))


def _seconds(name: str) -> float:
    begun = time.perf_counter()
    run(shipped_config(name), workers=2)
    return time.perf_counter() - begun


if __name__ == "__main__":
    main()
