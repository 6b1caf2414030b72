"""Many trajectories at once, for those who want states and not orbits."""

from __future__ import annotations

import numpy as np

from stickslip import kernels
from stickslip.options import Options
from stickslip.orbit import prepared_points


def end_states(
    points: np.ndarray, periods: int, options: Options
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where trajectories are after a number of drive periods from their starts.

    Parameters
    ----------
    points
        (n, 20) parameters in SI units, in the order of `Parameters._fields`.
    periods
        Drive periods to integrate.
    options
        `rtol`, `max_steps`, `noise`; the method is adaptive, in lanes.

    Returns
    -------
    states
        (n, 3): x [m], v [m/s], ln(phi).
    steps
        (n,) attempted steps.
    statuses
        (n,) the Status of each as an integer; unless ok the state is where the lane stopped.

    Raises
    ------
    NoiseError
        phi_0 = 0 without noise.
    """
    points = prepared_points(points, options.noise)
    return kernels.lane_end_states(points, periods, options.settings())
