"""`stickslip sensitivity`: Sobol indices over the box of a config, as a file and a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.sweeps.commands import Command

from stickslip import sensitivity_indices
from stickslip.boxes import Design
from stickslip.distributions import Range
from stickslip.indices import indices_of
from stickslip.variables import RESULT_COLUMNS
from sweeps.files.netcdf import open_result
from sweeps.sensitivity import summary_of

BOX = """\
model: {gamma: 0}
sample: {sobol: 16, seed: 3, temperature: [280, 300], k: {log: [2e4, 1e5]}}
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4}
"""


def test_the_command_writes_the_indices_of_the_function(command: Command) -> None:
    Path("box.yaml").write_text(BOX)
    done = command.ok("sensitivity", "box.yaml", "--of", "friction_force_amplitude", "-o", "i.nc")
    assert "64 points, 16 of 16 base points used; 95 % intervals" in done.out
    assert "viscosity_coefficient" in done.out
    assert "motions: 56.2% liquid, 34.4% locked, 9.4% stick_slip_symmetric" in done.out
    assert Path("i.png").is_file()
    written = open_result(Path("i.nc"))
    known = sensitivity_indices(
        {"T": (280, 300), "k": {"log": (2e4, 1e5)}, "gamma": 0},
        "friction_force_amplitude",
        base_points=16,
        seed=3,
        rtol=1e-4,
    )
    for name in known.data_vars:
        np.testing.assert_array_equal(written[name], known[name], err_msg=str(name))
    again = command("sensitivity", "box.yaml", "--of", "F_max", "-o", "i.nc")
    assert again.code == 0
    assert "complete, nothing to do" in again.err
    command.ok("plot", "i.nc", "-o", "again.svg")


def test_the_summary_gives_the_level_in_full_and_says_where_no_interval_is_known() -> None:
    design = Design.of({"temperature": Range(280.0, 300.0)}, 16, 3)
    rows = np.zeros((48, len(RESULT_COLUMNS)))
    rows[0, RESULT_COLUMNS.index("solid_fraction")] = 1.0
    lines = summary_of(indices_of(design, rows, ["solid_fraction"], confidence=0.999)).splitlines()
    assert lines[0] == "48 points, 16 of 16 base points used; 99.9 % intervals"
    assert lines[-1].count("no interval") == 2


@pytest.mark.parametrize(
    ("changed", "arguments", "message"),
    [
        ("sweep: {T: [200, 250]}\n", (), "indices need a box that a Sobol sequence samples"),
        (BOX + "sweep: {K: [500, 900]}\n", (), "leave out `sweep`"),
        (BOX.replace("16", "20"), (), "power of 2"),
        (BOX, ("--of", "force"), "no result force; there are elastic_stress_amplitude"),
        (BOX, ("--of", "asymmetry", "--of", "asymmetry"), "asymmetry is named twice"),
        (BOX, ("--confidence", "95"), "confidence must be between 0 and 1, not 95"),
        (BOX, ("--largest-missing", "2"), "must be from 0 to 1, not 2"),
    ],
)
def test_configs_and_options_without_indices_are_refused(
    command: Command, changed: str, arguments: tuple[str, ...], message: str
) -> None:
    Path("box.yaml").write_text(changed)
    done = command("sensitivity", "box.yaml", *arguments)
    assert done.code == 2, done.err
    assert message in done.err
    assert not Path("results").exists()
