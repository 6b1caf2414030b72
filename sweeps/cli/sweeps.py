"""The verbs of configs and sweeps: new, schema, check, plan, sweep, status, merge, sensitivity."""

from __future__ import annotations

import os
import re
import shlex
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from sweeps.cli.shared import (
    BackendOption,
    ConfigArgument,
    NoProgressOption,
    OutputOption,
    OverwriteOption,
    SchedulerOption,
    SetOption,
    WorkersOption,
    checked_config,
    discard,
    execution_changes,
    flag,
    is_config,
    option,
    output_of,
    output_option,
    print_names,
    recalled_or_computed,
    require_netcdf,
    say,
    stop_with,
    usage_errors,
)
from sweeps.exits import Exit, ExpectedError
from sweeps.human import counted

if TYPE_CHECKING:
    from sweeps.config.load import Config
    from sweeps.engine.existing import Part
    from sweeps.engine.resume import ExistingPolicy
    from sweeps.engine.signals import Stop
    from sweeps.engine.sweep import Outcome

PartOption = Annotated[
    str | None, option("I/N", "Only every Nth point, beginning with the Ith, for job arrays.")
]

# Options that the command to resume must not repeat.
_ONCE = ("--overwrite", "--retry-failed")
_PLAIN = re.compile(r"[\w./+=-]+")  # names that need no quotes in YAML
_MANY = 10_000_000  # points; planning this many takes more than a moment


class _Kind(StrEnum):
    """What a new config is for; each has a shipped file."""

    PAPER = "paper"
    LUBRICANT = "lubricant"
    MAP = "map"
    FIT = "fit"


def new(
    file: Annotated[Path, typer.Argument(help="Config to write.")],
    kind: Annotated[
        _Kind,
        typer.Option(
            help="The paper's film against temperature, your own lubricant, a map of the kinds of "
            "motion, or the machine and the start of a fit."
        ),
    ] = _Kind.PAPER,
) -> None:
    """Write a commented config to begin with."""
    from sweeps.config.paper import shipped_config
    from sweeps.config.yaml_writer import block_yaml
    from sweeps.files.outputs import Outputs

    if file.suffix not in (".yaml", ".yml"):
        stop_with(f"{file}: the name of a config must end in .yaml", Exit.USAGE)
    text = shipped_config(f"new/{kind}").read_text(encoding="utf-8")
    result, config = f"results/{file.stem}", shlex.quote(str(file))
    names = {"FILE": config, "RESULT.nc": shlex.quote(f"{result}.nc")}
    names["RESULT-boundaries.nc"] = shlex.quote(f"{result}-boundaries.nc")
    output = f"output: {result}.nc\n"
    if not _PLAIN.fullmatch(result):  # a name that YAML would read as something else
        output = block_yaml({"output": f"{result}.nc"})
    names[f"output: results/{kind}.nc\n"] = output
    # In one pass, since a name may contain the placeholder of another.
    text = re.sub("|".join(map(re.escape, names)), lambda match: names[match[0]], text)
    with Outputs([file], {"config": text}, ways_out="choose another name").held() as outputs:
        outputs.write({file: text.encode()})
    print_names(outputs)
    verb = f"fit DATA.csv {config} --free k,gamma" if kind is _Kind.FIT else f"sweep {config}"
    print(f"next: stickslip {verb}")


def schema() -> None:
    """Print the JSON Schema of a config, for editors."""
    from sweeps.config.json_schema import json_schema_text

    print(json_schema_text(), end="")


def check(file: ConfigArgument, output: OutputOption = None, set_: SetOption = None) -> None:
    """Validate a config and show what a sweep of it would compute, or why it would not."""
    import numpy as np

    from sweeps.cli.summaries import parameters_text
    from sweeps.engine.resume import intention
    from sweeps.grid import Grid

    config = checked_config(file, set_)
    path = output_of(config, file, output)
    there = int(np.count_nonzero(intention(config, path).there))
    grid = Grid.from_config(config)
    axes = [f"{dim} {length}" for dim, length in zip(grid.dims, grid.shape, strict=True)]
    method = ", ".join(f"{key} {value}" for key, value in config.integrator.used().items())
    print(f"{file}: valid")
    points = f"points: {grid.size}" + (f" ({' x '.join(axes)})" if axes else "")
    print(points + (f", {there} already computed" if there else ""))
    print(f"parameters: {parameters_text(grid)}")
    print(f"integrator: {method}")
    print(f"output: {path}")


def sweep(
    file: ConfigArgument,
    output: OutputOption = None,
    workers: WorkersOption = None,
    backend: BackendOption = None,
    scheduler: SchedulerOption = None,
    max_runtime: Annotated[
        str | None, option("DURATION", "Stop after this time, such as 2h or 90min; resumable.")
    ] = None,
    set_: SetOption = None,
    no_progress: NoProgressOption = False,
    overwrite: Annotated[
        bool, flag("--overwrite", "Start afresh, whatever the output contains.")
    ] = False,
    retry_failed: Annotated[bool, flag("--retry-failed", "Compute failed points again.")] = False,
    partial: Annotated[
        bool, flag("--partial", "Compute nothing; write the points finished so far.")
    ] = False,
    keep_journal: Annotated[
        bool, flag("--keep-journal", "Keep the journal beside the result.")
    ] = False,
    part: PartOption = None,
) -> None:
    """Compute the points of a config that are still missing, and write the result to NetCDF.

    The same command runs, resumes and extends a sweep: after an interruption, with more values on
    an axis or a finer grid, exactly the missing points are computed. The parts 1/16 to 16/16 write
    separate files, which `stickslip merge` combines.
    """
    from sweeps.engine.resume import ExistingPolicy
    from sweeps.engine.signals import Stop, parse_duration

    if partial and retry_failed:
        stop_with(
            "--partial computes nothing, and --retry-failed computes failed points again: leave "
            "one of the two out",
            Exit.USAGE,
        )
    with usage_errors("--max-runtime: "):
        stop = Stop(None if max_runtime is None else parse_duration(max_runtime))
    chosen = _part(part)
    config = checked_config(file, [*(set_ or []), *execution_changes(workers, backend, scheduler)])
    path = output_of(config, file, output, chosen)
    failures = sweep_and_report(
        config,
        path,
        ExistingPolicy(overwrite, retry_failed),
        stop,
        progress=not no_progress,
        partial=partial,
        keep_journal=keep_journal,
        part=chosen,
    )
    if failures:
        raise typer.Exit(Exit.FAILED_POINTS)


def _part(text: str | None) -> Part | None:
    """Return the part that an option names; an invalid one ends the command."""
    from sweeps.engine.existing import Part

    with usage_errors("--part: "):
        return None if text is None else Part.parse(text)


def plan(
    file: ConfigArgument,
    output: OutputOption = None,
    workers: WorkersOption = None,
    backend: BackendOption = None,
    scheduler: SchedulerOption = None,
    set_: SetOption = None,
    no_progress: NoProgressOption = False,
    part: PartOption = None,
) -> None:
    """Estimate a sweep: points, blocks, bytes, and the time, from a pilot sample."""
    from sweeps.cli.summaries import print_plan
    from sweeps.engine.plan import plan as make_plan
    from sweeps.engine.progress import Compiling
    from sweeps.engine.signals import interruptible
    from sweeps.grid import Grid

    config = checked_config(file, [*(set_ or []), *execution_changes(workers, backend, scheduler)])
    chosen, compiling = _part(part), Compiling(wanted=not no_progress)
    path = output_of(config, file, output, chosen)
    points = Grid.from_config(config).size
    if points >= _MANY:
        say(f"{points} points; checking existing results and computing a sample")
    made = interruptible(lambda: make_plan(config, path, compiling, chosen), compiling.stop)
    print_plan(made, config.execution.backend)


def status(
    target: Annotated[
        Path, typer.Argument(metavar="FILE_OR_CONFIG", help="Result file or config of the sweep.")
    ],
    json_: Annotated[bool, flag("--json", "Print JSON, for programs.")] = False,
) -> None:
    """Show the state of a sweep, running or finished, without disturbing it.

    For a config, also say why `stickslip sweep` would refuse it, if it would.
    """
    from sweeps.cli.summaries import print_state
    from sweeps.engine.resume import state_of

    config = checked_config(target, None) if is_config(target) else None
    path = target if config is None else output_of(config, target)
    lacking, refusal = (0, None) if config is None else _to_compute(config, path)
    try:
        state = state_of(path)
    except (ExpectedError, OSError):
        if refusal is not None:  # it names the cause
            stop_with(str(refusal), refusal.code)
        raise
    if refusal is not None:
        state["refused"] = str(refusal)
    elif lacking and state["state"] == "complete":  # but the config has gained points
        state["to_compute"] = lacking
    if json_:
        import json

        print(json.dumps(state))
    elif state["state"] != "absent":
        print_state(state)
        if "to_compute" in state:
            print(f"{counted(lacking, 'more point')} of {target} to compute")
    elif refusal is None:
        absent = f"{path} does not exist, and no sweep was ever started for it"
        stop_with(absent, Exit.STORAGE)
    if refusal is not None:
        stop_with(str(refusal), refusal.code)


def merge(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="The parts of the result of one config.")
    ],
    output: Annotated[Path, output_option("Result file.")],
    overwrite: OverwriteOption = False,
    partial: Annotated[
        bool, flag("--partial", "Write the result even if points are missing.")
    ] = False,
) -> None:
    """Combine the parts of a sweep into the file that a single run would have written.

    Points that occur in several files must be equal. The parts are not changed.
    """
    from sweeps.cli.summaries import print_summary
    from sweeps.engine.merge import merge as merge_files

    require_netcdf(output)
    outcome = merge_files(files, output, overwrite=overwrite, partial=partial)
    print_summary(outcome)
    if outcome.complete:
        say(f"{output} is complete, nothing to do")
    if outcome.failures:
        raise typer.Exit(Exit.FAILED_POINTS)


def sensitivity(
    config: ConfigArgument,
    output: OutputOption = None,
    of: Annotated[
        list[str] | None,
        option("RESULT", "A result variable. [default: both amplitudes]"),
    ] = None,
    confidence: Annotated[float, typer.Option(help="Confidence level of the intervals.")] = 0.95,
    largest_missing: Annotated[
        float, typer.Option(help="Share of base points that may lack a result.")
    ] = 0.02,
    overwrite: OverwriteOption = False,
    workers: WorkersOption = None,
    backend: BackendOption = None,
    scheduler: SchedulerOption = None,
    set_: SetOption = None,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute which parameter matters over a whole box: Sobol indices with intervals.

    `sample` in the config gives the box and the number of base points, a power of 2; n base points
    of d parameters take (d + 2) n orbits. The command writes a NetCDF file and a picture.
    """
    from stickslip.indices import AMPLITUDES
    from sweeps.figures import draw
    from sweeps.figures.save import pictures_of, rendered
    from sweeps.files.outputs import Outputs
    from sweeps.sensitivity import Request, summary_of

    target = output or Path("results") / f"{config.stem}-sensitivity.nc"
    require_netcdf(target, strict=True)
    changes = execution_changes(workers, backend, scheduler)
    checked, results = checked_config(config, [*(set_ or []), *changes]), of or AMPLITUDES
    request = Request(checked, results, confidence, largest_missing)
    identity = {
        "config": checked.resolved_yaml(),
        "of": list(request.of),
        "confidence": confidence,
        "largest_missing": largest_missing,
    }
    paths = [target, *pictures_of(target.with_suffix(""))]
    with Outputs(paths, identity, overwrite=overwrite, inputs=[config]).held() as outputs:
        ds = recalled_or_computed(outputs, lambda: request.computed(progress=not no_progress))
        print(summary_of(ds))
        pictures = rendered(draw(ds), target.with_suffix(""))
        outputs.write({target: outputs.dataset(ds), **pictures})
    print_names(outputs)


def _to_compute(config: Config, path: Path) -> tuple[int, ExpectedError | None]:
    """Return how many points a sweep would compute, and the error that would refuse it, if any.

    A running sweep is left alone: it counts 0 points.
    """
    import numpy as np

    from sweeps.engine.resume import intention
    from sweeps.files.run_folder import InUseError

    try:
        return int(np.count_nonzero(intention(config, path).missing)), None
    except InUseError:
        return 0, None
    except ExpectedError as error:
        return 0, error


def sweep_and_report(
    config: Config,
    path: Path,
    policy: ExistingPolicy,
    stop: Stop,
    *,
    progress: bool = True,
    partial: bool = False,
    keep_journal: bool = False,
    part: Part | None = None,
    timing: bool = True,
) -> int:
    """Run a sweep and print its summary; return the number of failed points."""
    from sweeps.cli.summaries import print_summary, write_timing
    from sweeps.engine.sweep import sweep as run_sweep

    def say_if_wanted(line: str) -> None:
        if progress or line.startswith("warning"):
            say(line)

    outcome = run_sweep(
        config,
        path,
        say=say_if_wanted,
        progress=progress,
        policy=policy,
        stop=stop,
        partial=partial,
        keep_journal=keep_journal,
        part=part,
    )
    if outcome.stopped is not None:
        _leave(outcome)
    if outcome.computed and timing:
        write_timing(outcome, config.execution.backend)
    try:
        print_summary(outcome)
        sys.stdout.flush()
    except OSError:  # the result is complete, even if nobody can read the summary
        discard(sys.stdout)
    return outcome.failures


def _leave(outcome: Outcome) -> NoReturn:
    """Say how to resume, and exit at once: a compiler in a thread would keep the process alive."""
    from stickslip.status import Status
    from sweeps.cli.summaries import print_reasons

    command = shlex.join(["stickslip", *(a for a in sys.argv[1:] if a not in _ONCE)])
    kept = outcome.points - int(outcome.statuses[Status.PENDING])
    say(
        f"Stopped: {outcome.reason}. {kept} of {outcome.points} points are kept in "
        f"{outcome.output}.run. To resume:\n  {command}"
    )
    failed = outcome.statuses.copy()
    failed[Status.PENDING] = 0
    print_reasons(failed)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(outcome.stopped or Exit.STOPPED)
