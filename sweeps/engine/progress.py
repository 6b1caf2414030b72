"""The progress of a sweep, and how a person sees it and other long computations.

A terminal shows a bar, a log gets plain lines, and a notebook a bar under its cell. Nothing here
affects a computation: what cannot be written is lost.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self, TextIO, cast

from stickslip.dispatch.blocks import Costs
from stickslip.dispatch.in_flight import InFlight
from stickslip.dispatch.stop import LONGEST_STOP, Stop
from stickslip.status import Status
from sweeps.files.journal import Journal
from sweeps.files.result_rows import Memory, failures, tally
from sweeps.human import Messages, clock, counted, duration, points_per_time

if TYPE_CHECKING:
    from IPython.display import HTML
    from rich.progress import Progress

_FRAMES_PER_SECOND = 4.0  # so that no elapsed second is skipped

SECONDS_BETWEEN_LINES = 5.0
"""The time between two lines of a log; it grows to a minute while no point is finished."""
_MOST_LINES_LEFT_OUT = 12

MOMENT = 1.5  # seconds; loading compiled code takes less, so that no message flashes up

_GONE_SECONDS = 1.0  # how long to wait for a terminal that blocks
SOON = 5.0  # seconds; from this age on, the age of the oldest block in flight is shown


class Scene(Protocol):
    """What a display shows: `done` of a `goal` (or None), a `headline` and an `outlook`."""

    @property
    def done(self) -> int: ...  # noqa: D102 - a protocol
    @property
    def goal(self) -> int | None: ...  # noqa: D102
    @property
    def headline(self) -> str: ...  # noqa: D102
    @property
    def outlook(self) -> str: ...  # noqa: D102


class Display:
    """Shows a scene during a long computation; a context manager. This class shows nothing."""

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def start(self) -> None:
        """Take the terminal."""

    def stop(self) -> None:
        """Give the terminal back: the last state stays on screen and the cursor reappears."""


def display_of(scene: Scene, *, wanted: bool = True) -> Display:
    """Return the display that suits the stream of messages, standard error."""
    if not wanted:
        return Display()
    if is_in_notebook():
        return _InNotebook(scene)
    can_replace_lines = os.environ.get("TERM") not in ("dumb", "unknown")
    on_terminal = sys.stderr.isatty() and can_replace_lines
    return _OnTerminal(scene) if on_terminal else _InLog(scene)


def is_in_notebook() -> bool:
    """Return whether this runs in an IPython kernel, whose pages show HTML."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


class _InLog(Display):
    """A line every few seconds, without control characters; fewer while no point is finished."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._over = scene, threading.Event()

    def start(self) -> None:
        threading.Thread(target=self._keep_saying, daemon=True).start()

    def stop(self) -> None:
        self._over.set()

    def _keep_saying(self) -> None:
        if self._scene.goal is None:  # nothing else tells the reader what is going on
            self._say()
        done, left_out, patience = self._scene.done, 0, 0
        while not self._over.wait(SECONDS_BETWEEN_LINES):
            if self._scene.done != done:
                done, patience = self._scene.done, 0
            elif left_out < patience:
                left_out += 1
                continue
            else:
                patience = min(2 * patience + 1, _MOST_LINES_LEFT_OUT - 1)
            self._say()
            left_out = 0

    def _say(self) -> None:
        messages = Messages(sys.stderr)
        messages.write(", ".join(filter(None, (self._scene.headline, self._scene.outlook))) + "\n")
        messages.flush()


class _OnTerminal(Display):
    """A bar with the headline and a line with the outlook, drawn again several times a second.

    Without a goal it is a spinner, which disappears at the end.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._bar: Progress | None = None

    def start(self) -> None:
        from rich.console import Console, RenderableType
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn
        from rich.text import Text

        scene = self._scene

        class Bar(Progress):
            def get_renderables(self) -> Iterable[RenderableType]:
                for task in self.tasks:
                    task.total, task.completed = scene.goal, scene.done
                    task.description = scene.headline
                yield self.make_tasks_table(self.tasks)
                if scene.goal is not None:
                    yield Text(scene.outlook.replace("about ", ""))  # room for it in 80 columns

        self._bar = Bar(
            SpinnerColumn("line") if scene.goal is None else BarColumn(bar_width=None),
            TextColumn("{task.description}", markup=False),
            console=Console(file=cast(TextIO, Messages(sys.stderr))),
            refresh_per_second=_FRAMES_PER_SECOND,
            transient=scene.goal is None,
            expand=True,
        )
        self._bar.add_task(scene.headline)
        self._bar.start()

    def stop(self) -> None:
        if self._bar is not None:
            self._bar.stop()


class _InNotebook(Display):
    """Progress as HTML under the cell of a notebook; without a goal it disappears at the end."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._painter: threading.Thread | None = None

    def start(self) -> None:
        from IPython.display import display

        self._over = threading.Event()
        self._shown = display(self._picture(), display_id=True)
        # A daemon: the interpreter may end before the sweep does.
        self._painter = threading.Thread(target=self._keep_drawing, daemon=True)
        self._painter.start()

    def stop(self) -> None:
        if self._painter is not None:
            self._over.set()
            self._painter.join()
            self._shown.update(self._picture(over=True))

    def _keep_drawing(self) -> None:
        while not self._over.wait(1.0 / _FRAMES_PER_SECOND):
            self._shown.update(self._picture())

    def _picture(self, *, over: bool = False) -> HTML:
        from IPython.display import HTML

        scene = self._scene
        if scene.goal is None:
            return HTML("" if over else scene.headline)
        bar = f'<progress value="{scene.done}" max="{scene.goal}" style="width: 20em"></progress>'
        return HTML(f"{bar} {scene.headline}<br>{scene.outlook}")


class Compiling:
    """Says that kernels are being compiled if that takes longer than a moment; a context manager.

    The first run of a version compiles for a minute. Unless `wanted` is true, nothing is shown.
    `stop` clears the message at any time.
    """

    # An object of this class is its own scene, of unknown length.
    done: ClassVar[int] = 0
    goal: ClassVar[None] = None
    outlook: ClassVar[str] = ""

    def __init__(self, *, wanted: bool = True) -> None:
        self._wanted = wanted
        self._display = display_of(self, wanted=wanted)
        self._soon = threading.Timer(MOMENT, self._display.start)
        self._soon.daemon = True
        self._begun = 0.0

    def __enter__(self) -> Self:
        self._begun = time.monotonic()
        if self._wanted:
            self._soon.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def stop(self) -> None:
        """Give the terminal back, as it was before."""
        self._soon.cancel()
        if self._soon.is_alive():
            self._soon.join(_GONE_SECONDS)
        self._display.stop()

    @property
    def headline(self) -> str:
        """The reason for the wait, and how long it has taken so far."""
        elapsed = clock(time.monotonic() - self._begun)
        return f"compiling for this processor: up to a minute; the code is kept ({elapsed})"


SILENT = Compiling(wanted=False)
"""Shows nothing."""


class Counts:
    """The progress of a sweep of `total` points, and its remaining time.

    The `store` that keeps the points knows how many are finished and how they ended; this class
    counts the points that this run has added, and what they cost.
    """

    def __init__(self, total: int, store: Journal | Memory) -> None:
        self.total = total
        self.goal = total  # points known to be needed: fewer while a grid is refined
        self.costs = Costs()
        self.in_flight = InFlight()
        self._store = store
        self._begun = time.monotonic()
        self._slots: Callable[[], int] = lambda: 1
        self._stop = Stop()

    def begin(self, slots: Callable[[], int], stop: Stop | None = None) -> None:
        """Start the clock after compiling; `slots` returns the current number of workers."""
        self._slots, self._stop = slots, stop or self._stop
        if not self.computed:
            self._begun = time.monotonic()

    @property
    def slots(self) -> int:
        """The number of workers, which on a cluster come and go."""
        return self._slots()

    @property
    def computed(self) -> int:
        """The number of points that this run has finished."""
        return self.costs.points

    @property
    def done(self) -> int:
        """The number of points finished by this run or before it."""
        return int(self._store.statuses.sum())

    @property
    def left(self) -> int:
        """The number of points not yet finished."""
        return self.total - self.done

    @property
    def failed(self) -> int:
        """The number of finished points without a result."""
        return failures(self._store.statuses)

    @property
    def seconds(self) -> float:
        """The time since this run began to compute, in seconds."""
        return time.monotonic() - self._begun

    @property
    def rate(self) -> float:
        """Points per second in this run."""
        return self.computed / max(self.seconds, 1e-9)

    @property
    def seconds_left(self) -> float | None:
        """The time until this run ends, in seconds, with the current number of workers.

        None while it is unknown: before the first block is finished, and when the last blocks take
        longer than earlier ones. Blocks in flight count as partly done, so that the time never
        grows while no block comes back.
        """
        if not self.computed:
            return None
        slots, cost = self.slots, self.costs.seconds / self.computed
        running = self.in_flight.ages[:slots]
        rest = [max(cost * points - age, 0.0) for points, age in running]
        spent = sum(cost * points for points, _ in running) - sum(rest)
        ahead = self.in_flight.points if self._stop.reason else self.goal - self.done
        return max((cost * ahead - spent) / slots, *rest, 0.0) or None

    def as_dict(self) -> dict[str, Any]:
        """Return the progress as a dict for the heartbeat."""
        statuses, left = self._store.statuses.copy(), self.seconds_left
        statuses[Status.PENDING] = self.total - statuses.sum()
        return tally(statuses) | {
            "computed": self.computed,
            "seconds": round(self.seconds, 3),
            "points_per_second": round(self.rate, 3),
            "seconds_left": None if left is None else round(left, 1),
            "slots": self.slots,
        }

    @property
    def headline(self) -> str:
        """The state as text: `120/1200 points, 0 failed, 1:20 elapsed`."""
        return (
            f"{self.done}/{self.goal} points, {self.failed} failed, {clock(self.seconds)} elapsed"
        )

    @property
    def outlook(self) -> str:
        """Rate, remaining time and points in flight as text, if they are known."""
        in_flight = in_flight_text(self.in_flight)
        parts = ["stopping"] if self._stop.reason and in_flight else []
        if self.computed:
            parts.append(points_per_time(self.rate))
        if left := self.seconds_left:
            parts.append(f"about {duration(left)} left")
        return ", ".join([*parts, in_flight] if in_flight else parts)


def in_flight_text(in_flight: InFlight) -> str:
    """Return text such as `512 points in flight, the oldest for 1:03`; empty if there are none."""
    ages = in_flight.ages
    if not ages:
        return ""
    count, oldest = sum(points for points, _ in ages), ages[0][1]
    waited = f", the oldest for {clock(oldest)}" if oldest >= SOON else ""
    return f"{counted(count, 'point')} in flight{waited}"


def stop_text(in_flight: InFlight) -> str:
    """Return what a stop waits for and what it gives up, as text; empty if there is neither."""
    awaited = in_flight.awaited
    lost = in_flight.points - awaited.points
    given_up = f"leaving {counted(lost, 'point')}, which may take minutes, for the next run"
    longest = f"finishing {in_flight_text(awaited)}, for {LONGEST_STOP:.0f} s at most"
    finishing = longest if awaited.tasks else ""
    return "; ".join(filter(None, [finishing, given_up if lost else ""]))
