"""What experiments report of an orbit, against independent integrators.

LSODA on the same equations, settled to 1e-9 of X_m; good to the digits that stand here.
"""

from __future__ import annotations

import pytest

from stickslip import Parameters, stationary_orbit

MEASURED: dict[float, dict[str, float]] = {
    200.0: {"dissipated_energy": 3.343224e-9},
    250.0: {"dissipated_energy": 1.828701e-9},
}
DIGITS = 0.5e-6  # relative, of the last digit of a number that begins with 1


@pytest.mark.parametrize("temperature", MEASURED)
def test_they_are_those_of_independent_integrators(temperature: float) -> None:
    orbit = stationary_orbit(Parameters(temperature=temperature), rtol=1e-10)
    for name, value in MEASURED[temperature].items():
        assert getattr(orbit, name) == pytest.approx(value, rel=DIGITS), name
