"""Mechanisms: a motor-driven shaft as arm, elevator, flywheel, rack or roller; pneumatic cylinders and servos.

A shaft is a record in the arrays of the loop, which steps it together with its robot; `step` advances a shaft on its
own. A step of the loop is exact for a motor at constant voltage; current limits, reversing friction and hard stops are
evaluated every millisecond.
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


_USUAL_VOLTS = 1e3  # [V]; what is beyond is looked at twice


class ShaftSim:
    """Motors, a gear and an inertia, with optional load, friction, current limit and hard stops.

    Args:
        gearbox: Motors and gears.
        inertia: Inertia of all turning parts, seen at the mechanism [kg m^2].
        lower_stop: Hard stop [rad]; an impact on it is fully inelastic.
        upper_stop: Hard stop [rad].
        position: Initial position [rad].

    Raises:
        ConfigError: The inertia is not positive, or the initial position is not between the stops.
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
        """Number of motors that share the current."""
        self.stops = lower_stop, upper_stop
        """Lower and upper hard stop [rad]; infinite without a stop."""
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
        """Record of this shaft in the arrays of the loop, shape (1,); a world's loop has those of all its robots."""
        return self._record

    @record.setter
    def record(self, record: Records) -> None:
        self._record, request = record, record["request"]
        # Fields that are asked for many times a tick: by name one takes 0.23 us, so 0.05.
        self._position, self._speed = record["position"], record["speed"]
        self._mode, self._value, self._brakes = request["mode"], request["value"], request["brakes"]

    @property
    def position(self) -> float:
        """Angle of the mechanism [rad]."""
        return float(self._position[0])

    @position.setter
    def position(self, angle: float) -> None:
        self._position[0] = angle

    @property
    def velocity(self) -> float:
        """Angular velocity of the mechanism [rad/s]."""
        return float(self._speed[0])

    @velocity.setter
    def velocity(self, rate: float) -> None:
        self._speed[0] = rate

    @property
    def volts(self) -> float:
        """Commanded voltage, before the battery limits it, or the voltage of a duty cycle [V]; `set_volts` sets it."""
        return float(self._record["volts"][0] if self._mode[0] == DUTY else self._value[0])

    @property
    def motor_output(self) -> tuple[float, float]:
        """Voltage at each motor [V] and current in it [A] at the end of the last step."""
        return float(self.record["volts"][0]), float(self.record["current"][0])

    @property
    def current(self) -> float:
        """Stator current of all motors together, mean over the last step [A]."""
        return float(self.record["mean_current"][0])

    @property
    def supply_current(self) -> float:
        """Supply current of all motors together, mean over the last step; negative while regenerating [A]."""
        return float(self.record["mean_supply"][0])

    @property
    def time_constant(self) -> float:
        """Time in which the speed covers 63 % of the difference to its final value [s]."""
        box = self.gearbox
        return box.resistance * self.inertia / (box.torque_per_amp * box.volts_per_speed)

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of the turning parts [J]."""
        return 0.5 * self.inertia * self.velocity * self.velocity

    def set_volts(self, volts: float) -> None:
        """Apply this voltage from the next step on; zero volts brake.

        Raises:
            NonFiniteError: `volts` is NaN or infinite.
        """
        if type(volts) is not float or not abs(volts) < _USUAL_VOLTS:
            volts = checked_number(f"{type(self).__name__}: volts", volts)
        self._mode[0], self._value[0], self._brakes[0] = VOLTS, volts, 1

    def set_duty_cycle(self, share: float) -> None:
        """Apply this fraction of the battery voltage from the next step on, -1 to 1; zero brakes.

        Raises:
            NonFiniteError: `share` is NaN or infinite.
        """
        share = checked_number(f"{type(self).__name__}: duty cycle", share)
        self._mode[0], self._value[0], self._brakes[0] = DUTY, min(max(share, -1.0), 1.0), 1

    @property
    def load_torque(self) -> float:
        """External torque on the mechanism, along positive motion [N m]."""
        return float(self.record["request"]["load"][0])

    def set_load(self, torque: float) -> None:
        """Apply this external torque [N m], along positive motion, from the next step on."""
        self.record["request"]["load"] = checked_number(f"{type(self).__name__}: load torque", torque)

    def keep_limits(self, stator: float, supply: float) -> None:
        """Limit each motor's stator and supply current [A] from the next step on, within the gearbox's own limits."""
        request, box = self.record["request"], self.gearbox
        request["stator_limit"] = min(stator, box.stator_current_limit)
        request["supply_limit"] = min(supply, box.supply_current_limit)

    def coast(self) -> None:
        """Open the circuit: no current flows until the next command."""
        request = self.record["request"]
        request["mode"], request["value"], request["brakes"] = NEUTRAL, 0.0, 0

    def reset(self, position: float = 0.0, velocity: float = 0.0) -> None:
        """Set position and velocity, and command zero volts."""
        position = checked_number(f"{type(self).__name__}: position", position)
        velocity = checked_number(f"{type(self).__name__}: velocity", velocity)
        lower, upper = self.stops
        self.position, self.velocity = min(max(position, lower), upper), velocity
        record, request = self.record, self.record["request"]
        request["mode"], request["value"], request["brakes"] = VOLTS, 0.0, 1
        record["mean_current"] = record["mean_supply"] = 0.0

    def step(self, dt: float, battery_voltage: float = 12.0) -> None:
        """Advance by `dt` at the held voltage; for a mechanism that belongs to no robot.

        Args:
            dt: Duration, split into steps of 1 ms or less [s].
            battery_voltage: Limit of the motors' voltage, in both directions [V].

        Raises:
            ConfigError: `dt` is not positive or a number is NaN.
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
    """Arm with its drive and range. Angles are from the horizontal, up positive."""

    gearbox: GearboxConfig
    inertia: float
    """Moment of inertia about the joint, rotors included [kg m^2]."""
    mass: float = 0.0
    """Mass of all parts that swing; 0 for an arm that springs or a counterweight fully balance [kg]."""
    center_of_mass: float = 0.0
    """Distance from the joint to the center of mass [m]."""
    min_angle: float
    """Lower hard stop [rad]."""
    max_angle: float
    """Upper hard stop [rad]."""
    start_angle: float | None = None
    """Initial angle; None: the lower stop [rad]."""
    gravity: float = GRAVITY
    """Gravitational acceleration; zero for an arm that turns about a vertical axis [m/s^2]."""
    spring_share: float = 0.0
    """Fraction of gravity's torque, at any angle, that springs carry [-]."""

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
        """Torque that the motors hold while the arm is level [N m]."""
        return self.mass * self.gravity * self.center_of_mass * (1.0 - self.spring_share)

    @property
    def start(self) -> float:
        """Initial angle [rad]."""
        return self.min_angle if self.start_angle is None else self.start_angle


class ArmSim(ShaftSim):
    """Single-jointed arm: J dw/dt = motor - m g c cos(angle) + load."""

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
        """Voltage that holds the arm at its current angle against gravity [V]."""
        return self.gearbox.holding_volts(float(self.record["model"]["weight_torque"][0]) * math.cos(self.position))


@dataclass(frozen=True, slots=True, kw_only=True)
class ElevatorConfig:
    """Elevator carriage with its drive and range."""

    gearbox: GearboxConfig
    carriage_mass: float
    """Mass of all lifted parts, rotor inertia over radius squared included [kg]."""
    drum_radius: float
    """Carriage travel per rad of the drum [m]."""
    min_height: float = 0.0
    """Lower hard stop [m]."""
    max_height: float
    """Upper hard stop [m]."""
    start_height: float | None = None
    """Initial height of the carriage; None: the lower stop [m]."""
    gravity: float = GRAVITY
    """Gravitational acceleration along the elevator [m/s^2]."""
    spring_force: float = 0.0
    """Upward force of constant-force or gas springs; may exceed the weight [N]."""

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
        """Torque at the drum that the motors hold; negative if springs push the carriage up [N m]."""
        return (self.carriage_mass * self.gravity - self.spring_force) * self.drum_radius

    @property
    def start(self) -> float:
        """Initial height [m]."""
        return self.min_height if self.start_height is None else self.start_height


class ElevatorSim(ShaftSim):
    """Elevator; `position` is the angle of the drum, `height` that of the carriage. Exact, as gravity is constant."""

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
        """Voltage that holds the carriage against gravity [V]."""
        self.set_load(0.0)

    def set_load(self, torque: float) -> None:
        """Apply this torque [N m] to the drum in addition to the weight, along positive motion."""
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
        """Speed of the carriage, upward positive [m/s]."""
        return self.velocity * self._radius


@dataclass(frozen=True, slots=True, kw_only=True)
class FlywheelConfig:
    """Flywheel with its drive."""

    gearbox: GearboxConfig
    inertia: float
    """Inertia of wheels, shafts and rotors, seen at the wheel [kg m^2]."""

    def __post_init__(self) -> None:
        require_fields(self, inertia=INERTIA)


class FlywheelSim(ShaftSim):
    """Launcher wheels: the motors spin them up, and each shot takes energy from them."""

    __slots__ = ()

    def __init__(self, config: FlywheelConfig) -> None:
        super().__init__(config.gearbox, config.inertia)


@dataclass(frozen=True, slots=True, kw_only=True)
class RackConfig:
    """Slide on a rack with its drive and range. Lengths are along the slide."""

    gearbox: GearboxConfig
    mass: float
    """Mass of all sliding parts, rotor inertia over radius squared included [kg]."""
    pinion_radius: float
    """Pitch radius of the pinion: slide travel per rad of the pinion [m]."""
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
    """Rack on a pinion without gravity; `position` is the pinion's angle, `extension` the travel of the slide."""

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
        """Distance from the inner stop [m]."""
        return self.position * self._radius

    @property
    def speed(self) -> float:
        """Speed of the slide, outward positive [m/s]."""
        return self.velocity * self._radius

    @property
    def extended_fraction(self) -> float:
        """Extension as a fraction of the travel: 0 at the inner stop, 1 at the outer one [-]."""
        return self.extension / self._travel


@dataclass(frozen=True, slots=True, kw_only=True)
class RollerConfig:
    """Roller with its drive."""

    gearbox: GearboxConfig
    inertia: float
    """Inertia seen at the roller [kg m^2]."""
    radius: float
    """Radius of the surface that touches the pieces [m]."""

    def __post_init__(self) -> None:
        require_fields(self, inertia=INERTIA, radius=ROBOT_LENGTH)


class RollerSim(ShaftSim):
    """Roller on a motor; squeezed pieces act as a load (`set_load`)."""

    __slots__ = ("radius",)

    def __init__(self, config: RollerConfig) -> None:
        super().__init__(config.gearbox, config.inertia)
        self.radius = config.radius


_VALVE_VOLTS = 12.0
_SPEED_UP = 0.05  # [-]; fraction of the stroke time to get up to speed. Estimate: 2 kg on a 3/4 in bore
_SERVO_VOLTS = 6.0  # [V]; the roboRIO's servo rail
_SERVO_TORQUE = 1.32  # [N m], and
_SERVO_AMPS = 2.0  # [A], both at stall. Source: REV Smart Robot Servo (REV-41-1097), 13.5 kg cm and 2 A at 6 V
_SERVO_SPEED_UP = 0.02  # [s]; time constant of a servo that swings a light part. Estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class PistonConfig:
    """Pneumatic cylinder on a solenoid valve, and the part that it pushes."""

    stroke: float
    """Distance from the retracted to the extended stop [m]."""
    stroke_time: float
    """Time from one stop to the other, as set by the flow controls [s]."""
    is_double: bool = False
    """Whether the valve has two coils and keeps its state without power; a single-coil valve returns by a spring."""
    springs_out: bool = False
    """Whether the spring of a single-coil valve extends the cylinder without power; False: it retracts it."""
    starts_extended: bool = False
    """Whether the cylinder is extended at the start."""

    def __post_init__(self) -> None:
        require_fields(self, stroke=ROBOT_LENGTH, stroke_time=DURATION)

    @property
    def speed(self) -> float:
        """Speed of the rod once it is up to speed [m/s].

        The travel from rest with a time constant tau is v (t - tau (1 - exp(-t / tau))); it equals the stroke after the
        stroke time.
        """
        tau = _SPEED_UP * self.stroke_time
        return self.stroke / (self.stroke_time - tau * -math.expm1(-self.stroke_time / tau))

    @property
    def rack(self) -> RackConfig:
        """Equivalent slide: the force of a throttled cylinder falls linearly with speed, like that of a DC motor."""
        # Only speed and time constant matter: one kilogram, and the force that gives it that time constant.
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
    """Cylinder: `position` and `extension` are those of its rod [m], `volts` is 12 to extend and -12 to retract.

    The air supply is unlimited: compressor and tanks are not modelled, nor is the coil's current (0.3 A).

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
        """Power the valve: positive volts extend the rod, negative ones retract it.

        Without power a single-coil valve returns by its spring; a valve with two coils keeps its state.
        """
        volts = checked_number("PistonSim: volts", volts)
        if volts == 0.0:
            volts = float(self.record["model"]["idle"][0])
        if volts != 0.0:
            super().set_volts(math.copysign(_VALVE_VOLTS, volts))

    def coast(self) -> None:
        """Cut power to the valve."""
        self.set_volts(0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoConfig:
    """Servo, and the part that it turns between two angles."""

    min_angle: float
    """Lower end of the travel [rad]."""
    max_angle: float
    """Upper end of the travel [rad]."""
    speed: float
    """No-load speed at 6 V [rad/s]; data sheets give the time for 60 degrees."""
    start_angle: float | None = None
    """Initial angle; None: the lower end [rad]."""

    def __post_init__(self) -> None:
        require_fields(self, min_angle=ANGLE, max_angle=ANGLE, speed=TURN_RATE, start_angle=ANGLE)
        if not self.min_angle < self.max_angle:
            raise ConfigError(f"ServoConfig: min_angle must be below max_angle, got {self.min_angle}, {self.max_angle}")

    @property
    def arm(self) -> ArmConfig:
        """Equivalent weightless arm: the servo's motor and gear, and an inertia that gives its time constant."""
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
    """Servo: its own controller drives it to `goal` at the rate of its motor; without a signal it holds still.

    The controller is proportional, with the highest gain that does not overshoot: with a motor's time constant tau that
    is a quarter of (speed / volts) / tau, and the last 4 tau of the motion are slower.

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
        """Goal angle [rad]; the current angle without a signal."""
        request = self.record["request"]
        return self.position if request["mode"][0] != TARGET else float(request["value"][0])

    def set_goal(self, angle: float) -> None:
        """Set the goal angle [rad], clamped to the travel."""
        require("ServoSim", "goal", angle, ANGLE)
        lower, upper = self.stops
        request = self.record["request"]
        request["mode"], request["value"], request["brakes"] = TARGET, min(max(angle, lower), upper), 1

    def coast(self) -> None:
        """Cut the signal: the gear holds the servo in place."""
        super().coast()
        self.velocity = 0.0


_SPIN_UP = 0.05  # [s]; time constant without a kA. Estimate: rollers have .02 to .1, shooters .1 to .5


@dataclass(frozen=True, slots=True, kw_only=True)
class GuessedMechanism:
    """Mechanism that a group of motor controllers probably drives, guessed from their configuration.

    The guess makes at-setpoint logic work: velocity loops spin up, position loops arrive, and gravity gains find the
    weight that they hold. It models no particular mechanism; `simcore.toml` describes the real one.
    """

    mechanism: ShaftSim
    motor: str
    arm_gain: str = "kG"
    """Name of the gain whose volts hold an arm."""
    sensors: tuple[DeviceKey, ...] = ()
    """Further devices that report its position."""

    has_wired_sensor: bool = False
    """Whether an encoder wired to the controller reports its position."""

    @property
    def has_weight(self) -> bool:
        """Whether gravity acts on it."""
        return isinstance(self.mechanism, ArmSim) or self.mechanism.load_torque != 0.0

    def __str__(self) -> str:
        m = self.mechanism
        text = f"{m.motors} x {self.motor}, {m.gearing:.3g}:1, {m.inertia:.2g} kg m^2"
        if isinstance(m, ArmSim):
            return f"{text}, weight of its {self.arm_gain} as an arm"
        return text + (", weight of its kG" if self.has_weight else "")


def guessed_inertia(gearbox: GearboxConfig, spin_up: float = _SPIN_UP) -> float:
    """Return the inertia at the mechanism with which the motors reach 63 % of their speed within `spin_up` [kg m^2]."""
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
    """Build a free shaft, or with a weight one that starts at rest on a hard stop.

    A weight that pulls up (a negative kG: a spring, or a position that counts down) starts on the upper stop.

    Args:
        gearbox: Motors and gears.
        static: kS [V]; 0: not tuned, so that the friction is the motors' default.
        kv: kV, in the unit of `ka`; their quotient is the time constant, 50 ms where they are not tuned.
        ka: kA; see `kv`.
        weight: kG [V]; of an arm when level.
        arm: Lower stop and initial angle of an arm [rad]; None: the load does not depend on the angle.
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
            gravity=1.0,  # only the product of mass and lever arm is known, and only that is needed
            min_angle=low,
            max_angle=start + math.pi,
            start_angle=start,
        )
    )


def place_text(mechanism: ShaftSim, position: float) -> str:
    """Format a position [rad] in the usual unit of its kind of mechanism."""
    if isinstance(mechanism, ArmSim):
        return f"{math.degrees(position):.0f} deg"
    if isinstance(mechanism, ElevatorSim | RackSim):
        return f"{position * mechanism.travel_per_radian:.2f} m"
    return f"{position / math.tau:.1f} turns"
