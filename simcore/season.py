"""Access to WPILib 2026 and WPILib 2027 under the names of 2027.

Only this module imports WPILib and checks the season. Public names of WPILib 2027 are snake_case. With WPILib 2026,
this module adds the names of 2027 in `NAMES` to WPILib's classes, so that other code works with both seasons. A module
of WPILib is imported on first use: `season.wpilib_simulation` imports wpilib.simulation. Importing this module requires
no part of WPILib.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from importlib import import_module, metadata
from importlib.util import find_spec
from itertools import cycle
from pathlib import Path
from types import ModuleType
from typing import Any, TypeAlias

from simcore.errors import ConfigError
from simcore.install_text import install_command

__all__ = [
    "EPOCH",
    "NAMES",
    "NetworkTables",
    "camel_case",
    "initialize_hal",
    "installed_seasons",
    "is_installed",
    "is_local",
    "mixed_seasons",
    "pub_sub_options",
    "start_server",
]

NetworkTables: TypeAlias = Any
"""Type of a `NetworkTableInstance`."""

_TOPICS = "boolean double integer raw string double_array integer_array string_array"
_KINDS = "raw double double_array float float_array integer integer_array"
_SUBSCRIBERS = ("Boolean", "Double", "Integer", "Raw", "String", "DoubleArray", "IntegerArray")

EPOCH = 1e7
"""Upper bound of a computer's uptime [s]; since 2027, a test starts when the clock shows a multiple of this time."""

_GEOMETRY = ("Pose2d", "Pose3d", "Quaternion", "Rotation2d", "Rotation3d", "Transform3d", "Translation3d")
DRIVES = (*(f"SwerveDrive{n}" for n in (2, 3, 4, 6)), "DifferentialDrive", "MecanumDrive")
"""Prefixes of WPILib's kinematics, odometry and pose estimator classes."""

_KINEMATICS = ("Kinematics", "Odometry", "Odometry3d")

NAMES: dict[str, dict[str, str]] = {
    # module: class in the module, or "" for the module itself: names of 2027 that simcore uses
    "ntcore": {
        "NetworkTable": "get_sub_table get_string_topic get_integer_topic get_instance get_path",
        "NetworkTableEntry": "get_string get_string_array set_string set_string_array get_name",
        "Subscriber": "get_topic",
        "NetworkTableInstance": "get_entry get_topics "
        "create destroy get_default get_network_mode get_topic get_table has_schema add_schema "
        "start_local start_server stop_server " + " ".join(f"get_{kind}_topic" for kind in _TOPICS.split()),
        "NetworkTableListenerPoller": "add_listener read_queue close",
        "Topic": "generic_subscribe get_name",
        "GenericSubscriber": "read_queue",
        **{f"{kind}Topic": "get_entry publish subscribe" for kind in _SUBSCRIBERS},
        **{f"{kind}Subscriber": "get_atomic read_queue" for kind in _SUBSCRIBERS},
        **{f"{kind}Entry": "set_default set" for kind in _SUBSCRIBERS},
        "Value": "is_valid time value " + " ".join(f"is_{kind} get_{kind}" for kind in _KINDS.split()),
        "EventFlags": "VALUE_ALL IMMEDIATE PUBLISH",
    },
    "rev": {
        "": "MotorType=SparkLowLevel.MotorType IdleMode=SparkBaseConfig.IdleMode",
        "SparkBase": "get_device_id get_motor_type is_follower",
        **{spark: "config_accessor" for spark in ("SparkMax", "SparkFlex")},
        "SparkBaseConfigAccessor": "absolute_encoder analog_sensor closed_loop limit_switch soft_limit get_idle_mode "
        "get_closed_loop_ramp_rate get_follower_mode_inverted get_follower_mode_leader_id get_open_loop_ramp_rate "
        "get_smart_current_limit get_voltage_compensation get_voltage_compensation_enabled",
        "SparkMaxConfigAccessor": "alternate_encoder",
        "SparkFlexConfigAccessor": "external_encoder",
        "ClosedLoopConfigAccessor": "feed_forward max_motion get_allowed_closed_loop_error get_d get_d_filter get_i "
        "get_feedback_sensor get_i_zone get_max_i_accumulation get_max_output get_min_output get_p "
        "get_position_wrapping_enabled",
        "FeedForwardConfigAccessor": "getk_a getk_cos getk_cos_ratio getk_g getk_s getk_v",
        "MAXMotionConfigAccessor": "get_allowed_profile_error get_cruise_velocity get_max_acceleration",
        "LimitSwitchConfigAccessor": "get_forward_limit_switch_trigger_behavior "
        "get_reverse_limit_switch_trigger_behavior",
        "SoftLimitConfigAccessor": "get_forward_soft_limit get_forward_soft_limit_enabled get_reverse_soft_limit "
        "get_reverse_soft_limit_enabled",
        "ClosedLoopSlot": "SLOT0 SLOT1 SLOT2 SLOT3",
        "FeedbackSensor": "PRIMARY_ENCODER ABSOLUTE_ENCODER ALTERNATE_OR_EXTERNAL_ENCODER ANALOG_SENSOR",
        "ResetMode": "RESET_SAFE_PARAMETERS",
        "MotorType": "BRUSHED",
        "IdleMode": "BRAKE",
    },
    "hal": {
        "AllianceStationID": " ".join(f"{c}_{n}=k{c.capitalize()}{n}" for c in ("BLUE", "RED") for n in (1, 2, 3)),
    },
    "hal.simulation": {"": "is_timing_paused"},
    "wpilib": {
        "": "Alliance=DriverStation.Alliance MatchState=DriverStation get_deploy_directory "
        "DifferentialDrive=drive.DifferentialDrive MecanumDrive=drive.MecanumDrive",
        "Alliance": "RED=kRed BLUE=kBlue",
        "AnalogEncoder": "get_channel",
        "MotorControllerGroup": "get_inverted",
        "DigitalInput": "get_channel",
        "DigitalOutput": "get_channel",
        "AnalogInput": "get_channel",
        "DoubleSolenoid": "get_fwd_channel get_rev_channel",
        "DutyCycleEncoder": "get get_source_channel",
        "Encoder": "get_distance_per_pulse set_distance_per_pulse",
        "Field2d": "set_robot_pose get_object",
        "FieldObject2d": "set_poses",
        "IterativeRobotBase": "get_period",
        "MatchState": "get_alliance get_game_data=getGameSpecificMessage",
        "Notifier": "start_single start_periodic set_callback",
        "PWMMotorController": "get_channel get_inverted",
        "PneumaticHub": "get_module_number",
        "PneumaticsControlModule": "get_module_number",
        "RobotController": "get_battery_voltage get_monotonic_time=getFPGATime",
        "RobotState": "is_enabled is_disabled is_autonomous is_autonomous_enabled=DriverStation.isAutonomousEnabled "
        "is_fms_attached=DriverStation.isFMSAttached",
        "Solenoid": "get_channel",
        "TimedRobot": "add_periodic",
        "Timer": "get_monotonic_timestamp=getFPGATimestamp",
    },
    "wpilib.simulation": {
        "": "pause_timing resume_timing step_timing is_timing_paused",
        "AddressableLEDSim": "get_length get_data",
        "AnalogEncoderSim": "set",
        "AnalogInputSim": "get_initialized get_voltage set_voltage",
        **{f"{module}Sim": "get_solenoid_output set_solenoid_output" for module in ("CTREPCM", "REVPH")},
        "DIOSim": "get_initialized get_value set_value",
        "DriverStationSim": "set_ds_attached set_enabled notify_new_data set_match_time set_alliance_station_id "
        "set_game_data=setGameSpecificMessage set_joystick_axis set_joystick_button",
        "DutyCycleSim": "create_for_channel get_output set_output",
        "EncoderSim": "create_for_channel get_reset set_reset get_distance_per_pulse get_count set_count set_rate "
        "get_period get_direction set_direction",
        "PWMSim": "get_initialized get_pulse_microsecond set_pulse_microsecond",
        "PowerDistributionSim": "get_initialized set_voltage set_current",
        "RoboRioSim": "set_brownout_voltage get_brownout_voltage set_vin_voltage=setVInVoltage "
        "get_vin_voltage=getVInVoltage "
        "set_user_active_3v3=setUserActive3V3 set_user_faults_3v3=setUserFaults3V3",
        "SimDeviceSim": "get_boolean get_double get_int enumerate_devices enumerate_values",
    },
    "wpimath": {
        "": " ".join(
            f"{name}={module}.{name}"
            for module, names in (
                ("geometry", _GEOMETRY),
                ("trajectory", ("TrapezoidProfile",)),
                (
                    "kinematics",
                    (f"{drive}{kind}" for drive in DRIVES for kind in _KINEMATICS),
                ),
                ("estimator", (f"{drive}PoseEstimator{space}" for drive in DRIVES for space in ("", "3d"))),
            )
            for name in names
        ),
        "Pose3d": "to_pose2d",
        **{f"{drive}Kinematics": "get_modules" for drive in DRIVES if drive.startswith("Swerve")},
        "DifferentialDriveKinematics": "trackwidth=trackWidth",
        "MecanumDriveKinematics": "get_front_left get_front_right get_rear_left get_rear_right",
        **{f"{drive}Odometry{space}": "get_pose" for drive in DRIVES for space in ("", "3d")},
        **{f"{drive}PoseEstimator{space}": "get_estimated_position" for drive in DRIVES for space in ("", "3d")},
    },
}
"""Names of 2027 that simcore uses, by module and class.

An entry `new=old` also gives the name of 2026 if `old` is not the camelCase form of `new` (or `kNew` for `NEW`). A
name of 2026 with a dot is the path of the object from the module.
"""


def __getattr__(name: str) -> ModuleType:
    path = name.replace("_", ".")
    if path not in NAMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _module(path)


@cache
def _module(name: str) -> ModuleType:
    try:
        module = import_module(name)
    except ImportError as error:
        mixed = mixed_seasons(
            installed_seasons((d.metadata["Name"] or "", d.version) for d in metadata.distributions())
        )
        cure = mixed or f"{install_command('robotpy')} installs it"
        raise ConfigError(f"this needs {name} of WPILib, which cannot be imported ({error}): {cure}") from error
    for class_name, names in NAMES[name].items():
        _add_names(module, getattr(module, class_name) if class_name else module, names.split())
    return module


def _add_names(module: ModuleType, owner: Any, entries: list[str]) -> None:
    for entry in entries:
        name, _, old = entry.partition("=")
        if not hasattr(owner, name):
            old = old or ("k" + camel_case(name.lower(), first=True) if name.isupper() else camel_case(name))
            setattr(owner, name, _value(module, old) if "." in old else getattr(owner, old))


def _value(module: ModuleType, path: str) -> Any:
    first, name = path.split(".")
    owner = getattr(module, first, None) or import_module(f"{module.__name__}.{first}")
    return getattr(owner, name)


def own_name(owner: Any, name: str, old: str = "") -> str:
    """Return the name of a WPILib object in the installed season, e.g. of a method that robot code overrides.

    Args:
        owner: Class or module that defines the name.
        name: Name in 2027.
        old: Name in 2026; empty if the old name is the camel case of `name`.
    """
    old = old or camel_case(name)
    return old if hasattr(owner, old) else name


def class_before_2027(module: str, name: str) -> Any:
    """Return a class that WPILib removed in 2027; if the class is missing, return an empty class of the same name."""
    return getattr(_module(module), name, None) or type(name, (), {})


def loop_classes() -> tuple[Any, ...]:
    """Return the robot classes with WPILib's loop and `add_periodic`: TimedRobot and, since 2027, OpModeRobot."""
    wpilib = _module("wpilib")
    return tuple(getattr(wpilib, name) for name in ("TimedRobot", "OpModeRobot") if hasattr(wpilib, name))


def add_between_loops(robot: Any, call: Callable[[], None], period: float) -> None:
    """Schedule a function to run once per loop period, half a period after each loop of the robot.

    Args:
        robot: Robot of one of the `loop_classes`.
        call: Function without arguments.
        period: Loop period of the robot [s].
    """
    if isinstance(robot, _module("wpilib").TimedRobot):
        robot.add_periodic(call, period, period / 2.0)
        return
    halves = cycle((call, None))  # an OpModeRobot has no offset, so every second call coincides with a loop

    def half() -> None:
        due = next(halves)
        if due is not None:
            due()

    robot.add_periodic(half, period / 2.0)


def set_mode(mode: str, name: str = "") -> None:
    """Select a robot mode on the simulated driver station and, since 2027, an op mode of the robot mode.

    Args:
        mode: `autonomous`, `teleop` or `utility` (`test` in 2026).
        name: Name of the op mode; an unknown name selects the first op mode of the robot mode, if there is one.
    """
    sim = _module("wpilib.simulation").DriverStationSim
    if hasattr(sim, "setAutonomous"):
        sim.setAutonomous(mode == "autonomous")
        sim.setTest(mode == "utility")
        return
    hal = _module("hal")
    kind = {"autonomous": hal.RobotMode.AUTONOMOUS, "utility": hal.RobotMode.UTILITY}.get(
        mode, hal.RobotMode.TELEOPERATED
    )
    sim.set_robot_mode(kind)
    options = [o for o in sim.get_opmode_options() if int(hal.opmode_get_robot_mode(o.id)) == int(kind)]
    chosen = next((o for o in options if o.name == name), options[0] if options else None)
    sim.set_opmode(0 if chosen is None else chosen.id)


def op_modes(mode: str) -> list[str]:
    """Return the names of the op modes that the simulated driver station offers in a robot mode; empty in 2026."""
    sim, hal = _module("wpilib.simulation").DriverStationSim, _module("hal")
    if not hasattr(sim, "get_opmode_options"):
        return []
    kind = {"autonomous": "AUTONOMOUS", "utility": "UTILITY"}.get(mode, "TELEOPERATED")
    found = sim.get_opmode_options()
    return [o.name for o in found if int(hal.opmode_get_robot_mode(o.id)) == int(getattr(hal.RobotMode, kind))]


def open_joystick(port: int, *, axes: int, buttons: int, povs: int) -> None:
    """Connect a simulated joystick with the given numbers of axes, buttons and POV hats to a driver station port."""
    sim = _module("wpilib.simulation").DriverStationSim
    for count, old, new in ((axes, "Axis", "axes"), (buttons, "Button", "buttons"), (povs, "POV", "povs")):
        if hasattr(sim, f"setJoystick{old}Count"):
            getattr(sim, f"setJoystick{old}Count")(port, count)
        else:
            getattr(sim, f"set_joystick_{new}_maximum_index")(port, count)


def press_button(port: int, number: int, down: bool) -> None:
    """Press or release a button of a simulated joystick.

    Args:
        port: Driver station port of the joystick.
        number: Number of the button, from 1 in both seasons, although WPILib 2027 counts from 0.
        down: Whether the button is pressed.
    """
    sim = _module("wpilib.simulation").DriverStationSim
    sim.set_joystick_button(port, number if hasattr(sim, "setJoystickButton") else number - 1, down)


def clock_rate() -> float:
    """Return the number of NetworkTables timestamp units per second: 1e6 in 2026 or without ntcore, 1e9 in 2027."""
    try:
        return 1e6 if hasattr(import_module("ntcore").NetworkTableInstance, "getDefault") else 1e9
    except ImportError:
        return 1e6


def is_chooser(instance: NetworkTables, key: str) -> bool:
    """Return whether a NetworkTables key holds a `SendableChooser`; since 2027, also for any key under `/Tunables/`."""
    if instance.get_entry(f"{key}/.type").get_string("") == "String Chooser":
        return True
    return clock_rate() > 1e6 and key.startswith("/Tunables/")


def chooser_keys() -> tuple[str, str]:
    """Return the NetworkTables subkeys of a chooser: the requested choice, and the active choice."""
    return ("selected", "active") if clock_rate() == 1e6 else ("selected/tune", "selected/value")


def set_pov(port: int, angle: int | None) -> None:
    """Press or release the first POV hat of a simulated joystick.

    Args:
        port: Driver station port of the joystick.
        angle: Direction clockwise from forward, a multiple of 45 [deg]; None to release the POV hat.
    """
    sim, wpilib = _module("wpilib.simulation").DriverStationSim, _module("wpilib")
    if hasattr(sim, "setJoystickPOV"):
        sim.setJoystickPOV(port, 0, -1 if angle is None else angle)
        return
    around = ("UP", "UP_RIGHT", "RIGHT", "DOWN_RIGHT", "DOWN", "DOWN_LEFT", "LEFT", "UP_LEFT")
    name = "CENTER" if angle is None else around[angle // 45]
    sim.set_joystick_pov(port, 0, getattr(wpilib.POVDirection, name))


def silence_joystick_warnings() -> None:
    """Turn off WPILib's warning about missing joysticks."""
    wpilib = _module("wpilib")
    if hasattr(wpilib, "DriverStationBackend"):
        wpilib.DriverStationBackend.silence_joystick_connection_alert(True)
    else:
        wpilib.DriverStation.silenceJoystickConnectionWarning(True)


def spark_sim_name(spark: Any, model: str) -> str:
    """Return the name of a SPARK's SimDevice: model, CAN ID and, since 2027, CAN port."""
    port = f"{int(spark.get_can_port())}," if hasattr(spark, "get_can_port") else ""
    return f"{model} [{port}{spark.get_device_id()}]"


def spark_factors(encoder: Any) -> tuple[float, float]:
    """Return the position and velocity conversion factors of a SPARK encoder; since 2027, both factors are 1.

    Args:
        encoder: Encoder part of the SPARK's `config_accessor`.
    """
    if not hasattr(encoder, "getPositionConversionFactor"):
        return 1.0, 1.0
    return float(encoder.getPositionConversionFactor()), float(encoder.getVelocityConversionFactor())


def spark_wrap(loop: Any) -> tuple[float, float] | None:
    """Return the input range of a SPARK's position wrapping, since 2027 always 0 to 1; None if wrapping is disabled.

    Args:
        loop: Closed-loop part of the SPARK's `config_accessor`.
    """
    if not loop.get_position_wrapping_enabled():
        return None
    if not hasattr(loop, "getPositionWrappingMinInput"):
        return 0.0, 1.0
    return float(loop.getPositionWrappingMinInput()), float(loop.getPositionWrappingMaxInput())


def centered_spark_encoder(encoder: Any, written: bool) -> bool:
    """Return whether a SPARK's absolute encoder is zero-centered: readings from -1/2 to 1/2 turn.

    Args:
        encoder: Encoder part of the SPARK's `config_accessor`.
        written: Setting that the program wrote; used in 2026, when a program cannot read the SPARK's setting.
    """
    return bool(encoder.is_zero_centered()) if hasattr(encoder, "is_zero_centered") else written


def spark_answer(read: Callable[[], Any], value: float | bool) -> Any:
    """Return a value in the type of a SPARK reading.

    In 2026, a reading is a plain value. Since 2027, a reading is a signal, and the result has the error and timestamp
    of REVLib's reading.

    Args:
        read: Function that returns REVLib's reading.
        value: Value that replaces REVLib's value.
    """
    own = read()
    return type(own)(value, own.get_error(), own.get_timestamp()) if hasattr(own, "get_timestamp") else value


def show_field(field: Any, *, again: bool = False) -> None:
    """Publish a `Field2d` under the key that the simulation GUI displays.

    Args:
        field: Field to publish.
        again: Whether the field is already published and has changed. In 2026, such a call has no effect, because
            SmartDashboard publishes changes automatically.
    """
    wpilib = _module("wpilib")
    if not hasattr(wpilib, "SmartDashboard"):
        import_module("telemetry").log("Field", field)
    elif not again:  # SmartDashboard publishes changes automatically
        wpilib.SmartDashboard.putData("Field", field)


def module_speed(state: Any) -> float:
    """Return the speed of a `SwerveModuleState` or, in 2027, a `SwerveModuleVelocity` [m/s]."""
    return float(state.speed if hasattr(state, "speed") else state.velocity)


def pwm_speed(sim: Any) -> float:
    """Return the motor output [-1..1] that robot code requests by PWM; since 2027, for pulses of 1 to 2 ms."""
    if hasattr(sim, "getSpeed"):
        return float(sim.getSpeed())
    return max(-1.0, min(1.0, (float(sim.get_pulse_microsecond()) - 1500.0) / 500.0))


def pwm_position(sim: Any) -> float:
    """Return the servo position [0..1] that robot code requests by PWM; since 2027, for pulses of 1 to 2 ms."""
    return float(sim.getPosition()) if hasattr(sim, "getPosition") else 0.5 * (pwm_speed(sim) + 1.0)


def robot_test_plugin(robot_class: Any, robot_file: Path, patience: float) -> Any:
    """Return RobotPy's pytest plugin for a robot that is tested in a separate process.

    The plugin is part of wpilib.testing if that module is installed, and otherwise part of pyfrc.

    Args:
        robot_class: Robot class of the program.
        robot_file: Path of robot.py.
        patience: Longest wall time for the robot program to start [s], used only by the plugin of pyfrc.
    """
    if is_installed("wpilib.testing"):
        return import_module("wpilib.testing.pytest_plugin").RobotTestingPlugin(robot_class, robot_file, True)
    return import_module("pyfrc.test_support.pytest_plugin").PyFrcPlugin(robot_class, robot_file, True, patience)


def test_controller() -> Any:
    """Return the module `wpilib.testing.controller`, which starts a robot under test."""
    return import_module("wpilib.testing.controller")


def led_sim(channel: int) -> Any:
    """Return the `AddressableLEDSim` of the LED strip on a channel."""
    cls = _module("wpilib.simulation").AddressableLEDSim
    return cls.createForChannel(channel) if hasattr(cls, "createForChannel") else cls(channel)


def is_led_running(sim: Any) -> bool:
    """Return whether robot code has started an LED strip; since 2027, always True."""
    return bool(sim.getRunning()) if hasattr(sim, "getRunning") else True


def show_input_current(amps: float) -> None:
    """Set the robot controller's input current [A]; do nothing in 2027, whose simulation has no input current."""
    sim = _module("wpilib.simulation").RoboRioSim
    if hasattr(sim, "setVInCurrent"):
        sim.setVInCurrent(amps)


def start_of_clock() -> float:
    """Return the time on the robot controller's clock at which a robot under test starts [s].

    In 2026, the time is 0, because RobotPy resets the clock before each test. Since 2027, the reset has no effect,
    because the clock counts from the start of the computer. Therefore, in 2027 this function pauses the clock and steps
    the clock to the next multiple of `EPOCH`.
    """
    sim = _module("wpilib.simulation")
    if hasattr(sim.DriverStationSim, "setAutonomous"):
        return 0.0
    now = _module("wpilib").Timer.get_monotonic_timestamp
    sim.pause_timing()
    sim.step_timing(EPOCH - now() % EPOCH)
    return float(now())


def user_rails() -> list[tuple[Any, Any]]:
    """Return two setters for each user rail of the robot controller: the active state, and the number of faults.

    The rails are 6 V and 5 V, if the installed season has these rails, and then 3.3 V.
    """
    sim = _module("wpilib.simulation").RoboRioSim
    rails = [
        (getattr(sim, f"setUserActive{rail}"), getattr(sim, f"setUserFaults{rail}"))
        for rail in ("6V", "5V")
        if hasattr(sim, f"setUserActive{rail}")
    ]
    return [*rails, (sim.set_user_active_3v3, sim.set_user_faults_3v3)]


def camel_case(name: str, *, first: bool = False) -> str:
    """Convert a snake_case name of 2027 to the camelCase name of 2026, or to PascalCase if `first` is True.

    >>> camel_case("get_double_topic"), camel_case("value_all", first=True)
    ('getDoubleTopic', 'ValueAll')
    """
    head, *others = name.split("_")
    return (head.capitalize() if first else head) + "".join(word.capitalize() for word in others)


_SEASONAL = {"wpilib", "pyntcore", "pyfrc", "phoenix6", "photonlibpy"}
_SEASONAL |= {f"robotpy-{part}" for part in "hal wpimath wpinet wpiutil apriltag cscore fields".split()}
_SEASONAL |= {f"robotpy-{part}" for part in "commands-v2 wpilib-utilities rev ctre navx playingwithfusion".split()}


def installed_seasons(distributions: Iterable[tuple[str, str]]) -> dict[int, list[str]]:
    """Return the name and version of each installed WPILib or vendor package, by season.

    The version numbers of Phoenix 6 do not follow the season: versions from 26.50 to 26.99 are for 2027.

    >>> installed_seasons([("wpilib", "2026.2.2"), ("phoenix6", "26.70.0a2"), ("numpy", "2.4")])
    {2026: ['wpilib 2026.2.2'], 2027: ['phoenix6 26.70.0a2']}

    Args:
        distributions: Name and version of each package.
    """
    found: dict[int, list[str]] = {}
    for name, version in sorted(distributions):
        name = name.lower().replace("_", "-")
        numbers = version.split(".")
        if (name not in _SEASONAL and not name.startswith("robotpy-native-")) or not numbers[0].isdecimal():
            continue
        year = int(numbers[0])
        if name == "phoenix6":
            year += 2001 if year == 26 and int(numbers[1]) >= 50 else 2000
        found.setdefault(year, []).append(f"{name} {version}")
    return dict(sorted(found.items()))


def mixed_seasons(seasons: dict[int, list[str]]) -> str:
    """Return an error message if packages of several seasons are installed; empty otherwise.

    The message names the packages whose season differs from the season of WPILib.
    """
    if len(seasons) < 2:
        return ""
    main, *others = sorted(seasons, key=lambda year: (any(t.startswith("wpilib ") for t in seasons[year]), year))[::-1]
    odd = ", ".join(text for year in others for text in seasons[year])
    return f"two seasons are mixed, {odd} next to WPILib of {main}: make a new environment with one of them"


def is_installed(name: str) -> bool:
    """Return whether a module of WPILib is installed."""
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:  # the parent package is missing
        return False


def pub_sub_options(**options: Any) -> Any:
    """Return NetworkTables `PubSubOptions` from options named as in 2027, such as `periodic` and `poll_storage`."""
    options_class = _module("ntcore").PubSubOptions
    try:
        return options_class(**options)
    except TypeError:
        return options_class(**{camel_case(name): value for name, value in options.items()})


def is_local(instance: NetworkTables) -> bool:
    """Return whether a NetworkTables instance is in local mode, without a network, as under `robotpy test`."""
    modes = _module("ntcore").NetworkTableInstance.NetworkMode
    local = modes.LOCAL if hasattr(modes, "LOCAL") else modes.kNetModeLocal
    return int(instance.get_network_mode()) == int(local)


def initialize_hal() -> None:
    """Initialize the HAL in simulation, as a robot program does.

    Raises:
        ConfigError: If the HAL cannot be initialized.
    """
    hal = _module("hal")
    try:
        is_up = hal.initialize()
    except TypeError:  # 2026 requires a timeout [ms] and a mode for other running programs
        is_up = hal.initialize(500, 0)
    if not is_up:
        raise ConfigError("WPILib's hardware layer does not start; is another robot program running?")


def start_server(instance: NetworkTables, address: str, port: int) -> None:
    """Start a NetworkTables 4 server at an address and port, without a persistent file or mDNS announcement.

    NetworkTables timestamps then count from the start of the process, as in a robot program, instead of from 1970.
    """
    _module("ntcore")
    import_module("hal")  # this import only sets the clock of ntcore's timestamps
    third = "" if hasattr(type(instance), "start_ds_client") else 0  # mDNS service in 2027, NT3 port in 2026
    instance.start_server("", address, third, port)
