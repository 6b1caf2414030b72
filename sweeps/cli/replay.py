"""The verb that recomputes a point of a result and its motion: replay."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import NoProgressOption, OverwriteOption, print_names, say, stop_with
from sweeps.exits import Exit
from sweeps.human import counted

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.points import Point


def replay(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep.")],
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=VALUE", help="The nearest point of an axis; SI units."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="NetCDF file. [default: FILE with -replay]"),
    ] = None,
    periods: Annotated[
        int | None, typer.Option(min=1, help="Drive periods. [default: until the orbit closes]")
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(metavar="initial|stationary", help="Where to begin. [default: on the orbit]"),
    ] = None,
    overwrite: OverwriteOption = False,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute one point of a result again, and draw its motion.

    The values are compared with those of the file; with the same version on the same type of
    processor they agree bit for bit. An older replay of the file is replaced.
    """
    from sweeps.engine.progress import Compiling
    from sweeps.figures import draw
    from sweeps.figures.save import pictures_of, rendered
    from sweeps.files.datasets import open_result, readable
    from sweeps.files.outputs import Outputs
    from sweeps.points import point_of

    if start not in (None, "initial", "stationary"):
        stop_with(f"--start is initial or stationary, not {start}", Exit.USAGE)
    target = output or file.with_name(f"{file.stem}-replay.nc")
    if target.suffix != ".nc":
        stop_with(f"{target}: -o names a NetCDF file, which ends in .nc", Exit.USAGE)
    with readable(file), open_result(file, whole=False) as ds:
        point = point_of(ds, at or ())
    stem = target.with_suffix("")
    outputs = Outputs(
        [target, *pictures_of(stem)], overwrite=overwrite, inputs=[file], replaces=_is_of_replay
    )
    with outputs.held():
        with Compiling(wanted=not no_progress):
            point.orbit()
        same = _compare(point)
        motion = _motion(point, periods, start)
        pictures = rendered(draw(motion, "orbit"), stem)
        outputs.write({target: outputs.dataset(motion), **pictures})
    print_names(outputs)
    if not same and not point.versions:
        raise typer.Exit(Exit.FAILED_POINTS)


def _compare(point: Point) -> bool:
    """Print the point's values in the file and any differences now; return whether they agree."""
    from stickslip.regime import Regime
    from stickslip.variables import RESULTS

    print(point.where)
    differing = point.differences()
    for name, stored in point.stored.items():
        units = f" {RESULTS[name].unit}".rstrip()
        change = f", now {differing[name][1]!r}" if name in differing else ""
        words = f" ({Regime(int(stored)).name.lower()})" if name == "regime" else ""
        print(f"  {name}: {stored!r}{units}{words}{change}")
    print(f"status: {point.status.name.lower()}: {point.status.sentence}")
    for note in point.versions:
        say(f"note: {note}")
    if not point.is_comparable:
        print("the file has no computed values for it; its orbit is computed now")
    elif differing:
        say(f"warning: the file has other values of {counted(len(differing), 'variable')}")
    else:
        print(f"all {len(point.stored)} variables agree with the file bit for bit")
    return not differing


def _motion(point: Point, periods: int | None, start: str | None) -> xr.Dataset:
    from stickslip import IntegrationError

    try:
        return point.replay(periods, start)  # type: ignore[arg-type] # checked above
    except IntegrationError as error:
        stop_with(f"the motion cannot be computed: {error}", Exit.FAILED_POINTS)


def _is_of_replay(path: Path) -> bool:
    """Tell whether a file is a replay, or the picture of one, which a later one replaces."""
    from sweeps.exits import ExpectedError
    from sweeps.figures.save import is_picture_of_ours
    from sweeps.files.datasets import open_result

    if path.suffix != ".nc":
        return is_picture_of_ours(path)
    try:
        with open_result(path, whole=False) as ds:
            # No other file has both a time course and a stroboscopic map.
            return {"elapsed_time", "period"} <= ds.sizes.keys() and "config" in ds.attrs
    except ExpectedError:  # no NetCDF file
        return False
