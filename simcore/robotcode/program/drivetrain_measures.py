"""Drivetrain measures from all sources: simcore.toml, robot code, PathPlanner, Choreo, and guesses."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from simcore.robot.cots import MODULES
from simcore.robot.dc_motor import motor
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robot_file.template import FILE_NAME
from simcore.robotcode.program.found_drivetrain import FoundDrivetrain, Measure
from simcore.robotcode.program.project_settings import project_measures
from simcore.units import inches

__all__ = ["MODULE_MEASURES", "complete_measures", "in_meters"]

MODULE_MEASURES = (
    *("drive_gearing", "steer_gearing", "wheel_radius", "wheel_cof", "coupling_ratio"),
    *("drive_stator_limit", "drive_supply_limit", "steer_stator_limit", "steer_supply_limit"),
)
"""Names of the measures that are fields of `SwerveModuleConfig`."""
_SANE = {
    "wheel_radius": (0.02, 0.2),
    "drive_gearing": (1.0, 40.0),
    "steer_gearing": (4.0, 150.0),
    "trackwidth": (0.2, 1.5),
    "mass": (5.0, 100.0),
    "yaw_inertia": (0.1, 50.0),
    "wheel_cof": (0.3, 3.0),
    "drive_stator_limit": (5.0, 1000.0),
    "drive_supply_limit": (5.0, 1000.0),
    "steer_stator_limit": (5.0, 1000.0),
    "steer_supply_limit": (5.0, 1000.0),
}
"""Plausible range of each measure [m, -, kg, kg m^2, A]; `complete_measures` reports and ignores other values."""
_FAR = 1.5  # [m], largest plausible distance of a wheel from the center
_SAME = 0.02  # largest relative difference between two values that count as equal
_WEAK = 3.0  # [V], minimum plausible feedforward at free speed; a gain in fractions of full output gives 1
_MAXSWERVE = MODULES["REV MAXSwerve"]
_IS_MAXSWERVE = f"{_MAXSWERVE.name} has this ratio"
_GUESSES: dict[str, dict[str, float]] = {
    "swerve": {"wheel_radius": inches(2.0), "drive_gearing": 6.75, "steer_gearing": 150.0 / 7.0},
    "tank": {"wheel_radius": inches(3.0), "drive_gearing": 8.45, "trackwidth": 0.56},
    "mecanum": {"wheel_radius": inches(3.0), "drive_gearing": 8.45},
}
"""Guesses for measures without a source, by kind of drive: SDS MK4i L2 for swerve, FIRST's kit bot otherwise."""
_FOREIGN = {"swerve": {"trackwidth"}, "mecanum": {"trackwidth"}, "tank": {"places"}}
"""Measures to ignore for each kind of drive, because PathPlanner and Choreo store these for every robot."""
_GEARINGS = (3.0, 24.0)
_SPEEDS = (1.0, 8.0)  # [m/s], plausible top speeds of robots, up to the fastest gearing on sale
_UNITS = {"inches": inches(1.0), "centimeters": 0.01, "millimeters": 0.001}
"""Size of each unit [m] that a tank or mecanum drive in robot code may use for distance instead of meters."""


def complete_measures(found: FoundDrivetrain, settings: RobotSettings, folder: Path) -> FoundDrivetrain:
    """Return the drivetrain with every measure that the model needs, and with contradictions in `differences`.

    Args:
        found: Drivetrain as found in the program.
        settings: Settings of simcore.toml, which override every other source.
        folder: Folder of robot.py.
    """
    projects = [
        {name: m for name, m in project.items() if name not in _FOREIGN[found.kind]}
        for project in project_measures(folder)
    ]
    known: dict[str, Measure] = _of_file(settings)
    differences: list[str] = []
    found = _placed(found, projects, differences)
    for source in (dict(found.measures), *projects):
        for name, measure in source.items():
            low, high = _SANE.get(name, (-math.inf, math.inf))
            if name in _SANE and not low <= measure.value <= high:
                differences.append(f"{name} is {measure}, outside the plausible range ({low:g} to {high:g}): ignored")
                continue
            before = known.get(name)
            if before is None or (before.is_guess and not measure.is_guess):
                known[name] = measure
            elif not measure.is_guess and _differ(before.value, measure.value):
                differences.append(f"{name} is {before} but {measure}")
    differences += [
        f"{volts.source} has a velocity feedforward that gives {volts.value:.2g} V at the motor's free speed, where 12 "
        "V are needed: it is in volts, not a fraction of full output"
        for volts in found.free_speed_volts
        if volts.value < _WEAK
    ]
    differences += _places_differ(found, projects)
    _fill_wheel(known, found, [m for project in projects for m in project.values()], differences)
    if known.get("wheel_radius", Measure(0, "")).source == _IS_MAXSWERVE:
        known.setdefault("steer_gearing", Measure(_MAXSWERVE.steer_gearing, _IS_MAXSWERVE, is_guess=True))
        if known["steer_motor"].is_guess:
            known["steer_motor"] = Measure("NEO 550", _IS_MAXSWERVE, is_guess=True)
    for name, value in _GUESSES[found.kind].items():
        known.setdefault(name, Measure(value, "a common value", is_guess=True))
    _judge_speed(known, differences)
    if found.kind != "swerve":
        says = "a program does not say which way its motors drive"
        turned = known.setdefault("reversed", Measure(False, says, is_guess=True))
        if turned.value:
            wheels = tuple(replace(wheel, drive_sign=-wheel.drive_sign) for wheel in found.wheels)
            found = replace(found, wheels=wheels)
    return replace(found, measures=known, differences=(*found.differences, *differences))


def _placed(
    found: FoundDrivetrain, projects: Sequence[Mapping[str, Measure]], differences: list[str]
) -> FoundDrivetrain:
    """Return the drivetrain with wheel positions from PathPlanner or Choreo if the program gives no positions."""
    guess = found.measures.get("x and y")
    if guess is None or found.kinematics:
        return found
    count = len(found.wheels)
    places = next((p["places"] for p in projects if "places" in p and len(p["places"].value) == count), None)
    if places is None:
        if found.kind == "swerve":
            xs, ys = ([place[axis] for place in found.places] for axis in (0, 1))
            names = ", ".join(wheel.name for wheel in found.wheels)
            differences.append(
                f"{guess.source}: they are assumed to be 0.56 m apart, in this order: {names}; if that is wrong, "
                f"correct x = {xs} and y = {ys} under [drivetrain] in {FILE_NAME}"
            )
        return found
    wheels = tuple(replace(w, place=place) for w, place in zip(found.wheels, places.value, strict=True))
    measures = {**found.measures, "x and y": Measure("those of its modules", places.source)}
    return replace(found, wheels=wheels, measures=measures)


def in_meters(found: FoundDrivetrain) -> FoundDrivetrain:
    """Return the drivetrain with positions and trackwidth in meters.

    Positions beyond 1.5 count as inches, and positions beyond 60 as millimeters.
    """
    far = max(abs(v) for place in found.places for v in place)
    if far <= _FAR:
        return found
    unit, size = ("millimeters", 1e-3) if far > 60.0 else ("inches", inches(1.0))
    wheels = tuple(replace(w, place=(w.place[0] * size, w.place[1] * size)) for w in found.wheels)
    measures = dict(found.measures)
    if "trackwidth" in measures:
        width = measures["trackwidth"]
        measures["trackwidth"] = Measure(width.value * size, f"{width.source}, as {unit}", width.is_guess)
    sentence = (
        f"the program's kinematics have a wheel {far:.4g} m from the robot's center: taken as {unit}, {far * size:.3g} "
        "m; WPILib needs meters, and until then its wheel speeds are wrong while it turns"
    )
    return replace(found, wheels=wheels, measures=measures, differences=(*found.differences, sentence))


def _of_file(settings: RobotSettings) -> dict[str, Measure]:
    """Return the drivetrain measures that simcore.toml gives, by name; lengths in meters."""
    said: dict[str, Any] = dict(settings.drivetrain.measures)
    if "wheel_diameter" in said:
        said["wheel_radius"] = 0.5 * said.pop("wheel_diameter")
    for name, value in (("drive_motor", settings.drive_motor), ("steer_motor", settings.steer_motor)):
        if value is not None:
            said.setdefault(name, value)
    if "mass" in settings.given:
        said["mass"] = settings.mass
    if "tread" in settings.given:
        said["wheel_cof"] = settings.wheel_cof
    return {name: Measure(value, FILE_NAME) for name, value in said.items()}


def _fill_wheel(
    known: dict[str, Measure], found: FoundDrivetrain, of_projects: Sequence[Measure], differences: list[str]
) -> None:
    """Choose wheel radius and gearing to match the distance per rotor turn in the program.

    Teams measure the distance in robot code on the robot, while settings of PathPlanner and Choreo often date from an
    older robot, so the program's value overrides these settings. A distance that is far too large, and whose
    inverse is a plausible gearing, counts as wheel turns per rotor turn, the usual position unit of Phoenix 6
    controllers. The function adds contradictions to `differences`.
    """
    way, radius, gearing = (known.get(name) for name in ("meters_per_rotor_turn", "wheel_radius", "drive_gearing"))
    if way is None:
        return
    speed = motor(known["drive_motor"].value).free_speed / math.tau * way.value
    counts_wheels = speed > _SPEEDS[1] and _GEARINGS[0] <= 1.0 / way.value <= _GEARINGS[1]
    is_sane = _SPEEDS[0] <= speed <= _SPEEDS[1]
    if not (is_sane or counts_wheels or found.kind == "swerve"):
        for unit, size in _UNITS.items():
            if _SPEEDS[0] <= speed * size <= _SPEEDS[1]:
                way, is_sane = Measure(way.value * size, f"{way.source}, in {unit}", is_guess=True), True
                break
    if not is_sane and (found.kind == "swerve" or not counts_wheels):
        differences.append(
            f"a turn of a drive motor is {way.value:.4g} m by {way.source}, which is {speed:.3g} m/s at its free "
            f"speed, but robots drive {_SPEEDS[0]:g} to {_SPEEDS[1]:g}: is that in meters, with the wheel's "
            "circumference and the gearing?"
        )
    if counts_wheels and (radius is None or gearing is None):
        known.setdefault(
            "drive_gearing", Measure(1.0 / way.value, f"{way.source}, in turns of the wheel", is_guess=True)
        )
        return
    if radius is not None and gearing is not None:
        by_measures = math.tau * radius.value / gearing.value
        if not _differ(by_measures, way.value):
            return
        said = (
            f"a turn of a drive motor is {by_measures:.4f} m by wheel_radius {radius} and drive_gearing {gearing}, "
            f"but {way.value:.4f} m by {way.source}"
        )
        if is_sane and any(gearing is m for m in of_projects):
            gearing = None
        elif is_sane and any(radius is m for m in of_projects):
            radius = None
        else:
            differences.append(f"{said}: odometry will be off by that much")
            return
        differences.append(f"{said}: simcore uses the program's value")
    if gearing is not None:
        known["wheel_radius"] = Measure(way.value * gearing.value / math.tau, f"{way.source} and the gearing")
        return
    if radius is None:
        radius = known["wheel_radius"] = _likely_radius(way.value, found)
    known["drive_gearing"] = Measure(
        math.tau * radius.value / way.value,
        f"{way.source} and the wheel",
        is_guess=radius.is_guess,
    )


def _judge_speed(known: Mapping[str, Measure], differences: list[str]) -> None:
    """Report an implausible top speed of the robot in `differences`, unless the distance per rotor turn is known."""
    radius, gearing = known["wheel_radius"], known["drive_gearing"]
    speed = motor(known["drive_motor"].value).free_speed / gearing.value * radius.value
    is_known = known.get("meters_per_rotor_turn") is not None
    if not (_SPEEDS[0] <= speed <= _SPEEDS[1] or is_known):
        differences.append(
            f"it would drive {speed:.3g} m/s at its motors' free speed, but robots drive {_SPEEDS[0]:g} to "
            f"{_SPEEDS[1]:g}: wheel_radius is {radius}, drive_gearing {gearing}"
        )


def _likely_radius(way: float, found: FoundDrivetrain) -> Measure:
    """Guess a common wheel radius [m] that gives a MAXSwerve gearing, or else a plausible gearing.

    Args:
        way: Distance per rotor turn in robot code [m].
        found: Drivetrain as found in the program.
    """
    first = found.wheels[0]
    if first.is_wired:
        gearing = math.tau * _MAXSWERVE.wheel_radius / way
        if any(abs(gearing / g - 1.0) < _SAME for g in _MAXSWERVE.drive_gearings):
            return Measure(_MAXSWERVE.wheel_radius, _IS_MAXSWERVE, is_guess=True)
    usual = _GUESSES[found.kind]["wheel_radius"]
    for radius in (usual, inches(2.0), inches(1.5), inches(3.0)):
        if _GEARINGS[0] <= math.tau * radius / way <= _GEARINGS[1]:
            return Measure(radius, "a common value", is_guess=True)
    return Measure(usual, "a common value", is_guess=True)


def _differ(one: Any, other: Any) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        # FOC is a licensed control mode, not a different motor
        return str(one).removesuffix(" FOC") != str(other).removesuffix(" FOC")
    if isinstance(one, (tuple, list)) or isinstance(other, (tuple, list)):
        return False
    return not math.isclose(float(one), float(other), rel_tol=_SAME)


def _places_differ(found: FoundDrivetrain, projects: Sequence[Mapping[str, Measure]]) -> list[str]:
    if found.kind != "swerve" or "x and y" in found.measures:
        return []
    for project in projects:
        places = project.get("places")
        if places is None or len(places.value) != len(found.places):
            continue
        far = max(min(math.dist(a, b) for b in found.places) for a in places.value)
        if far > _SAME:
            return [f"module positions in {places.source} differ by up to {far:.3f} m from those in the program"]
    return []
