"""Writing a picture: the same figure gives the same bytes."""

from __future__ import annotations

import io
import os
from collections.abc import Iterable
from pathlib import Path

from matplotlib.figure import Figure

from sweeps.files.atomic import replacing

_DPI = 200
# What changes between two runs, the date, or between two installations, the writer, is left out.
_ANONYMOUS: dict[str, dict[str, str | None]] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def save(figure: Figure, paths: str | os.PathLike[str] | Iterable[str | Path]) -> list[Path]:
    """Write a figure and return the files, complete or not written at all.

    Parameters
    ----------
    figure
        What `draw` returned.
    paths
        One path: with the ending `.png` or `.pdf` that file, else the stem of one of each.
        Or a list of paths with these endings.

    Raises
    ------
    ValueError
        For another ending, before anything is written.
    OSError
        Where a file cannot be written.
    """
    targets = _targets(paths)
    figure.draw_without_rendering()  # the layout is made once: it is half of the work
    figure.set_layout_engine("none")
    pictures = [_render(figure, path.suffix.lower()) for path in targets]
    for path, picture in zip(targets, pictures, strict=True):
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path, fsync=False) as temporary:
            temporary.write_bytes(picture)
    return targets


def _targets(paths: str | os.PathLike[str] | Iterable[str | Path]) -> list[Path]:
    if isinstance(paths, str | os.PathLike):
        stem = Path(paths)
        # Not with_suffix: a stem like T=1.5 has no ending to replace.
        both = [stem.with_name(stem.name + suffix) for suffix in _ANONYMOUS]
        return [stem] if stem.suffix.lower() in _ANONYMOUS else both
    targets = [Path(path) for path in paths]
    for path in targets:
        if path.suffix.lower() not in _ANONYMOUS:
            raise ValueError(f"{path}: a picture ends in {' or '.join(_ANONYMOUS)}")
    return targets


def _render(figure: Figure, suffix: str) -> bytes:
    picture = io.BytesIO()
    metadata = {**_ANONYMOUS[suffix], "Title": str(figure.get_label()) or None}
    figure.savefig(picture, format=suffix[1:], dpi=_DPI, metadata=metadata)
    return picture.getvalue()
