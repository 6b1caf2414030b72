"""A user's law of friction, and an installed package with it."""

from __future__ import annotations

from pathlib import Path

LAW = """
import math

from stickslip import FrictionLaw
from stickslip.compiled.decorators import inline


@inline
def _stress(p, u, phi):
    rate = u / p.film_thickness
    return FACTOR * p.viscosity_coefficient * math.atan(rate / p.rheological_index)


@inline
def _slope(p, u):
    ratio = u / p.film_thickness / p.rheological_index
    steepest = FACTOR * p.viscosity_coefficient / p.rheological_index / p.film_thickness
    return steepest / (1.0 + ratio * ratio)


def rounded(p, u, phi, u_s):
    return _stress(p, u, phi), _slope(p, u), 0.0


LIMITED = FrictionLaw(
    name="limited",
    stress=_stress,
    rounded=rounded,
    has_cusp=lambda p: False,
    stable_slope=lambda p, u, phi: _slope(p, 0.0),
    scaled={
        "viscosity_coefficient": lambda p, rate, stress: p.viscosity_coefficient / stress,
        "rheological_index": lambda p, rate, stress: p.rheological_index / rate,
    },
    parameters=("viscosity_coefficient", "rheological_index"),
    fluids=({"k": 1e6, "gamma": 1e3}, {"k": 1e4, "gamma": 1e6}),
)
"""
"""The source of a law whose stress a rate limits; it needs a `FACTOR` before it."""

MODEL = "model: {k: 1e6, gamma: 1000, omega: 30}\nsweep: {T: {linspace: [200, 320], num: 4}}\n"
LOOSE = "integrator: {rtol: 1e-4}\nstationary: {rtol: 1e-4}\n"
CONFIG = f"{MODEL}film: {{friction: limited}}\n{LOOSE}"


def install(site: Path, *, factor: float = 1.0, version: str = "1.0", name: str = "pliant") -> Path:
    """Write a distribution with the law into a folder, as an installer does; return its module."""
    package, info = site / name, site / f"{name}-{version}.dist-info"
    for folder in (package, info):
        folder.mkdir(parents=True, exist_ok=True)
        folder.chmod(0o755)
    files = {
        package / "__init__.py": "",
        package / "laws.py": f"FACTOR = {factor}\n{LAW}",
        info / "METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        info / "entry_points.txt": f"[stickslip.laws]\nlimited = {name}.laws:LIMITED\n",
    }
    listed = [*files, package / "__pycache__" / "laws.pyc"]  # as pip does
    record = "".join(f"{path.relative_to(site).as_posix()},,\n" for path in listed)
    for path, text in {**files, info / "RECORD": record}.items():
        path.write_text(text)
        path.chmod(0o644)
    return package / "laws.py"
