"""Friction laws from outside: from installed packages, or registered in this process.

The identity of such a law is known before any of its code runs. It is the name and version of the
distribution with a hash of its files, or a hash of the registered code. Options, kernels, their
cache and the tasks of workers refer to the law as `NAME@IDENTITY`.
"""

from __future__ import annotations

import hashlib
import os
import re
import stat
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any

GROUP = "stickslip.laws"
"""The group of entry points in which a distribution declares its laws."""

_HOW_TO = (
    "to add a law of your own, install a package with an entry point in the group "
    f"{GROUP!r}, or call stickslip.register_law (docs/how-to/friction-law.md)"
)

_IN_PYTHON = "python+"
_DIGITS = 32  # hexadecimal digits of a hash: 128 bits, as for the keys of points
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,39}")  # file names contain it


class LawError(ValueError):
    """A friction law is unknown, breaks a promise or is not the version that was requested.

    >>> Options(friction="eyring")
    Traceback (most recent call last):
    stickslip.options.OptionError: friction must be one of power-law, not 'eyring'; ...
    >>> register_law(FrictionLaw("power-law", *4 * [abs]))
    Traceback (most recent call last):
    stickslip.laws.LawError: 'power-law' is a law of stickslip itself; choose another name
    """


class UnknownLawError(LawError):
    """No law has this name; the message explains how to add one."""


@dataclass(frozen=True)
class Origin:
    """The source of a law; `load` returns the law unchecked."""

    name: str
    identity: str
    load: Callable[[], Any] = field(compare=False, repr=False)

    @property
    def full_name(self) -> str:
        """The name with the identity, which is unique to the law."""
        return f"{self.name}@{self.identity}"


REGISTERED: dict[str, Origin] = {}
"""The laws of this process, by name and by full name; a replaced law keeps its full name."""


def is_of_this_process(full_name: str) -> bool:
    """Return whether a law was registered in Python, so that only this process knows it."""
    return full_name.partition("@")[2].startswith(_IN_PYTHON)


def origin_of(given: str) -> Origin:
    """Return the origin of a law, given by name or full name; raises LawError."""
    name, _, identity = str(given).partition("@")
    origin = REGISTERED.get(given) or REGISTERED.get(name)
    try:
        origin = origin or _installed(name)
    except UnknownLawError:
        if not identity:
            raise
        how = "register" if is_of_this_process(given) else "install"
        raise LawError(f"the law {given} is missing; {how} the same law first") from None
    if identity not in ("", origin.identity):
        raise LawError(
            f"the law {given} is {origin.identity} here, which may give other numbers; install or "
            "register the original again, or recompute without `film.law`"
        )
    return origin


def origin_in_python(name: str, code: str, law: object) -> Origin:
    """Return the origin of a law registered in Python, with a hash of its code; raises LawError."""
    if not _NAME.fullmatch(name):
        raise LawError(
            f"{name!r} cannot name a law: up to 40 letters, digits, . _ -, first a letter or digit"
        )
    if entries := metadata.entry_points(group=GROUP, name=name):
        raise LawError(f"{name!r} is a law of {_packages(entries)}; choose another name")
    return Origin(name, f"{_IN_PYTHON}{code[:_DIGITS]}", lambda: law)


def register(origin: Origin) -> None:
    """Register a law of this process under its name and its full name."""
    REGISTERED[origin.name] = REGISTERED[origin.full_name] = origin


@cache
def _installed(name: str) -> Origin:
    """Return the origin of a law from an installed distribution; raises LawError."""
    entries = metadata.entry_points(group=GROUP, name=name)
    if not entries or not _NAME.fullmatch(name):
        others = sorted(REGISTERED.keys() | metadata.entry_points(group=GROUP).names)
        known = ", ".join(each for each in others if "@" not in each)
        raise UnknownLawError(f"{f'other known laws: {known}; ' if known else ''}{_HOW_TO}")
    if len(entries) > 1:
        raise LawError(f"{name!r} is a law of {_packages(entries)}; uninstall all but one")
    (entry,) = entries
    identity = _identity(entry)

    def load() -> Any:
        law = entry.load()
        if _identity(entry) != identity:
            raise LawError(f"{identity} was changed while it was in use; start again")
        return law

    return Origin(name, identity, load)


def _packages(entries: metadata.EntryPoints) -> str:
    return " and ".join(sorted(entry.dist.name for entry in entries if entry.dist))


def _identity(entry: metadata.EntryPoint) -> str:
    """Return the name and version of a law's distribution with a hash of its files.

    Raises LawError if its code would come from elsewhere, or another user could have changed it.
    """
    distribution: Any = entry.dist
    called = f"the package {distribution.name}, which has the law {entry.name!r},"
    root = Path(distribution.locate_file("")).resolve()
    files = {
        path.as_posix(): root / path
        for path in distribution.files or ()
        if "__pycache__" not in path.parts and ".." not in path.parts  # commands are elsewhere
    }
    if root == Path.cwd():
        raise LawError(
            f"{called} lies in the current folder, {root}; install it, or run from another folder"
        )
    _require_its_module(entry.module, root, files, called)
    for path in dict.fromkeys(p for file in files.values() for p in (file, *file.parents)):
        _refuse_exposed(path, called, inside=root == path or root in path.parents)
    version = f"{re.sub(r'[-_.]+', '-', distribution.name).lower()}-{distribution.version}"
    digest = hashlib.sha256(f"{version}\0{entry.value}".encode())
    for name, path in sorted(files.items()):
        if not name.partition("/")[0].endswith((".dist-info", ".egg-info")):
            content = hashlib.sha256(path.read_bytes()).digest()
            digest.update(f"\0{name}\0".encode() + content)
    return f"{version}+{digest.hexdigest()[:_DIGITS]}"


def _require_its_module(module: str, root: Path, files: dict[str, Path], called: str) -> None:
    """Raise LawError if a module is not a file of its distribution, or another module hides it."""
    path, top = module.replace(".", "/"), module.partition(".")[0]
    if not {f"{path}.py", f"{path}/__init__.py"} & files.keys():
        raise LawError(
            f"{called} does not have the module {module} among its files: it is damaged, or "
            "installed with --editable; reinstall it without --editable"
        )
    spec = find_spec(top)
    inside, origin = (spec.submodule_search_locations, spec.origin) if spec else (None, None)
    places = [Path(place).resolve() for place in inside or [origin or "."]]
    if places not in ([root / top], [root / f"{top}.py"]):
        raise LawError(f"{called} is hidden by another module {top}, {places[0]}; remove that one")


def _refuse_exposed(path: Path, called: str, *, inside: bool) -> None:
    """Raise LawError if another user could have changed a file or a folder."""
    from stickslip.compiled.cache import writable_by_others  # it loads the compiler

    try:
        status = path.stat()
    except OSError as error:
        raise LawError(f"{called} is damaged ({error}); install it again") from error
    # Root, this user, and whoever installed this package can run any code anyway.
    if status.st_uid not in (0, os.geteuid(), Path(__file__).stat().st_uid):
        raise LawError(f"{called} could be changed by others: {path} belongs to another user")
    # In a folder with a sticky bit, such as /tmp, only the owner of an entry can replace it.
    if writable_by_others(status) and (inside or not status.st_mode & stat.S_ISVTX):
        raise LawError(
            f"{called} could be changed by others, who may write to {path}; if nobody has done "
            f"so, run chmod go-w {path}"
        )
