"""`python -m sweeps.cli`: the command `stickslip` where no script is installed."""

from __future__ import annotations

from sweeps.cli import main

main()
