"""How things look in a notebook."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from sweeps.figures.style import styled


def displayed(figure: Figure) -> Figure:
    """The same figure, which a notebook shows although pyplot does not know it."""

    def png() -> bytes:
        stream = io.BytesIO()
        with styled():
            figure.savefig(stream, format="png", dpi=120)
        return stream.getvalue()

    figure._repr_png_ = png  # type: ignore[attr-defined] # IPython asks objects for it
    return figure
