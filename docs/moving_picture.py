"""Draws docs/pictures/blocks.gif for README.md: `python docs/moving_picture.py`.

A period of the stationary orbit of Fig. 3, as the page of `stickslip report` plays it: two blocks
with the film between them, darker the more solid it is, and the time courses.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrow, Rectangle
from numpy.typing import NDArray
from PIL import Image

from stickslip import Parameters, simulate

PICTURE = Path(__file__).parent / "pictures" / "blocks.gif"
FRAMES, SECONDS = 96, 7.7
COLOURS = 32

_LIQUID, _SOLID = np.array([0.84, 0.92, 0.965]), np.array([0.0, 0.35, 0.59])
_BLUE, _GREY, _RED = "#0072b2", "#777777", "#b03a00"
_UPPER, _LOWER, _WALL = 1.7, 0.95, 3.4  # half widths of the blocks, and where the walls are, in µm
_FILM, _TOP = (1.0, 1.4), 2.05  # lower and upper edge of the film, top of the upper block
_SLANT, _ARROW = 0.22, 0.75


def main() -> None:
    """Draw the picture."""
    frames = pictures(simulate(Parameters(), periods=1, start="stationary"), FRAMES)
    palette = frames[FRAMES // 2].quantize(COLOURS, dither=Image.Dither.NONE)
    reduced = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    first, *others = reduced
    milliseconds = round(1000 * SECONDS / FRAMES)
    first.save(PICTURE, save_all=True, append_images=others, duration=milliseconds, loop=0)
    print(f"{PICTURE}: {len(reduced)} frames, {PICTURE.stat().st_size / 1000:.0f} kB")


def pictures(motion: xr.Dataset, count: int) -> list[Image.Image]:
    """Return pictures of so many moments, evenly spread over a motion that repeats."""
    times = motion.elapsed_time.values
    moments = np.linspace(times[0], times[-1], count, endpoint=False)
    shown = {
        name: np.interp(moments, times, motion[name].values)
        for name in (
            "upper_displacement",
            "lower_displacement",
            "order_parameter",
            "elastic_stress",
            "friction_force",
        )
    }
    largest = {name: float(np.abs(motion[name]).max()) for name in shown}
    style: Any = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False}
    found = []
    with mpl.rc_context(style):
        for at, moment in enumerate(moments):
            now = {name: float(values[at]) for name, values in shown.items()}
            figure = Figure(figsize=(5.6, 4.3), dpi=100, layout="constrained")
            blocks, displacement, force = figure.subplots(3, height_ratios=(1.5, 1.0, 1.0))
            draw_blocks(blocks, now, largest)
            draw_courses(displacement, force, motion, float(moment), now)
            canvas: Any = FigureCanvasAgg(figure)
            canvas.draw()
            found.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    return found


def draw_blocks(axes: Axes, now: dict[str, float], largest: dict[str, float]) -> None:
    """Draw blocks, springs and film; displacements are to scale with each other."""
    upper, lower = 1e6 * now["upper_displacement"], 1e6 * now["lower_displacement"]
    solid = now["order_parameter"] / largest["order_parameter"]
    slant = _SLANT * now["elastic_stress"] / largest["elastic_stress"]
    force = _ARROW * now["friction_force"] / largest["friction_force"]
    low, high = _FILM
    for wall in (-_WALL, _WALL):
        axes.add_line(Line2D([wall, wall], [0.0, high], color=_GREY, linewidth=3))
    for begin, end in ((-_WALL, lower - _LOWER), (lower + _LOWER, _WALL)):
        axes.plot(*_zigzag(begin, end, 0.45), color=_GREY, linewidth=1)
    _box(axes, upper - _UPPER, high, 2 * _UPPER, _TOP - high, facecolor="#d9dce1", edgecolor="#555")
    _box(axes, lower - _LOWER, 0.0, 2 * _LOWER, low, facecolor="#cfe6f5", edgecolor=_BLUE)
    colour = _LIQUID + solid * (_SOLID - _LIQUID)
    _box(axes, lower - _LOWER, low, 2 * _LOWER, high - low, facecolor=colour)
    for x in np.linspace(lower - 0.82, lower + 0.82, 12):
        line = Line2D([x, x + slant], [low, high], color="white", alpha=solid, linewidth=1.5)
        axes.add_line(line)
    if abs(force) > 0.05:
        arrow = FancyArrow(
            lower, 0.72, force, 0.0, width=0.04, head_width=0.18, head_length=0.12, color=_RED,
            length_includes_head=True, linewidth=0,
        )  # fmt: skip
        axes.add_patch(arrow)
    axes.text(upper, 0.5 * (high + _TOP), "driven block", ha="center", va="center")
    axes.text(lower, 0.3, "block on springs", ha="center", va="center")
    state = "solid: the blocks stick" if solid > 0.5 else "melted: the lower block slips"
    axes.set_title(f"film {state}", fontsize=9, loc="left")
    axes.set(xlim=(-_WALL - 0.05, _WALL + 0.05), ylim=(-0.05, _TOP + 0.05))
    axes.axis("off")


def draw_courses(
    displacement: Axes, force: Axes, motion: xr.Dataset, moment: float, now: dict[str, float]
) -> None:
    """Draw displacements and friction force over the whole time, with marks at the moment."""
    times = motion.elapsed_time.values
    displacement.plot(times, 1e6 * motion.upper_displacement, color="0.65")
    displacement.plot(times, 1e6 * motion.lower_displacement, color=_BLUE)
    force.plot(times, 1e3 * motion.friction_force, color=_RED)
    for axes, value in (
        (displacement, 1e6 * now["lower_displacement"]),
        (force, 1e3 * now["friction_force"]),
    ):
        axes.axvline(moment, color="0.6", linewidth=0.8)
        axes.plot([moment], [value], "o", color="black", markersize=4)
        axes.set_xlim(times[0], times[-1])
    displacement.set_ylabel("X, x (µm)")
    displacement.tick_params(labelbottom=False)
    force.set(xlabel="t (s)", ylabel="F (mN)")


def _box(axes: Axes, x: float, y: float, width: float, height: float, **look: Any) -> None:
    axes.add_patch(Rectangle((x, y), width, height, **look))


def _zigzag(begin: float, end: float, height: float) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the points of a spring."""
    turns = np.arange(13)
    aside = np.where((turns == 0) | (turns == 12), 0.0, np.where(turns % 2, 0.14, -0.14))
    return np.linspace(begin, end, 13), height + aside


if __name__ == "__main__":
    main()
