"""`python -m sweeps.cli`: the command `stickslip` where no script is installed."""

from sweeps.cli import main

main()
