"""Keeps files that git does not track out of what is built from a checkout."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class TrackedFilesOnly(BuildHookInterface):
    """Excludes untracked files; what .gitignore names, hatchling leaves out by itself."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002 - hatchling's
        """Add the untracked files to the `exclude` of the target, before it is read."""
        excluded = list(self.build_config.target_config.get("exclude", []))
        self.build_config.target_config["exclude"] = excluded + untracked(Path(self.root))


def untracked(root: Path) -> list[str]:
    """Patterns of the untracked files below `root`; none where that is no checkout of its own.

    A source distribution, unpacked anywhere, holds tracked files alone.
    """
    if not (root / ".git").exists():
        return []
    command = ["git", "-C", str(root), "ls-files", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(command, capture_output=True, check=True).stdout
    return ["/" + _escaped(name) for name in listed.decode().split("\0") if name]


def _escaped(name: str) -> str:
    """A name as a pattern of .gitignore that matches nothing else."""
    return "".join("\\" + letter if letter in "\\*?[]!# " else letter for letter in name)
