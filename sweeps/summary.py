"""What the command line prints about a sweep, a file or the installation."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


def write_timing(path: Path, ds: xr.Dataset, seconds: float, workers: int) -> None:
    """Timing in a file beside the result, because it is no part of the result."""
    import json
    import platform

    timing = {
        "seconds": round(seconds, 3),
        "points": int(ds.status.size),
        "points_per_second": round(ds.status.size / max(seconds, 1e-9), 3),
        "workers": workers,
        "machine": platform.machine(),
        "code_sha256": ds.attrs["code_sha256"],
    }
    try:
        path.with_name(path.name + ".timing.json").write_text(json.dumps(timing, indent=2) + "\n")
    except OSError as error:
        print(f"warning: the timing was not written: {error}", file=sys.stderr)


def print_summary(ds: xr.Dataset, path: Path, seconds: float) -> int:
    """Print where the result is and how it went; returns the number of failed points."""
    from stickslip.status import Status
    from sweeps.progress import duration

    statuses = ds.status.values.ravel()
    failures = int((statuses != Status.OK).sum())
    rate = statuses.size / max(seconds, 1e-9)
    print(path)
    print(
        f"{statuses.size} points in {duration(seconds)} ({rate:.1f} points/s), {failures} failed"
        f"{_worst_error(ds)}"
    )
    for status in Status:
        count = int((statuses == status).sum())
        if count and status is not Status.OK:
            print(f"  {count} {status.name.lower()}: {status.sentence}", file=sys.stderr)
    return failures


def _worst_error(ds: xr.Dataset) -> str:
    errors = ds.amplitude_error.values
    known = errors[errors == errors]
    return f", largest amplitude error {known.max():.1e}" if known.size else ""


def describe_installation() -> None:
    """Print versions, machine, hash of the code and the folder of compiled code."""
    import platform

    from stickslip.compiled import cache_folder, source_hash
    from sweeps.dataset import software

    print(software())
    print(f"machine: {platform.machine()}, {platform.system()}")
    print(f"code: {source_hash()}")
    print(f"compiled code is cached in: {cache_folder()}")


def describe_file(ds: xr.Dataset) -> None:
    """Print what a result file holds and where it comes from."""
    from sweeps.storage import content_hash

    print(f"title: {ds.attrs.get('title', '')}")
    print("dimensions: " + (", ".join(f"{d} {n}" for d, n in ds.sizes.items()) or "none"))
    print(f"variables: {', '.join(map(str, ds.data_vars))}")
    if "status" in ds:
        meanings = str(ds.status.attrs["flag_meanings"]).split()
        for flag, meaning in zip(ds.status.attrs["flag_values"], meanings, strict=True):
            count = int((ds.status == flag).sum())
            if count:
                print(f"  {meaning}: {count}")
    for name in ("source", "history", "software", "config_sha256"):
        print(f"{name}: {ds.attrs.get(name, 'unknown')}")
    print(f"content_sha256: {content_hash(ds)}")
