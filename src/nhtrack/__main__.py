"""`python -m nhtrack` is the command line."""

from nhtrack.cli import main

if __name__ == "__main__":
    main()
