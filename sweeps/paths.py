"""Paths as people write them: with `~`, with `$SCRATCH`, or from another system."""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path

_VARIABLE = re.compile(r"\$(\w+|\{\w+\})")
_ADDRESS = re.compile(r"[A-Za-z][\w+.-]+:/")  # a Path has one slash where an address has two
_WINDOWS = re.compile(r"[A-Za-z]:[\\/]")


def expanded(path: str | os.PathLike[str]) -> str:
    """Return a path with the home folder for `~`, and the values of `$NAME` and `${NAME}`.

    Raises ValueError for a variable that is not set, for a URL, and for a Windows path on another
    system: each would create a folder with an odd name.
    """
    text = os.fspath(path)
    for match in _VARIABLE.finditer(text):
        name = match[1].strip("{}")
        if not os.environ.get(name):
            raise ValueError(
                f"has {match[0]}, an environment variable that is not set here; set it, or write "
                "the path without it"
            )
    if _ADDRESS.match(text):
        raise ValueError("is a URL; give a file on this machine, such as results/mine.nc")
    if os.sep == "/" and (_WINDOWS.match(text) or "\\" in text):
        raise ValueError("is a Windows path; here / separates folders (and C:\\ is /mnt/c/ in WSL)")
    text = os.path.expandvars(text)
    try:
        return str(Path(text).expanduser()) if text.startswith("~") else text
    except RuntimeError:
        raise ValueError(
            f"begins with {text.partition('/')[0]}, but there is no such user"
        ) from None


def path_of(path: str | os.PathLike[str]) -> Path:
    """Return the path of an existing file as it is, and any other path `expanded`.

    Raises ValueError with the path in its message.
    """
    with contextlib.suppress(OSError):  # a name too long, or in a folder that we may not read
        if Path(path).exists():
            return Path(path)
    try:
        return Path(expanded(path))
    except ValueError as error:
        raise ValueError(f"{os.fspath(path)} {error}") from None
