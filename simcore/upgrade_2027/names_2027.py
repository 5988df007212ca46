"""Names of WPILib, commands2 and Phoenix 6 that changed from 2026 to 2027 in another way than to snake_case."""

from __future__ import annotations

import logging
import re
import threading
import unittest

__all__ = [
    "ATTRIBUTES",
    "ELEMENT_TYPES",
    "GONE",
    "HOOKS",
    "LIBRARIES",
    "MOTORS",
    "MOVED",
    "OF_KINDS",
    "OF_NUMBERS",
    "PHOENIX_DEVICES",
    "REQUIREMENTS",
    "SPARKS",
    "STAMPS",
    "VENDORS",
    "new_name",
    "new_path",
]

LIBRARIES = {"wpilib", "wpimath", "wpiutil", "hal", "ntcore", "commands2", "rev", "phoenix6", "robotpy_apriltag",
             "magicbot", "robotpy_ext"}  # fmt: skip
"""Their public names are snake_case in 2027."""
VENDORS = {"pathplannerlib", "photonlibpy", "navx", "phoenix5", "choreo", "playingwithfusion"}
"""Have no release that works with 2027.0.0a7, or keep their names: what comes from them is left as it is."""

_MATCH = "getAlliance getMatchTime getMatchNumber getMatchType getEventName getLocation getReplayNumber"
_STATE = "isEnabled isDisabled isAutonomous isAutonomousEnabled isTeleop isTeleopEnabled isFMSAttached isDSAttached"
_PUT = {"Number": "", "String": "", "Boolean": "", "NumberArray": "float", "StringArray": "str", "BooleanArray": "bool"}

OF_NUMBERS = {
    "wpimath.kinematics.ChassisSpeeds.fromFieldRelativeSpeeds": "to_robot_relative",
    "wpimath.kinematics.ChassisSpeeds.fromRobotRelativeSpeeds": "to_field_relative",
    "wpimath.kinematics.ChassisSpeeds.discretize": "discretize",
}
"""Functions that take three velocities and one thing more: methods of ChassisVelocities, which takes the velocities."""

MOVED = {
    **{f"wpilib.DriverStation.{name}": f"wpilib.MatchState.{name}" for name in _MATCH.split()},
    **{f"wpilib.DriverStation.{name}": f"wpilib.RobotState.{name}" for name in _STATE.split()},
    "wpilib.DriverStation.isEStopped": "wpilib.RobotState.is_e_stopped",
    "wpilib.DriverStation.isTest": "wpilib.RobotState.is_utility",
    "wpilib.DriverStation.isTestEnabled": "wpilib.RobotState.is_utility_enabled",
    "wpilib.DriverStation.getGameSpecificMessage": "wpilib.MatchState.get_game_data",
    "wpilib.DriverStation.silenceJoystickConnectionWarning": (
        "wpilib.DriverStationBackend.silence_joystick_connection_alert"
    ),
    **{
        f"wpilib.DriverStation.{old}": f"wpilib.DriverStationBackend.{new}"
        for old, new in (
            ("refreshData", "refresh_data"),
            ("getStickAxis", "get_stick_axis"),
            ("getStickButton", "get_stick_button"),
            ("isJoystickConnected", "is_joystick_connected"),
        )
    },
    "wpilib.drive": "wpilib",
    "wpilib.DriverStation.Alliance": "wpilib.Alliance",
    "wpilib.DriverStation.MatchType": "wpilib.MatchType",
    **{f"wpilib.SmartDashboard.put{kind}": "telemetry.log" for kind in _PUT},
    "wpilib.SmartDashboard.putData": "telemetry.log",
    "wpilib.SendableChooser": "tunables.Selectable",
    "wpilib.XboxController": "wpilib.NiDsXboxController",
    "wpilib.PS4Controller": "wpilib.NiDsPS4Controller",
    "commands2.button.CommandXboxController": "commands2.button.CommandNiDsXboxController",
    "commands2.button.CommandPS4Controller": "commands2.button.CommandNiDsPS4Controller",
    "wpilib.PS5Controller": "wpilib.NiDsPS5Controller",
    "wpilib.interfaces": "wpilib",
    "wpilib.event": "wpilib",
    "wpilib.Color": "wpiutil.Color",
    "wpilib.Color8Bit": "wpiutil.Color8Bit",
    "wpilib.Alert": "wpiutil.Alert",
    "hal.getFPGATime": "hal.get_monotonic_time",
    **{f"rev.Spark{model}": f"spark_units.Spark{model}" for model in ("Max", "Flex", "MaxConfig", "FlexConfig")},
    "phoenix6.utils.get_system_time_seconds": "phoenix6.utils.get_monotonic_time_seconds",
    "phoenix6.swerve.requests.ApplyFieldSpeeds": "phoenix6.swerve.requests.ApplyFieldVelocity",
    "phoenix6.swerve.requests.ApplyRobotSpeeds": "phoenix6.swerve.requests.ApplyRobotVelocity",
    **{
        f"wpimath.kinematics.{old}": f"wpimath.{new}"
        for old, new in (
            ("ChassisSpeeds", "ChassisVelocities"),
            ("SwerveModuleState", "SwerveModuleVelocity"),
            ("DifferentialDriveWheelSpeeds", "DifferentialDriveWheelVelocities"),
            ("MecanumDriveWheelSpeeds", "MecanumDriveWheelVelocities"),
        )
    },
    **{old: f"wpimath.ChassisVelocities.{new}" for old, new in OF_NUMBERS.items()},
    **{f"wpimath.system.plant.DCMotor.{n}": f"wpimath.DCMotor.{n.lower()}" for n in "CIM NEO NEO550 RS775_125".split()},
    "wpimath.system.plant.LinearSystemId": "wpimath.Models",
    **{
        f"wpimath.system.plant.LinearSystemId.{old}System": f"wpimath.Models.{new}_from_physical_constants"
        for old, new in (("flywheel", "flywheel"), ("elevator", "elevator"), ("singleJointedArm", "single_jointed_arm"))
    },
    "pyfrc.tests": "wpilib.testing.robot_tests",
    "pyfrc.tests.basic": "wpilib.testing.robot_tests",
}
"""By full name."""

ELEMENT_TYPES = {f"wpilib.SmartDashboard.put{kind}": element for kind, element in _PUT.items() if element}
"""Of sequences, which `telemetry.log` has to be told."""

ATTRIBUTES = {
    **{f"k{color}{n}": f"{color.upper()}_{n}" for color in ("Red", "Blue") for n in (1, 2, 3)},
    **{f"get{side}Bumper{what}": f"get_{side.lower()}_bumper_button{what and '_' + what.lower()}"
       for side in ("Left", "Right") for what in ("", "Pressed", "Released")},
    "getFPGATimestamp": "get_monotonic_timestamp",
    "getFPGATime": "get_monotonic_time",
    "setVInVoltage": "set_vin_voltage",
    "setReference": "set_setpoint",
    **{"IZone": "i_zone", "DFilter": "d_filter", "IMaxAccum": "i_max_accum"},
    "setGameSpecificMessage": "set_game_data",
    "getGameSpecificMessage": "get_game_data",
    "setJoystickAxisCount": "set_joystick_axes_maximum_index",
    "setJoystickButtonCount": "set_joystick_buttons_maximum_index",
    "setJoystickPOVCount": "set_joystick_povs_maximum_index",
    "setDefaultOption": "add_default",
    "addOption": "add",
    "toChassisSpeeds": "to_chassis_velocities",
    "toSwerveModuleStates": "to_swerve_module_velocities",
    "desaturateWheelSpeeds": "desaturate_wheel_velocities",
    "toWheelSpeeds": "to_wheel_velocities",
    "startClient4": "start_client",
    "deadlineWith": "deadline_for",
    "isTest": "is_utility",
    "trackWidth": "trackwidth",
    "with_speeds": "with_velocity",
    "with_state": "with_velocity",
    "speeds": "velocity",
    "module_states": "module_velocities",
    **{f"get_{which}_state": f"get_{which}_velocity" for which in ("current", "target")},
    "with_desaturate_wheel_speeds": "with_desaturate_wheel_velocities",
    "set_operator_perspective_forward": "set_operator_forward_direction",
}  # fmt: skip
"""Of an object, whatever it is, if the project has no such name of its own."""

OF_KINDS = {
    "wpimath.controller.PIDController": {"getPositionError": "get_error", "getVelocityError": "get_error_derivative"},
    "wpimath.kinematics.SwerveModuleState": {"speed": "velocity"},
    **{f"wpilib.{pad}Controller": {"getRawAxis": "get_hid().get_raw_axis"} for pad in ("Xbox", "PS4", "PS5")},
}
"""Attributes of objects of one class, by its full name."""

HOOKS = {
    **{f"{mode}{when}": "" for mode in ("autonomous", "teleop", "disabled") for when in ("Init", "Periodic", "Exit")},
    **{f"test{when}": f"utility_{when.lower()}" for when in ("Init", "Periodic", "Exit")},
    **{f"{what}Periodic": "" for what in ("robot", "simulation")},
    **{
        name: ""
        for name in "isFinished runsWhenDisabled getInterruptionBehavior startCompetition createObjects".split()
    },
    **{name: "" for name in "simulationInit endCompetition driverStationConnected getRequirements".split()},
    "_simulationInit": "simulation_init",
    "_simulationPeriodic": "simulation_periodic",
    "robotInit": "__init__",
}
"""Methods that robot code overrides; without a name: the same in snake_case."""

STAMPS = {"time", "getLastChange", "getFPGATime", "getFPGATimestamp", "getServerTimeOffset"}
"""Have to do with a clock that counts microseconds in 2026 and nanoseconds in 2027."""

PHOENIX_DEVICES = {f"phoenix6.hardware.{n}" for n in "TalonFX TalonFXS CANcoder Pigeon2 CANrange CANdi CANdle".split()}
"""Need their CANBus."""
SPARKS = "spark_units"
"""Module that is put into the copy of a project with SPARKs: REVLib of 2027 has other arguments, units and answers."""
MOTORS = ("wpilib.PWM", "wpilib.MotorController", "phoenix6.hardware.TalonFX", "rev.Spark", "wpilib.VictorSP")
"""What their full names begin with: `set` is `set_throttle`."""

_NO_CHIP = "removed from WPILib: its hardware does not exist on the robot of 2027"
_NO_PULSES = "has no class in RobotPy 2027.0.0a7, where a PWMMotorController gives no pulses: a controller on CAN does"
GONE = {
    **{f"wpilib.{n}": _NO_CHIP for n in "Relay Servo Ultrasonic AnalogTrigger Counter SPI".split()},
    **{f"wpilib.{n}": _NO_CHIP for n in "ADXRS450_Gyro ADIS16448_IMU ADIS16470_IMU AnalogGyro AnalogOutput".split()},
    **{f"wpilib.{n}": _NO_PULSES for n in "Spark Talon VictorSP Koors40".split()},
    **{f"wpilib.PWM{n}": _NO_PULSES for n in "SparkMax SparkFlex TalonFX TalonSRX Venom VictorSPX".split()},
    "wpilib.SmartDashboard": "has no like in 2027: `telemetry.log` writes, `tunables.add` makes what can be set",
    "wpilib.DriverStation": "is RobotState, MatchState and DriverStationBackend in 2027: say which",
    "wpilib.shuffleboard": "removed: use telemetry and tunables",
    "wpilib.LiveWindow": "removed: use telemetry and tunables",
    "wpiutil.Sendable": "removed: use telemetry.TelemetryLoggable",
    "wpiutil.log": "is the package wpilog in 2027",
    "robotpy_apriltag.AprilTagField": "field layouts are in robotpy-fields: get_field(FieldId....)",
    "robotpy_apriltag.AprilTagFieldLayout": "field layouts are in robotpy-fields: get_field(FieldId....)",
    "wpimath.controller.RamseteController": "removed: LTVUnicycleController does the same",
    "wpimath.controller.HolonomicDriveController": "removed",
    "wpimath.trajectory.Trajectory": "removed: DrivetrainSpline... took its place",
    **{
        f"commands2.{name}": "removed: write the controller in a command of your own"
        for name in "PIDCommand PIDSubsystem ProfiledPIDCommand ProfiledPIDSubsystem SwerveControllerCommand".split()
    },
    "pyfrc": "is not in RobotPy 2027: a physics.py of simcore runs under `robotpy sim --simcore`, its tests too",
    "phoenix6.utils.current_time_to_fpga_time": "gone: there is one clock",
}
"""What a person has to decide, by full name or the beginning of it."""

REQUIREMENTS = {
    "phoenix6": "phoenix6>=26.70.0a2,<27",
    "robotpy-rev": "robotpy-rev>=2027.0.0a7,<2028",
    "robotpy-commands-v2": "robotpy-commands-v2>=2027.0.0a7,<2028",
    "wpilib": "wpilib>=2027.0.0a7,<2028",
    "robotpy": "robotpy>=2027.0.0a7,<2028",
}
"""Of pip, by package."""

_OF_PYTHON = {
    name
    for owner in (logging.Logger, logging.LogRecord, logging.Handler, threading.Thread, unittest.TestCase)
    for name in dir(owner)
}
"""Camel case in the standard library, which stays."""
_WORDS = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_FLAT = re.compile(r"^wpimath\.(geometry|kinematics|controller|filter|trajectory|system|plant|estimator|spline|"
                   r"optimization|interpolation)\.")  # fmt: skip


def new_name(name: str) -> str:
    """An attribute of 2026 as 2027 spells it, if it is one of WPILib's.

    >>> [new_name(n) for n in ("robotPeriodic", "isFMSAttached", "kOnboard", "kRed1", "toPose2d", "Pose2d", "k_p")]
    ['robot_periodic', 'is_fms_attached', 'ONBOARD', 'RED_1', 'to_pose2d', 'Pose2d', 'k_p']
    """
    if name in ATTRIBUTES:
        return ATTRIBUTES[name]
    if name in _OF_PYTHON:
        return name
    if re.match(r"k[A-Z]", name):
        return _WORDS.sub("_", name[1:]).upper()
    return _WORDS.sub("_", name).lower() if re.match(r"_?[a-z]+\w*[A-Z]", name) else name


def new_path(path: str) -> str:
    """A full name of 2026 in 2027.

    >>> new_path("wpilib.DriverStation.Alliance.kRed"), new_path("wpimath.geometry.Rotation2d.fromDegrees")
    ('wpilib.Alliance.RED', 'wpimath.Rotation2d.from_degrees')
    """
    words = path.split(".")
    if words[0] not in LIBRARIES and path not in MOVED:
        return path
    head = len(words)
    while head > 1 and ".".join(words[:head]) not in MOVED:
        head -= 1
    full = ".".join((MOVED.get(".".join(words[:head]), ".".join(words[:head])), *words[head:]))
    while (flat := _FLAT.sub("wpimath.", full + ".")[:-1]) != full:
        full = flat
    return ".".join(new_name(word) for word in full.split("."))
