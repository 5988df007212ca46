"""Discovery of a program's drivetrain, of any kind and maker: in simcore.toml, a library, or the program's classes."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress
from simcore.robot_file.drivetrain_table import ON_PORTS, DrivetrainSettings
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robot_file.template import FILE_NAME
from simcore.robotcode.program.drivetrain_measures import complete_measures, in_meters
from simcore.robotcode.program.drivetrain_model import connect_drivetrain, drivetrain_config
from simcore.robotcode.program.found_drivetrain import DrivetrainNotFoundError, FoundDrivetrain, FoundWheel
from simcore.robotcode.program.makers import MakersDrivetrain, find_device, makers
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.object_graph import ObjectGraph
from simcore.robotcode.program.sides_discovery import find_mecanum, find_tank, wired_encoder, with_followers
from simcore.robotcode.program.simulation_questions import place_of_question
from simcore.robotcode.program.swerve_discovery import find_swerve, free_speed_volts, motor_measures, with_beliefs

__all__ = ["ProgramDrivetrain", "find_drivetrain"]

_log = logging.getLogger(__name__)


class ProgramDrivetrain:
    """Drivetrain whose devices the program commands directly; implements `MakersDrivetrain`.

    Args:
        found: Drivetrain with complete measures.
        settings: Settings of simcore.toml.
    """

    def __init__(self, found: FoundDrivetrain, settings: RobotSettings) -> None:
        self.found = found
        self.config = drivetrain_config(found, settings)

    def connect(self, drive: Any) -> Any:
        """Return ports that connect the program's devices to the drivetrain's model `drive`."""
        return connect_drivetrain(self.found, drive)


def find_drivetrain(robot: Any, folder: Path, settings: RobotSettings) -> MakersDrivetrain:
    """Return the program's drivetrain with complete measures and a model configuration; log contradictions.

    Args:
        robot: Robot object; None if the devices exist without a robot object.
        folder: Folder of robot.py.
        settings: Settings of simcore.toml.

    Raises:
        DrivetrainNotFoundError: The program has no drivetrain that simcore can find.
        ConfigError: A measure is out of range, simcore.toml contradicts the program, or a device does not respond.
    """
    table = settings.drivetrain
    graph = ObjectGraph(robot, folder)
    if table.has_devices:
        found = _described(table)
    else:
        for maker in makers():
            ready = maker.drivetrain(settings, folder)
            if ready is not None:
                corrections = (*(["kind"] if table.kind else []), *table.corrections)
                _refuse(corrections, "cannot be corrected here: the program's own SwerveDrivetrain sets it")
                return ready
        found = _discovered(graph)
        if table.kind and table.kind != found.kind:
            raise ConfigError(
                f"{FILE_NAME} [drivetrain]: kind is {table.kind}, but the program has a {found.kind} drive"
            )
        if found.kind == "swerve":
            found = with_beliefs(found, graph)
        found = _corrected(in_meters(found), table)
        _require_around(found)
    if found.gyro is None:
        found = replace(found, gyro=_gyro(table.gyro))
    if found.kind == "swerve" and not table.has_devices:
        found = _with_gaps(found)
    found = complete_measures(found, settings, folder)
    for sentence in found.differences:
        _log.warning("drivetrain: %s", sentence)
    return ProgramDrivetrain(found, settings)


def _discovered(graph: ObjectGraph) -> FoundDrivetrain:
    why = ""
    for find in (find_swerve, find_mecanum, find_tank):
        try:
            found = find(graph)
        except DrivetrainNotFoundError as error:
            why = why or str(error)
            continue
        if found is not None:
            return found
    asked = place_of_question()
    if asked and not any(device.model in maker.motors for maker in makers() for device in maker.built()):
        raise DrivetrainNotFoundError(
            "no drivetrain found: the program builds no motor controller in simulation; it asks whether it is real "
            f"({asked}): real = true under [robot] in {FILE_NAME} makes it build those of the robot"
        )
    raise DrivetrainNotFoundError(
        f"no drivetrain found: {why or 'the program builds none of SwerveDrivetrain, Kinematics, DifferentialDrive'}; "
        f"describe it in a [drivetrain] table in {FILE_NAME} (docs/which_robots.md); until then there is no field"
    )


def _refuse(keys: Sequence[str], why: str) -> None:
    if keys:
        raise ConfigError(f"{FILE_NAME} [drivetrain]: {keys[0]} {why}")


def _corrected(found: FoundDrivetrain, table: DrivetrainSettings) -> FoundDrivetrain:
    """Return the drivetrain with the signs, zeros, positions and encoder distances given in simcore.toml.

    Raises:
        ConfigError: A value does not fit the kind of drive or the number of wheels.
    """
    n = len(found.wheels)
    _refuse(
        table.of_swerve if found.kind != "swerve" else (), f"is for a swerve drive, but this is a {found.kind} drive"
    )
    _refuse(("x",) if table.places and found.kind == "tank" else (), "is for drives whose wheels have x and y")
    for key, row in (("zeros_deg", table.zeros), ("x", table.places), ("wheel_distances", table.wheel_distances)):
        _refuse(
            (key,) if row and len(row) != n else (), f"must have {n} entries, one for each wheel or side of the drive"
        )
    for key in ("reversed_drive", "reversed_steer", "reversed_encoders"):
        beyond = [k for k in getattr(table, key) if k >= n]
        _refuse((key,) if beyond else (), f"counts wheels from 0 to {n - 1}, got {beyond}")
    measures = dict(found.measures)
    for key, is_said in (("x and y", bool(table.places)), ("zeros_deg", bool(table.zeros))):
        if is_said:
            measures.pop(key, None)
    turned = (set(table.reversed_drive), set(table.reversed_steer), set(table.reversed_encoders))
    wheels = []
    for k, wheel in enumerate(found.wheels):
        own: dict[str, Any] = {"place": table.places[k]} if table.places else {}
        own |= {"zero": table.zeros[k]} if table.zeros else {}
        own |= {"meters_per_encoder_turn": table.wheel_distances[k]} if table.wheel_distances else {}
        for name, given in zip(("drive_sign", "steer_sign", "encoder_sign"), turned, strict=True):
            own |= {name: -1.0 if k in given else 1.0} if given else {}
        if table.reversed_steer:
            own["is_steer_sign_known"] = True
        wheels.append(replace(wheel, **own))
    return replace(found, wheels=tuple(wheels), measures=measures)


def _require_around(found: FoundDrivetrain) -> None:
    """Check that the wheels have distinct positions around the robot's center.

    Raises:
        ConfigError: Two wheels are less than 1 cm apart, or all wheels are on one side of the center.
    """
    places, part = found.places, "modules" if found.kind == "swerve" else "wheels"
    for k, place in enumerate(places):
        same = [str(j) for j in range(k, len(places)) if math.dist(places[j], place) < 0.01]
        if len(same) > 1:
            raise ConfigError(
                f"{part} {', '.join(same[:-1])} and {same[-1]} are at one position in your kinematics, "
                f"{place[0]:.3g} m forward and {place[1]:.3g} m left of the center (counted from 0): "
                "each needs its own Translation2d"
            )
    angles = sorted(math.atan2(y, x) for x, y in places)
    gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + math.tau], strict=True)]
    if len(places) > 2 and max(gaps) >= math.pi:
        given = ", ".join(f"({x:.3g}, {y:.3g})" for x, y in places)
        raise ConfigError(
            f"all {part} in your kinematics are on one side of the robot's center: {given}; a Translation2d is from "
            "the center, x forward and y to the left [m]"
        )


def _with_gaps(found: FoundDrivetrain) -> FoundDrivetrain:
    """Return the swerve drivetrain with a sentence in `differences` about missing encoders or a missing gyro."""
    gaps = (
        []
        if any(wheel.encoder for wheel in found.wheels)
        else ["azimuth encoders that simcore knows (so the modules start straight)"]
    )
    gaps += [] if found.gyro else ["gyro"]
    if not gaps:
        return found
    sentence = f"{found.about}: found no {' and no '.join(gaps)}"
    return replace(found, differences=(*found.differences, sentence))


def _described(table: DrivetrainSettings) -> FoundDrivetrain:
    """Return the drivetrain that the table in simcore.toml describes, with the program's devices."""
    where = f"{FILE_NAME} [drivetrain]"
    steer_model = table.steer_controller or table.controller
    wheels = []
    for k, places in enumerate(table.drive):
        motors = tuple(find_device(where, table.controller, address) for address in places)
        steer = find_device(where, steer_model, table.steer[k]) if table.steer else None
        encoder = steer if table.encoder == "wired" else None
        if table.encoders:
            models = (table.encoder, *ON_PORTS) if table.encoder in ON_PORTS else (table.encoder or "CANcoder",)
            encoder = find_device(where, models, table.encoders[k])
        if table.kind == "tank":
            motors = with_followers(motors)
        wheel = wired_encoder(motors[0])
        if k < len(table.wheel_encoders):
            wheel = find_device(where, "Encoder", DeviceAddress(table.wheel_encoders[k]))
        wheels.append(
            FoundWheel(
                name=("left", "right")[k] if table.kind == "tank" else f"module {k}",
                place=table.places[k] if table.places else _place(table, k),
                motors=motors,
                steer=steer,
                encoder=encoder,
                wheel_encoder=wheel,
                meters_per_encoder_turn=table.wheel_distances[k] if k < len(table.wheel_distances) else None,
                drive_sign=-1.0 if k in table.reversed_drive else 1.0,
                steer_sign=-1.0 if k in table.reversed_steer else 1.0,
                encoder_sign=-1.0 if k in table.reversed_encoders else 1.0,
                zero=table.zeros[k] if table.zeros else 0.0,
                is_steer_sign_known=bool(table.reversed_steer),
            )
        )
    measures = dict(motor_measures("drive", wheels[0].motors[0]))
    if wheels[0].steer is not None:
        measures |= motor_measures("steer", wheels[0].steer)
    return FoundDrivetrain(
        kind=table.kind,
        wheels=tuple(wheels),
        measures=measures,
        free_speed_volts=free_speed_volts(wheels[0]),
        about=f"as {FILE_NAME} says",
    )


def _place(table: DrivetrainSettings, k: int) -> tuple[float, float]:
    """Return the default position [m] of tank side k or mecanum wheel k, from the trackwidth."""
    half = 0.5 * float(table.measures.get("trackwidth", 0.56))
    return (0.0, half if k == 0 else -half) if table.kind == "tank" else ((0.28, -0.28)[k // 2], (half, -half)[k % 2])


def _gyro(named: str) -> BuiltDevice | None:
    """Return the gyro named in simcore.toml, else the first gyro that the program has built; None without a gyro.

    Raises:
        ConfigError: The program has not built the named gyro.
    """
    built = [d for maker in makers() for d in maker.built() if d.model in maker.gyros]
    if not named:
        return built[0] if built else None
    for device in built:
        if named in (device.model, str(device)):
            return device
    there = ", ".join(map(str, built)) or "none"
    raise ConfigError(f"{FILE_NAME} [drivetrain]: gyro {named!r} is not built by the program; it builds {there}")
