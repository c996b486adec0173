"""`python -m nhtrack.cli` is the `nhtrack` command."""

from nhtrack.cli import main

main()
