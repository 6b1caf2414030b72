"""The state of the sources from which something was made."""

from __future__ import annotations

import hashlib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = (ROOT / "stickslip", ROOT / "sweeps")


def source_hash(*sources: Path, also: str = "") -> str:
    """Return the hexadecimal SHA-256 of files, Python files below folders, and a text."""
    digest = hashlib.sha256(also.encode())
    for source in sources:
        for path in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
            digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
