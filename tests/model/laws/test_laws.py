"""The promises of laws of the viscous stress: our laws keep them, and messages name broken ones.

Every law in `options.FRICTION_LAWS` is tested, in the `fluids` that it declares or in
`promises.FLUIDS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from stickslip.laws import LawError
from stickslip.model.laws import FrictionLaw, friction_law, promises
from stickslip.model.laws.promises import FLUIDS, PROMISES, Fluid, fluids_of, require_promises
from stickslip.options import FRICTION_LAWS
from stickslip.parameters import Parameters

TRIED = [
    (name, number)
    for name in FRICTION_LAWS
    for number in range(len(friction_law(name).fluids or FLUIDS))
]


@pytest.mark.parametrize("promise", PROMISES, ids=lambda promise: promise.__name__)
@pytest.mark.parametrize(("name", "fluid"), TRIED)
def test_a_law_keeps_its_promises(name: str, fluid: int, promise: Callable[[Fluid], None]) -> None:
    promise(fluids_of(friction_law(name), name)[fluid])


@pytest.mark.parametrize("name", FRICTION_LAWS)
def test_a_law_of_stickslip_passes_the_checks_of_outside_laws(name: str) -> None:
    require_promises(friction_law(name), name)


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(LawError, match=r"entry point in the group 'stickslip.laws', or call stick"):
        friction_law("no-such-law")


# --- broken promises ------------------------------------------------------------------------------


def newtonian(p: Parameters, u: float, phi: float) -> float:
    return p.viscosity_coefficient * (u / p.film_thickness)


def steep(p: Parameters) -> float:
    return p.viscosity_coefficient / p.film_thickness


SOUND: dict[str, Any] = {
    "stress": newtonian,
    "rounded": lambda p, u, phi, _: (newtonian(p, u, phi), steep(p), 0.0),
    "has_cusp": lambda *_: False,
    "stable_slope": lambda p, *_: steep(p),
    "own": lambda p, u, phi: newtonian(p, u, phi),
}


def fluid_of(**functions: Any) -> Fluid:
    """A fluid with a law in plain Python; `own` is the stress in the units of the point."""
    f = SOUND | functions

    def sample(point: np.ndarray, where: np.ndarray, _: np.ndarray, out: np.ndarray) -> None:
        p = Parameters(*point)
        for (u, phi, u_s), row in zip(where.tolist(), out, strict=True):
            row[:] = (
                f["stress"](p, u, phi),
                *f["rounded"](p, u, phi, u_s),
                f["stable_slope"](p, u, phi),
                f["own"](p, u, phi),
                f["has_cusp"](p),
            )

    return Fluid(friction_law("power-law"), Parameters(k=1.0, gamma=0.0), sample)


def test_a_sound_law_breaks_no_promise() -> None:
    for promise in PROMISES:
        promise(fluid_of())


BROKEN: dict[str, tuple[Any, dict[str, Any], str]] = {
    "even": (promises.odd, {"stress": lambda p, u, phi: abs(newtonian(p, u, phi))}, r"-u\) = -str"),
    "driving": (promises.odd, {"stress": lambda p, u, phi: -newtonian(p, u, phi)}, "stress > 0"),
    "swallows NaN": (
        promises.odd,
        {"stress": lambda p, u, phi: 0.0 if math.isnan(u) else newtonian(p, u, phi)},
        "stress of NaN is NaN, at u = nan",
    ),
    "falling": (
        promises.rising_with_the_slip,
        {"stress": lambda p, u, phi: newtonian(p, u / (1.0 + 1e4 * u * u), phi)},
        r"stress does not fall with u, at u = -0\.",
    ),
    "falling with phi": (
        promises.rising_with_the_order,
        {"stress": lambda p, u, phi: newtonian(p, u, phi) * (1.0 - 0.1 * phi)},
        r"does not fall with phi, up to 1e-09|does not fall with phi, up to 0\.1",
    ),
    "without its slope over phi": (
        promises.derivative_over_the_log_of_the_order,
        {"stress": lambda p, u, phi: newtonian(p, u, phi) * (1.0 + phi)},
        r"third value of rounded = d stress/d ln\(phi\), at u = 1e-15 .*: 0\.0 instead of 3\.7",
    ),
    "with a wrong slope": (
        promises.slope,
        {"rounded": lambda p, u, phi, _: (newtonian(p, u, phi), 2.0 * steep(p), 0.0)},
        r"slope = d stress/du, at u = -1 m/s, k = 1, gamma = 0: 1999999999.* instead of 1000000000",
    ),
    "infinite at rest": (
        promises.finite_at_rest,
        {"rounded": lambda p, u, phi, _: (newtonian(p, u, phi), math.inf if u == 0 else 1.0, 0.0)},
        "slope is finite and >= 0, at u = 0 m/s",
    ),
    "sticking at rest": (
        promises.finite_at_rest,
        {"stress": lambda p, u, phi: newtonian(p, u, phi) + 1.0},
        r"stress\(0\) = 0, at u = 0 m/s, k = 1, gamma = 0: 1\.0",
    ),
    "rounded elsewhere": (
        promises.exact_away_from_the_cusp,
        {"rounded": lambda p, u, phi, u_s: (newtonian(p, u + u_s, phi), steep(p), 0.0)},
        r"rounded stress at u_s = 10 \|u\| = exact one",
    ),
    "rounded to one side": (
        promises.rounded_odd,
        {"rounded": lambda p, u, phi, u_s: (newtonian(p, u + u_s, phi), steep(p), 0.0)},
        r"rounded\(-u\) = -rounded\(u\)",
    ),
    "rounded with another slope": (
        promises.rounded_slope,
        {"rounded": lambda p, u, phi, u_s: (newtonian(p, u, phi), steep(p) + 1e14 * u_s, 0.0)},
        "slope = d stress/du, rounded at u_s = 8e-12 m/s",
    ),
    "with a cusp it does not have": (
        promises.cusp,
        {"has_cusp": lambda *_: True},
        "slope is unbounded at a cusp, at u = 0",
    ),
    "of a stable slope that is too small": (
        promises.stable_slope,
        {"stable_slope": lambda p, *_: 0.9 * steep(p)},
        "stable_slope >= slope at 0 u",
    ),
    "with a hidden unit": (
        promises.scaled,
        {"own": lambda p, u, phi: 1.1 * newtonian(p, u, phi)},
        r"same in the units of kernels .*, at u = -1\.6e-05 m/s",
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_law_that_breaks_a_promise_is_refused_with_the_speed(name: str) -> None:
    promise, functions, message = BROKEN[name]
    with pytest.raises(LawError, match=message):
        promise(fluid_of(**functions))


def law_of(**changes: Any) -> FrictionLaw:
    functions = {name: SOUND[name] for name in SOUND if name != "own"}
    return FrictionLaw(**{"name": "newtonian", **functions, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"parameters": ("eyring_speed",)}, "no parameter 'eyring_speed'"),
        ({"scaled": {"film_thickness": steep}}, "film_thickness, on which more than the law de"),
        ({"fluids": ({"gamma": -2.0},)}, "`fluids`: rheological_index must be greater than -1"),
    ],
)
def test_a_law_with_invalid_declarations_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(LawError, match=message):
        fluids_of(law_of(**changes), "newtonian")
