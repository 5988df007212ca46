"""Mechanisms: arms, elevators, flywheels, racks and rollers on motor-driven shafts; pneumatic cylinders and servos.

A shaft is a record in the arrays of the loop. The loop steps the shafts of a robot together with the robot; `step`
advances a shaft without a robot. A step is exact for a motor at constant voltage. The loop evaluates current limits,
friction reversals and hard stops every millisecond.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from simcore.errors import ConfigError
from simcore.loop.robot_state import DUTY, MECHANISM, NEUTRAL, PISTON, SERVO, SHAFT, TARGET, VOLTS, Records, records
from simcore.loop.shaft import turn_alone
from simcore.quantities import (
    ACCELERATION,
    ANGLE,
    DURATION,
    FORCE_OR_NONE,
    FRACTION,
    INERTIA,
    MASS,
    MASS_OR_NONE,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    TURN_RATE,
    DeviceKey,
    checked_number,
    require,
    require_fields,
)
from simcore.robot.dc_motor import MotorModel
from simcore.robot.gearbox import GearboxConfig, default_friction, friction_from_volts
from simcore.units import GRAVITY

__all__ = [
    "ArmConfig",
    "ArmSim",
    "ElevatorConfig",
    "ElevatorSim",
    "FlywheelConfig",
    "FlywheelSim",
    "GuessedMechanism",
    "PistonConfig",
    "PistonSim",
    "RackConfig",
    "RackSim",
    "RollerConfig",
    "RollerSim",
    "ServoConfig",
    "ServoSim",
    "ShaftSim",
    "guessed_inertia",
    "guessed_shaft",
    "place_text",
]


_USUAL_VOLTS = 1e3  # [V]; larger values take the slow check


class ShaftSim:
    """Shaft with motors, gears and an inertia, and with optional load, friction, current limits and hard stops.

    Args:
        gearbox: Motors and gears.
        inertia: Moment of inertia of all turning parts, referred to the mechanism [kg m^2].
        lower_stop: Position of the lower hard stop [rad], minus infinity without a stop; impacts are fully inelastic.
        upper_stop: Position of the upper hard stop [rad], infinity without a stop.
        position: Initial position [rad].

    Raises:
        ConfigError: If the inertia is not positive or the initial position is not between the stops.
    """

    __slots__ = (
        *("gearbox", "gearing", "inertia", "motors", "stops"),
        *("_brakes", "_mode", "_position", "_record", "_speed", "_value"),
    )

    def __init__(
        self,
        gearbox: GearboxConfig,
        inertia: float,
        *,
        lower_stop: float = -math.inf,
        upper_stop: float = math.inf,
        position: float = 0.0,
    ) -> None:
        require(type(self).__name__, "inertia", inertia, INERTIA)
        require(type(self).__name__, "position", position, ANGLE)
        if not lower_stop <= position <= upper_stop or not lower_stop < upper_stop:
            raise ConfigError(
                f"{type(self).__name__}: need lower stop <= start <= upper stop,"
                f" got {lower_stop}, {position}, {upper_stop}"
            )
        self.gearbox = gearbox
        self.inertia = inertia
        self.gearing = gearbox.gearing
        """Rotor turns per turn of the mechanism [-]."""
        self.motors = gearbox.motors
        """Number of motors on the shaft."""
        self.stops = lower_stop, upper_stop
        """Positions of the lower and upper hard stop [rad]; infinite without a stop."""
        self.record = records(SHAFT)
        model, request = self.record["model"], self.record["request"]
        for name, value in {
            "kind": MECHANISM,
            "inertia": inertia,
            "emf": gearbox.volts_per_speed,
            "resistance": gearbox.resistance,
            "winding": gearbox.motor.winding_resistance,
            "driving": gearbox.torque_per_amp,
            "driven": gearbox.torque_per_amp,
            "friction": gearbox.friction_torque,
            "stator_limit": gearbox.stator_current_limit,
            "supply_limit": gearbox.supply_current_limit,
            "count": gearbox.motors,
            "lower": lower_stop,
            "upper": upper_stop,
            "partner": -1,
        }.items():
            model[name] = value
        request["mode"], request["brakes"], self.record["position"] = VOLTS, 1, position
        self.keep_limits(math.inf, math.inf)

    @property
    def record(self) -> Records:
        """Record of this shaft in the arrays of the loop, shape (1,)."""
        return self._record

    @record.setter
    def record(self, record: Records) -> None:
        self._record, request = record, record["request"]
        # Fields read many times per tick: by name a read takes 0.23 us, by view 0.05 us.
        self._position, self._speed = record["position"], record["speed"]
        self._mode, self._value, self._brakes = request["mode"], request["value"], request["brakes"]

    @property
    def position(self) -> float:
        """Angle of the mechanism's shaft [rad]."""
        return float(self._position[0])

    @position.setter
    def position(self, angle: float) -> None:
        self._position[0] = angle

    @property
    def velocity(self) -> float:
        """Angular velocity of the mechanism's shaft [rad/s]."""
        return float(self._speed[0])

    @velocity.setter
    def velocity(self, rate: float) -> None:
        self._speed[0] = rate

    @property
    def volts(self) -> float:
        """Commanded voltage [V], which may exceed the battery voltage.

        Without a commanded voltage, as for a duty cycle, the value is the motor voltage in the last step.
        """
        return float(self._value[0] if self._mode[0] == VOLTS else self._record["volts"][0])

    @property
    def motor_output(self) -> tuple[float, float]:
        """Voltage [V] and stator current [A] of each motor at the end of the last step."""
        return float(self.record["volts"][0]), float(self.record["current"][0])

    @property
    def current(self) -> float:
        """Total stator current of all motors, averaged over the last call of `step` or of the loop [A]."""
        return float(self.record["mean_current"][0])

    @property
    def supply_current(self) -> float:
        """Total supply current of all motors, averaged like `current` [A]; negative while regenerating."""
        return float(self.record["mean_supply"][0])

    @property
    def time_constant(self) -> float:
        """Time constant of the speed at constant voltage [s]: the time in which the speed makes 63 % of a change."""
        box = self.gearbox
        return box.resistance * self.inertia / (box.torque_per_amp * box.volts_per_speed)

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of the turning parts [J]."""
        return 0.5 * self.inertia * self.velocity * self.velocity

    def set_volts(self, volts: float) -> None:
        """Command a voltage [V] from the next step on; at zero volts, the motors brake.

        Raises:
            NonFiniteError: If `volts` is NaN or infinite.
        """
        if type(volts) is not float or not abs(volts) < _USUAL_VOLTS:
            volts = checked_number(f"{type(self).__name__}: volts", volts)
        self._mode[0], self._value[0], self._brakes[0] = VOLTS, volts, 1

    def set_duty_cycle(self, share: float) -> None:
        """Command a duty cycle, clamped to -1..1, from the next step on; at zero, the motors brake.

        Raises:
            NonFiniteError: If `share` is NaN or infinite.
        """
        share = checked_number(f"{type(self).__name__}: duty cycle", share)
        self._mode[0], self._value[0], self._brakes[0] = DUTY, min(max(share, -1.0), 1.0), 1

    @property
    def load_torque(self) -> float:
        """External torque on the mechanism, positive along positive motion [N m]; an elevator adds the weight."""
        return float(self.record["request"]["load"][0])

    def set_load(self, torque: float) -> None:
        """Apply an external torque [N m] to the mechanism, positive along positive motion, from the next step on.

        Raises:
            NonFiniteError: If `torque` is NaN or infinite.
        """
        self.record["request"]["load"] = checked_number(f"{type(self).__name__}: load torque", torque)

    def keep_limits(self, stator: float, supply: float) -> None:
        """Limit each motor's stator and supply current [A] from the next step on; the gearbox's limits still apply."""
        request, box = self.record["request"], self.gearbox
        request["stator_limit"] = min(stator, box.stator_current_limit)
        request["supply_limit"] = min(supply, box.supply_current_limit)

    def coast(self) -> None:
        """Open the motor circuit, so that the mechanism coasts until the next command."""
        request = self.record["request"]
        request["mode"], request["value"], request["brakes"] = NEUTRAL, 0.0, 0

    def reset(self, position: float = 0.0, velocity: float = 0.0) -> None:
        """Set position and velocity, command zero volts, and zero the mean currents.

        Args:
            position: New position, clamped to the stops [rad].
            velocity: New velocity [rad/s].

        Raises:
            NonFiniteError: If an argument is NaN or infinite.
        """
        position = checked_number(f"{type(self).__name__}: position", position)
        velocity = checked_number(f"{type(self).__name__}: velocity", velocity)
        lower, upper = self.stops
        self.position, self.velocity = min(max(position, lower), upper), velocity
        record, request = self.record, self.record["request"]
        request["mode"], request["value"], request["brakes"] = VOLTS, 0.0, 1
        record["mean_current"] = record["mean_supply"] = 0.0

    def step(self, dt: float, battery_voltage: float = 12.0) -> None:
        """Advance a mechanism without a robot by `dt` under the last command.

        Args:
            dt: Duration, split into steps of at most 1 ms [s].
            battery_voltage: Battery voltage, which limits the motor voltage [V]; no effect on pistons and servos, which
                have a separate supply.

        Raises:
            ConfigError: If `dt` is not positive and finite, or the battery voltage is negative or not finite.
        """
        if not 0.0 < dt < math.inf:
            raise ConfigError(f"{type(self).__name__}: dt must be finite and > 0 s, got {dt}")
        if not 0.0 <= battery_voltage < math.inf:
            raise ConfigError(
                f"{type(self).__name__}: battery_voltage must be finite and >= 0 V, got {battery_voltage}"
            )
        turn_alone(self.record, 0, dt, battery_voltage)


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmConfig:
    """Config of a single-jointed arm; all angles are relative to the horizontal, positive up."""

    gearbox: GearboxConfig
    inertia: float
    """Moment of inertia about the joint, including rotors [kg m^2]."""
    mass: float = 0.0
    """Mass of all parts that turn about the joint [kg]; 0 for an arm that springs or a counterweight fully balance."""
    center_of_mass: float = 0.0
    """Distance from the joint to the center of mass [m]."""
    min_angle: float
    """Angle of the lower hard stop [rad]."""
    max_angle: float
    """Angle of the upper hard stop [rad]."""
    start_angle: float | None = None
    """Initial angle [rad]; None for the lower stop."""
    gravity: float = GRAVITY
    """Gravitational acceleration [m/s^2]; 0 for an arm that turns about a vertical axis."""
    spring_share: float = 0.0
    """Fraction of the gravity torque that springs balance, equal at all angles [-]."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            inertia=INERTIA,
            spring_share=FRACTION,
            mass=MASS_OR_NONE,
            center_of_mass=ROBOT_PLACE,
            min_angle=ANGLE,
            max_angle=ANGLE,
            start_angle=ANGLE,
            gravity=ACCELERATION,
        )
        if not self.min_angle < self.max_angle:
            raise ConfigError(f"ArmConfig: min_angle must be below max_angle, got {self.min_angle}, {self.max_angle}")
        if not self.min_angle <= self.start <= self.max_angle:
            raise ConfigError(
                f"ArmConfig: start_angle must be between the stops, min_angle = {self.min_angle:g} and max_angle = "
                f"{self.max_angle:g} rad, got {self.start_angle:g}"
            )

    @property
    def weight_torque(self) -> float:
        """Gravity torque about the joint of the horizontal arm, minus the torque of the springs [N m]."""
        return self.mass * self.gravity * self.center_of_mass * (1.0 - self.spring_share)

    @property
    def start(self) -> float:
        """Initial angle [rad]."""
        return self.min_angle if self.start_angle is None else self.start_angle


class ArmSim(ShaftSim):
    """Single-jointed arm.

    The torque balance is J dw/dt = motor + load - friction - (1 - spring_share) m g c cos(angle), where c is
    `center_of_mass`.
    """

    __slots__ = ("config",)

    def __init__(self, config: ArmConfig) -> None:
        super().__init__(
            config.gearbox,
            config.inertia,
            lower_stop=config.min_angle,
            upper_stop=config.max_angle,
            position=config.start,
        )
        self.config = config
        self.record["model"]["weight_torque"] = config.weight_torque

    @property
    def holding_volts(self) -> float:
        """Motor voltage that holds the arm at the current angle against gravity without friction [V]."""
        return self.gearbox.holding_volts(float(self.record["model"]["weight_torque"][0]) * math.cos(self.position))


@dataclass(frozen=True, slots=True, kw_only=True)
class ElevatorConfig:
    """Config of an elevator: a carriage that a motor-driven drum lifts."""

    gearbox: GearboxConfig
    carriage_mass: float
    """Mass of all parts that move with the carriage, plus rotor inertia over the drum radius squared [kg]."""
    drum_radius: float
    """Carriage travel per radian of the drum [m]."""
    min_height: float = 0.0
    """Height of the lower hard stop [m]."""
    max_height: float
    """Height of the upper hard stop [m]."""
    start_height: float | None = None
    """Initial height of the carriage [m]; None for the lower stop."""
    gravity: float = GRAVITY
    """Component of the gravitational acceleration along the elevator [m/s^2]."""
    spring_force: float = 0.0
    """Upward force of constant-force or gas springs [N]; may exceed the weight."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            carriage_mass=MASS,
            drum_radius=ROBOT_LENGTH,
            min_height=ROBOT_PLACE,
            max_height=ROBOT_PLACE,
            start_height=ROBOT_PLACE,
            gravity=ACCELERATION,
            spring_force=FORCE_OR_NONE,
        )
        if not self.min_height < self.max_height:
            raise ConfigError(
                f"ElevatorConfig: min_height must be below max_height, got {self.min_height}, {self.max_height}"
            )
        if not self.min_height <= self.start <= self.max_height:
            raise ConfigError(f"ElevatorConfig: start_height must be between the stops, got {self.start_height}")

    @property
    def weight_torque(self) -> float:
        """Drum torque that holds the carriage [N m]; negative if the spring force exceeds the weight."""
        return (self.carriage_mass * self.gravity - self.spring_force) * self.drum_radius

    @property
    def start(self) -> float:
        """Initial height of the carriage [m]."""
        return self.min_height if self.start_height is None else self.start_height


class ElevatorSim(ShaftSim):
    """Elevator with a carriage on a drum: `position` is the angle of the drum, and `height` is that of the carriage.

    The weight is constant, so a step at constant voltage is exact.
    """

    __slots__ = ("_radius", "_weight_torque", "holding_volts")

    def __init__(self, config: ElevatorConfig) -> None:
        radius = config.drum_radius
        super().__init__(
            config.gearbox,
            config.carriage_mass * radius * radius,
            lower_stop=config.min_height / radius,
            upper_stop=config.max_height / radius,
            position=config.start / radius,
        )
        self._radius = radius
        self._weight_torque = config.weight_torque
        self.holding_volts = config.gearbox.holding_volts(self._weight_torque)
        """Motor voltage that holds the carriage against gravity without friction [V]."""
        self.set_load(0.0)

    def set_load(self, torque: float) -> None:
        """Apply a torque [N m] to the drum in addition to the weight, positive upward, from the next step on."""
        super().set_load(checked_number("ElevatorSim: load torque", torque) - self._weight_torque)

    @property
    def travel_per_radian(self) -> float:
        """Carriage travel per radian of the drum [m]."""
        return self._radius

    @property
    def height(self) -> float:
        """Height of the carriage [m]."""
        return self.position * self._radius

    @property
    def speed(self) -> float:
        """Velocity of the carriage, positive up [m/s]."""
        return self.velocity * self._radius


@dataclass(frozen=True, slots=True, kw_only=True)
class FlywheelConfig:
    """Config of a flywheel: gearbox and moment of inertia."""

    gearbox: GearboxConfig
    inertia: float
    """Moment of inertia of wheels, shafts and rotors, referred to the wheel [kg m^2]."""

    def __post_init__(self) -> None:
        require_fields(self, inertia=INERTIA)


class FlywheelSim(ShaftSim):
    """Launcher wheels, spun up by motors and slowed by each shot."""

    __slots__ = ()

    def __init__(self, config: FlywheelConfig) -> None:
        super().__init__(config.gearbox, config.inertia)


@dataclass(frozen=True, slots=True, kw_only=True)
class RackConfig:
    """Config of a slide that a rack and pinion moves; all lengths are along the slide."""

    gearbox: GearboxConfig
    mass: float
    """Mass of all parts that move with the slide, plus rotor inertia over the pinion radius squared [kg]."""
    pinion_radius: float
    """Pitch radius of the pinion: slide travel per radian of the pinion [m]."""
    travel: float
    """Distance from the inner to the outer hard stop [m]."""
    start_extension: float = 0.0
    """Initial extension of the slide [m]."""

    def __post_init__(self) -> None:
        require_fields(self, mass=MASS, pinion_radius=ROBOT_LENGTH, travel=ROBOT_LENGTH, start_extension=ROBOT_PLACE)
        if not 0.0 <= self.start_extension <= self.travel:
            raise ConfigError(
                f"RackConfig: start_extension must be between 0 and {self.travel} m, got {self.start_extension}"
            )


class RackSim(ShaftSim):
    """Rack and pinion without gravity.

    `position` is the angle of the pinion, and `extension` is the travel of the slide.
    """

    __slots__ = ("_radius", "_travel")

    def __init__(self, config: RackConfig) -> None:
        radius = config.pinion_radius
        super().__init__(
            config.gearbox,
            config.mass * radius * radius,
            lower_stop=0.0,
            upper_stop=config.travel / radius,
            position=config.start_extension / radius,
        )
        self._radius = radius
        self._travel = config.travel

    @property
    def travel_per_radian(self) -> float:
        """Slide travel per radian of the pinion [m]."""
        return self._radius

    @property
    def extension(self) -> float:
        """Distance of the slide from the inner hard stop [m]."""
        return self.position * self._radius

    @property
    def speed(self) -> float:
        """Velocity of the slide, positive outward [m/s]."""
        return self.velocity * self._radius

    @property
    def extended_fraction(self) -> float:
        """Extension as a fraction of the travel: 0 at the inner stop, 1 at the outer stop [-]."""
        return self.extension / self._travel


@dataclass(frozen=True, slots=True, kw_only=True)
class RollerConfig:
    """Config of a roller: gearbox, moment of inertia and radius."""

    gearbox: GearboxConfig
    inertia: float
    """Moment of inertia of roller, shafts and rotors, referred to the roller [kg m^2]."""
    radius: float
    """Outer radius of the roller, at the contact with pieces [m]."""

    def __post_init__(self) -> None:
        require_fields(self, inertia=INERTIA, radius=ROBOT_LENGTH)


class RollerSim(ShaftSim):
    """Motor-driven roller; `set_load` can apply the torque of compressed pieces."""

    __slots__ = ("radius",)

    def __init__(self, config: RollerConfig) -> None:
        super().__init__(config.gearbox, config.inertia)
        self.radius = config.radius


_VALVE_VOLTS = 12.0
_SPEED_UP = 0.05  # [-]; time constant of the speed over stroke time. Estimate: 2 kg on a 3/4 in bore
_SERVO_VOLTS = 6.0  # [V]; the roboRIO's servo rail
_SERVO_TORQUE = 1.32  # [N m]; stall torque
_SERVO_AMPS = 2.0  # [A]; stall current. Source: REV Smart Robot Servo (REV-41-1097), 13.5 kg cm and 2 A at 6 V
_SERVO_SPEED_UP = 0.02  # [s]; time constant of a servo that turns a light part. Estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class PistonConfig:
    """Config of a pneumatic cylinder with a solenoid valve, which moves a part of the robot."""

    stroke: float
    """Distance from the retracted to the extended stop [m]."""
    stroke_time: float
    """Time from one stop to the other [s]; the flow controls determine this time."""
    is_double: bool = False
    """Whether the valve has two coils. A two-coil valve keeps the last state without power; a single-coil valve has a
    return spring."""
    springs_out: bool = False
    """Whether the cylinder of a single-coil valve extends without power; False if the cylinder retracts."""
    starts_extended: bool = False
    """Whether the cylinder is extended at the start."""

    def __post_init__(self) -> None:
        require_fields(self, stroke=ROBOT_LENGTH, stroke_time=DURATION)

    @property
    def speed(self) -> float:
        """Final speed of the rod [m/s].

        The rod starts at rest and approaches the final speed v with a time constant tau. The final speed makes the
        travel v (t - tau (1 - exp(-t / tau))) equal to the stroke at the stroke time.
        """
        tau = _SPEED_UP * self.stroke_time
        return self.stroke / (self.stroke_time - tau * -math.expm1(-self.stroke_time / tau))

    @property
    def rack(self) -> RackConfig:
        """Config of an equivalent rack.

        The force of a throttled cylinder falls linearly with speed, like the force of a rack with a DC motor.
        """
        # Only speed and time constant matter, so the mass is 1 kg and the force follows from the time constant.
        force = self.speed / (_SPEED_UP * self.stroke_time)
        motor = MotorModel(
            name="piston",
            nominal_voltage=_VALVE_VOLTS,
            stall_torque=force,
            stall_current=1.0,
            free_current=0.0,
            free_speed=self.speed,
        )
        return RackConfig(
            gearbox=GearboxConfig(motor=motor, gearing=1.0),
            mass=1.0,
            pinion_radius=1.0,
            travel=self.stroke,
            start_extension=self.stroke if self.starts_extended else 0.0,
        )


class PistonSim(RackSim):
    """Pneumatic cylinder; `position` and `extension` are the travel of the rod [m].

    A voltage of 12 V extends the rod, and -12 V retracts the rod. The air supply is unlimited. The model ignores
    compressor, tanks and the current of the coils (0.3 A).

    >>> piston = PistonSim(PistonConfig(stroke=0.2, stroke_time=0.4))
    >>> piston.set_volts(12.0)
    >>> piston.step(0.41)
    >>> piston.extension
    0.2
    """

    __slots__ = ()

    def __init__(self, config: PistonConfig) -> None:
        super().__init__(config.rack)
        model = self.record["model"]
        model["kind"], model["rail"] = PISTON, _VALVE_VOLTS
        model["idle"] = 0.0 if config.is_double else _VALVE_VOLTS if config.springs_out else -_VALVE_VOLTS
        super().set_volts(_VALVE_VOLTS if config.starts_extended else -_VALVE_VOLTS)

    def set_volts(self, volts: float) -> None:
        """Power the valve: a positive voltage extends the rod, and a negative voltage retracts the rod.

        At zero volts, a spring returns a single-coil valve to the idle state. A two-coil valve keeps the last state.
        """
        volts = checked_number("PistonSim: volts", volts)
        if volts == 0.0:
            volts = float(self.record["model"]["idle"][0])
        if volts != 0.0:
            super().set_volts(math.copysign(_VALVE_VOLTS, volts))

    def coast(self) -> None:
        """Cut the power of the valve, like `set_volts` with zero volts."""
        self.set_volts(0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoConfig:
    """Config of a servo that turns a part between two angles."""

    min_angle: float
    """Angle at the lower end of the travel [rad]."""
    max_angle: float
    """Angle at the upper end of the travel [rad]."""
    speed: float
    """No-load speed at 6 V [rad/s]. Datasheets usually give the time for 60 degrees instead."""
    start_angle: float | None = None
    """Initial angle [rad]; None for the lower end."""

    def __post_init__(self) -> None:
        require_fields(self, min_angle=ANGLE, max_angle=ANGLE, speed=TURN_RATE, start_angle=ANGLE)
        if not self.min_angle < self.max_angle:
            raise ConfigError(f"ServoConfig: min_angle must be below max_angle, got {self.min_angle}, {self.max_angle}")

    @property
    def arm(self) -> ArmConfig:
        """Config of an equivalent arm without weight.

        The gearbox has the torque and speed of the servo, and the inertia gives the arm the time constant of the servo.
        """
        motor = MotorModel(
            name="servo",
            nominal_voltage=_SERVO_VOLTS,
            stall_torque=_SERVO_TORQUE,
            stall_current=_SERVO_AMPS,
            free_current=0.0,
            free_speed=self.speed,
        )
        return ArmConfig(
            gearbox=GearboxConfig(motor=motor, gearing=1.0),
            inertia=_SERVO_SPEED_UP * _SERVO_TORQUE / self.speed,
            min_angle=self.min_angle,
            max_angle=self.max_angle,
            start_angle=self.start_angle,
        )


class ServoSim(ArmSim):
    """Servo with an internal position controller; without a signal, the servo holds the current angle.

    The controller is proportional. The gain is the highest gain without overshoot: (volts / speed) / (4 tau) for a
    motor with the time constant tau. The servo slows down in the last 4 tau of a motion.

    >>> servo = ServoSim(ServoConfig(min_angle=0.0, max_angle=1.0, speed=8.0))
    >>> servo.set_goal(0.5)
    >>> servo.step(0.5)
    >>> round(servo.position, 3)
    0.5
    """

    __slots__ = ()

    def __init__(self, config: ServoConfig) -> None:
        super().__init__(config.arm)
        model = self.record["model"]
        model["kind"], model["rail"] = SERVO, _SERVO_VOLTS
        model["kp"] = self.gearbox.volts_per_speed / (4.0 * _SERVO_SPEED_UP)
        self.coast()

    @property
    def goal(self) -> float:
        """Goal angle [rad]; equal to the current angle without a signal."""
        request = self.record["request"]
        return self.position if request["mode"][0] != TARGET else float(request["value"][0])

    def set_goal(self, angle: float) -> None:
        """Set the goal angle [rad], clamped to the travel."""
        require("ServoSim", "goal", angle, ANGLE)
        lower, upper = self.stops
        request = self.record["request"]
        request["mode"], request["value"], request["brakes"] = TARGET, min(max(angle, lower), upper), 1

    def coast(self) -> None:
        """Cut the signal: the servo stops at once, and the gears hold the angle."""
        super().coast()
        self.velocity = 0.0


_SPIN_UP = 0.05  # [s]; time constant of a mechanism without a kA. Estimate: rollers have .02 to .1, shooters .1 to .5


@dataclass(frozen=True, slots=True, kw_only=True)
class GuessedMechanism:
    """Mechanism of a group of motor controllers, guessed from the controllers' configuration.

    With a guessed mechanism, velocity and position loops reach their setpoints, so at-setpoint checks in robot code
    work. A gravity gain implies a matching weight. A table in `simcore.toml` can describe the real mechanism instead.
    """

    mechanism: ShaftSim
    motor: str
    arm_gain: str = "kG"
    """Name of the gain that holds an arm against gravity."""
    sensors: tuple[DeviceKey, ...] = ()
    """Model and address of each other device that reports the position of the mechanism."""

    has_wired_sensor: bool = False
    """Whether an encoder wired to the controller reports the mechanism's position."""

    @property
    def has_weight(self) -> bool:
        """Whether gravity acts on the mechanism."""
        return isinstance(self.mechanism, ArmSim) or self.mechanism.load_torque != 0.0

    def __str__(self) -> str:
        m = self.mechanism
        text = f"{m.motors} x {self.motor}, {m.gearing:.3g}:1, {m.inertia:.2g} kg m^2"
        if isinstance(m, ArmSim):
            return f"{text}, weight of its {self.arm_gain} as an arm"
        return text + (", weight of its kG" if self.has_weight else "")


def guessed_inertia(gearbox: GearboxConfig, spin_up: float = _SPIN_UP) -> float:
    """Compute the moment of inertia at the mechanism that gives a speed time constant of `spin_up` seconds [kg m^2]."""
    return spin_up * gearbox.torque_per_amp / gearbox.resistance * gearbox.volts_per_speed


def guessed_shaft(
    gearbox: GearboxConfig,
    *,
    static: float = 0.0,
    kv: float = 0.0,
    ka: float = 0.0,
    weight: float = 0.0,
    arm: tuple[float, float] | None = None,
) -> ShaftSim:
    """Build a shaft at rest with friction, inertia and weight from a controller's gains.

    A shaft with a constant weight starts at position 0 on a hard stop. The stop is the lower stop for a positive
    kG, and the upper stop for a negative kG. A negative kG means that a spring pulls up, or that the position decreases
    upward.

    Args:
        gearbox: Motors and gears.
        static: Gain kS [V]; 0 for the default friction of a controller without kS.
        kv: Gain kV, in the velocity unit of `ka`; the time constant is ka / kv, or 50 ms if either gain is 0.
        ka: Gain kA, in the velocity unit of `kv`.
        weight: Gain kG, for an arm at the horizontal [V]; 0 for a shaft without weight or stops.
        arm: Lower stop and initial angle of an arm [rad]; None for a weight that does not depend on the position.
    """
    friction = friction_from_volts(gearbox, static) if static else default_friction(gearbox)
    gearbox = replace(gearbox, friction_torque=friction)
    inertia = guessed_inertia(gearbox, ka / kv if ka > 0.0 and kv > 0.0 else _SPIN_UP)
    torque = weight * gearbox.torque_per_amp / gearbox.resistance
    if torque == 0.0:
        return ShaftSim(gearbox, inertia)
    if arm is None:
        shaft = ShaftSim(gearbox, inertia, **{"lower_stop" if torque > 0.0 else "upper_stop": 0.0})
        shaft.set_load(-torque)
        return shaft
    low, start = arm
    return ArmSim(
        ArmConfig(
            gearbox=gearbox,
            inertia=inertia,
            mass=torque,
            center_of_mass=1.0,
            gravity=1.0,  # only the product of weight and lever arm is known and needed
            min_angle=low,
            max_angle=start + math.pi,
            start_angle=start,
        )
    )


def place_text(mechanism: ShaftSim, position: float) -> str:
    """Format a shaft position [rad]: as degrees for an arm, meters for an elevator or rack, and turns otherwise."""
    if isinstance(mechanism, ArmSim):
        return f"{math.degrees(position):.0f} deg"
    if isinstance(mechanism, ElevatorSim | RackSim):
        return f"{position * mechanism.travel_per_radian:.2f} m"
    return f"{position / math.tau:.1f} turns"
