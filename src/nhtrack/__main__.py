"""The command line, as the program `nhtrack` and as `python -m nhtrack`."""

import atexit
import os
import sys
from typing import NoReturn


def main() -> NoReturn:
    """Runs the command line; also what is interrupted while it is being imported ends with a plain line."""
    try:
        from nhtrack.stopping import listen

        listen()
        from nhtrack.cli import run_app

        run_app()
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        _end(130)
    except SystemExit as end:
        _end(end.code)
    _end(0)


def _end(code: int | str | None) -> NoReturn:
    """Ends the process at once: to take the interpreter apart takes a second where machine code was loaded."""
    from nhtrack.stopping import end_at_once

    end_at_once()
    if not isinstance(code, int | None):
        sys.exit(code)
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of our output left
        code = code or 1
    except OSError as error:
        code = code or 1
        sys.stderr.write(f"error: cannot write the output: {error.strerror}\n")
    sys.stderr.flush()
    os._exit(code or 0)


if __name__ == "__main__":
    main()
