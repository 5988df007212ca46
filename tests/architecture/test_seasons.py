"""Which season is installed is asked in one module, and of Phoenix 6 in the emulator's table."""

import ast
import re
from pathlib import Path

import pytest
from each_case import each

from simcore import season

ROOT = Path(__file__).resolve().parents[2]
WHO_MAY = {"simcore/season.py", "simcore/robotcode/emulator/emulated_native.py"}
KNOWN = {"simcore/robotcode/sim/attach.py": {"pyfrc"}}
"""Modules that wrap pyfrc's own calls where it is installed."""
SEASONAL = {"pyfrc", "wpilib.testing", "telemetry", "tunables", "robotpy_fields"}
"""Packages of one season alone."""


def _code(path: Path) -> list[ast.AST]:
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("package", ["simcore", "games"])
def test_no_other_module_asks_for_the_season(package):
    found = []
    for path in sorted((ROOT / package).rglob("*.py")):
        name = str(path.relative_to(ROOT))
        if name in WHO_MAY:
            continue
        for node in _code(path):
            if isinstance(node, ast.Compare):
                numbers = {n.value for n in ast.walk(node) if isinstance(n, ast.Constant)}
                if numbers & {2026, 2027} and name.startswith("simcore"):
                    found.append(f"{name}:{node.lineno}: {ast.unparse(node)}")
            elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("find_spec", "season.is_installed"):
                asked = {n.value for n in node.args if isinstance(n, ast.Constant)}
                if (asked & SEASONAL) - KNOWN.get(name, set()):
                    found.append(f"{name}:{node.lineno}: {ast.unparse(node)}")
            elif isinstance(node, ast.Call) and ast.unparse(node.func) == "hasattr":
                owner = ast.unparse(node.args[0])
                if re.search(r"\b(wpilib|ntcore|hal|wpimath|DriverStation)\b", owner) and not owner.startswith("self."):
                    found.append(f"{name}:{node.lineno}: {ast.unparse(node)}")
    assert found == []


@each("module", sorted(season.NAMES))
def test_every_name_that_simcore_needs_is_there(module):
    """In the season that is installed, whichever it is."""
    loaded = pytest.importorskip(module) and getattr(season, module.replace(".", "_"))
    for owner, names in season.NAMES[module].items():
        for entry in names.split():
            assert hasattr(getattr(loaded, owner) if owner else loaded, entry.partition("=")[0]), (owner, entry)


@each(
    ("installed", "sentence"),
    [
        ([], ""),
        ([("wpilib", "2026.2.2"), ("pyntcore", "2026.2.2"), ("phoenix6", "26.3.0")], ""),
        ([("wpilib", "2027.0.0a7"), ("phoenix6", "26.70.0a2")], ""),
        ([("wpilib", "2027.0.0a7"), ("phoenix6", "26.3.0")], "phoenix6 26.3.0 next to WPILib of 2027"),
        ([("wpilib", "2026.2.2"), ("pyntcore", "2027.0.0a7")], "pyntcore 2027.0.0a7 next to WPILib of 2026"),
    ],
)
def test_two_seasons_are_one_sentence_and_none_or_one_are_none(installed, sentence):
    said = season.mixed_seasons(season.installed_seasons(installed))
    assert sentence in said and bool(said) == bool(sentence) and said.count("\n") == 0


BEFORE_2027 = {"navx", "photonvision"}
"""Packages of makers whose libraries keep their names or have no release of 2027."""
GONE_IN_2027 = {
    "simcore/robotcode/sim/built_ports.py": {"getInitializedForward", "getInitializedReverse"},
    "simcore/robotcode/sim/wpilib_ports.py": {
        *("getAngle", "setAngle", "setRate"),
        *("getYawAxis", "getPitchAxis", "getRollAxis", "getPort"),
    },
    "simcore/robotcode/sim/port_assignment.py": {"getForward", "getReverse"},
    "simcore/bridge/mirrored_ports.py": {  # refuses 2027 before its first call
        *("getAngle", "getRate", "setForward", "setReverse", "setSpeed", "setPosition"),
        *("getAllianceStationId", "getStickAxis", "getStickButtons", "getStickPOV", "getJoystickCounts"),
        *("refreshDSData", "getEventName", "getMatchNumber", "getMatchType", "getReplayNumber"),
    },
    "simcore/bridge/serve_command.py": {"startClient4", "setServer"},
}
"""Of relays, gyros and the driver station that the robot of 2027 has no more, or under other names."""


def test_names_of_2026_stand_in_one_module():
    """What WPILib has in camel case is asked for by its name of 2027: else it fails there, where few tests run."""
    named = set()
    for module in sorted({*season.NAMES, "wpilib.drive", "wpimath.kinematics", "wpimath.estimator"}):
        loaded = pytest.importorskip(module)
        for owner in (loaded, *(value for value in vars(loaded).values() if isinstance(value, type))):
            named |= {name for name in dir(owner) if re.match(r"[a-z]+\d*[A-Z]|k[A-Z]", name)}
    found = []
    for path in sorted((ROOT / "simcore").rglob("*.py")):
        name = str(path.relative_to(ROOT))
        if BEFORE_2027 & set(path.parts) or name in WHO_MAY:
            continue
        found += [
            f"{name}:{node.lineno}: {node.attr}"
            for node in _code(path)
            if isinstance(node, ast.Attribute) and node.attr in named - GONE_IN_2027.get(name, set())
        ]
    assert found == []
