"""Write simcore/vision/tag_layouts.json from the layouts that come with WPILib: `python scripts/make_tag_layouts.py`.

It needs robotpy-apriltag, which simcore itself does not.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

TARGET = Path(__file__).resolve().parents[1] / "simcore" / "vision" / "tag_layouts.json"


def layouts() -> dict[str, Any]:
    """Return layouts by WPILib's name: length and width [m]; id, x, y, z [m] and quaternion w, x, y, z of each tag."""
    from robotpy_apriltag import AprilTagField, AprilTagFieldLayout

    return {
        name: _rows(AprilTagFieldLayout.loadField(field))
        for name, field in vars(AprilTagField).items()
        if name.startswith("k2")
    }


def _rows(field: Any) -> dict[str, Any]:
    tags = []
    for tag in field.getTags():
        p, q = tag.pose, tag.pose.rotation().getQuaternion()
        tags.append([tag.ID, p.X(), p.Y(), p.Z(), q.W(), q.X(), q.Y(), q.Z()])
    return {"field": [field.getFieldLength(), field.getFieldWidth()], "tags": tags}


def main() -> None:
    """Write the file with one row per tag."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    TARGET.write_text(json.dumps(layouts(), separators=(",", ":")).replace("],[", "],\n[") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
