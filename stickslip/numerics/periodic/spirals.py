"""The middle of a spiral: the limit of a sequence that turns while it contracts.

Two displacements and their images determine the map of both components; the secant step to the
limit is a Newton step with this map.
"""

from __future__ import annotations

import math
from typing import Any

from stickslip.compiled.decorators import inline, jit
from stickslip.numerics.periodic.convergence import displacement
from stickslip.numerics.periodic.ratios import CLEARANCE, length_of, stands_out

# The smallest angle between displacements, as a sine; and the largest error of their map, as a
# fraction of the newest displacement (relative to the way to the limit), and of earlier ones.
_LEAST_ANGLE = 0.05
_MISSED, _MORE_OR_LESS = 0.3, 0.3

# Before the first jump a spiral must have shrunk by this factor, or lasted for this many
# applications. A film that freezes now and then moves on spirals in between, which do not end at
# the limit.
_SHRUNK = 30.0
_LONGEST_HELD = 64.0

# A spiral that appears within this many of its lags after a jump is the same one.
_SOON = 8

# The determinant of a sequence that is known to contract is no larger than this.
_LARGEST_DETERMINANT = 1.0 - 1e-6


@inline
def held_for(memory: Any, lag: int, radius: float) -> int:
    """Number of applications that a spiral must last before a jump to its middle.

    The spiral contracts by `radius` over `lag` applications.
    """
    if memory.jumps > 0 and memory.newest <= _SOON * lag:
        return 4 * lag
    shrunk = min(_LONGEST_HELD, lag * math.log(_SHRUNK) / -math.log(radius))
    return max(4 * lag, math.ceil(shrunk))


@jit
def middle_of_spiral(
    memory: Any, newest: int, lag: int, noise: float
) -> tuple[float, float, float]:
    """Return the way (dx, dv) to the middle of a spiral, and its contraction, 0 if there is none.

    Three displacements over `lag` applications determine their map, and all displacements in
    `held_for` must confirm it. The contraction must be known, or clear of the noise.
    """
    a = displacement(memory, newest - 3 * lag, newest - 4 * lag)
    b = displacement(memory, newest - 2 * lag, newest - 3 * lag)
    c = displacement(memory, newest - lag, newest - 2 * lag)
    d = displacement(memory, newest, newest - lag)
    area = a[0] * b[1] - a[1] * b[0]
    lengths = length_of(a), length_of(b), length_of(c), length_of(d)
    if not (CLEARANCE * noise <= lengths[3] and lengths[3] <= memory.calm):
        return 0.0, 0.0, 0.0
    if not abs(area) >= _LEAST_ANGLE * lengths[0] * lengths[1]:
        return 0.0, 0.0, 0.0
    # The map that takes a to b and b to c.
    xx, xv = (b[0] * b[1] - c[0] * a[1]) / area, (c[0] * a[0] - b[0] * b[0]) / area
    vx, vv = (b[1] * b[1] - c[1] * a[1]) / area, (c[1] * a[0] - b[1] * b[0]) / area
    determinant, trace = xx * vv - xv * vx, xx + vv
    away = 1.0 - trace + determinant
    contracting = memory.contracting >= 4 * lag
    determinant = min(determinant, _LARGEST_DETERMINANT) if contracting else determinant
    if not (4.0 * determinant > trace * trace and determinant < 1.0 and away > 0.0):
        return 0.0, 0.0, 0.0
    radius = math.sqrt(determinant)
    held = held_for(memory, lag, radius)
    if held > newest:
        return 0.0, 0.0, 0.0
    image = xx * d[0] + xv * d[1], vx * d[0] + vv * d[1]
    way = (
        ((1.0 - vv) * image[0] + xv * image[1]) / away,
        (vx * image[0] + (1.0 - xx) * image[1]) / away,
    )
    for newer in range(newest - held + 2 * lag, newest + 1):
        d = displacement(memory, newer, newer - lag)
        c = displacement(memory, newer - lag, newer - 2 * lag)
        missed = length_of((d[0] - (xx * c[0] + xv * c[1]), d[1] - (vx * c[0] + vv * c[1])))
        strictness = _MORE_OR_LESS
        if newer == newest:
            strictness = _MISSED / max(1.0, length_of(way) / lengths[3])
        if not missed <= strictness * length_of(d):
            return 0.0, 0.0, 0.0
    clear = contracting or stands_out(radius, lengths[3], noise)
    return way[0], way[1], radius if clear else 0.0
