"""Display in notebooks."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from sweeps.figures.style import styled


def displayed(figure: Figure) -> Figure:
    """Return the figure so that a notebook shows it, although pyplot does not know it."""

    def png() -> bytes:
        stream = io.BytesIO()
        with styled():
            figure.savefig(stream, format="png", dpi=120)
        return stream.getvalue()

    figure._repr_png_ = png  # type: ignore[attr-defined] # IPython asks objects for it
    return figure
