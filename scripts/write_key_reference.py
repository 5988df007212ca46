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

These are the tables of the file next to `robot.py` that `simcore init` writes ([Connect your robot
code](connect.md#simcoretoml)). Every key is optional, unless it is marked as needed. Lengths are in meters, masses in
kg, angles in degrees; x is forward, y to the left, z up from the floor. There may be several tables `[[intake]]`; a
single one may be written `[intake]` (shooter, claw, storage and climber, too). An unknown key or an invalid value
ends the start with one sentence.

This page is made by `scripts/write_key_reference.py`; edit the keys, not the page.

"""


def text() -> str:
    """Return the page."""
    return _HEAD + reference()


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(text(), encoding="utf-8")
