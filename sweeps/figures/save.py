"""Writing a picture: the same figure gives the same bytes."""

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
_USUAL = (".png", ".pdf")  # what is written where no ending is given
_WRITER = "stickslip figure"
# What changes between two runs, the date, or between two installations, versions, is left out.
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
    """Write a figure and return the files, complete or not written at all.

    A path with the ending `.png`, `.pdf` or `.svg` is that file, any other the stem of a PNG and a
    PDF. `look` is that which the figure was drawn with. Raises OSError, and ValueError where the
    figure is too small for what it holds.
    """
    pictures = rendered(figure, path, look)
    for target, picture in pictures.items():
        target.parent.mkdir(parents=True, exist_ok=True)
        with replacing(target, fsync=False) as temporary:
            temporary.write_bytes(picture)
    return [*pictures]


def pictures_of(path: Path) -> list[Path]:
    """Return a picture's files: the one with an extension, or the PNG and PDF of a stem."""
    # Not with_suffix: a stem like T=1.5 has no ending to replace.
    both = [path.with_name(path.name + suffix) for suffix in _USUAL]
    return [path] if path.suffix.lower() in ENDINGS else both


def rendered(figure: Figure, path: Path, look: Look | None = None) -> dict[Path, bytes]:
    """Return the contents of the files that `save` writes."""
    look = look or Look()
    title = str(figure.get_label())
    pictures = {}
    with styled(look.style, look.frame):
        _lay_out(figure)  # once: it is half of the work
        figure.set_layout_engine("none")
        for target in pictures_of(path):
            suffix, picture = target.suffix.lower(), io.BytesIO()
            metadata = _ANONYMOUS[suffix] | ({"Title": title} if title else {})
            figure.savefig(picture, format=suffix[1:], metadata=metadata)
            pictures[target] = picture.getvalue()
    return pictures


def is_picture_of_ours(path: Path) -> bool:
    """Tell whether a file is a picture that this program drew, which it may draw anew."""
    mark = _MARKS.get(path.suffix.lower())
    return mark is not None and path.is_file() and mark in path.read_bytes()


def _lay_out(figure: Figure) -> None:
    """Give the panels their places; raises ValueError where nothing is left for them."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "constrained_layout not applied", UserWarning)
        try:
            figure.draw_without_rendering()
        except UserWarning:
            width, height = figure.get_size_inches()
            raise ValueError(
                f"{width:.3g} x {height:.3g} inches leave no room for the panels beside their "
                "labels: take a larger size, or a smaller font"
            ) from None


def displayed(figure: Figure, look: Look | None = None) -> Figure:
    """Return the figure so that a notebook shows it, although pyplot does not know it.

    Its `savefig` has the settings that it was drawn with, TrueType fonts among them.
    """
    savefig = figure.savefig

    @functools.wraps(savefig)
    def save_styled(*args: Any, **kwargs: Any) -> None:
        with styled(look.style if look else None):
            savefig(*args, **kwargs)

    def png() -> bytes:
        stream = io.BytesIO()
        save_styled(stream, format="png", dpi=120)
        return stream.getvalue()

    figure.savefig = save_styled  # type: ignore[method-assign]
    figure._repr_png_ = png  # type: ignore[attr-defined] # IPython asks objects for it
    return figure
