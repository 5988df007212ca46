"""Discovery of tank and mecanum drives: the side of each motor, from WPILib's drive classes or attribute names."""

from __future__ import annotations

import functools
import re
import types
from collections.abc import Mapping, Sequence
from typing import Any

from simcore.robotcode.program.found_drivetrain import DrivetrainNotFoundError, FoundDrivetrain, FoundWheel, Measure
from simcore.robotcode.program.makers import device_of, maker_of, makers
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.object_graph import ObjectGraph
from simcore.robotcode.program.place_names import CORNERS, SIDES, says_place, words_of
from simcore.robotcode.program.recorder import Built, built
from simcore.robotcode.program.swerve_discovery import free_speed_volts, motor_measures

__all__ = ["find_mecanum", "find_tank", "wired_encoder", "with_followers"]

_DRIVE = re.compile(r"drive|chassis|tank", re.IGNORECASE)
_PLAIN = re.compile(
    rf"(({SIDES['left']}|{SIDES['right']}|front|back|rear|lead(er)?|follow(er)?|motor|talon|victor|spark|wheel|\d+)"
    "s? ?)+"
)
_PULSES = 2048.0  # pulses per turn that simcore assumes for an encoder on the roboRIO's ports


def find_tank(graph: ObjectGraph) -> FoundDrivetrain | None:
    """Find a tank drive from a `DifferentialDrive`, else from `left`, `right`, `l` or `r` in motor names.

    Without a WPILib tank drive object, the names must also suggest drive motors.

    Returns:
        Drivetrain, or None if the program has no tank drive.

    Raises:
        DrivetrainNotFoundError: The program has a WPILib tank drive object, but the motors of a side are unknown.
    """
    drives, kinematics, odometry = (
        graph.built(kind, "DifferentialDrive") for kind in ("drive", "kinematics", "odometry")
    )
    names = _named_motors(graph)
    if not (drives or kinematics or odometry):
        if any(graph.built(kind, "") for kind in ("drive", "kinematics")):
            return None  # a drivetrain of another kind
        names = {name: motor for name, motor in names.items() if _drives(name)}
    sides = _given(drives[-1], ("leftMotor", "rightMotor")) if drives else None
    if sides is None:
        sides = _by_name(names, tuple(SIDES))
    if sides is None and not (drives or kinematics or odometry):
        return None
    if sides is None:
        owner = (*drives, *kinematics, *odometry)[0].name
        raise DrivetrainNotFoundError(
            f"it has a {owner}, but which of its motors are left and which are right is not known: their names do not "
            f"say so ({', '.join(sorted(filter(None, names))) or 'it has none'}); name them as left and right under "
            "[drivetrain]"
        )
    width = float(kinematics[0].made.trackwidth) if kinematics else None
    half = 0.28 if width is None else 0.5 * width
    wheels = _wheels(graph, ("left", "right"), ((0.0, half), (0.0, -half)), sides)
    measures = {**motor_measures("drive", wheels[0].motors[0]), **_way(wheels[0])}
    if width is not None:
        measures["trackwidth"] = Measure(width, "the program's kinematics")
    about = "DifferentialDrive" if drives else "names of motors"
    return FoundDrivetrain(
        kind="tank",
        wheels=wheels,
        measures=measures,
        free_speed_volts=free_speed_volts(wheels[0]),
        about=f"sides of {about}",
    )


def find_mecanum(graph: ObjectGraph) -> FoundDrivetrain | None:
    """Find a mecanum drive from a `MecanumDrive`, else from mecanum kinematics and corners in motor names.

    Returns:
        Drivetrain, or None if the program has no mecanum drive.

    Raises:
        DrivetrainNotFoundError: The program has a WPILib mecanum drive object, but the motors of a corner are unknown.
    """
    drives, kinematics = graph.built("drive", "MecanumDrive"), graph.built("kinematics", "MecanumDrive")
    if not (drives or kinematics):
        return None
    order = ("frontLeftMotor", "rearLeftMotor", "frontRightMotor", "rearRightMotor")
    given = _given(drives[-1], order) if drives else None
    if given is not None:
        given = [given[0], given[2], given[1], given[3]]
    else:
        given = _by_name(_named_motors(graph), CORNERS)
    if given is None:
        raise DrivetrainNotFoundError("it is not known which motors of its mecanum drive are at which corner")
    places = [(0.28, 0.28), (0.28, -0.28), (-0.28, 0.28), (-0.28, -0.28)]
    if kinematics:
        made = kinematics[0].made
        corners = (made.get_front_left(), made.get_front_right(), made.get_rear_left(), made.get_rear_right())
        places = [(float(t.x), float(t.y)) for t in corners]
    wheels = _wheels(graph, CORNERS, places, given)
    measures = {**motor_measures("drive", wheels[0].motors[0]), **_way(wheels[0])}
    if not kinematics:
        measures["x and y"] = Measure("0.56 x 0.56 m", "a common value", is_guess=True)
    return FoundDrivetrain(
        kind="mecanum",
        wheels=wheels,
        measures=measures,
        free_speed_volts=free_speed_volts(wheels[0]),
        about="corners of MecanumDrive",
        kinematics=kinematics[0].name if kinematics else "",
    )


def _wheels(
    graph: ObjectGraph,
    names: Sequence[str],
    places: Sequence[tuple[float, float]],
    leaders: Sequence[Sequence[BuiltDevice]],
) -> tuple[FoundWheel, ...]:
    """Return the wheel or side at each position, with leaders, followers, drive sign and encoder."""
    encoders = _encoders(graph, names, leaders)
    return tuple(
        FoundWheel(
            name=name,
            place=place,
            motors=with_followers(motors),
            drive_sign=_drive_sign(motors[0]),
            wheel_encoder=encoder,
            meters_per_encoder_turn=_meters_per_turn(encoder),
        )
        for name, place, motors, encoder in zip(names, places, leaders, encoders, strict=True)
    )


# --- motors -----------------------------------------------------------------------------------------------------------


def _given(record: Built, names: Sequence[str]) -> list[list[BuiltDevice]] | None:
    """Return the motors passed to a drive class as objects, groups or bound methods; None if a motor is unknown."""
    found = [_motors_of(record.argument(k, name)) for k, name in enumerate(names)]
    return found if all(found) else None


def _motors_of(given: Any, deep: int = 4) -> list[BuiltDevice]:
    """Return the motors reachable from an object or function within `deep` steps."""
    device = device_of(given)
    if device is not None:
        return [device] if device.model in maker_of(device).motors else []
    if deep == 0 or isinstance(given, (type, types.ModuleType)):
        return []
    return list({m.key: m for part in _parts_of(given) for m in _motors_of(part, deep - 1)}.values())


def _parts_of(given: Any) -> list[Any]:
    """Return the members of an object, or the objects named in the body of a function or method."""
    function, owner = getattr(given, "__func__", given), getattr(given, "__self__", None)
    if isinstance(given, functools.partial):
        return [given.func, *given.args]
    if not isinstance(function, types.FunctionType):
        return [owner] if owner is not None else [*getattr(given, "__dict__", {}).values(), *_members_of(given)]
    names = function.__code__.co_names
    around = [owner, *(cell.cell_contents for cell in function.__closure__ or ()), *(function.__defaults__ or ())]
    around += [function.__globals__[name] for name in names if name in function.__globals__]
    parts = []
    for made in around:
        if device_of(made) is not None or not hasattr(made, "__dict__") or isinstance(made, types.FunctionType):
            parts.append(made)
        elif not isinstance(made, types.ModuleType):
            parts += [vars(made)[name] for name in names if name in vars(made)]
            methods = [getattr(type(made), name, None) for name in names]
            parts += [method.__get__(made) for method in methods if isinstance(method, types.FunctionType)]
    return parts


def _members_of(given: Any) -> Sequence[Any]:
    """Return the motor controllers in a `MotorControllerGroup`; empty for any other object."""
    return next((r.args for r in built("group") if r.made is given), ())


def _drive_sign(motor: BuiltDevice) -> float:
    """Return -1 if inverted motor controller groups reverse a motor, else 1."""
    groups = [r.made for r in built("group") if motor.key in {m.key for m in _motors_of(r.made)}]
    return -1.0 if sum(bool(group.get_inverted()) for group in groups) % 2 else 1.0


def with_followers(leaders: Sequence[BuiltDevice]) -> tuple[BuiltDevice, ...]:
    """Return motor controllers and the followers that robot code has configured for these controllers."""
    devices = [d for maker in makers() for d in maker.built() if d.model in maker.motors]
    found = list(leaders)
    for leader in leaders:
        maker = maker_of(leader)
        for group in maker.groups([d for d in devices if d.model in maker.motors]):
            if group.leader.key == leader.key:
                found += [f for f in group.followers if f.key not in {d.key for d in found}]
    return tuple(found)


def _named_motors(graph: ObjectGraph) -> dict[str, BuiltDevice]:
    """Return all motor controllers by attribute path."""
    motors = [d for maker in makers() for d in maker.built() if d.model in maker.motors]
    return {graph.name_of(d): d for d in motors}


def _by_name(names: Mapping[str, BuiltDevice], places: Sequence[str]) -> list[list[BuiltDevice]] | None:
    """Return the leaders at each side or corner by attribute names, or None if a side or corner has no motor."""
    found = []
    for place in places:
        own = [d for name, d in names.items() if says_place(name, place)]
        own = own or [d for name, d in names.items() if any(says_place(n, place) for n in name.split(".")[:-1])]
        if not own:
            return None
        followers = {f.key for d in own for g in maker_of(d).groups(own) for f in g.followers}
        found.append([d for d in own if d.key not in followers])
    return found


def _drives(name: str) -> bool:
    """Return whether an attribute path suggests a drive motor: a drive word, or a plain name on the robot itself.

    >>> _drives("container.drive_train.left_leader"), _drives("leftMotor"), _drives("lift.left_motor")
    (True, True, False)
    """
    return bool(_DRIVE.search(name)) or ("." not in name and _PLAIN.fullmatch(words_of(name)) is not None)


# --- encoders and distances -------------------------------------------------------------------------------------------


def _encoders(
    graph: ObjectGraph, names: Sequence[str], motors: Sequence[Sequence[BuiltDevice]]
) -> list[BuiltDevice | None]:
    """Return the encoder of each side or corner: on the roboRIO's ports, else wired to the leader, else None."""
    all_of_them = [d for maker in makers() for d in maker.built() if d.model == "Encoder"]
    found = [next((d for d in all_of_them if says_place(graph.name_of(d), place)), None) for place in names]
    if not any(found) and len(all_of_them) == len(names):
        return list(all_of_them)
    return [own or wired_encoder(leaders[0]) for own, leaders in zip(found, motors, strict=True)]


def wired_encoder(leader: BuiltDevice) -> BuiltDevice | None:
    """Return the leader if the leader reads an encoder on the wheel, else None."""
    return leader if maker_of(leader).has_wheel_encoder(leader) else None


def _meters_per_turn(encoder: BuiltDevice | None) -> float | None:
    """Return the configured distance per encoder turn [m], or None without an encoder or a configured distance."""
    if encoder is None:
        return None
    if encoder.model != "Encoder":  # the encoder is wired to a motor controller
        units = abs(maker_of(encoder).facts(encoder).units_per_rotor_turn)
        return None if units in (0.0, 1.0) else units
    distance = float(encoder.hardware.get_distance_per_pulse())
    return None if distance == 1.0 else distance * _PULSES


def _way(wheel: FoundWheel) -> dict[str, Measure]:
    """Return `meters_per_rotor_turn` from the leader's conversion factor.

    The result is empty for a leader without a conversion factor, or a wheel with an encoder.
    """
    leader = wheel.motors[0]
    units = abs(maker_of(leader).facts(leader).units_per_rotor_turn)
    if wheel.wheel_encoder is not None or units in (0.0, 1.0):
        return {}
    return {"meters_per_rotor_turn": Measure(units, f"conversion factor of {leader}")}
