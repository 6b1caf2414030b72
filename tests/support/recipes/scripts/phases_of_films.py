"""Print the phases of films, whose parameters are given as the argument."""

import json
import sys

from stickslip import Parameters, phase_diagram
from stickslip.model import solids

found = []
for values in json.loads(sys.argv[1]):
    p = Parameters(**values)
    ds = phase_diagram(p, temperatures=[p.temperature], samples=201)
    found.append(
        {
            "turning points": solids.turning_points(p),
            "thresholds": solids.thresholds(p),
            "largest": solids.largest_order_parameter(p),
            "melting strain": solids.melting_strain(p),
            "melting strain of the page": float(ds.melting_strain[0]),
            "order parameter": ds.order_parameter.values.tolist(),
            "stable": ds.equilibrium_stability.values[0].tolist(),
            "ramp": ds.ramped_order_parameter.values[0].tolist(),
            "strain": ds.ramped_strain.values.tolist(),
        }
    )
json.dump(found, sys.stdout)
