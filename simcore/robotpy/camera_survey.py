"""The cameras that a robot program has built or asked for until it was built, for `simcore init`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from simcore.photonvision.photon_mounts import mounts
from simcore.photonvision.photon_program import photon_program
from simcore.robotpy.robot_cameras import LIMELIGHT
from simcore.robotpy.table_watch import table_watch
from simcore.vision.questnav_table import TABLE

__all__ = ["surveyed_cameras"]


def surveyed_cameras(folder: Path) -> list[dict[str, Any]]:
    """Fields of a `FoundCamera` of each; `watch_cameras` must have been called before the program was loaded.

    A Limelight is known by the name of its table. What a program asks for in its loops only is not seen.

    Args:
        folder: Of the project, whose modules are searched for tables.
    """
    program, watch = photon_program(), table_watch()
    watch.search(folder)
    placed = mounts(program)
    found: list[dict[str, Any]] = []
    for name in watch.names:
        if LIMELIGHT.fullmatch(name):
            found.append({"maker": "limelight", "name": name})
    for name in program.cameras:
        mount = placed.get(name)
        camera: dict[str, Any] = {"maker": "photonvision", "name": name}
        if mount is not None:
            m = mount.mount
            camera["place"] = [m.x, m.y, m.z, m.roll_deg, m.pitch_deg, m.yaw_deg]
            camera["source"] = mount.source
        found.append(camera)
    if TABLE in watch.names:
        found.append({"maker": "questnav"})
    return found
