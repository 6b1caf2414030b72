"""What a step in lanes costs, against what the machine could do it in, for each kernel.

For each fluid: vector operations in an attempted step of all lanes and in the look at it that
measures, from their machine code; the least time in which this machine does so many, by rates
measured in the same run; the time of the loops alone; and the time in a search for orbits, where
lanes are also loaded, judged and idle. Then a single trajectory, by the scalar drive and in one of
the lanes. The fixed step is the affair of bench_fixed_lanes.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from common import arguments, finish, parameter, random_points
from inside import LaneLoops, attempted, lane_end, scalar_end, search
from parts.machine_code import counted, fastest, least_time, rates

from stickslip.compiled.simd import LANES
from stickslip.options import Options

GAMMAS = (-2 / 3, -1 / 3, 0.0, 1 / 3, 2 / 3, -1 / 2)
SEED, POINTS = 7, 4096
CALLS = 20_000
PERIODS = 20  # of a single trajectory


def main() -> None:
    quick = arguments(__doc__).quick
    can = rates()
    print("vector operations a nanosecond:", {kind: f"{rate:.3g}" for kind, rate in can.items()})
    drawn = random_points(POINTS // 16 if quick else POINTS, SEED)
    gammas = parameter(drawn, "rheological_index")
    rows = {
        f"{gamma:.2f}": _row(gamma, drawn[np.isclose(gammas, gamma)], can)
        for gamma in (GAMMAS[:1] if quick else GAMMAS)
    }
    finish("lanes", {"rates": can, "lanes": LANES, "fluids": rows}, quick=quick)


def _row(gamma: float, points: np.ndarray, can: dict[str, float]) -> dict[str, Any]:
    loops = LaneLoops(points)
    row = {"attempt": _loop(loops, "attempt", can), "see": _loop(loops, "see", can)}
    row["search"] = _search(points, row["attempt"]["least_ns"])
    row["single"] = _single(points[0])
    print(f"gamma = {gamma:.3g}")
    for name, part in row.items():
        print(f"   {name}: " + "  ".join(f"{key} {value:.3g}" for key, value in part.items()))
    return row


def _loop(loops: LaneLoops, name: str, can: dict[str, float]) -> dict[str, float]:
    """Operations of a loop over all lanes; its nanoseconds, the least possible and measured."""
    counts = counted(loops.assembly(name))
    loops.repeat(name, 1)
    ns, least = fastest(lambda: loops.repeat(name, CALLS), CALLS), least_time(counts, can)
    return counts | {"least_ns": least, "ns": ns, "part_of_peak": least / ns}


def _search(points: np.ndarray, least: float) -> dict[str, float]:
    """Nanoseconds of all lanes for an attempted step in the search for orbits of many points."""
    options = Options(rtol=1e-4, max_periods=64)
    attempts = attempted(search(points, options))
    ns = fastest(lambda: search(points, options), attempts / LANES, 3)
    return {"points": len(points), "ns": ns, "part_of_peak": least / ns}


def _single(point: np.ndarray) -> dict[str, float]:
    """Nanoseconds for a drive period of one point, in turn by either way, whose ends agree."""
    options = Options(rtol=1e-6)
    by_scalar, by_lanes = (
        lambda: scalar_end(point, options, PERIODS)[0],
        lambda: lane_end(point, options, PERIODS),
    )
    size = parameter(point[None], "drive_amplitude")[0]
    assert abs(by_scalar() - by_lanes()) < 1e-4 * size
    scalar, lanes = (fastest(run, PERIODS, 9) for run in (by_scalar, by_lanes))
    return {"scalar_ns": scalar, "one_lane_ns": lanes, "ratio": lanes / scalar}


if __name__ == "__main__":
    main()
