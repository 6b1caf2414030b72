"""The verb that turns measurements into parameters: fit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sweeps.cli.shared import (
    BackendOption,
    NoProgressOption,
    OverwriteOption,
    SchedulerOption,
    SetOption,
    WorkersOption,
    checked_config,
    execution_changes,
    flag,
    option,
    output_option,
    print_names,
    recalled_or_computed,
    require_netcdf,
    say,
    stop_with,
)
from sweeps.exits import Exit

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.files.outputs import Outputs
    from sweeps.fitting.parameters import Range


def fit(
    data: Annotated[
        Path,
        typer.Argument(
            metavar="DATA.csv",
            help="Columns: parameters, measured variables and their errors, NAME_error; SI units.",
        ),
    ],
    free: Annotated[
        str, option("NAME[=LOW:HIGH],...", "Parameters to fit, such as k,gamma=-0.9:0.")
    ],
    config: Annotated[
        Path | None,
        typer.Argument(
            metavar="[CONFIG]",
            help="All other parameters, and the start of the fit. [default: the paper's Fig. 3]",
        ),
    ] = None,
    output: Annotated[
        Path | None, output_option("NetCDF file. [default: results/DATA-fit.nc]")
    ] = None,
    set_: SetOption = None,
    profile: Annotated[
        bool, flag("--profile", "Add intervals from the profile likelihood; slower.")
    ] = False,
    posterior: Annotated[
        bool, flag("--posterior", "Also sample the posterior; takes minutes.")
    ] = False,
    prior: Annotated[
        list[str] | None,
        option("NAME={KIND: [A, B]}", "A prior, such as gamma={normal: [-0.5, 0.1]}."),
    ] = None,
    overwrite: OverwriteOption = False,
    workers: WorkersOption = None,
    backend: BackendOption = None,
    scheduler: SchedulerOption = None,
    no_progress: NoProgressOption = False,
) -> None:
    """Fit parameters to measurements, and draw data, fitted curve and residuals.

    If the data have no errors, residuals are relative, with a common unknown factor. The command
    writes a NetCDF file, a picture, and the config that computes the fitted curve; with
    --posterior also a corner plot, and groups in the file that ArviZ opens.
    """
    from sweeps.fitting.fitting import (
        FOR_A_POSTERIOR,
        fit_measured,
        odd_values,
        require,
        summary_of,
    )
    from sweeps.measurements import read_data

    target = output or Path("results") / f"{data.stem}-fit.nc"
    require_netcdf(target, strict=True)
    changes = execution_changes(workers, backend, scheduler)
    settled = checked_config(config, [*(set_ or []), *changes])
    ranges, measured = _ranges(free), read_data(data)
    priors = _priors(prior or []) if posterior or prior else None
    if priors is not None:  # the picture comes last, after minutes
        require("corner", "the picture of a posterior", FOR_A_POSTERIOR)
    for line in odd_values(measured, settled, data):
        say(f"warning: {line}")
    inputs = [data, *([config] if config else [])]
    request = {"free": _by_name(ranges), "config": settled.resolved_yaml(), "profile": profile}
    if priors is not None:
        request["priors"] = _by_name(priors)
    outputs = _outputs(target, inputs, request, overwrite=overwrite)
    with outputs.held():
        ds = recalled_or_computed(
            outputs,
            lambda: fit_measured(
                measured,
                ranges,
                settled,
                profile=profile,
                priors=priors,
                progress=not no_progress,
            ),
        )
        print(summary_of(ds))
        _write(ds, outputs)
    print_names(outputs)
    _warn(ds)


def _outputs(
    target: Path, inputs: list[Path], request: dict[str, Any], *, overwrite: bool
) -> Outputs:
    """Return the files of a fit: the result, the config of the fitted curve, and the pictures."""
    from sweeps.figures.save import pictures_of
    from sweeps.files.outputs import Outputs, sha256_of

    pictures = pictures_of(target.with_suffix(""))
    if "priors" in request:
        pictures += pictures_of(_corner(target))
    paths = [target, target.with_suffix(".yaml"), *pictures]
    request = {"data": sha256_of(inputs[0])} | request
    return Outputs(paths, request, overwrite=overwrite, inputs=inputs)


def _corner(target: Path) -> Path:
    """Return the name of the picture of a posterior, without its ending."""
    return target.with_name(f"{target.stem}-posterior")


def _priors(given: list[str]) -> dict[str, Any]:
    """Return the priors that `--prior` names, in the form of a config."""
    from sweeps.config.yaml_reader import read_text

    priors: dict[str, Any] = {}
    for word in given:
        name, _, text = (part.strip() for part in word.partition("="))
        read = read_text(text, f"--prior {word}", name)
        if read.problems or read.data is None or name in priors:
            stop_with(
                f"--prior: must be NAME={{KIND: [A, B]}}, once per name, not {word}", Exit.USAGE
            )
        priors[name] = read.data
    return priors


def _ranges(free: str) -> dict[str, Range]:
    """Return the free parameters that `--free` names, with their ranges."""
    from sweeps.config.numbers import finite
    from sweeps.config.yaml_reader import scalar

    ranges: dict[str, Range] = {}
    for word in free.split(","):
        name, equals, limits = (part.strip() for part in word.partition("="))
        if name in ranges:
            stop_with(f"--free: {name} is given twice", Exit.USAGE)
        if not equals:
            ranges[name] = None
            continue
        try:
            low, high = (finite(scalar(end.strip())) for end in limits.split(":"))
        except ValueError as problem:
            what = str(problem) if limits.count(":") == 1 else f"a range is written {name}=LOW:HIGH"
            stop_with(f"--free {word}: {what}", Exit.USAGE)
        ranges[name] = low, high
    return ranges


def _by_name(given: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Return what is given under full names, so that using a symbol does not alter the request."""
    from stickslip.variables import canonical_name

    return [(canonical_name(name) or name, value) for name, value in given.items()]


def _write(ds: xr.Dataset, outputs: Outputs) -> None:
    """Write the file, the config of the fitted curve, and the pictures."""
    from sweeps.config.yaml_writer import block_yaml
    from sweeps.figures import draw
    from sweeps.figures.save import rendered
    from sweeps.fitting.output import posterior_groups

    target, written, *_ = outputs.paths
    curve = block_yaml({"output": f"results/{target.stem}-curve.nc"})
    pictures, groups = rendered(draw(ds), target.with_suffix("")), {}
    if "posterior_draws" in ds:
        pictures |= rendered(draw(ds, "posterior"), _corner(target))
        groups = posterior_groups(ds)
    config = f"{ds.attrs['config']}{curve}".encode()
    outputs.write({target: outputs.dataset(ds, groups), written: config, **pictures})


def _warn(ds: xr.Dataset) -> None:
    """Warn if the data do not settle the fit; end the command if some have no fitted value."""
    names, codes = ds.free_parameter.values, ds.parameter_determination.values
    if undetermined := ", ".join(names[codes == 1]):
        say(f"warning: not determined by these data: {undetermined}")
    if bounded := ", ".join(names[codes == 2]):
        every = "all free parameters end" if (codes == 2).all() else "the fit ends"
        say(
            f"warning: {every} at a bound: {bounded}; the ranges may not contain the best fit: are "
            "the data in SI units, and do the other parameters describe the machine?"
        )
    if lost := int(ds.fitted_value.isnull().sum()):
        say(
            f"warning: {lost} of {ds.sizes['datum']} data have no fitted value: no orbit was "
            "found; chi2 counts only the others"
        )
        raise typer.Exit(Exit.FAILED_POINTS)
