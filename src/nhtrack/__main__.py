"""The command line, as the program `nhtrack` and as `python -m nhtrack`."""

import sys


def main() -> None:
    """Runs the command line; also what is interrupted while it is being imported ends with a plain line."""
    try:
        from nhtrack.cli import run_app

        run_app()
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        sys.exit(130)


if __name__ == "__main__":
    main()
