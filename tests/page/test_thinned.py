"""Orbits in a page: fewer samples, between which straight lines miss nothing."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("bokeh", reason="bokeh is not installed")
from sweeps.page.chosen_orbits import thinned


def test_lines_between_the_kept_samples_miss_no_curve():
    time = np.linspace(0.0, 1.0, 4001)
    heights = np.stack([np.sin(20 * time), np.where(time < 0.3, 0.0, 5.0), np.zeros_like(time)])
    kept = thinned(np.stack([time, *heights]))
    assert 20 < kept.size < 1000
    for height in heights:
        missed = np.abs(np.interp(time, time[kept], height[kept]) - height).max()
        assert missed <= 1e-3 * max(np.ptp(height), 1e-300)
