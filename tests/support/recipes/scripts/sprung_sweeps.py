"""Print orbits with a rigid upper block, and with one on springs of 1e7, 1e8 and 1e9 N/m."""

import json
import sys

from sweeps import run

CASES = {
    "locked": {"gamma": 0, "T": 200, "K": 500, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6},
    "liquid": {"gamma": 0, "T": 310, "K": 1e4, "omega": 30, "x_0": 0.8e-6},
}
found = {}
for case, model in CASES.items():
    sprung = [({"strain": "sprung"}, {"upper_stiffness": K_2}) for K_2 in (1e7, 1e8, 1e9)]
    found[case] = []
    for film, more in [({}, {}), *sprung]:
        ds = run(
            {
                "model": model | more,
                "film": film,
                "integrator": {"rtol": 1e-8},
                "stationary": {"rtol": 1e-8},
            },
            workers=1,
        )
        found[case].append({name: float(ds[name]) for name in ds.data_vars})
json.dump(found, sys.stdout)
