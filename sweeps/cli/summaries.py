"""Printed summaries of sweeps, files, borders, points and the installation."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Mapping
from importlib.metadata import packages_distributions
from typing import TYPE_CHECKING, Any

from stickslip.compiled.cache import processor, source_hash, usable_cache_folder
from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.plausibility import SUSPICIOUS_BALANCE
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.cli.shared import say
from sweeps.files.atomic import replacing
from sweeps.files.attributes import flags_of, software
from sweeps.files.netcdf import content_hash
from sweeps.human import counted, duration, points_per_time, printable, size_text

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

    from sweeps.engine.plan import Plan
    from sweeps.engine.sweep import Outcome
    from sweeps.grid import Grid
    from sweeps.points import Point


def write_timing(outcome: Outcome, backend: str) -> None:
    """Write the timing to a file beside the result."""
    timing = {
        "seconds": round(outcome.seconds, 3),
        "kernel_seconds": round(outcome.kernel_seconds, 3),
        "points": outcome.computed,
        "points_per_second": round(outcome.computed / max(outcome.seconds, 1e-9), 3),
        "workers": outcome.workers,
        "backend": backend,
        "machine": platform.machine(),
        "processor": processor(),
        "code_sha256": source_hash(),
    }
    path = outcome.output.with_name(outcome.output.name + ".timing.json")
    try:
        with replacing(path, fsync=False, follow=False) as temporary:
            temporary.write_text(json.dumps(timing, indent=2) + "\n")
    except OSError as error:
        say(f"warning: the timing was not written: {error}")


def print_summary(outcome: Outcome) -> None:
    """Print the name of the result and a summary of the sweep."""
    _print(str(outcome.output))
    part = f"part {outcome.part}: " if outcome.part else ""
    points = f"{part}{counted(outcome.points, 'point')}"
    if outcome.computed:
        rate = outcome.computed / max(outcome.seconds, 1e-9)
        computed = "" if outcome.computed == outcome.points else f", {outcome.computed} computed"
        points += f"{computed} in {duration(outcome.seconds)} ({points_per_time(rate)})"
    left = int(outcome.statuses[Status.PENDING])
    pending = f", {left} pending" if left else ""
    print(f"{points}, {outcome.failures} failed{pending}{_errors(outcome)}")
    print_reasons(outcome.statuses)
    print_suspicions(outcome.suspicious)


def _errors(outcome: Outcome) -> str:
    """Return the largest errors; those of means are separate: they do not test the integration."""
    worst, wandering = outcome.worst_error, int(outcome.statuses[Status.APERIODIC])
    of_others = " of the others" if wandering else ""
    largest = "" if math.isnan(worst) else f", largest amplitude error{of_others} {worst:.1e}"
    means = f", {wandering} aperiodic with a statistical error of up to "
    return (f"{means}{outcome.statistical_error:.1e}" if wandering else "") + largest


def print_reasons(statuses: NDArray[np.int64]) -> None:
    """Print how many points did not end ok, and what that means."""
    for status in Status:
        count = int(statuses[status])
        if count and status is not Status.OK:
            say(f"  {count} {status.name.lower()}: {status.sentence}")


def print_suspicions(suspicious: tuple[int, int]) -> None:
    """Print warnings about results that are possible but suspicious."""
    balance, stress = suspicious
    if balance:
        say(
            f"warning: power_balance_error and amplitude_error are above {SUSPICIOUS_BALANCE:g} at "
            f"{counted(balance, 'point')}; check with a smaller integrator.rtol (or dt)"
        )
    if stress:
        say(
            "warning: the elastic stress exceeds its static maximum by more than 10 % at "
            f"{counted(stress, 'point')}; slow kinetics can do that, but so can an inaccurate "
            "integration"
        )


# The range around the estimate of `plan`: this many standard errors, but at least this part of it.
_DEVIATIONS, _LEAST_WIDE = 2.0, 0.15


def print_plan(plan: Plan, backend: str) -> None:
    """Print the size and the expected time of a sweep."""
    slots = f"{counted(plan.workers, 'worker')} ({backend})"
    print(f"points: {plan.points}" + (f", {plan.there} already computed" if plan.there else ""))
    print(f"blocks: {plan.blocks}")
    print(
        f"bytes: up to {size_text(plan.result_bytes)} for the result, "
        f"{size_text(plan.journal_bytes)} for the journal while it runs"
    )
    if not plan.pilot_points:
        print(f"time: about {duration(0.0)} on {slots}; nothing to compute")
        return
    wide = 1.0 + max(_LEAST_WIDE, _DEVIATIONS * plan.uncertainty)
    low, high = duration(plan.least_seconds / wide), duration(plan.seconds * wide)
    between = f"about {low}" if low == high else f"{low} to {high}"
    refined = plan.least_seconds < plan.seconds
    least = ", less if much of the grid is interpolated" if refined else ""
    print(
        f"time: {between} on {slots}{least}, from a sample of {plan.pilot_points}; "
        "rare slow points may lengthen it"
    )


def print_state(state: Mapping[str, Any]) -> None:
    """Print the state of a sweep."""
    part = f" (part {state['part']})" if "part" in state else ""
    _print(f"{state['output']}: {state['state']}{part}")
    if "points" not in state:
        return
    _print(f"{state['done']} of {state['points']} points done, {state['failed']} failed")
    if state.get("points_per_second"):
        left = state.get("seconds_left")
        ahead = "" if left is None else f", about {duration(left)} left"
        _print(f"{points_per_time(state['points_per_second'])}{ahead}")
    if "pid" in state:
        _print(f"process {state['pid']} on {state['host']}, last heard from at {state['updated']}")
    for name, count in state["statuses"].items():
        if name != "ok":
            _print(f"  {count} {name}: {Status[name.upper()].sentence}")


def describe_installation() -> None:
    """Print versions, machine, hash of the code, and the folder of compiled code."""
    _print(software())
    _print(f"machine: {platform.machine()}, {platform.system()}")
    _print(f"code: {source_hash()}")
    for other in sorted(set(packages_distributions().get("sweeps", ())) - {"stickslip"}):
        _print(
            f"warning: {other}, which is installed here, also has a package `sweeps`: one "
            "overwrites the other; install stickslip into a separate environment"
        )
    try:
        _print(f"compiled code is cached in: {usable_cache_folder()}")
    except RuntimeError as error:
        _print(f"compiled code is not cached: {error}")


def describe_file(ds: xr.Dataset) -> None:
    """Print the contents and the provenance of a result file."""
    _print(f"title: {ds.attrs.get('title', '')}")
    _print("dimensions: " + (", ".join(f"{d} {n}" for d, n in ds.sizes.items()) or "none"))
    _print(f"variables: {', '.join(map(str, ds.data_vars))}")
    if "status" in ds:
        version = ds.attrs.get("numerics_version", "unknown")
        if version != str(NUMERICS_VERSION):
            _print(f"computed with numerics version {version}; this program has {NUMERICS_VERSION}")
        usual = {int(status): status.name.lower() for status in Status}
        for flag, meaning in (flags_of(ds.status.attrs) or usual).items():
            count = int((ds.status == flag).sum())
            if count:
                _print(f"  {meaning}: {count}")
    for name in ("source", "history", "software", "config_sha256"):
        _print(f"{name}: {ds.attrs.get(name, 'unknown')}")
    _print(f"content_sha256: {content_hash(ds)}")


def parameters_text(grid: Grid) -> str:
    """Return the parameters that differ from the paper's, as text."""
    changed = []
    for name, variable in PARAMETERS.items():
        values = grid.values(name)
        low, high = values[0], values[-1]
        if low < high:
            changed.append(f"{variable.symbol} {low:g} to {high:g} {variable.unit}".rstrip())
        elif low != variable.default:
            changed.append(f"{variable.symbol} {low:g} {variable.unit}".rstrip())
    rest = "the others as in the paper" if changed else "as in the paper"
    return ", ".join([*changed, rest])


def print_borders(borders: xr.Dataset) -> None:
    """Print the borders of one axis, or how many lines of a map separate each pair of kinds."""
    axes = [name for name in PARAMETERS if f"{name}_bracket" in borders.variables]
    sides = list(zip(borders.kind_left.values, borders.kind_right.values, strict=True))
    is_fold = borders.type.values == 1
    if len(axes) == 1:
        for place, pair, fold in zip(borders[axes[0]].values, sides, is_fold, strict=True):
            value = f"{place:.8g} {PARAMETERS[axes[0]].unit}".rstrip()
            print(f"{axes[0]} {value}: {_between(*pair)}, {'fold' if fold else 'grazing'}")
    for pair in dict.fromkeys(sides) if len(axes) > 1 else ():
        own = [other == pair for other in sides]
        lines = len(set(borders.line.values[own]))
        folds = int(is_fold[own].sum())
        size = f"{counted(lines, 'line')}, {counted(sum(own), 'point')}"
        print(f"{_between(*pair)}: {size}, {folds} of them at folds")
    if (wide := int(borders.attrs.get("wide_brackets", 0))) > 0:
        brackets = counted(wide, "bracket")
        print(f"{brackets} wider than requested, where motions close late or never")


def _between(left: int, right: int) -> str:
    return f"{Regime(left).name.lower()} | {Regime(right).name.lower()}"


def print_comparison(point: Point) -> bool:
    """Print a point's values in the file and how new ones differ; return whether they agree."""
    print(point.where)
    differing = point.differences()
    for name, stored in point.stored.items():
        units = f" {RESULTS[name].unit}".rstrip()
        change = f", now {differing[name][1]!r}" if name in differing else ""
        named = name == "regime" and not math.isnan(stored)  # NaN where a point was masked
        words = f" ({Regime(int(stored)).name.lower()})" if named else ""
        print(f"  {name}: {stored!r}{units}{words}{change}")
    print(f"status: {point.status.name.lower()}: {point.status.sentence}")
    for note in point.versions:
        say(f"note: {note}")
    if not point.is_comparable:
        print("the file has no computed values for it; its orbit is computed now")
    elif differing:
        say(f"warning: the file has different values for {counted(len(differing), 'variable')}")
    else:
        print(f"all {len(point.stored)} variables agree with the file bit for bit")
    return not differing


def _print(text: str) -> None:
    """Print text from a file; its control characters must not reach the terminal."""
    print(printable(text))
