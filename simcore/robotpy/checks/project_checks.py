"""The robot project's folder: what it needs, and what earlier runs left in it."""

from __future__ import annotations

import ast
import json
import re
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from simcore.errors import SimcoreError
from simcore.robotpy.checks.findings import Finding, fail, ok, warn

__all__ = [
    "check_device_settings",
    "check_physics_file",
    "check_robot_file",
    "check_settings_file",
    "check_stored_values",
    "check_writable",
]

_DEVICE_FILE = re.compile(r"^(?P<model>.+?)(?: vers\. \w+)? - 0(?P<id>\d+) - ")
_RECENT = 12 * 3600.0  # [s]; younger settings are probably of this very session


def check_robot_file(folder: Path) -> Finding:
    """Whether this is a robot project."""
    if (folder / "robot.py").is_file():
        return ok("robot.py", "found")
    return warn(
        "robot.py", f"not in {str(folder.resolve())!r}", "go to the folder of your robot code before `robotpy sim`"
    )


def check_physics_file(folder: Path) -> Finding:
    """Whether a physics.py can be read and has what pyfrc loads; it is not run."""
    path = folder / "physics.py"
    if not path.exists():
        return ok("physics.py", "none, and none is needed with `robotpy sim --simcore`")
    try:
        tree = ast.parse(path.read_text(encoding="utf-8"), str(path))
    except SyntaxError as error:
        return fail("physics.py", f"line {error.lineno}: {error.msg}", "correct it; pyfrc would end the program")
    except (OSError, UnicodeDecodeError, ValueError) as error:
        return fail("physics.py", f"cannot be read: {error}", "save it as UTF-8, and look at its permissions")
    engine = [node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == "PhysicsEngine"]
    imported = [
        alias.asname or alias.name for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names
    ]
    if not engine and "PhysicsEngine" not in imported:
        return fail("physics.py", "has no class PhysicsEngine", "name the class so: pyfrc looks for it")
    return ok("physics.py", "has a PhysicsEngine")


def check_settings_file(folder: Path, read: Callable[[Path], object]) -> Finding:
    """Whether a simcore.toml can be read.

    Args:
        folder: Of the project.
        read: Reads and checks it.
    """
    path = folder / "simcore.toml"
    if not path.exists():
        return ok("simcore.toml", "none: defaults, and what the drivetrain's constants say")
    try:
        read(path)
    except (SimcoreError, ValueError) as error:  # a TOMLDecodeError is a ValueError
        return fail("simcore.toml", str(error), "correct that line")
    except OSError as error:
        return fail("simcore.toml", f"cannot be read: {error.strerror or error}", "look at its permissions")
    return ok("simcore.toml", "can be read")


def check_device_settings(folder: Path, now: float) -> Finding:
    """Whether Phoenix 6 will load settings of an earlier run.

    Args:
        folder: Where `robotpy sim` runs.
        now: Time of day [s since 1970].
    """
    files = sorted((folder / "ctre_sim").glob("*.dat"))
    if not files:
        return ok("ctre_sim", "no device settings of an earlier run")
    age = now - max(path.stat().st_mtime for path in files)
    devices: dict[str, list[int]] = {}
    for path in files:
        match = _DEVICE_FILE.match(path.name)
        devices.setdefault(match["model"] if match else path.stem, []).extend([int(match["id"])] if match else [])
    listed = ", ".join(f"{model} {' '.join(map(str, sorted(ids)))}".strip() for model, ids in sorted(devices.items()))
    text = f"settings of {len(files)} devices, {_ago(age)}: {listed}"
    if age < _RECENT:
        return ok("ctre_sim", text)
    return warn(
        "ctre_sim",
        text,
        "Phoenix loads them at the next start, so what your code no longer sets comes from the past: "
        f"delete the folder {str(folder / 'ctre_sim')!r}",
    )


def check_stored_values(folder: Path) -> Finding:
    """Whether NetworkTables will restore values of an earlier run."""
    path = folder / "networktables.json"
    try:
        stored = json.loads(path.read_text(encoding="utf-8") or "[]")
    except FileNotFoundError:
        return ok("stored values", "no networktables.json")
    except (OSError, ValueError) as error:
        return warn("stored values", f"networktables.json cannot be read: {error}", "delete it")
    names = (
        [str(entry.get("name", "")) for entry in stored if isinstance(entry, dict)] if isinstance(stored, list) else []
    )
    if not names:
        return ok("stored values", "networktables.json is empty")
    groups = Counter(name.lstrip("/").split("/")[0] for name in names)
    shown = ", ".join(f"{group} ({count})" for group, count in groups.most_common(4))
    return warn(
        "stored values",
        f"{len(names)} persistent values in networktables.json: {shown}",
        "they come back at the next start, Preferences and choosers among them: delete the file if a value seems old",
    )


def check_writable(folder: Path) -> Finding:
    """Whether logs and settings can be written here."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return warn(
            "folder",
            f"cannot write to {str(folder.resolve())!r}: {error.strerror or error}",
            "run in a folder of your own: logs, pictures and Phoenix's device settings go into the one where you start",
        )
    return ok("folder", "can be written")


def _ago(seconds: float) -> str:
    if seconds < 3600.0:
        return f"{max(0.0, seconds) / 60.0:.0f} minutes old"
    if seconds < 48 * 3600.0:
        return f"{seconds / 3600.0:.0f} hours old"
    return f"{seconds / 86400.0:.0f} days old"
