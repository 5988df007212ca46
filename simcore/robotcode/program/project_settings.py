"""Robot measures from the PathPlanner and Choreo settings in a project's deploy folder.

Source: PathPlanner 2026 `deploy/pathplanner/settings.json`; Choreo 2026 `deploy/choreo/*.chor`, with SI values under
`val`.
"""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from simcore.robotcode.program.found_drivetrain import Measure

__all__ = ["project_measures"]

_log = logging.getLogger(__name__)

_MOTORS = {
    "krakenX60": "Kraken X60",
    "krakenX60FOC": "Kraken X60 FOC",
    "krakenX44": "Kraken X44",
    "krakenX44FOC": "Kraken X44 FOC",
    "falcon500": "Falcon 500",
    "falcon500FOC": "Falcon 500 FOC",
    "vortex": "NEO Vortex",
    "NEO": "NEO",
    "CIM": "CIM",
    "miniCIM": "Mini CIM",
}
_PATHPLANNER = {
    "robotMass": "mass",
    "robotMOI": "yaw_inertia",
    "robotTrackwidth": "trackwidth",
    "driveWheelRadius": "wheel_radius",
    "driveGearing": "drive_gearing",
    "driveCurrentLimit": "drive_stator_limit",
    "wheelCOF": "wheel_cof",
}
_CHOREO = {
    "mass": "mass",
    "inertia": "yaw_inertia",
    "gearing": "drive_gearing",
    "radius": "wheel_radius",
    "cof": "wheel_cof",
    "differentialTrackWidth": "trackwidth",
}
_CORNERS = ("fl", "fr", "bl", "br")


def project_measures(folder: Path) -> list[dict[str, Measure]]:
    """Return the measures of each settings file by name, PathPlanner's file first; `places` are module positions [m].

    Args:
        folder: Folder of robot.py.
    """
    found = []
    path = folder / "deploy" / "pathplanner" / "settings.json"
    settings = _read(path)
    if settings is not None:
        found.append(dict(_pathplanner(settings)))
    for path in sorted((folder / "deploy" / "choreo").glob("*.chor")):
        settings = _read(path)
        config = None if settings is None else settings.get("config")
        if isinstance(config, Mapping):
            found.append(dict(_choreo(config, path.name)))
    return found


def _pathplanner(settings: Mapping[str, Any]) -> Iterator[tuple[str, Measure]]:
    source = "PathPlanner's settings"
    for key, name in _PATHPLANNER.items():
        value = _number(settings.get(key))
        if value is not None:
            yield name, Measure(value, source)
    kind = settings.get("driveMotorType")
    if kind in _MOTORS:
        yield "drive_motor", Measure(_MOTORS[kind], source)
    if settings.get("holonomicMode", True):
        places = [[_number(settings.get(f"{c}Module{axis}"), zero=True) for axis in "XY"] for c in _CORNERS]
        if all(v is not None for place in places for v in place):
            yield "places", Measure(tuple((x, y) for x, y in places), source)
    size = [_number(settings.get(key)) for key in ("robotLength", "robotWidth")]
    if None not in size:
        yield "bumper", Measure(tuple(size), source)


def _choreo(config: Mapping[str, Any], name: str) -> Iterator[tuple[str, Measure]]:
    source = f"Choreo's {name}"
    for key, own in _CHOREO.items():
        value = _value(config.get(key))
        if value is not None:
            yield own, Measure(value, source)
    front, back = ([_value(dict(config.get(k) or {}).get(axis)) for axis in "xy"] for k in ("frontLeft", "backLeft"))
    if None not in (*front, *back):
        (fx, fy), (bx, by) = front, back
        yield "places", Measure(((fx, fy), (fx, -fy), (bx, by), (bx, -by)), source)  # type: ignore[operator]


def _value(entry: Any) -> float | None:
    return _number(entry.get("val") if isinstance(entry, Mapping) else entry, zero=True)


def _number(value: Any, *, zero: bool = False) -> float | None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return None
    return float(value) if value > 0.0 or zero else None


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
    except (OSError, ValueError) as error:
        _log.warning("%s is not read: %s", path, error)
        return None
