"""Checks of a config that need several values at once; single values are already valid.

A check is left out if one of its values was refused.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import pairwise, product
from typing import Any

import numpy as np

from stickslip.distributions import Distribution, DistributionError, Range, of_parameter
from stickslip.laws import LawError
from stickslip.options import (
    FRICTION_LAWS,
    NO_NOISE,
    STOCHASTIC,
    full_law_name,
    methods_for,
)
from stickslip.variables import (
    ENERGY_COEFFICIENTS,
    PARAMETERS,
    STARTING,
    ParameterVariable,
    canonical_name,
    unbounded,
)
from sweeps.config.numbers import whole
from sweeps.config.sample import Sample
from sweeps.config.schema import Config
from sweeps.config.written_config import PARAMETER_SECTIONS, Document, Path, path_text, quoted
from sweeps.human import counted, did_you_mean

MAX_POINTS = 1_000_000_000
# Relative; steps of a refined axis may differ by rounding.
_EVEN = 1e-6
NEAR = 1e-9
"""Relative; values closer than this differ by rounding, not by intention."""

# The paper's k is above this, its K below; if both are on the wrong side, they look exchanged.
_K_BORDER = 1e4
# A value this many times larger or smaller than the paper's is probably in another unit.
_FAR = 1e4
# Kelvin; a temperature below the first is probably in degrees Celsius, and so are several
# temperatures all below the second.
_COLD, _ALL_COLD = 70.0, 100.0
# Parameters of any size: their power of ten is free, or their unit depends on the fluid.
_OF_ANY_SIZE = ("viscosity_coefficient", "noise_intensity", "rheological_index", *STARTING)

_CHANCE = f"`noise: {{treatment: {STOCHASTIC}}}`"


def judged(
    document: Document, config: Config, unsound: Collection[str], picked: Mapping[str, Any]
) -> Config:
    """Return a config after all checks, without the values that they refuse.

    `unsound` are keys already refused. `picked` may hold the `case` to which the config is reduced.
    """
    if config.sample:
        config = config.model_copy(update={"cases": _drawn(document, config.sample)})
    config = _judged_parameters(document, config)
    if "case" in picked:
        config = _one_case(document, config, picked["case"])
    scheduled = _judge_schedule(document, config)
    for message in _wrong_with_pull(config) if config.simulation.drive else ():
        document.refuse(message, "simulation", "drive")
    if "film" not in unsound:
        config = _with_law(document, config)
    _judge_order(document, config, unsound)
    _refuse_unbounded_films(document, config, scheduled)
    _refuse_unfit(document, config, unsound)
    _refuse_scheduler(document)
    if "noise" not in unsound:
        _refuse_frozen_start(document, config)
    return config


def _judged_parameters(document: Document, config: Config) -> Config:
    """Return a config without the parameters that have a value out of range, and refuse those."""
    _refuse_repeats(document)
    parts = {name: getattr(config, name) for name in PARAMETER_SECTIONS}
    if not _sizes_fit(document, config):
        parts |= {"sweep": {}, "cases": {}}
    for name, values in parts["sweep"].items():
        _judge_neighbours(document, name, values)
    for section, part in parts.items():
        listed = {n: [v] if section == "model" else v for n, v in part.items()}
        valid = [n for n, v in listed.items() if _are_valid(document, document.path_of(n), n, *v)]
        parts[section] = {name: part[name] for name in valid}
    sound = config.model_copy(update=parts)
    _refuse_repeated_cases(document, sound)
    _warn_of_exchange(document, sound)
    _warn_of_magnitudes(document, sound, sound.names)
    return sound


def _drawn(document: Document, sample: Sample) -> dict[str, tuple[float, ...]]:
    """Return the cases that a sample draws, or none if the sample is refused."""
    if document.data.get("cases"):
        message = "draws the cases, and `cases` lists them; keep one of the two"
        document.refuse(message, "sample")
        return {}
    valid = [_is_sound(document, name, drawn) for name, drawn in sample.written.items()]
    for name in sample.fitted.joint.names if sample.fitted else ():
        if path := document.path_of(name):
            message = f"draws {name}, which {path_text(path)} gives too; keep one of the two"
            document.refuse(message, "sample", "from")
            valid.append(False)
    return sample.cases() if all(valid) else {}


def _is_sound(document: Document, name: str, drawn: Distribution) -> bool:
    """Return whether a distribution is possible for a parameter; refuse it if not."""
    path = document.path_of(name)
    if isinstance(drawn, Range):
        return _are_valid(document, path, name, drawn.low, drawn.high)
    try:
        of_parameter(drawn, name)
    except DistributionError as error:
        document.refuse(str(error), *path)
        return False
    return True


def _one_case(document: Document, config: Config, case: object) -> Config:
    """Return a config whose linked parameters are fixed at the values of one case.

    The config is then no longer a sample, so that its result is not described as one.
    """
    count = min(map(len, config.cases.values()), default=0)
    try:
        index = whole(case)
        if not 0 <= index < count:
            ends = f"must be between 0 and {count - 1}"
            raise ValueError(ends if count else "there are no `cases` to pick from")
    except ValueError as error:
        document.refuse(str(error), "case")
        return config
    picked = {name: values[index] for name, values in config.cases.items()}
    fixed = {"model": config.model | picked, "cases": {}, "sample": None}
    return config.model_copy(update=fixed)


def _refuse_repeats(document: Document) -> None:
    first: dict[str, Path] = {}
    for name, path in document.parameters():
        if other := first.get(name):
            _, line = document.place(other)
            where = path_text(other) + (f" in line {line}" if line else "")
            document.refuse(f"gives {name} a second time, after {where}; keep one", *path)
        first.setdefault(name, path)


def _sizes_fit(document: Document, config: Config) -> bool:
    """Return whether the grid is small enough to be made; refuse cases of unequal length too."""
    if unequal := _unequal("linked", config.cases):
        document.refuse(unequal, "cases")
    count = max(map(len, config.cases.values()), default=1)
    points = math.prod(map(len, config.sweep.values())) * count
    if points > MAX_POINTS:
        message = f"{points} points exceed the limit of {MAX_POINTS}; use fewer values or axes"
        document.refuse(message, "sweep" if config.sweep else "cases")
    return points <= MAX_POINTS


def _judge_neighbours(document: Document, name: str, values: tuple[float, ...]) -> None:
    pairs, path = list(pairwise(sorted(values))), document.path_of(name)
    repeated = dict.fromkeys(a for a, b in pairs if a == b)
    near = [(a, b) for a, b in pairs if b - a <= NEAR * max(abs(a), abs(b))]
    if repeated:
        listed = ", ".join(map(repr, list(repeated)[:5])) + (", …" if len(repeated) > 5 else "")
        document.refuse(f"has values that occur more than once: {listed}", *path)
    elif near:
        message = "has adjacent values that agree to one part in 1e9: {!r} and {!r}"
        document.warn(message.format(*near[0]), *path)


def _are_valid(document: Document, path: Path, name: str, *values: float) -> bool:
    """Return whether all values lie in the range of a parameter; refuse all others."""
    judge = PARAMETERS[name].complaint
    complaints = {i: complaint for i, value in enumerate(values) if (complaint := judge(value))}
    if isinstance(document.at(*path), list):
        for i, complaint in complaints.items():
            document.refuse(complaint, *path, i)
    elif complaints:
        more = f" (and {len(complaints) - 1} more like it)" if len(complaints) > 1 else ""
        document.refuse(next(iter(complaints.values())) + more, *path)
    return not complaints


def _refuse_repeated_cases(document: Document, config: Config) -> None:
    first: dict[tuple[float, ...], int] = {}
    for index, values in enumerate(zip(*config.cases.values(), strict=False)):
        other = first.setdefault(values, index)
        if other != index:
            document.refuse(f"case {index} repeats case {other} (counted from 0)", "cases")
            return


def _warn_of_exchange(document: Document, config: Config) -> None:
    k, K = config.values("viscosity_coefficient"), config.values("spring_stiffness")
    if max(k) <= _K_BORDER <= min(K) and min(k) < _K_BORDER < max(K):
        document.warn(
            f"K = {K[0]:g} N/m with k = {k[0]:g}: both are far from their usual magnitude "
            "(K about 3000, k about 5e4), as if k and K had been swapped",
            *document.path_of("spring_stiffness"),
        )


def warnings_of_columns(
    columns: Mapping[str, Sequence[float]], config: Config, source: str
) -> list[str]:
    """Return the warnings for a config that has the columns of a table as axes."""
    document = Document(source, {})
    axes = {name: tuple(dict.fromkeys(values)) for name, values in columns.items()}
    config = config.model_copy(update={"sweep": axes})
    if axes.keys() & {"viscosity_coefficient", "spring_stiffness"}:
        _warn_of_exchange(document, config)
    _warn_of_magnitudes(document, config, axes)
    return [str(warning) for warning in document.warnings]


def _warn_of_magnitudes(document: Document, config: Config, names: Collection[str]) -> None:
    """Warn of valid values that were probably meant in another unit."""
    for name in sorted({*names} - {*_OF_ANY_SIZE}):
        variable, values = PARAMETERS[name], config.values(name)
        far = [value for value in values if _is_far(value, variable)]
        if not far and variable.units == "K" and len(values) > 1 and max(values) < _ALL_COLD:
            far = [min(values)]
        if not far:
            continue
        if variable.units == "K":
            size = f"{far[0]:g} K is {far[0] - 273.15:.0f} degrees Celsius"
        else:
            usual = "in the paper" if variable.in_paper else "by default"
            size = f"{far[0]:g} {variable.unit}, against {variable.default:g} {usual}"
        message = f"{variable.symbol} = {size}: is it in another unit? all values are in SI units"
        document.warn(message, *document.path_of(name))


def _is_far(value: float, variable: ParameterVariable) -> bool:
    """Return whether a value is probably in another unit; 0 never is."""
    if value == 0.0 or variable.default == 0.0:
        return False
    if variable.units == "K":
        return value < _COLD
    return not 1.0 / _FAR <= abs(value / variable.default) <= _FAR


def _judge_schedule(document: Document, config: Config) -> dict[str, tuple[float, ...]]:
    """Refuse a schedule with values out of range, unequal lengths, or initial values.

    Return the schedule, empty if there is none or if a value is out of range.
    """
    schedule, path = config.simulation.schedule, ("simulation", "schedule")
    if schedule is None:
        return {}
    known, valid = {*config.sweep, *config.cases}, True
    for key in document.at(*path):
        name = canonical_name(key)
        if name not in schedule:  # already refused
            continue
        valid &= _are_valid(document, (*path, key), name, *schedule[name])
        if name in known:
            document.refuse(f"gives {name} a second time; keep one of the two", *path, key)
        elif name in STARTING:
            document.refuse("cannot be scheduled: a run has only one start", *path, key)
        elif name in config.model:
            message = "applies to a simulated run only; a sweep uses the value under `model`"
            document.warn(message, *path, key)
        known.add(name)
    if unequal := _unequal("scheduled", schedule):
        document.refuse(unequal, *path)
    return schedule if valid else {}


def _wrong_with_pull(config: Config) -> Iterator[str]:
    """Yield a message for each setting that works only with a periodic drive."""
    if config.integrator.method != "adaptive":
        method = f"`integrator: {{method: {config.integrator.method}}}`"
        yield f"cannot be combined with {method}; leave one of them out"
    if config.noise.treatment == STOCHASTIC:
        yield f"cannot be combined with {_CHANCE}; leave one of them out"


def _unequal(kind: str, values: Mapping[str, tuple[float, ...]]) -> str:
    """Return a complaint about parameters with unequal numbers of values, or an empty text."""
    if len({*map(len, values.values())}) < 2:
        return ""
    listed = ", ".join(f"{name} {len(some)}" for name, some in values.items())
    return f"{kind} parameters need the same number of values, but have: {listed}"


def _judge_order(document: Document, config: Config, unsound: Collection[str]) -> None:
    """Refuse to follow or refine parameters that are not swept, or axes that do not allow it."""
    if follow := config.follow and _swept(document, config, config.follow, "follow"):
        for message in _wrong_with_line(document, config, follow, unsound):
            document.refuse(message, "follow")
    if (refine := config.refine) and "refine" not in unsound:
        path = ("refine", "axes")
        names = [_swept(document, config, n, *path, i) for i, n in enumerate(refine.axes)]
        known = [name for name in names if name]
        if len(set(known)) < len(known):
            document.refuse("names an axis twice", *path)
        cell = 2**refine.levels
        for name in known:
            length = len(config.sweep[name])
            if (length - 1) % cell or length < cell + 1:
                close = max((length - 1) // cell, 1) * cell + 1
                document.refuse(
                    f"{name} has {counted(length, 'value')}; {counted(refine.levels, 'level')} "
                    f"need one more than a multiple of {cell}, such as {close} or {close + cell}",
                    "refine",
                )
            elif not _is_even(config.sweep[name]):
                document.refuse(
                    f"{name} needs values with a constant step or ratio, such as a linspace "
                    "or a geomspace: values between them are interpolated",
                    "refine",
                )


def _is_even(axis: Sequence[float]) -> bool:
    """Return whether values are evenly spaced on a linear or a logarithmic scale."""
    values = np.array(axis)
    has_scale = (values > 0).all() or (values < 0).all()
    scales = [values, np.log(np.abs(values))] if has_scale else [values]
    return any(np.allclose(steps := np.diff(s), steps.mean(), rtol=_EVEN, atol=0.0) for s in scales)


def _wrong_with_line(
    document: Document, config: Config, name: str, unsound: Collection[str]
) -> Iterator[str]:
    """Yield the reasons why an axis cannot be followed."""
    for other in ("refine", "sample", "cases"):
        is_left = getattr(config, other) or other in unsound  # no cases if one was picked
        if document.data.get(other) and is_left:
            yield f"cannot be combined with `{other}`; leave one of them out"
    if config.noise.treatment == STOCHASTIC:
        yield f"cannot be combined with {_CHANCE}: random paths leave no state to continue from"
    if name in STARTING:
        yield f"cannot be {name}: each point on a followed line starts from the previous one"
    if any(b <= a for a, b in pairwise(config.sweep[name])):
        yield f"needs the values of {name} in increasing order: they are followed up, then down"


def _swept(document: Document, config: Config, name: str, *path: str | int) -> str | None:
    """Return the name of a swept axis; refuse any other name."""
    if name in config.sweep:
        return name
    if document.path_of(name, "sweep"):  # the axis was already refused
        return None
    known = ", ".join(config.sweep) or "none"
    written, hint = quoted(document.at(*path)), did_you_mean(name, config.sweep)
    message = f"must name a swept axis, not {written}; swept axes: {known}{hint}"
    document.refuse(message, *path)
    return None


def _refuse_unbounded_films(
    document: Document, config: Config, scheduled: Mapping[str, tuple[float, ...]]
) -> None:
    """Refuse points, and sections of a schedule, whose order parameter would grow without bound."""
    if not _unknown(document, config).isdisjoint(ENERGY_COEFFICIENTS):
        return
    # The defaults are bounded; a coefficient that is given nowhere comes from a sample of a fit.
    given: Path = next(filter(None, map(document.path_of, ENERGY_COEFFICIENTS)), ("sample",))
    runs = [(config, given)]
    if not scheduled.keys().isdisjoint(ENERGY_COEFFICIENTS):
        run = config.model_copy(update={"cases": scheduled})  # linked, as those of cases are
        runs.append((run, ("simulation", "schedule")))
    for run, path in runs:
        growths = (unbounded(*signs) for signs in _signs(run, ENERGY_COEFFICIENTS))
        if growth := next(filter(None, growths), None):
            document.refuse(f"{growth}: otherwise the order parameter grows without bound", *path)
            return


def _signs(config: Config, names: Collection[str]) -> Iterator[tuple[float, ...]]:
    """Yield each combination of signs, -1, 0 or 1, that these parameters have at some point."""
    linked = [name for name in names if name in config.cases]
    free = [name for name in names if name not in linked]
    signs = {name: np.sign(config.values(name)).tolist() for name in names}
    # Cases of unequal length were already refused.
    together = set(zip(*(signs[name] for name in linked), strict=False)) or {()}
    for case, *others in product(together, *(set(signs[name]) for name in free)):
        by_name = dict(zip((*linked, *free), (*case, *others), strict=True))
        yield tuple(by_name[name] for name in names)


def _refuse_frozen_start(document: Document, config: Config) -> None:
    """Refuse a start at phi = 0 without noise, from which the film would stay liquid forever."""
    start, noise = "initial_order_parameter", "noise_intensity"
    names = [start] if config.noise.treatment == NO_NOISE else [start, noise]
    linked = [config.cases[name] for name in names if name in config.cases]
    are_zero = all(0 in config.values(name) for name in names)
    meet = not linked or (0,) * len(linked) in zip(*linked, strict=False)
    if start in _unknown(document, config) or not (are_zero and meet):
        return
    path = next(filter(None, map(document.path_of, names)), ("noise", "treatment"))
    document.refuse(
        "initial_order_parameter (phi_0) is 0 with noise off: phi = 0 is an exact solution of the "
        "equation, so the film could never solidify; start at a small value such as 0.01, or keep "
        "`noise: {treatment: typical-path}` with noise_intensity above 0",
        *path,
    )


def _refuse_unfit(document: Document, config: Config, unsound: Collection[str]) -> None:
    """Refuse a model of the strain or a treatment of the noise that the method does not support."""
    for section, key, field in (("film", "strain", "strains"), ("noise", "treatment", "noises")):
        choice = getattr(getattr(config, section), key)
        able = methods_for(field, choice)
        if config.integrator.method not in able and not {section, "integrator"} & {*unsound}:
            message = f"{choice} needs `integrator: {{method: {' or '.join(able)}}}`"
            document.refuse(message, section, key)


def _with_law(document: Document, config: Config) -> Config:
    """Return a config with the identity of a law that is not ours; refuse an unknown law.

    A given identity, for example in a result, is checked only before a computation, so that any
    result can be shown.
    """
    film = config.film
    if film.friction in FRICTION_LAWS:
        if film.law is not None:
            document.refuse(f"{film.friction} is a built-in law; leave this key out", "film", "law")
    elif film.law is None:
        try:
            friction, _, law = full_law_name(film.friction).partition("@")
        except LawError as error:
            document.refuse(str(error), "film", "friction")
        else:
            film = film.model_copy(update={"friction": friction, "law": law})
            return config.model_copy(update={"film": film})
    return config


def _refuse_scheduler(document: Document) -> None:
    """Refuse a scheduler in a file, even one on this machine, where anybody can open a port.

    A scheduler's answers can run code here. On the command line or in Python the user means it.
    """
    path = "execution", "scheduler"
    address = document.section("execution").get("scheduler")
    _, line = document.place(path)
    if isinstance(address, str) and line is not None:
        document.refuse(
            f"{quoted(address)} could run code on this machine, so no file may name it; "
            "if you trust it, leave the line out and give it as --scheduler ADDRESS",
            *path,
        )


def _unknown(document: Document, config: Config) -> set[str]:
    """Return the parameters whose values are unknown because they or their section was refused."""
    sections = [document.data.get(section) or {} for section in PARAMETER_SECTIONS]
    if not all(isinstance(section, dict) for section in sections):
        return {*PARAMETERS} - config.names
    return {name for name, _ in document.parameters()} - config.names
