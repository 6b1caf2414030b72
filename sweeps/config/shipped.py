"""The configs that are shipped: in a checkout beside the package, in a wheel inside it."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).parents[1]


def shipped_config(name: str) -> Path:
    """The path of a shipped config such as `fig7`; raises FileNotFoundError if there is none."""
    for folder in (_PACKAGE / "configs", _PACKAGE.parent / "configs"):
        path = folder / f"{name}.yaml"
        if path.is_file():
            return path
    raise FileNotFoundError(f"no shipped config is called {name}")
