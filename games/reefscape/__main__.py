"""Command `python -m games.reefscape`, short for `simcore play reefscape`: play a scripted auto."""

import sys

from simcore.cli import main

if __name__ == "__main__":
    sys.exit(main(["play", "reefscape", *sys.argv[1:]], program="python -m games.reefscape"))
