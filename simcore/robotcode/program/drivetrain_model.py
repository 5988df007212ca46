"""Model configuration of a found drivetrain, and the ports between the model and the program's devices."""

from __future__ import annotations

import logging
import math
from typing import Any

from simcore import season
from simcore.errors import ConfigError
from simcore.quantities import DeviceKey
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.fixed_wheel_drive import MecanumDrive, TankDrive
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot.wheel_config import MOST_FRICTION, plate_inertia
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robotcode.program.drivetrain_measures import MODULE_MEASURES
from simcore.robotcode.program.found_drivetrain import FoundDrivetrain, FoundWheel
from simcore.robotcode.program.makers import maker_of
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.motor_ports import (
    AnglePort,
    DrivetrainPorts,
    MotorPort,
    Setpoint,
    ShaftPorts,
    SwervePorts,
)
from simcore.robotcode.program.program_odometry import on_wheel_distances

__all__ = ["connect_drivetrain", "drivetrain_config"]

_log = logging.getLogger(__name__)

_SIDE_MEASURES = {
    "drive_gearing": "gearing",
    "wheel_radius": "wheel_radius",
    "wheel_cof": "wheel_cof",
    "drive_stator_limit": "stator_limit",
    "drive_supply_limit": "supply_limit",
}


def drivetrain_config(found: FoundDrivetrain, settings: RobotSettings) -> SwerveConfig | TankConfig | MecanumConfig:
    """Return the model configuration of a drivetrain with complete measures.

    Args:
        found: Drivetrain from `complete_measures`.
        settings: Settings of simcore.toml: mass, bumpers, height of the center of mass.

    Raises:
        ConfigError: A measure is out of range.
    """
    measures = {name: m.value for name, m in found.measures.items()}
    mass = measures.get("mass", settings.mass)
    bumper = settings.with_bumper_around(found.places).bumper
    assert bumper is not None
    inertia = measures.get("yaw_inertia") or plate_inertia(mass, *bumper)
    center = (0.0, 0.0, settings.center_of_mass_height)
    cof = measures.get("wheel_cof", settings.wheel_cof)
    if found.kind == "swerve":
        given = {name: measures[name] for name in MODULE_MEASURES if name in measures}
        modules = tuple(
            SwerveModuleConfig(
                **{
                    **given,
                    **_own_friction(found, "drive_friction_volts"),
                    "name": wheel.name.split(".")[-1] if not wheel.name.split(".")[-1].isdigit() else f"module {k}",
                    "x": wheel.place[0],
                    "y": wheel.place[1],
                    "wheel_cof": cof,
                    "drive_motor": motor(measures["drive_motor"]),
                    "steer_motor": motor(measures["steer_motor"]),
                }
            )
            for k, wheel in enumerate(found.wheels)
        )
        return SwerveConfig(modules=modules, mass=mass, yaw_inertia=inertia, center_of_mass=center)
    shafts: dict[str, Any] = {own: measures[name] for name, own in _SIDE_MEASURES.items() if name in measures}
    if "wheel_cof" in measures or "tread" in settings.given:
        shafts["wheel_cof"] = cof
    shafts |= {"mass": mass, "yaw_inertia": inertia, "center_of_mass": center, "motor": motor(measures["drive_motor"])}
    shafts |= _own_friction(found, "friction_volts")
    motors = max(len(wheel.motors) for wheel in found.wheels)
    if found.kind == "mecanum":
        return MecanumConfig(**shafts, places=found.places, motors_per_wheel=motors)
    own = {name: measures[name] for name in ("trackwidth", "dropped_center") if name in measures}
    return TankConfig(**shafts, **own, motors_per_side=motors)


def _own_friction(found: FoundDrivetrain, name: str) -> dict[str, float]:
    """Return the friction argument of the model configuration from the drive motors' kS; empty without a valid kS."""
    measures, device = found.measures, found.wheels[0].motors[0]
    gearing = float(measures["drive_gearing"].value) if "drive_gearing" in measures else 1.0
    gearbox = GearboxConfig(motor=motor(measures["drive_motor"].value), gearing=gearing)
    try:
        volts = maker_of(device).friction_volts(device, gearbox)
    except ConfigError as error:
        _log.warning("the drivetrain keeps the default friction of its kind: %s", error)
        return {}
    return {name: volts} if 0.0 < volts < MOST_FRICTION else {}


def connect_drivetrain(found: FoundDrivetrain, drive: SwerveDrive | TankDrive | MecanumDrive) -> DrivetrainPorts:
    """Return ports that connect the program's devices to the drivetrain's model.

    Args:
        found: Drivetrain with complete measures.
        drive: Model of the drivetrain.

    Raises:
        ConfigError: Two wheels share a device, or a device does not respond.
    """
    _require_own(found)
    gyro = None if found.gyro is None else maker_of(found.gyro).gyro_port(found.gyro)
    drives = [[_motor_port(d) for d in wheel.motors] for wheel in found.wheels]
    radius = float(found.measure("wheel_radius"))
    wheels = [_wheel_encoder(wheel, radius, row[0]) for wheel, row in zip(found.wheels, drives, strict=True)]
    ports: DrivetrainPorts
    if not isinstance(drive, SwerveDrive):
        mounted = [[_Mounted(port, w.drive_sign) for port in row] for w, row in zip(found.wheels, drives, strict=True)]
        if any(found.measures[name].is_guess for name in ("wheel_radius", "drive_gearing") if name in found.measures):
            turn = math.tau * radius / float(found.measure("drive_gearing"))
            ways = []
            for wheel, row in zip(wheels, mounted, strict=True):
                ways.append(_Way(row[0], turn) if wheel is None else _Way(wheel, radius))
                for sensor in (*row, *filter(None, [wheel])):
                    sensor.way = ways[-1]

            def note(reported: list[float]) -> None:
                for way, distance in zip(ways, reported, strict=False):
                    way.note(distance)

            on_wheel_distances(note)
        ports = ShaftPorts(drive, mounted, encoders=wheels, gyro=gyro)
    else:
        steers = [_motor_port(wheel.steer) for wheel in found.wheels]
        gearings = [m.steer_gearing for m in drive.config.modules]
        unknown: list[_DecidingMotor] = []
        ports = SwervePorts(
            drive,
            [_Mounted(row[0], w.drive_sign) for row, w in zip(drives, found.wheels, strict=True)],
            [
                _Mounted(port, w.steer_sign, -w.zero * g / math.tau)
                if w.is_steer_sign_known
                else _DecidingMotor(port, w.steer_sign, -w.zero * g / math.tau, g, unknown)
                for port, w, g in zip(steers, found.wheels, gearings, strict=True)
            ],
            steer_encoders=[_azimuth(w, port) for w, port in zip(found.wheels, steers, strict=True)],
            wheel_encoders=wheels,
            gyro=gyro,
        )
    ports.devices = found.keys
    return ports


def _require_own(found: FoundDrivetrain) -> None:
    owners: dict[DeviceKey, str] = {}
    for wheel in found.wheels:
        for device in wheel.devices:
            if device.key in owners:
                raise ConfigError(f"drivetrain: {device} is in {owners[device.key]} and in {wheel.name}")
            owners[device.key] = wheel.name


def _motor_port(device: BuiltDevice | None) -> MotorPort:
    assert device is not None, "a swerve module has two motors"
    return maker_of(device).motor_port(device)


def _azimuth(wheel: FoundWheel, steer: MotorPort) -> AnglePort | None:
    if wheel.encoder is None:
        return None
    port = maker_of(wheel.encoder).encoder_port(wheel.encoder, steer)
    return _Shaft(port, wheel.encoder_sign * wheel.encoder_turns, wheel.zero)


def _wheel_encoder(wheel: FoundWheel, radius: float, drive: MotorPort) -> _Shaft | None:
    if wheel.wheel_encoder is None:
        return None
    way = wheel.meters_per_encoder_turn
    port = maker_of(wheel.wheel_encoder).encoder_port(wheel.wheel_encoder, drive)
    return _Shaft(port, 1.0 if way is None else math.tau * radius / way, 0.0)


class _Counter:
    """Sensor with a scale on the reading that makes the program's odometry agree with the distance in the model."""

    way: _Way | None = None
    turned = shown = 0.0
    """Position in the model, and scaled position written to the sensor: rotor [rotations], encoder [rad]."""

    @property
    def factor(self) -> float:
        """Correction of the sensor's scale for a guessed gearing or wheel radius [-]; 1 without a correction."""
        return 1.0 if self.way is None else self.way.factor

    def _count(self, turned: float) -> float:
        self.turned, self.shown = turned, self.factor * turned
        return self.shown


class _Way:
    """Estimate of a sensor's scale from the program's odometry, for a guessed gearing or wheel radius.

    Args:
        sensor: Sensor of a wheel or side that the program reads.
        meters: Modelled distance per unit of sensor position [m].
    """

    def __init__(self, sensor: _Counter, meters: float) -> None:
        self.factor = 1.0
        self._sensor, self._meters = sensor, meters
        self._begin = (0.0, 0.0, 0.0)
        self._next = -1.0
        self._last = 0.0, 0.0  # distance in the program and position of the sensor, one loop earlier

    def note(self, reported: float) -> None:
        """Record the wheel or side distance in the program's odometry [m], and update the scale."""
        sensor, (reported_before, shown_before) = self._sensor, self._last
        self._last, jump = (reported, sensor.shown), abs(reported - reported_before)
        if self._next < 0.0 or jump > _JUMP or not season.wpilib.RobotState.is_enabled():
            self._begin = reported, sensor.turned, sensor.shown
            self._next = max(self._next, _FIRST_WAY)
            return
        rolled = abs(sensor.turned - self._begin[1]) * self._meters
        if rolled < self._next or reported == self._begin[0]:
            return
        self._next *= 2.0
        # The odometry used a reading from some time in the last loop, so the ratio is between these two bounds, which
        # converge with distance.
        reported_turns = (reported - self._begin[0]) / self._meters
        least, most = sorted(abs((shown - self._begin[2]) / reported_turns) for shown in (shown_before, sensor.shown))
        factor = 1.0 if 0.99 * least < 1.0 < 1.01 * most else 0.5 * (least + most)
        if abs(factor / self.factor - 1.0) > 0.01 and 1.0 / _MOST < factor < _MOST:
            _log.info("drivetrain: the program's odometry counts %.3g m per guessed meter", 1.0 / factor)
            self.factor = factor


_FIRST_WAY = 0.05  # [m], travel before the first estimate
_JUMP = 0.5  # [m], largest change within one loop that is not a reset of the encoder
_MOST = 50.0  # largest correction factor of a guess; inches give 39


class _Mounted(_Counter, MotorPort):
    """Motor port with a sign and a zero offset between robot code and the model.

    Args:
        port: Port of the motor.
        sign: -1 if the positive direction in robot code is negative in the model, else 1.
        ahead: Rotor position of the motor minus that of the model, with the model's sign [rotations].
    """

    def __init__(self, port: MotorPort, sign: float, ahead: float = 0.0) -> None:
        self._port = port
        self._sign = sign
        self._ahead = ahead
        self.set_supply = port.set_supply  # type: ignore[method-assign]
        self.is_open = port.is_open  # type: ignore[method-assign]
        self.limits = port.limits  # type: ignore[method-assign]
        self.run = port.run  # type: ignore[method-assign]

    def volts(self) -> float:
        """Return the motor voltage with the model's sign [V]."""
        return self._sign * self._port.volts()

    def duty_cycle(self) -> float | None:
        """Return the duty cycle with the model's sign [-], or None if the controller commands volts."""
        share = self._port.duty_cycle()
        return None if share is None else self._sign * share

    def setpoint(self) -> Setpoint | None:
        """Return the set-point with the model's sign, or None without a set-point."""
        goal = self._port.setpoint()
        return None if goal is None else goal._replace(turns=self._sign * goal.turns)

    def show_motor(self, volts: float, amps: float) -> None:
        """Write the model's motor voltage [V] and current [A] to the controller, with robot code's sign."""
        self._port.show_motor(self._sign * volts, self._sign * amps)

    def write(self, rotations: float, rps: float) -> None:
        """Write the model's rotor position [rotations] and speed [rotations/s] with robot code's sign."""
        self._port.write(self._sign * (self._count(rotations) + self._ahead), self._sign * self.factor * rps)


_SOON = 0.25  # [s], longest time between two sign changes of an unstable loop; a slow loop needs half of this time
_CHANGES = 3  # consecutive sign changes, each from and to more than half of the largest output, before a reversal
_FAR = 1.25  # [turns], travel of the steering axis without approaching the goal, before a reversal
_HOLDS = 0.5  # [s], time after which a reversal is kept
_FADES = 0.995  # decay of the largest output per check


class _DecidingMotor(_Mounted):
    """Steer motor whose unknown sign is inferred from the behavior of the program's steer loop.

    With the wrong sign, the loop drives the module away from its goal. If the loop takes the shortest path, the output
    keeps changing sign at large values, half a turn from the goal (a quarter turn if the module may reverse the
    wheel); otherwise, the module turns without end. In either case this class reverses the motor. If the behavior
    continues, the class restores the original sign for good.
    """

    def __init__(
        self, port: MotorPort, sign: float, ahead: float, gearing: float, motors: list[_DecidingMotor]
    ) -> None:
        super().__init__(port, sign, ahead)
        self._motors = motors
        motors.append(self)
        self._far = _FAR * gearing
        self._rotations = self._near = 0.0
        self._last = self._peak = 0.0
        self._changed_at = self._turned_at = -math.inf
        self._changes = self._turns = 0
        self._is_decided = False

    @property
    def is_turned(self) -> bool:
        """Whether this class has reversed the motor."""
        return self._turns == 1

    def volts(self) -> float:
        volts = self._port.volts()
        if not self._is_decided:
            self._observe(volts, float(season.wpilib.Timer.get_monotonic_timestamp()))
        return self._sign * volts

    def _observe(self, volts: float, now: float) -> None:
        last, self._last = self._last, volts
        self._peak = max(abs(volts), _FADES * self._peak)
        if abs(volts) < 0.1 * self._peak or self._peak == 0.0:
            self._near = self._rotations
        if last * volts < 0.0 and min(abs(last), abs(volts)) > 0.5 * self._peak:
            self._changes = self._changes + 1 if now - self._changed_at < _SOON else 1
            self._changed_at = now
        if self._changes >= _CHANGES or abs(self._rotations - self._near) > self._far:
            self._changes, self._near = 0, self._rotations
            self._turned_at = now
            self._sign = -self._sign
            self._turns += 1
            self._is_decided = self._turns > 1
        elif self.is_turned and now - self._turned_at > _HOLDS:
            self._is_decided = True
            self._log_reversed()

    def _log_reversed(self) -> None:
        """Log the indices of all reversed motors, unless another reversed motor has already done so."""
        if any(motor._is_decided and motor.is_turned for motor in self._motors if motor is not self):
            return
        turned = [k for k, motor in enumerate(self._motors) if motor.is_turned]
        _log.warning(
            "drivetrain: steer motors of modules %s turn clockwise with positive output, judging by the program's "
            "loops: nothing shows it before they run. In simcore.toml: [drivetrain] reversed_steer = %s",
            *(", ".join(map(str, turned)), turned),
        )

    def write(self, rotations: float, rps: float) -> None:
        self._rotations = rotations
        super().write(rotations, rps)


class _Shaft(_Counter):
    """Encoder that reads `scale` times the shaft's angle relative to `zero` [rad]."""

    def __init__(self, port: AnglePort, scale: float, zero: float) -> None:
        self._port = port
        self._scale = scale
        self._zero = zero

    def write(self, angle: float, rate: float) -> None:
        """Write the modelled angle [rad] and rate [rad/s] of the shaft."""
        self._port.write(self._scale * (self._count(angle) - self._zero), self._scale * self.factor * rate)
