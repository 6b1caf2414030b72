"""The verb that says which parameter matters over a box: sensitivity."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

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
    execution_changes,
    print_names,
)

_AMPLITUDES = ["elastic_stress_amplitude", "friction_force_amplitude"]


def sensitivity(
    config: ConfigArgument,
    output: OutputOption = None,
    of: Annotated[
        list[str] | None,
        typer.Option(metavar="RESULT", help="A result variable. [default: both amplitudes]"),
    ] = None,
    confidence: Annotated[float, typer.Option(help="Confidence of the intervals.")] = 0.95,
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

    The box and the number of base points, a power of 2, are those of `sample` in the config; n base
    points of d parameters take (d + 2) n orbits. Beside the NetCDF file a picture is written.
    """
    from sweeps.engine.signals import interruptible
    from sweeps.figures import draw
    from sweeps.figures.save import pictures_of, rendered
    from sweeps.files.outputs import Outputs
    from sweeps.indices import indices, summary_of

    changes = execution_changes(workers, backend, scheduler)
    checked, results = checked_config(config, [*(set_ or []), *changes]), of or _AMPLITUDES
    target = output or Path("results") / f"{config.stem}-sensitivity.nc"
    request = {
        "config": checked.resolved_yaml(),
        "of": results,
        "confidence": confidence,
        "largest_missing": largest_missing,
    }
    paths = [target, *pictures_of(target.with_suffix(""))]
    with Outputs(paths, request, overwrite=overwrite, inputs=[config]).held() as outputs:
        ds = outputs.recalled()
        if ds is None and not outputs.finished:
            ds = interruptible(
                lambda: indices(
                    checked,
                    results,
                    confidence=confidence,
                    largest_missing=largest_missing,
                    progress=not no_progress,
                ),
                "Interrupted; nothing was kept.",
                at_once=outputs.release,
            )
        if ds is not None:
            print(summary_of(ds))
            pictures = rendered(draw(ds), target.with_suffix(""))
            outputs.write({target: outputs.dataset(ds), **pictures})
    print_names(outputs)
