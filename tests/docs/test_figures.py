"""The pages state the figures of the code; each expected phrase is built from a value in the code."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
from pathlib import Path

import pytest

from games.rebuilt import REBUILT
from games.rebuilt.fuel import FUEL
from games.reefscape import REEFSCAPE
from games.reefscape import rules as reef_rules
from simcore import Scatter, WpilogSink
from simcore.loop import balls
from simcore.match import starts
from simcore.match.players.player import SKILLS
from simcore.pieces import kinds, piece_manager
from simcore.robot.battery import BatteryConfig
from simcore.robot.chassis_config import BUMPER_STIFFNESS
from simcore.robot.dc_motor import controller_limits, motor
from simcore.robot.shooter import ShooterConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import GRAVITY
from simcore.vision.tag_layout import official_layout
from simcore.world.contact_law import CARPET, POLYCARBONATE, RUBBER, WALL

ROOT = Path(__file__).resolve().parents[2]


def text(page: str) -> str:
    """Return the text of a page with single spaces."""
    return " ".join((ROOT / page).read_text(encoding="utf-8").split())


def says(page: str, *phrases: str) -> None:
    missing = [phrase for phrase in phrases if phrase not in text(page)]
    assert missing == [], page


def test_the_docs_state_the_default_parameters_of_battery_motors_tires_and_chassis():
    battery = BatteryConfig()
    levels = f"Below {battery.brownout_voltage} V"
    says(
        "docs/connect.md", f"{levels} the roboRIO switches all motors off until {battery.recovered_voltage} V are back"
    )
    says(
        "docs/physics.md",
        f"{levels} the roboRIO wants all outputs off",
        f"until {battery.recovered_voltage} V are back",
        f"Below {battery.reset_voltage} V for {1e3 * battery.reset_hold:g} ms the roboRIO resets",
        f"| battery {battery.full_voltage} V, {1e3 * battery.resistance:g} mohm |",
        f"charge, {1e3 * battery.resistance:g} mohm",
    )
    kraken, neo = controller_limits(motor("Kraken X60")), controller_limits(motor("NEO"))
    says("docs/physics.md", f"{kraken[0]:g} A stator and {kraken[1]:g} A supply", f"{neo[0]:g} A stator (SPARK)")
    module = SwerveModuleConfig(x=0.0, y=0.0)
    says("docs/physics.md", f"s0 = {module.slip_ratio:g} x rolling speed + {1e3 * module.slip_speed:g} mm/s")
    says("docs/physics.md", f"{BUMPER_STIFFNESS / 1e6:g} MN/m for each meter of side")
    mass = SwerveConfig.square(0.53, module).mass
    says("docs/troubleshooting.md", f"Mass counts too: {mass:g} kg, unless you say otherwise")


def test_the_pages_state_the_simulated_figures_of_pieces():
    says("docs/physics.md", f"slower than {balls._QUIET_SPEED} m/s for {piece_manager._SLEEPY} s")
    says("docs/physics.md", f"with up to {kinds._MOST_PARTS} parts", f"thinner than {1e3 * kinds._THINNEST:g} mm")
    says(
        "docs/physics.md",
        f"bounce of fuel {FUEL.restitution:g}",
        f"drag coefficient {FUEL.aerodynamics.drag_coefficient:g}",
    )
    says("docs/robot.md", "wheels turn five times a second")
    assert default(ShooterConfig, "min_wheel_speed") == pytest.approx(5 * math.tau)
    for surface in (CARPET, WALL, RUBBER, POLYCARBONATE):
        friction, bounce = surface.friction * FUEL.friction, surface.restitution * FUEL.restitution
        row = f"| `{surface.name}` | {surface.friction:.1f} | {surface.restitution:.2f} | {surface.rolling:g} |"
        says("docs/physics.md", f"{row} {friction:.2f} / {bounce:.2f}")
    slows = CARPET.rolling * FUEL.friction * GRAVITY / (1.4 * FUEL.rest_height)
    says("docs/physics.md", f"slows by {slows:.2f} m/s²")


def default(config: type, name: str) -> float:
    """Return the default of a config field."""
    (value,) = (field.default for field in dataclasses.fields(config) if field.name == name)
    return value


def test_the_pages_state_the_defaults_of_robot_tests_and_the_tolerances_of_autos():
    says("docs/autos.md", f"more than {starts._APART[0]} m or {math.degrees(starts._APART[1]):g} degrees apart")
    pytest.importorskip("wpilib")
    from simcore.robotcode.sim import auto_start, pytest_plugin
    from simcore.robotcode.sim.robot_test import RobotTest

    says("docs/troubleshooting.md", f"With simcore's field it has {pytest_plugin.INIT_TIMEOUT:g} s")
    assert auto_start._WINDOW == 0.5
    near, turned = auto_start._SEEN
    says("docs/autos.md", "the first half second", f"within {near} m and {math.degrees(turned):g} degrees of the truth")
    for name in ("autonomous", "teleop", "disable"):
        seconds = inspect.signature(getattr(RobotTest, name)).parameters["seconds"].default
        assert re.search(rf"`sim\.{name}\([^)]*seconds={seconds:g}[,)]", text("docs/testing.md")), name
    plugin = (ROOT / "simcore/robotcode/sim/pytest_plugin.py").read_text(encoding="utf-8")
    for name, seconds in re.findall(r'addini\("(simcore_\w+)", .*default="(\d+)"\)', plugin):
        says("docs/testing.md", f"`{name} = {seconds}`")


def test_the_telemetry_page_states_the_period_of_long_arrays_in_logs():
    period = inspect.signature(WpilogSink).parameters["bulk_period"].default
    says("docs/telemetry.md", f"long arrays (over 64 poses) every {period:g} s")


def test_the_whole_match_page_states_the_skills_of_players():
    for level, skill in enumerate(SKILLS, start=1):
        cells = (
            *(f"{level}", f"{skill.speed}", f"{skill.collecting_speed}", f"{math.degrees(skill.aim):.1f} deg"),
            *(f"{skill.shot_speed:.0%}".replace("%", " %"), f"{skill.load}", f"{skill.shot_rate}"),
            *(f"{skill.reaction}", f"{skill.foresight:g}"),
        )
        says("docs/whole_match.md", f"| {' | '.join(cells)} |")


UNITS = {
    "°": 180.0 / math.pi,
    "°/s": 180.0 / math.pi,
    "ms": 1e3,
    "mm": 1e3,
    "%": 100.0,
}


def test_the_scatter_page_states_every_spread_and_its_default():
    rows = re.findall(
        r"^\| `(\w+)` \| (?:±|0-)?([\d.]+) ?([^ ,|]+)", (ROOT / "docs/scatter.md").read_text("utf-8"), re.M
    )
    told = {name: float(number) / UNITS[unit] for name, number, unit in rows}
    spreads = {field.name: getattr(Scatter(), field.name) for field in dataclasses.fields(Scatter)}
    assert told == {name: pytest.approx(value) for name, value in spreads.items()}


def test_the_reefscape_page_states_the_counts_sizes_and_points_of_the_game():
    page = "docs/reefscape.md"
    coral, algae = (supply.kind for supply in REEFSCAPE.pieces)
    counts = [supply.count for supply in REEFSCAPE.pieces]
    says(page, f"all {counts[0]} coral and {counts[1]} algae", f"{coral.mass} kg; algae as a ball of {algae.mass} kg")
    length, width = REEFSCAPE.field.size
    says(page, f"{length:.3f} x {width:.3f} m")
    auto, teleop = reef_rules._AUTO_CORAL, reef_rules._TELEOP_CORAL
    says(
        page,
        f"| {', '.join(str(auto[level]) for level in (1, 2, 3, 4))} |",
        f"| {', '.join(str(teleop[level]) for level in (1, 2, 3, 4))} |",
        f"at the end of auto | {reef_rules._LEAVE_POINTS} |",
        f"| 6, {reef_rules._NET_POINTS} |",
        f"to 3 s after it | {reef_rules._END_POINTS['Parked']} |",
        f"| {reef_rules._END_POINTS['ShallowCage']}, {reef_rules._END_POINTS['DeepCage']} |",
    )
    cage = REEFSCAPE.field.hanging[0]
    says(page, f"swing: {cage.mass:g} kg (an estimate)")
    narrower = official_layout("2025-welded").field_size[1] - official_layout("2025-andymark").field_size[1]
    says(page, f"AndyMark's, is {1e3 * narrower:.0f} mm narrower")


def test_ci_installs_the_packages_that_the_install_page_names_for_2027():
    """The workflow installs the packages named on the page from the 2027 releases."""
    section = (ROOT / "docs/install.md").read_text(encoding="utf-8").partition("## Move to 2027")[2]
    workflow = (ROOT / ".github/workflows/test.yml").read_text(encoding="utf-8").partition("  season_2027:")[2]
    named, tested = (set(re.findall(r'"([\w-]+>=[^"]+)"', text)) for text in (section, workflow))
    assert "wpilib>=2027.0.0a7,<2028" in named and named <= tested


def test_the_table_of_engines_agrees_with_the_dependencies():
    """The markers of the package's dependencies select the engine."""
    from packaging.markers import Marker

    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8").partition("dependencies = [")[2].partition("\n]")[0]
    rows = re.findall(r'"(pybullet-arm64|mujoco-core|mujoco)[^;"]*;\s*([^"]+)"', project)
    assert rows
    table = re.findall(
        r"^\| ([^|`\n]+) \| (\w+) \| (\w+) \| (\w+) \| (\w+) \|$", (ROOT / "docs/install.md").read_text(), re.M
    )
    systems = {
        "Windows x64, Linux x86-64, Mac with Apple silicon": (
            ("Windows", "AMD64"), ("Linux", "x86_64"), ("Darwin", "arm64"),
        ),
        "Mac with an Intel processor": (("Darwin", "x86_64"),),
        "Linux ARM (aarch64)": (("Linux", "aarch64"),),
        "Windows ARM, 32-bit": (("Windows", "ARM64"),),
    }  # fmt: skip
    assert {row[0] for row in table} == set(systems)
    for name, *told in table:
        for version, engine in zip(("3.10", "3.11", "3.13", "3.14"), told, strict=True):
            for system, machine in systems[name]:
                environment = {
                    "platform_system": system,
                    "platform_machine": machine,
                    "python_version": version,
                    "python_full_version": f"{version}.0",
                    "extra": "",
                }
                got = {package for package, marker in rows if Marker(marker).evaluate(environment)}
                wanted = {"PyBullet": {"pybullet-arm64"}, "none": set()}.get(engine)
                assert got == wanted if wanted is not None else got and "pybullet-arm64" not in got, (name, version)


def test_the_default_game_is_the_newest():
    says("docs/telemetry.md", "Of REBUILT")
    assert max((REBUILT, REEFSCAPE), key=lambda game: game.year) is REBUILT
