"""The simulator's window: its map is open, and shows the pieces of a game in the size and color that they have.

WPILib's window draws every object of a `Field2d` as a red box of 0.69 x 0.82 m, unless its settings say otherwise. It
reads them from `simgui.json` in the folder where it starts, and the places of windows from `simgui-window.json`, and
writes both when it ends.
"""

from __future__ import annotations

import copy
import functools
import json
import logging
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore.errors import SimcoreError

if TYPE_CHECKING:  # pyfrc loads this module for every command, so no game before one is needed
    from simcore.match.game import Game
    from simcore.pieces.kinds import GamePieceConfig

__all__ = ["SETTINGS", "WINDOWS", "is_for_simcore", "prepare_map", "prepare_window"]

_log = logging.getLogger(__name__)

SETTINGS = "simgui.json"
WINDOWS = "simgui-window.json"

_MAP = "/SmartDashboard/Field"  # of pyfrc
_SHUT = {"window": {"visible": False}}
_FIRST_SETTINGS = {
    "HALProvider": {"Other Devices": _SHUT, "Timing": _SHUT},
    "NTProvider": {"types": {"/FMSInfo": "FMSInfo"}},
    "NetworkTables Info": {"visible": False},
    "NetworkTables View": {"visible": False},
}
"""Of a project whose window was never open: what would lie over the map is shut."""
_FIRST_WINDOWS = {
    "Window": {
        f"###{_MAP}": {"Collapsed": "0", "Pos": "298,22", "Size": "977,506"},
        "###FMS": {"Collapsed": "0", "Pos": "5,212", "Size": "283,140"},
        "###Joysticks": {"Collapsed": "0", "Pos": "298,533", "Size": "796,180"},
        "###System Joysticks": {"Collapsed": "0", "Pos": "5,440", "Size": "192,218"},
        "Robot State": {"Collapsed": "0", "Pos": "5,22", "Size": "99,116"},
    }
}
"""Places in the window of 1280 x 720 that opens at first [pixels]."""


def prepare_window(command: Any) -> None:
    """Let `robotpy sim` find the settings of its window, which pyfrc opens before it loads any extension.

    Args:
        command: pyfrc's, as it adds its flags.
    """
    run = command.run

    @functools.wraps(run)  # robotpy asks for the names of its arguments
    def run_prepared(options: Any, nogui: bool, **further: Any) -> Any:
        folder = further.get("project_path", Path.cwd())  # in 2027 it is not handed on
        if not nogui and is_for_simcore(folder, has_flag=options.simcore):
            from simcore.match.registry import installed_games

            try:
                prepare_map(Path.cwd(), installed_games().values())
            except SimcoreError as error:  # said again, and better, when the match is built
                _log.debug("the window is not prepared: %s", error)
        return run(options=options, nogui=nogui, **further)

    command.run = run_prepared


def is_for_simcore(project: Path, *, has_flag: bool) -> bool:
    """Whether `robotpy sim` puts the robot of this project on a field: by `--simcore` or by its own physics.py."""
    if has_flag:
        return True
    try:
        return "simcore" in (project / "physics.py").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False


def prepare_map(folder: Path, games: Iterable[Game]) -> bool:
    """Add to the window's settings how its map draws the pieces of these games, and that it is open.

    What is there stays as it is. A file that cannot be read or written is left alone: the run goes on, with boxes.

    Args:
        folder: Where the window starts.
        games: Whose pieces.

    Returns:
        Whether the file was written.
    """
    path = folder / SETTINGS
    try:
        is_first = not path.exists()
        settings = copy.deepcopy(_FIRST_SETTINGS) if is_first else json.loads(path.read_text(encoding="utf-8"))
        provider = _part(settings, "NTProvider")
        kinds = _part(provider, "types")
        window = _part(_part(provider, "windows"), _MAP)
        missing = {
            kind.name: _drawn(kind)
            for game in games
            for kind in (supply.kind for supply in game.pieces)
            if kind.name not in window
        }
        if not missing:
            return False
        kinds.setdefault(_MAP, "Field2d")
        window.update(missing)
        window.setdefault("window", {"visible": True})
        path.write_text(json.dumps(settings, indent=2) + "\n", encoding="utf-8")
        places = folder / WINDOWS
        if is_first and not places.exists():
            places.write_text(json.dumps(_FIRST_WINDOWS, indent=2) + "\n", encoding="utf-8")
    except (OSError, ValueError, TypeError) as error:
        _log.warning("%s is left as it is, so the map shows pieces as large boxes: %s", path, error)
        return False
    _log.info("wrote into %s how the map draws %s", path, ", ".join(missing))
    return True


def _part(settings: Mapping[str, Any], name: str) -> dict[str, Any]:
    """An object within an object of the settings; made if it is not there."""
    if not isinstance(settings, dict) or not isinstance(found := settings.setdefault(name, {}), dict):
        raise TypeError(f"{name!r} of its settings is not an object")
    return found


def _drawn(kind: GamePieceConfig) -> dict[str, Any]:
    from simcore.physics.shapes import bounding_box

    low, high = bounding_box(kind.shape)
    length, width, _ = (0.8 * (high - low)).tolist()  # the line around it is drawn outside
    red, green, blue = (int(kind.color[place : place + 2], 16) / 255.0 for place in (1, 3, 5))
    return {
        "arrows": False,
        "color": [red, green, blue, 1.0],
        "length": length,
        "selectable": False,
        "style": "Box/Image",
        "weight": 3.0,
        "width": width,
    }
