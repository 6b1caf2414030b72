"""Writing a picture: the same figure gives the same bytes."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.figure import Figure

from sweeps.files.atomic import replacing

_DPI = 200
# What changes between two runs, the date, or between two installations, the writer, is left out.
_ANONYMOUS: dict[str, dict[str, str | None]] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def save(figure: Figure, path: Path) -> list[Path]:
    """Write a figure and return the files, complete or not written at all; raises OSError.

    A path with the ending `.png` or `.pdf` is that file, any other the stem of one of each.
    """
    # Not with_suffix: a stem like T=1.5 has no ending to replace.
    both = [path.with_name(path.name + suffix) for suffix in _ANONYMOUS]
    targets = [path] if path.suffix.lower() in _ANONYMOUS else both
    figure.draw_without_rendering()  # the layout is made once: it is half of the work
    figure.set_layout_engine("none")
    pictures = [_render(figure, target.suffix.lower()) for target in targets]
    for target, picture in zip(targets, pictures, strict=True):
        target.parent.mkdir(parents=True, exist_ok=True)
        with replacing(target, fsync=False) as temporary:
            temporary.write_bytes(picture)
    return targets


def _render(figure: Figure, suffix: str) -> bytes:
    picture = io.BytesIO()
    metadata = {**_ANONYMOUS[suffix], "Title": str(figure.get_label()) or None}
    figure.savefig(picture, format=suffix[1:], dpi=_DPI, metadata=metadata)
    return picture.getvalue()
