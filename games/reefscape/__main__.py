"""Command `python -m games.reefscape`: play a scripted auto; the same as `simcore play reefscape`."""

import sys

from simcore.cli import main

if __name__ == "__main__":
    sys.exit(main(["play", "reefscape", *sys.argv[1:]], program="python -m games.reefscape"))
