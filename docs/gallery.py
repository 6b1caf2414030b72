"""Makes the pictures of docs/gallery.md by running the commands that the page shows: `make docs`.

A section of the page is an entry: its `sh` block is run, and the picture that its `figure` shows
must then be there. Data are kept for as long as commands, configs and numerics stay the same,
pictures until the drawing changes as well.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from source_hash import ROOT, source_hash

PAGE = ROOT / "docs" / "gallery.md"
MADE = ROOT / "docs" / "_build" / "gallery"

_COMMANDS = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
_OWN_CONFIG = re.compile(
    r"^```\{code-block\} yaml\n:caption: (\S+)\n\n(.*?)^```", re.MULTILINE | re.DOTALL
)
_PICTURE = re.compile(r"^```\{figure\} _build/gallery/(\S+\.png)$", re.MULTILINE)
_SHIPPED = re.compile(r"\bconfigs/\S+\.yaml")
_FIGURE = re.compile(r"stickslip figure (\d)")
_THUMBNAILS = "<!-- thumbnails -->"


class GalleryError(RuntimeError):
    """An entry that fails to make its picture; the message says which and why."""


@dataclass(frozen=True)
class Entry:
    """A section of the gallery: title, picture and commands, and its own configs by name."""

    title: str
    picture: str
    commands: tuple[str, ...]
    configs: tuple[tuple[str, str], ...]

    @property
    def drawing(self) -> tuple[str, ...]:
        """The commands that draw a file."""
        return tuple(line for line in self.commands if line.startswith("stickslip plot "))

    @property
    def computing(self) -> tuple[str, ...]:
        """All other commands."""
        return tuple(line for line in self.commands if line not in self.drawing)

    def shipped(self) -> list[Path]:
        """The shipped configs that the commands read."""
        from sweeps.config.paper import PAPER, shipped_config

        text = "\n".join(self.commands)
        figures = [PAPER[int(number)].config for number in _FIGURE.findall(text)]
        return [ROOT / name for name in _SHIPPED.findall(text)] + [*map(shipped_config, figures)]


def entries(page: str) -> list[Entry]:
    """Return the entries of a page, in order; raises GalleryError for an invalid section."""
    sections = re.split(r"^## ", page, flags=re.MULTILINE)[1:]
    return [_entry(section) for section in sections]


def _entry(section: str) -> Entry:
    title = section.partition("\n")[0]
    blocks, pictures = _COMMANDS.findall(section), _PICTURE.findall(section)
    if len(blocks) != 1 or len(pictures) != 1:
        raise GalleryError(f"{title}: an entry has one block of `sh` and one figure")
    commands = blocks[0].replace("\\\n", " ").splitlines()
    return Entry(title, pictures[0], tuple(commands), tuple(_OWN_CONFIG.findall(section)))


def with_configs(page: str) -> str:
    """Return the page with the shipped configs of each entry before its commands."""
    if _THUMBNAILS not in page:
        return page
    head, *sections = re.split(r"^(?=## )", page, flags=re.MULTILINE)
    return head + "".join(map(_with_configs, sections))


def _with_configs(section: str) -> str:
    names = dict.fromkeys(path.name for path in _entry(section.removeprefix("## ")).shipped())
    block = "```{{literalinclude}} ../configs/{}\n:language: yaml\n```\n\n"
    return section.replace("```sh\n", "".join(map(block.format, names)) + "```sh\n")


def with_thumbnails(page: str) -> str:
    """Return the page with thumbnails that link to its entries."""
    if _THUMBNAILS not in page:
        return page
    cards = []
    for entry in entries(page):
        label = f"gallery-{Path(entry.picture).stem}"
        page = page.replace(f"\n## {entry.title}\n", f"\n({label})=\n## {entry.title}\n")
        picture = f":img-top: _build/gallery/{entry.picture}"
        link = f":link: {label}\n:link-type: ref"
        cards.append(f":::{{grid-item-card}} {entry.title}\n{picture}\n{link}\n:::")
    grid = "::::{grid} 2 3 4 4\n:gutter: 2\n:class-container: thumbnails\n"
    return page.replace(_THUMBNAILS, "\n".join([grid, *cards, "::::"]))


def data_name(entry: Entry) -> str:
    """Return the name of the folder of an entry's data, which changes whenever they might."""
    from stickslip.kernels.version import NUMERICS_VERSION

    asked = repr((NUMERICS_VERSION, entry.computing, entry.configs))
    return source_hash(*entry.shipped(), also=asked)[:12]


def make(entry: Entry, made: Path = MADE) -> str:
    """Make the picture of an entry unless it exists; return what was done."""
    folder = made / data_name(entry)
    shown_by = (ROOT / "sweeps" / name for name in ("charts", "figures"))
    drawn_by = (*shown_by, ROOT / "stickslip" / "variables.py")
    kept = folder / f"{source_hash(*drawn_by, also=repr(entry.drawing))[:12]}-{entry.picture}"
    done = "kept"
    if not kept.exists():
        done = _run(entry, folder, kept)
    shutil.copyfile(kept, made / entry.picture)
    return done


def _run(entry: Entry, folder: Path, kept: Path) -> str:
    begin, complete = time.monotonic(), folder / "complete"
    commands = entry.commands
    if complete.exists() and entry.drawing:
        commands = entry.drawing
    else:
        _prepare(entry, folder)
    for command in commands:
        _execute(entry, command, folder)
    complete.touch()
    found = [path for path in folder.glob(f"**/{entry.picture}") if path.is_file()]
    if not found:
        raise GalleryError(f"{entry.title}: no command wrote {entry.picture}")
    found[0].replace(kept)
    return f"{time.monotonic() - begin:.0f} s"


def _prepare(entry: Entry, folder: Path) -> None:
    """Provide an empty folder with the configs."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "configs").symlink_to(ROOT / "configs")
    for name, text in entry.configs:
        (folder / name).write_text(text, encoding="utf-8")


def _execute(entry: Entry, command: str, folder: Path) -> None:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    done = subprocess.run(
        ["sh", "-e", "-c", command],
        cwd=folder,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        why = f"`{command}` ended with {done.returncode}\n{done.stderr}"
        raise GalleryError(f"{entry.title}: {why}")


def main() -> None:
    """Make all pictures, and remove the data of entries that no longer exist."""
    MADE.mkdir(parents=True, exist_ok=True)
    found = entries(PAGE.read_text("utf-8"))
    for entry in found:
        print(f"gallery: {entry.picture} ...", end=" ", flush=True)
        print(make(entry))
    wanted = {*map(data_name, found), *(entry.picture for entry in found)}
    for old in MADE.iterdir():
        if old.name not in wanted:
            shutil.rmtree(old) if old.is_dir() else old.unlink()


if __name__ == "__main__":
    try:
        main()
    except GalleryError as error:
        sys.exit(str(error))
