"""One module decides which season is installed, and the emulator's table does so for Phoenix 6."""

import ast
import re
from pathlib import Path

import pytest
from each_case import each

from simcore import season

ROOT = Path(__file__).resolve().parents[2]
WHO_MAY = {"simcore/season.py", "simcore/robotcode/emulator/emulated_native.py"}
KNOWN = {"simcore/robotcode/sim/attach.py": {"pyfrc"}}
"""Modules that may check whether a package of one season is installed, with the names of the packages."""
SEASONAL = {"pyfrc", "wpilib.testing", "telemetry", "tunables", "robotpy_fields"}
"""Packages of one season only."""


def _code(path: Path) -> list[ast.AST]:
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("package", ["simcore", "games"])
def test_only_the_season_module_and_the_emulator_check_the_season(package):
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
def test_every_library_name_that_simcore_needs_exists(module):
    """The test checks the names of the installed season."""
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
def test_mixed_seasons_are_reported_in_one_sentence(installed, sentence):
    said = season.mixed_seasons(season.installed_seasons(installed))
    assert sentence in said and bool(said) == bool(sentence) and said.count("\n") == 0


BEFORE_2027 = {"navx", "photonvision"}
"""Packages of makers whose libraries keep their names or have no 2027 release."""
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
"""Names of relays, gyros and the driver station that 2027 has removed or renamed."""


def test_names_specific_to_2026_are_in_one_module():
    """Other modules use WPILib's names of 2027; a camel-case name would fail in 2027, where few tests run."""
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
