"""Print the errors of a smooth motion by the new method, for steps that are halved."""

import json
import sys

from stickslip import Parameters, simulate

NEWTONIAN = Parameters(
    temperature=310.0,
    rheological_index=0.0,
    viscosity_coefficient=1e3,
    kinetic_coefficient=1e-2,
    angular_frequency=30.0,
    initial_order_parameter=0.05,
)


def motion(**options):
    return simulate(NEWTONIAN, periods=1, samples_per_period=16, **options)


exact, names = motion(rtol=1e-12), ("lower_velocity", "order_parameter", "friction_force")
errors = {name: [] for name in names}
for dt in (2e-4, 1e-4, 5e-5):
    found = motion(method="rk4", dt=dt)
    for name in names:
        miss = abs(found[name] - exact[name]).max() / abs(exact[name]).max()
        errors[name].append(float(miss))
json.dump(errors, sys.stdout)
