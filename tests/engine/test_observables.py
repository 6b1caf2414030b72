"""The key `observables` of earlier versions, and files without these results."""

from __future__ import annotations

import netCDF4
import xarray as xr
from support.sweeps.sweeping import LOOSE, Shell, hash_of, write

THREE = "sweep: {temperature: [200, 225, 250]}\n"
A_YAML = THREE + LOOSE + "observables: [harmonics]\n"


def test_a_config_with_observables_equals_one_without(shell: Shell) -> None:
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    plain = write("b.yaml", THREE, LOOSE)
    assert "nothing to do" in shell("sweep", plain, "-o", "a.nc").err
    shell.ok("simulate", "a.yaml", "--set", "T=200", "-o", "b.nc")


def test_a_file_without_observables_is_shown_and_replayed_and_not_grown(shell: Shell) -> None:
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    with xr.open_dataset("a.nc") as ds:
        ds.drop_vars(["friction_force_rms", "friction_force_mean_abs"]).to_netcdf("b.nc")
    with netCDF4.Dataset("b.nc", "a") as file:
        file.config += "observables:\n- harmonics\n"
    before = hash_of("b.nc")
    more = write("c.yaml", "sweep: {temperature: [200, 225, 250, 275]}\n", LOOSE)
    code, _, err = shell("sweep", more, "-o", "b.nc")
    assert (code, shell.computed, hash_of("b.nc")) == (2, [], before)
    assert "lacks friction_force_rms, friction_force_mean_abs, which this version computes" in err
    shell.ok("replay", "b.nc", "--at", "T=225", "--no-progress")
    shell.ok("plot", "b.nc", "--variable", "dissipated_energy", "-o", "a.png")
    code, _, err = shell("plot", "b.nc", "--variable", "friction_force_rms", "-o", "b.png")
    assert code != 0
    assert "lacks friction_force_rms: it was left out, or an older version made the result" in err
