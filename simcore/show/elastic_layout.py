"""Layout for the Elastic dashboard: field, score, match clock, battery, sensors and mechanisms.

Sources: layouts that teams publish for Elastic 2025 and 2026, and the widget types and their properties in
https://github.com/Gold872/elastic-dashboard (`lib/widgets/nt_widgets`). Elastic uses its defaults for properties that a
layout file omits.
"""

from __future__ import annotations

import re
from typing import Any

from simcore.telemetry.snapshot import Snapshot

__all__ = ["elastic_layout"]

_CELL = 128  # [px]; size of a cell in Elastic's grid
_WIDTH = 11  # cells across a tab on a laptop screen 1,440 pixels wide
_PERIOD = 0.06  # [s]; update period of a widget, Elastic's default


def elastic_layout(snapshot: Snapshot) -> dict[str, Any]:
    """Return the content of an Elastic layout file, with a tab for driving and a tab for the robot.

    Args:
        snapshot: Snapshot of the run; the layout has no widgets for `Sim/` keys that the snapshot does not contain.
    """
    drive = [
        _widget("Field", "SmartDashboard/Field", "Field", (0, 0, 6, 4)),
        _widget("Auto", "SmartDashboard/Auto", "ComboBox Chooser", (6, 0, 3, 1)),
        _widget("FMS", "FMSInfo", "FMSInfo", (6, 1, 3, 1)),
    ]
    match = [
        ("Sim/Match/TimeLeft", "Match Time", "double"),
        ("Sim/Match/Period", "Text Display", "string"),
        ("Sim/Score/Blue", "Text Display", "int"),
        ("Sim/Score/Red", "Text Display", "int"),
        ("Sim/Intake/HeldCount", "Text Display", "int"),
        *((key, "Boolean Box", "boolean") for key in snapshot.booleans if key.startswith("Sim/Match/")),
    ]
    published = {**snapshot.doubles, **snapshot.strings, **snapshot.integers, **snapshot.booleans}
    drive += _rows([(key, kind, data) for key, kind, data in match if key in published], (6, 2, 9), (1, 1))
    battery = ("Sim/Debug/BatteryVoltage", "Sim/Debug/BatteryCurrent")
    drive += _rows([(key, "Graph", "double") for key in battery if key in published], (0, 4, 6), (3, 2))
    moves = r"Sim/Debug/.+(VelocityRPS|AngleDeg|HeightM|ExtendedPct|CurrentA)$"
    graphs = [(key, "Graph", "double") for key in snapshot.doubles if re.match(moves, key)]
    sensors = [(key, "Boolean Box", "boolean") for key in snapshot.booleans if re.match(r"Sim/(Debug|Sensors)/", key)]
    robot = _rows(sensors, (0, 0, _WIDTH), (1, 1))
    robot += _rows(graphs, (0, -(-len(sensors) // _WIDTH), _WIDTH), (2, 2))
    tabs = {"Drive": drive, "Robot": robot}
    return {
        "version": 1.0,
        "grid_size": _CELL,
        "tabs": [
            {"name": name, "grid_layout": {"layouts": [], "containers": widgets}} for name, widgets in tabs.items()
        ],
    }


def _rows(
    widgets: list[tuple[str, str, str]], area: tuple[int, int, int], size: tuple[int, int]
) -> list[dict[str, Any]]:
    """Return widgets of equal size that fill an area row by row.

    Args:
        widgets: Key, widget type and data type of each widget.
        area: First column, first row and end column of the area [cells].
        size: Width and height of each widget [cells].
    """
    (left, top, right), (width, height) = area, size
    columns = (right - left) // width
    return [
        _widget(
            *(_title(key), key, kind),
            (left + number % columns * width, top + number // columns * height, width, height),
            data_type=data_type,
        )
        for number, (key, kind, data_type) in enumerate(widgets)
    ]


def _title(key: str) -> str:
    """Convert a telemetry key to a title, e.g. `Sim/Debug/BatteryVoltage` to `Battery Voltage`."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", key.rpartition("/")[2])


def _widget(title: str, key: str, kind: str, place: tuple[int, int, int, int], **properties: str) -> dict[str, Any]:
    x, y, width, height = (float(_CELL * cells) for cells in place)
    return {
        **{"title": title, "x": x, "y": y, "width": width, "height": height, "type": kind},
        "properties": {"topic": f"/{key}", "period": _PERIOD, **properties},
    }
