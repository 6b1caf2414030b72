"""The command line; `main` loads it when it is called, so that importing costs nothing."""

from __future__ import annotations


def main() -> None:
    """Run the command `stickslip`."""
    from sweeps.cli.app import main as run

    run()
