"""The shipped configs, and the figures of the paper that they make."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: a shipped config, the name of the picture, and overrides."""

    config: str
    figure: str
    changes: list[str] = field(default_factory=list)


PAPER: dict[int, PaperFigure] = {
    2: PaperFigure("fig2", "free_energy"),
    3: PaperFigure("fig3", "time_courses"),
    4: PaperFigure("fig3", "relative_motion", ["title=Fig. 4 - relative motion at 200 K"]),
    5: PaperFigure("fig5", "phase_portraits"),
    6: PaperFigure("fig6", "time_courses"),
    7: PaperFigure("fig7", "amplitudes"),
    8: PaperFigure("fig8", "amplitudes"),
    9: PaperFigure("fig9", "amplitudes"),
}


def shipped_config(name: str) -> Path:
    """Return the path of a shipped config such as `fig7`; raises FileNotFoundError for others.

    An installed wheel has the configs inside the package, a checkout next to it.
    """
    for folder in (_PACKAGE / "configs", _PACKAGE.parent / "configs"):
        path = folder / f"{name}.yaml"
        if path.is_file():
            return path
    raise FileNotFoundError(f"no shipped config is called {name}")
