"""Command `python -m games.rebuilt`, short for `simcore play rebuilt`: play a scripted auto."""

import sys

from simcore.cli import main

if __name__ == "__main__":
    sys.exit(main(["play", "rebuilt", *sys.argv[1:]], program="python -m games.rebuilt"))
