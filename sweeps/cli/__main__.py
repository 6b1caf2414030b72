"""`python -m sweeps.cli`: the command `stickslip` without an installed script."""

from sweeps.cli import main

main()
