"""The command line; `main` loads it when called, so that importing this costs nothing."""

from __future__ import annotations


def main() -> None:
    """Run the command `stickslip`."""
    from sweeps.cli.app import main as run

    run()
