"""Laws of the viscous stress, each in one file with all that other code needs of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import import_module
from typing import Any

from stickslip.compiled.code_hash import code_hash
from stickslip.compiled.compilers import Part
from stickslip.compiled.decorators import inline
from stickslip.laws import LawError, Origin, origin_in_python, origin_of, register
from stickslip.options import FRICTION_LAWS, full_law_name


@dataclass(frozen=True, eq=False)
class FrictionLaw:
    """A law of the viscous stress, as inline functions of the parameters `p`.

    Code that integrates, measures, scales or bounds the friction uses nothing else. The stress is
    odd in the relative velocity `u`; its size decreases neither with the speed nor with the order
    parameter `phi`. The functions are called in SI units and in the units of `model/scaling.py`, so
    numbers with a unit must come from `p`. `register_law` shows a complete example.

    >>> newtonian = FrictionLaw(
    ...     name="newtonian",
    ...     stress=lambda p, u, phi: p.viscosity_coefficient * (u / p.film_thickness),
    ...     rounded=lambda p, u, phi, u_s: (
    ...         p.viscosity_coefficient * (u / p.film_thickness),
    ...         p.viscosity_coefficient / p.film_thickness,
    ...         0.0,
    ...     ),
    ...     has_cusp=lambda p: False,
    ...     stable_slope=lambda p, u, phi: p.viscosity_coefficient / p.film_thickness,
    ...     scaled={
    ...         "viscosity_coefficient": lambda p, rate, stress: (
    ...             p.viscosity_coefficient * rate / stress
    ...         )
    ...     },
    ... )
    >>> newtonian.stress(Parameters(k=2.0, h=1e-9), 1e-9, 0.0)
    2.0
    """

    name: str

    stress: Callable[..., float]
    """(p, u, phi): viscous stress [Pa], exact."""

    rounded: Callable[..., tuple[float, float, float]]
    """(p, u, phi, u_s): stress and its derivatives with respect to `u` [Pa s/m] and ln(phi) [Pa],
    with a cusp at u = 0 rounded for |u| < u_s. Orbits are integrated with this function. Far from
    the cusp, and for u_s = 0, it equals `stress`; an infinite slope becomes a huge finite one."""

    has_cusp: Callable[..., bool]
    """(p): whether the slope is infinite at u = 0."""

    stable_slope: Callable[..., float]
    """(p, u, phi): the largest slope with respect to `u` [Pa s/m] up to this speed and order
    parameter, except at a cusp. It bounds an explicit step."""

    scaled: Mapping[str, Callable[..., float]] = field(default_factory=dict)
    """Parameters whose unit does not determine their scaling: for each name a function
    (p, rate, stress) of the value in the units `rate` [1/s] of strain rate and `stress` [Pa]."""

    parameters: tuple[str, ...] = ()
    """The parameters that this law uses, including those it shares with other laws."""

    special_indices: tuple[float, ...] = ()
    """Rheological indices with specialised kernels, in which powers are roots."""

    fluids: tuple[Mapping[str, float], ...] = ()
    """Parameters, by name or symbol, of the fluids in which the law is checked; by default
    power laws with indices from -0.9 to 5."""


def friction_law(name: str) -> FrictionLaw:
    """Return a law by its name in `options.FRICTION_LAWS`, or by the name of a law from outside.

    Raises LawError if the law is unknown, or breaks a promise of laws.
    """
    if name in FRICTION_LAWS:
        shipped: FrictionLaw = import_module(FRICTION_LAWS[name]).LAW
        return shipped
    law, complaint = _judged(origin_of(full_law_name(name)))
    if law is None:
        raise LawError(complaint)
    return law


def register_law(law: FrictionLaw) -> None:
    """Register a law of your own, for the options and configs of this process.

    The example is a stress with an upper limit: k is the limit in Pa, gamma the strain rate in s-1
    at which the stress levels off. A number with a unit in the code of a law is refused.

    >>> import math
    >>> from stickslip.compiled.decorators import inline
    >>> @inline
    ... def stress(p, u, phi):
    ...     rate = u / p.film_thickness
    ...     return p.viscosity_coefficient * math.atan(rate / p.rheological_index)
    >>> @inline
    ... def slope(p, u):
    ...     ratio = u / p.film_thickness / p.rheological_index
    ...     steepest = p.viscosity_coefficient / p.rheological_index / p.film_thickness
    ...     return steepest / (1.0 + ratio * ratio)
    >>> register_law(
    ...     FrictionLaw(
    ...         name="limited",
    ...         stress=stress,
    ...         rounded=lambda p, u, phi, u_s: (stress(p, u, phi), slope(p, u), 0.0),
    ...         has_cusp=lambda p: False,
    ...         stable_slope=lambda p, u, phi: slope(p, 0.0),
    ...         scaled={
    ...             "viscosity_coefficient": lambda p, _, stress: p.viscosity_coefficient / stress,
    ...             "rheological_index": lambda p, rate, _: p.rheological_index / rate,
    ...         },
    ...         parameters=("viscosity_coefficient", "rheological_index"),
    ...         fluids=({"k": 1e6, "gamma": 1e3}, {"k": 1e4, "gamma": 1e6}),
    ...     )
    ... )
    >>> path = simulate(Parameters(T=320, k=1e6, gamma=1e3), periods=1, friction="limited")
    >>> path.friction_force.max().round(6).item()
    0.000874

    The functions may be plain Python. Such a law is computed in threads; the processes of loky and
    dask do not know it, and refuse it. For them, and for later runs, put the law into a package
    (docs/how-to/friction-law.md). A name may be registered again.

    Parameters
    ----------
    law
        The law. No law of stickslip or of an installed package may have its name.

    Raises
    ------
    LawError
        The name is taken, the law breaks a promise of laws, or its functions refer to anything but
        numbers, functions and the modules math, numpy, numba and stickslip.
    """
    if law.name in FRICTION_LAWS:
        raise LawError(f"{law.name!r} is a law of stickslip itself; choose another name")
    try:
        code = code_hash([*_functions(law).values(), *law.scaled.values(), _declared(law)])
    except TypeError as error:
        raise LawError(f"friction law {law.name!r}: {error}") from None
    origin = origin_in_python(law.name, code, law)
    judged, complaint = _judged(origin)
    if judged is None:
        raise LawError(complaint)
    register(origin)


@cache
def _judged(origin: Origin) -> tuple[FrictionLaw | None, str]:
    """Return a law from outside with inline functions, or None and what is wrong with it."""
    from stickslip.model.laws.promises import require_promises  # needs units, which need laws

    try:
        law = origin.load()
        if not isinstance(law, FrictionLaw) or law.name != origin.name:
            raise LawError(f"it is {law!r:.60}, not a FrictionLaw called {origin.name!r}")
        inlined = {name: _inlined(function) for name, function in _functions(law).items()}
        scaled = {name: _inlined(function) for name, function in law.scaled.items()}
        law = replace(law, **inlined, scaled=scaled)
        require_promises(law, origin.full_name)
    except Exception as error:  # noqa: BLE001 - code of others may raise anything
        kind = "" if isinstance(error, LawError) else f"{type(error).__name__}: "
        return None, f"friction law {origin.name!r} of {origin.identity}: {kind}{error}"
    return law, ""


def _declared(law: FrictionLaw) -> tuple[Any, ...]:
    """Return everything that a law declares except its functions, as plain values."""
    fluids = tuple(tuple(sorted(fluid.items())) for fluid in law.fluids)
    return tuple(law.scaled), tuple(law.parameters), tuple(law.special_indices), fluids


def _functions(law: FrictionLaw) -> dict[str, Callable[..., Any]]:
    return {name: getattr(law, name) for name in ("stress", "rounded", "has_cusp", "stable_slope")}


def _inlined(function: Any) -> Any:
    """Return a function with our compiler flags, even if it was compiled with others."""
    if isinstance(function, Part):
        return function
    return inline(getattr(function, "py_func", function))
