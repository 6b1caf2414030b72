"""Draws docs/pictures/data-flow.svg for docs/data-flow.md: `python docs/data_flow.py`."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import NamedTuple

PICTURE = Path(__file__).parent / "pictures" / "data-flow.svg"


class Stage(NamedTuple):
    """A form of the data, and the modules that turn it into the next one."""

    name: str
    meaning: tuple[str, ...]
    steps: tuple[tuple[str, str], ...] = ()


STAGES = (
    Stage(
        "config",
        ("a YAML file or a dict:", "model, sweep, cases, settings"),
        (
            ("sweeps/config/yaml_reader.py", "text to values with their lines"),
            ("sweeps/config/schema.py", "keys, types, defaults"),
            ("sweeps/config/checks.py", "values that must fit together"),
            ("sweeps/grid.py", "axes to numbered points"),
        ),
    ),
    Stage(
        "points",
        ("numbers 0 … N−1,", "each a row of parameters"),
        (
            ("sweeps/engine/existing.py", "skip points that exist already"),
            ("stickslip/dispatch/blocks.py", "shuffle, cut into blocks of a second"),
            ("stickslip/dispatch/ask.py", "hand blocks to workers"),
            ("stickslip/orbit.py", "choose the method; refuse unstable steps"),
        ),
    ),
    Stage(
        "lanes",
        ("16 trajectories side by side,", "in nondimensional form"),
        (
            ("stickslip/model/", "the equations, as scalar functions"),
            ("stickslip/numerics/", "steps, step control, search for the orbit"),
            ("stickslip/measure/", "extrema, work, phases to a result row"),
            ("stickslip/kernels/", "the three joined and compiled"),
        ),
    ),
    Stage(
        "journal",
        ("a row of results per point,", "appended with a checksum"),
        (
            ("sweeps/files/journal.py", "the rows of a chunk, verified"),
            ("sweeps/files/sweep_file.py", "written by chunks, read back, sealed"),
            ("sweeps/files/attributes.py", "units, meanings, provenance"),
        ),
    ),
    Stage("result file", ("NetCDF-4, CF-1.8:", "a dimension for each axis")),
)

WIDTH, LEFT, BOX, ROW, GAP = 860, 110, 230, 58, 34
LINE = 21  # between lines of text
INK, GREY, LIGHT, BLUE = "#1a1a1a", "#5f5f5f", "#f3f6fa", "#0072b2"


def picture() -> str:
    """Return the picture as SVG."""
    tops = _tops()
    height = tops[-1] + ROW + 76
    parts = [_workers(tops), *_loops(tops)]
    for stage, top, below in zip(STAGES, tops, [*tops[1:], None], strict=True):
        parts += _box(stage, top)
        if below is not None:
            parts += _steps(stage, top + ROW, below)
    parts += _readers(tops[-1] + ROW)
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" '
            f'font-family="Helvetica, Arial, sans-serif" font-size="14">',
            '<marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="9" '
            f'markerHeight="9" orient="auto"><path d="M0 0L10 5L0 10z" fill="{GREY}"/></marker>',
            f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
            *parts,
            "</svg>",
            "",
        ]
    )


def _tops() -> list[int]:
    tops = [16]
    for stage in STAGES[:-1]:
        tops.append(tops[-1] + ROW + LINE * len(stage.steps) + GAP)
    return tops


def _box(stage: Stage, top: int) -> list[str]:
    return [
        f'<rect x="{LEFT}" y="{top}" width="{BOX}" height="{ROW}" rx="6" fill="{LIGHT}" '
        f'stroke="{BLUE}" stroke-width="1.5"/>',
        _text(LEFT + BOX / 2, top + 35, stage.name, f'font-size="19" font-weight="bold" {_MIDDLE}'),
        *(
            _text(LEFT + BOX + 22, top + 25 + LINE * i, line, f'fill="{INK}"')
            for i, line in enumerate(stage.meaning)
        ),
    ]


def _steps(stage: Stage, top: int, below: int) -> list[str]:
    x = LEFT + BOX / 2
    lines = [_arrow(f"M{x} {top + 2}V{below - 2}")]
    for i, (module, does) in enumerate(stage.steps):
        y = top + GAP / 2 + LINE * i + 13
        lines.append(
            _text(x + 16, y, module, f'font-family="monospace" font-size="13" fill="{BLUE}"')
        )
        lines.append(_text(x + 292, y, does, f'fill="{GREY}" font-size="13"'))
    return lines


def _workers(tops: list[int]) -> str:
    """Return a labelled band behind the stages in the workers."""
    top, bottom = tops[2] - LINE - GAP / 2 - 3, tops[3] - GAP / 2 + 7
    return (
        f'<rect x="{LEFT - 14}" y="{top}" width="{WIDTH - LEFT}" height="{bottom - top}" rx="10" '
        f'fill="#fff8e8" stroke="#e0c88a"/>'
        + _text(WIDTH - 26, tops[2] + 25, "in the workers: threads,", f'fill="{GREY}" {_END}')
        + _text(WIDTH - 26, tops[2] + 45, "processes or machines", f'fill="{GREY}" {_END}')
    )


def _loops(tops: list[int]) -> list[str]:
    """Return the arrow of existing results back to the points."""
    to = tops[1] + ROW / 2
    lines = []
    for stage, x, label in ((3, 78, "resume"), (4, 34, "grow")):
        start = tops[stage] + ROW / 2
        lines.append(_arrow(f"M{LEFT - 3} {start}H{x}V{to + (6 if x > 50 else -6)}H{LEFT - 3}"))
        middle = (start + to) / 2
        turned = f'transform="rotate(-90 {x - 6} {middle})" fill="{GREY}" {_MIDDLE}'
        lines.append(_text(x - 6, middle, label, turned))
    return lines


def _readers(top: int) -> list[str]:
    x = LEFT + BOX / 2
    return [
        _arrow(f"M{x} {top + 2}V{top + 40}"),
        _text(
            x + 16,
            top + 27,
            "sweeps/figures/",
            f'font-family="monospace" font-size="13" fill="{BLUE}"',
        ),
        _text(x + 292, top + 27, "drawn, nothing computed", f'fill="{GREY}" font-size="13"'),
        _text(x, top + 60, "picture", f'font-weight="bold" {_MIDDLE}'),
    ]


_MIDDLE, _END = 'text-anchor="middle"', 'text-anchor="end"'


def _text(x: float, y: float, text: str, look: str) -> str:
    return f'<text x="{x:g}" y="{y:g}" {look}>{escape(text)}</text>'


def _arrow(path: str) -> str:
    return (
        f'<path d="{path}" fill="none" stroke="{GREY}" stroke-width="1.5" marker-end="url(#tip)"/>'
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
