"""Command `python -m games.rebuilt`: play a scripted auto; the same as `simcore play rebuilt`."""

import sys

from simcore.cli import main

if __name__ == "__main__":
    sys.exit(main(["play", "rebuilt", *sys.argv[1:]], program="python -m games.rebuilt"))
