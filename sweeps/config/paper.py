"""How the figures of the paper are made: the shipped config, its changes and the picture."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: a shipped config, overrides of it, and the name of the picture."""

    config: str
    figure: str
    changes: list[str] = field(default_factory=list)


PAPER: dict[int, PaperFigure] = {
    3: PaperFigure("fig3", "time_courses"),
    4: PaperFigure("fig3", "relative_motion", ["title=Fig. 4 - relative motion at 200 K"]),
    5: PaperFigure("fig5", "phase_portraits"),
    7: PaperFigure("fig7", "amplitudes"),
    8: PaperFigure("fig8", "amplitudes"),
    9: PaperFigure("fig9", "amplitudes"),
}
