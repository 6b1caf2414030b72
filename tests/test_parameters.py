"""Parameters: defaults, bounds from both sides, coercion to float, one compiled signature."""

import copy
import inspect
import math
import pickle
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import Any

import numba
import numpy as np
import pytest

from stickslip import phase_diagram, simulate, stationary_orbit, stationary_orbits
from stickslip.parameters import ParameterError, Parameters, ParameterValues
from stickslip.symbols import plain
from stickslip.variables import (
    PARAMETERS,
    RESULTS,
    ParameterKeywords,
    ParameterVariable,
    canonical_name,
    canonical_result,
)
from sweeps.config.load import from_mapping

TINY = 5e-324  # the smallest positive float

LARGE = 1e300
# With these the order parameter grows without bound unless the sextic coefficient is positive.
BOUNDED = {"quartic_coefficient", "quintic_coefficient"}


def edges(variable: ParameterVariable) -> tuple[list[float], list[float]]:
    """The last accepted and the first refused values at the ends of a range.

    tests/docs compares the ranges with docs/configuration.md.
    """
    lower, upper = variable.lower, variable.upper
    taken, refused = [min(upper, LARGE)], [math.inf, -math.inf, math.nan]
    if math.isfinite(lower):
        taken.append(math.nextafter(lower, math.inf))
        (refused if variable.lower_open else taken).append(lower)
        refused.append(math.nextafter(lower, -math.inf))
    else:
        taken.append(-LARGE)
    if math.isfinite(upper):
        refused.append(math.nextafter(upper, math.inf))
    if variable.nonzero:
        taken += [TINY, -TINY]
        refused += [0.0, -0.0]
    return taken, refused


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_range_ends_where_it_says(name: str):
    taken, refused = edges(PARAMETERS[name])
    bound = {"sextic_coefficient": 1.0} if name in BOUNDED else {}
    for value in taken:
        assert getattr(Parameters(**{name: value} | bound), name) == value
    for value in refused:
        with pytest.raises(ParameterError, match=rf"^{name} must .*"):
            Parameters(**{name: value})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"quartic_coefficient": 0.0}, r"quartic_coefficient \(c\) = 0 needs a sextic"),
        ({"quintic_coefficient": 1.0}, r"quintic_coefficient \(d\) > 0 needs a sextic"),
    ],
)
def test_a_film_whose_order_parameter_would_grow_is_refused(values: dict[str, float], message: str):
    with pytest.raises(ParameterError, match=message):
        Parameters(**values)
    assert Parameters(**values, sextic_coefficient=1.0).sextic_coefficient == 1.0


def test_all_invalid_values_are_named_at_once():
    with pytest.raises(ParameterError) as caught:
        Parameters(temperature=-1, block_mass=0, drive_amplitude=0)
    assert str(caught.value) == (
        "temperature must be at least 0, not -1.0; drive_amplitude must not be 0; "
        "block_mass must be greater than 0, not 0.0"
    )


@pytest.mark.parametrize(
    "value",
    [250, 250.0, np.int32(250), np.float32(250), np.array(250), Fraction(500, 2), Decimal(250)],
)
def test_numbers_become_floats(value: float):
    p = Parameters(value, spring_stiffness=value)
    assert p == Parameters(250.0, spring_stiffness=250.0)
    assert {type(field) for field in p} == {float}


@pytest.mark.parametrize(
    "value", ["250", b"250", True, np.True_, None, 250j, [250], [], {}, 10**400]
)
def test_anything_else_is_refused_by_name(value: object):
    with pytest.raises(ParameterError, match=r"^temperature must be a number, not "):
        Parameters(temperature=value)


def _calls() -> list[Callable[[], object]]:
    other: Any = 3.0
    schedules: list[Any] = ["x", {"temperature": 3.0}, [{"temperature": [1.0]}]]
    calls = (stationary_orbit, simulate, phase_diagram)
    return [
        *(partial(call, value) for call in calls for value in (other, "T", {"temperature": 3.0})),
        *(partial(simulate, schedule=schedule) for schedule in schedules),
    ]


@pytest.mark.parametrize("call", _calls())
def test_arguments_of_another_type_are_refused_with_an_example(call: Callable[[], object]):
    with pytest.raises(
        TypeError, match=r"must be a Parameters object, such as|must map parameters to"
    ):
        call()


@pytest.mark.parametrize(
    ("wrong", "meant"),
    [("temprature", "temperature"), ("gama", "gamma"), ("X_", "X_m")],
)
def test_an_unknown_name_is_refused_with_a_similar_one(wrong: str, meant: str):
    with pytest.raises(TypeError, match=rf"no parameter '{wrong}'; did you mean '{meant}'\?"):
        Parameters(**{wrong: 250})


def test_bare_values_have_no_defaults():
    # Compiled code that forgets a parameter must not compile.
    with pytest.raises(TypeError, match="missing"):
        ParameterValues(200.0)
    assert ParameterValues._fields == tuple(PARAMETERS)


@pytest.mark.parametrize(
    "made",
    [
        lambda T: Parameters()._replace(temperature=T),
        lambda T: Parameters._make([T, *Parameters()[1:]]),
    ],
    ids=["_replace", "_make"],
)
def test_other_constructors_convert_and_check_as_well(made: Callable[[int], Parameters]):
    p = made(250)
    assert type(p) is Parameters
    assert {type(field) for field in p} == {float}
    assert p == Parameters(temperature=250)
    with pytest.raises(ParameterError, match=r"^temperature must be at least 0"):
        made(-1)


def test_make_needs_every_field():
    with pytest.raises(TypeError, match=f"expected {len(PARAMETERS)} values, not 3"):
        Parameters._make([1, 2, 3])


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_pickle_round_trip(protocol: int):
    p = Parameters(temperature=250)
    restored = pickle.loads(pickle.dumps(p, protocol))
    assert type(restored) is Parameters
    assert restored == p


def test_copies_are_parameters():
    p = Parameters(temperature=250)
    assert type(copy.copy(p)) is type(copy.deepcopy(p)) is Parameters


@numba.njit
def _locked_force(p: Parameters) -> float:
    stiffness = 2.0 * p.spring_stiffness - p.block_mass * p.angular_frequency**2
    return abs(stiffness * p.drive_amplitude)


def test_one_compiled_signature_for_every_kind_of_number():
    for p in (
        Parameters(),
        Parameters(temperature=200, spring_stiffness=3000),
        Parameters(temperature=np.float32(200), block_mass=np.float64(0.4)),
        Parameters(np.int64(200), angular_frequency=np.int8(10)),
        Parameters()._replace(spring_stiffness=3000),
        Parameters._make(np.asarray(Parameters())),
        pickle.loads(pickle.dumps(Parameters())),
    ):
        assert _locked_force(p) == pytest.approx(4.768e-3, rel=1e-12)
    assert len(_locked_force.signatures) == 1


def test_parameters_are_given_by_name_symbol_or_greek_letter() -> None:
    by_name = Parameters(rheological_index=-0.5, initial_order_parameter=0.1, temperature=250)
    assert Parameters(gamma=-0.5, phi_0=0.1, T=250) == by_name
    assert Parameters(γ=-0.5, φ_0=0.1, T=250) == by_name
    assert Parameters(**{"γ": -0.5, "φ₀": 0.1, "T": 250}) == by_name
    assert Parameters()._replace(γ=-0.5, φ_0=0.1, T=250) == by_name


def test_symbols_are_known_as_pictures_and_pages_print_them() -> None:
    assert canonical_name("Xₘ") == "drive_amplitude"
    for name in ("elastic_stress_amplitude", "friction_force_amplitude", "friction_force_rms"):
        assert canonical_result(plain(f"${RESULTS[name].tex}$")) == name
    assert stationary_orbits({"γ": [-0.5], "ω": 12.0}).rheological_index.item() == -0.5
    assert from_mapping({"sweep": {"ω": [5, 10]}}).sweep.keys() == {"angular_frequency"}
    path = simulate(periods=1, samples_per_period=4, schedule={"T": [200, 250], "ω": [10, 11]})
    assert path.temperature.dims == ("elapsed_time",)


@pytest.mark.parametrize("twice", [{"T": 1, "temperature": 2}, {"γ": 0.1, "gamma": 0.2}])
def test_a_parameter_given_twice_is_refused(twice: dict[str, float]) -> None:
    with pytest.raises(TypeError, match="is given twice, by name and by symbol"):
        Parameters(**twice)
    with pytest.raises(TypeError, match="twice, by position and by name"):
        Parameters(200, T=250)


def test_the_signature_shows_all_names_and_defaults() -> None:
    """Shift-Tab in a notebook shows this signature."""
    shown = inspect.signature(Parameters).parameters
    assert {name: each.default for name, each in shown.items()} == Parameters()._asdict()
    description = inspect.getdoc(Parameters)
    assert all(f"{v.symbol} [{v.unit or 1}]" in description for v in PARAMETERS.values())


def test_type_checkers_know_all_names_and_symbols() -> None:
    greek = {canonical_name(name) for name in ParameterKeywords.__annotations__}
    assert greek == set(PARAMETERS)
    known = set(ParameterKeywords.__annotations__)
    assert known >= {*PARAMETERS, *(variable.symbol for variable in PARAMETERS.values())}
    assert set(ParameterKeywords.__annotations__.values()) == {float}
