"""Run small sweeps by the method named first, for the cases that follow or for all."""

import json
import sys

from sweeps import run

MODEL = {"gamma": 0, "T": 250, "delta": 1.0, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6}
METHODS = {
    "adaptive": {"rtol": 1e-5},
    "euler-cromer": {"method": "euler-cromer", "dt": 1e-7},
    "rk4": {"method": "rk4", "dt": 2e-6},
}
EYRING = {"friction": "eyring"}
CASES = {
    "plain": ({}, {}),
    "eyring": ({"gamma": "-2/3"}, EYRING),
    "stiffer eyring": ({"gamma": "-2/3", "eyring_stress": 4e5}, EYRING),
    "liquid eyring": ({"gamma": "-2/3", "T": 310, "K": 1e4}, EYRING),
    "octic": ({"octic_coefficient": 400.0}, {}),
    "plateau": ({"plateau_viscosity": 5e4}, {}),
    "damped": ({"block_damping": 100.0}, {}),
    "two tones": ({"seventh_harmonic": 0.25}, {}),
    "two tones of a mirrored drive": (
        {"seventh_harmonic": 0.25, "X_m": -0.8e-6, "x_0": -0.8e-6},
        {},
    ),
    "thickened": ({"viscosity_growth": 3.0}, {"friction": "of-the-solid"}),
    "not thickened": ({}, {"friction": "of-the-solid"}),
}
CASES = {case: CASES[case] for case in sys.argv[2:] or CASES}
found = {}
for case, (changes, film) in CASES.items():
    ds = run(
        {
            "model": MODEL | changes,
            "film": film,
            "integrator": METHODS[sys.argv[1]],
            "stationary": {"rtol": 1e-5},
        },
        workers=1,
    )
    found[case] = {name: float(ds[name]) for name in ds.data_vars}
json.dump(found, sys.stdout)
