"""Write docs/simcore_toml.md, all keys of simcore.toml, from the tables of keys that read the file.

python scripts/write_key_reference.py
"""

from __future__ import annotations

import argparse
from pathlib import Path

from simcore.robot_file.template import reference

PAGE = Path(__file__).resolve().parents[1] / "docs" / "simcore_toml.md"
_HEAD = """\
# Keys of simcore.toml

The file beside `robot.py` that `simcore init` writes, table by table; for a beginning see
[Connect your robot code](connect.md#simcoretoml). All of it is optional, but what a table marks as needed. Lengths are
in meters, masses in kg, angles in degrees; x is forward, y to the left, z up from the floor. `[[intake]]` is a table of
which there may be several; a single one may be written `[intake]` (shooter, claw, storage and climber, too). A key that
is not known, or makes no sense, ends the start with one sentence.

This page is made by `scripts/write_key_reference.py`; edit the keys, not the page.

"""


def text() -> str:
    """Return the page."""
    return _HEAD + reference()


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(text(), encoding="utf-8")
