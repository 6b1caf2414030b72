"""Observables of a sweep: in its file if they are asked for, whatever happens to it on the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support.sweeps.sweeping import LOOSE, ONE_BY_ONE, Shell, hash_of, write

from stickslip import Parameters, stationary_orbit
from stickslip.variables import asked_columns
from sweeps.files.datasets import open_result

THREE = "sweep: {temperature: [200, 225, 250]}\n"
FOUR = "sweep: {temperature: [200, 225, 250, 275]}\n"
ASKED = "observables: [harmonics]\n"
A_YAML = THREE + LOOSE + ASKED


def test_an_interrupted_sweep_and_one_that_grows_have_them_too(shell: Shell) -> None:
    assert shell("sweep", "a.yaml", "-o", "a.nc").code == 0
    step = write("b.yaml", THREE, LOOSE, ASKED, ONE_BY_ONE)
    shell.interrupted("sweep", step, "-o", "b.nc", after=2)
    assert shell("sweep", step, "-o", "b.nc").code == 0
    assert hash_of("b.nc") == hash_of("a.nc")
    assert shell("sweep", write("c.yaml", FOUR, LOOSE, ASKED), "-o", "a.nc").code == 0
    assert shell.values("temperature") == [275.0]
    ds = open_result(Path("a.nc"))
    assert set(ds.data_vars) == set(asked_columns(["harmonics"]))
    for temperature in (200.0, 275.0):
        p = Parameters(temperature=temperature)
        orbit = stationary_orbit(p, rtol=1e-4, observables="harmonics")
        found = ds.sel(temperature=temperature).friction_force_out_of_phase
        np.testing.assert_equal(found.item(), orbit.friction_force_out_of_phase)


def test_a_result_without_them_is_not_extended_by_them(shell: Shell) -> None:
    plain = write("b.yaml", THREE, LOOSE)
    assert shell("sweep", plain, "-o", "a.nc").code == 0
    before = hash_of("a.nc")
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert (code, shell.computed, hash_of("a.nc")) == (2, [], before)
    assert "  observables: not set -> ['harmonics']\n" in err
    code, _, err = shell("plot", "a.nc", "--variable", "friction_force_rms", "-o", "a.png")
    assert code != 0
    assert "was not asked for; sweep it again with `observables: [moments]`" in err
    assert shell("plot", "a.nc", "--variable", "dissipated_energy", "-o", "a.png").code == 0


def test_a_trajectory_of_such_a_config_is_computed_as_any_other(shell: Shell) -> None:
    assert shell("simulate", "a.yaml", "--set", "T=200", "-o", "b.nc").code == 0
