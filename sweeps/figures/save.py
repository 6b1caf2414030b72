"""Writing a picture, so that the same figure always gives the same bytes."""

from __future__ import annotations

import functools
import io
import warnings
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from sweeps.figures.look import Look
from sweeps.figures.style import styled
from sweeps.files.atomic import replacing

ENDINGS = (".png", ".pdf", ".svg")
_USUAL = (".png", ".pdf")  # written for a path without an ending
_WRITER = "stickslip figure"
# Without the date, which differs between runs, and versions, which differ between installations.
_ANONYMOUS: dict[str, dict[str, str | None]] = {
    ".png": {"Software": _WRITER},
    ".pdf": {"CreationDate": None, "Creator": _WRITER, "Producer": None},
    ".svg": {"Date": None, "Creator": _WRITER},
}
_MARKS = {
    ".png": f"Software\0{_WRITER}".encode(),
    ".pdf": f"/Creator ({_WRITER})".encode(),
    ".svg": f"<dc:title>{_WRITER}</dc:title>".encode(),
}


def save(figure: Figure, path: Path, look: Look | None = None) -> list[Path]:
    """Write a figure and return the files. Each is written completely or not at all.

    A path with the ending `.png`, `.pdf` or `.svg` is one file; any other is the stem of a PNG and
    a PDF. `look` must be the one that the figure was drawn with. Raises OSError, and ValueError if
    the figure is too small for its content.
    """
    pictures = rendered(figure, path, look)
    for target, picture in pictures.items():
        target.parent.mkdir(parents=True, exist_ok=True)
        with replacing(target, fsync=False) as temporary:
            temporary.write_bytes(picture)
    return [*pictures]


def pictures_of(path: Path) -> list[Path]:
    """Return the files of a picture: a path with an ending, or the PNG and PDF of a stem."""
    # Not with_suffix: a stem like T=1.5 has no ending to replace.
    both = [path.with_name(path.name + suffix) for suffix in _USUAL]
    return [path] if path.suffix.lower() in ENDINGS else both


def rendered(figure: Figure, path: Path, look: Look | None = None) -> dict[Path, bytes]:
    """Return the contents of the files that `save` writes."""
    look = look or Look()
    title = str(figure.get_label())
    pictures = {}
    with styled(look):
        _lay_out(figure)  # once: it is half of the work
        figure.set_layout_engine("none")
        for target in pictures_of(path):
            suffix, picture = target.suffix.lower(), io.BytesIO()
            metadata = _ANONYMOUS[suffix] | ({"Title": title} if title else {})
            figure.savefig(picture, format=suffix[1:], metadata=metadata)
            pictures[target] = picture.getvalue()
    return pictures


def is_picture_of_ours(path: Path) -> bool:
    """Return True if this program drew the picture in a file, so that it may replace it."""
    mark = _MARKS.get(path.suffix.lower())
    return mark is not None and path.is_file() and mark in path.read_bytes()


def _lay_out(figure: Figure) -> None:
    """Lay out the panels; raises ValueError if there is no room for them."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "constrained_layout not applied", UserWarning)
        try:
            figure.draw_without_rendering()
        except UserWarning:
            width, height = figure.get_size_inches()
            raise ValueError(
                f"{width:.3g} x {height:.3g} inches leave no room for the panels next to their "
                "labels; use a larger size, or a smaller font"
            ) from None


def displayed(figure: Figure, look: Look | None = None) -> Figure:
    """Return the figure in a form that a notebook shows, although pyplot does not know it.

    Its `savefig` uses the settings that it was drawn with, such as TrueType fonts.
    """
    savefig = figure.savefig

    @functools.wraps(savefig)
    def save_styled(*args: Any, **kwargs: Any) -> None:
        with styled(look):
            savefig(*args, **kwargs)

    def png() -> bytes:
        stream = io.BytesIO()
        save_styled(stream, format="png", dpi=120)
        return stream.getvalue()

    figure.savefig = save_styled  # type: ignore[method-assign]
    figure._repr_png_ = png  # type: ignore[attr-defined] # IPython asks objects for it
    return figure
