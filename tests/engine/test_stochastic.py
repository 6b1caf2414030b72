"""Sweeps and trajectories of stochastic films."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support import messages
from support.sweeps.sweeping import Shell

from stickslip import Status
from sweeps.config.load import from_mapping
from sweeps.engine.trajectories import trajectory
from sweeps.figures import draw
from sweeps.files.netcdf import open_result
from sweeps.points import point_of

A_YAML = """
model: {omega: 15}
sweep: {T: [190, 200, 210, 220, 300], gamma: [-2/3, 0]}
noise: {treatment: stochastic, realizations: 3, seed: 5}
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4, window: 20}
"""


def test_another_seed_makes_other_points(shell: Shell) -> None:
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc", "--set", "noise.seed=6")
    assert code == 2
    assert "noise.seed: 5 -> 6" in err


def test_a_point_of_a_stochastic_result_is_computed_again_and_drawn(shell: Shell) -> None:
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    point = point_of(open_result(Path("a.nc")), ["T=200", "gamma=0"])
    assert point.status == Status.OK
    assert not point.differences()
    course = point.simulate(periods=1, samples_per_period=50)
    assert course.sizes == {"elapsed_time": 51}
    point.portrait(1)
    code, out, _ = shell("replay", "a.nc", "--at", "T=200", "--at", "gamma=-2/3")
    assert (code, messages.SAME_BITS in out) == (0, True)


def test_the_trajectories_of_a_stochastic_film_are_its_realizations() -> None:
    config = from_mapping(
        {
            "model": {"omega": 15.0},
            "noise": {"treatment": "stochastic", "realizations": 3},
            "simulation": {"periods": 1, "samples_per_period": 20},
        }
    )
    ds = trajectory(config)
    assert ds.sizes == {"realization": 3, "elapsed_time": 21}
    assert ds.realization.values.tolist() == [0, 1, 2]
    assert len(np.unique(ds.order_parameter[:, -1])) == 3
    titles = [axes.get_title(loc="left") for axes in draw(ds, "phase_portraits").axes]
    assert [title for title in titles if title] == [
        f"({'abc'[i]}) realization ${i}$" for i in range(3)
    ]
