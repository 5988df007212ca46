"""Checks a folder of AdvantageScope models: your own CAD, or ours.

    python scripts/check_models.py FOLDER [--parts 16]

FOLDER is a Robot_NAME or Field3d_NAME folder, or the one that holds them (AdvantageScope's custom assets folder).
Exit status: 0 nothing wrong, 1 errors, 2 no such folder.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from simcore.errors import ModelError
from simcore.show.view_check import check_folder


def main(argv: list[str] | None = None) -> int:
    """Print one line for each thing that is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--parts", type=int, help="how many moving parts are published (the REBUILT robot: 16)")
    options = parser.parse_args(argv)
    try:
        findings = check_folder(options.folder, parts=options.parts)
    except ModelError as error:
        print(f"ModelError: {error}", file=sys.stderr)
        return 2
    for finding in findings:
        print(finding)
    errors = sum(finding.is_error for finding in findings)
    if not findings:
        print(f"{options.folder}: nothing wrong")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
