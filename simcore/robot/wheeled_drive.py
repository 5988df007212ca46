"""What every drivetrain on wheels shares: limits, battery, wheels and tires, and readings that are the same for all.

`simcore.loop` moves it; here its constants and commands are put into the arrays of the loop, and read from them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.geometry.rotation import Vector
from simcore.loop.robot_state import NEUTRAL, OUTLINE, PART, ROBOT, SHAFT, SPRING, WHEEL, WHEELS, Records, records
from simcore.loop.robots import move_robots, prepare
from simcore.loop.tires import share_loads
from simcore.quantities import ANGLE, DURATION, checked_number, require
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.wheel_config import DrivetrainConfig, LimitedMotor, RobotMass, WheelConfig
from simcore.typing import FloatArray
from simcore.units import GRAVITY, plain_sum

__all__ = [
    "DriveShaft",
    "MotorReadout",
    "PlanarChassis",
    "WheeledDrive",
    "free_speed",
    "launch_accel",
    "normal_loads",
    "set_motor",
]

NOMINAL_VOLTAGE = 12.0
"""What FRC figures are quoted at [V]."""


@dataclass(frozen=True, slots=True)
class DriveShaft:
    """What turns together: the wheel of a swerve module, or all wheels of one side of a tank, one behind the other."""

    inertia: float
    """Of wheels, gears and rotors about the axle [kg m^2]."""
    motor: LimitedMotor
    radius: float
    """Of its wheels [m]."""
    slip_ratio: float
    """Slip per rolling speed at which the tires begin to slide [-]."""
    slip_speed: float
    """The same at standstill [m/s]."""
    wheels: tuple[int, ...]
    """Rows of its wheels."""
    grain: float = 1.0
    """Friction of its treads across over that along [-]."""

    @staticmethod
    def of(wheel: WheelConfig, *, inertia: float, motor: LimitedMotor, wheels: tuple[int, ...]) -> DriveShaft:
        """A shaft with wheels of one kind; see the fields."""
        return DriveShaft(
            inertia=inertia,
            motor=motor,
            radius=wheel.wheel_radius,
            slip_ratio=wheel.slip_ratio,
            slip_speed=wheel.slip_speed,
            wheels=wheels,
            grain=wheel.wheel_grain,
        )


def free_speed(shaft: DriveShaft, wheels: Sequence[WheelConfig], loads: Sequence[float]) -> float:
    """Ground speed at which motor torque meets friction and rolling drag [m/s].

    Args:
        shaft: Motor, gears, wheel radius.
        wheels: All wheels of the robot.
        loads: On all wheels [N].
    """
    motor = shaft.motor
    drag = plain_sum([wheels[k].rolling_resistance * loads[k] for k in shaft.wheels]) * shaft.radius + motor.friction
    current = drag / motor.torque_driving
    return max(0.0, (NOMINAL_VOLTAGE - current * motor.resistance) / motor.emf * shaft.radius)


def launch_accel(
    shafts: Sequence[DriveShaft],
    wheels: Sequence[WheelConfig],
    loads: Sequence[float],
    arms: Sequence[float],
    inertia: float,
) -> float:
    """Acceleration from rest, straight (arms 1, inertia = mass) or on the spot (arms = radii, inertia = yaw inertia).

    A shaft within its grip drags its own rotor and wheels along; one beyond it pushes with mu N and no more. Which
    is which depends on the acceleration itself, so shafts change sides until it agrees: at most once each.

    Args:
        shafts: All drive shafts.
        wheels: All wheels.
        loads: On the wheels [N].
        arms: Per shaft, what a force of 1 N does: 1 [-] or the distance from the center of mass [m].
        inertia: Mass [kg] or yaw inertia [kg m^2].
    """
    slipping = [False] * len(shafts)
    while True:
        push, heavy = 0.0, inertia
        drives = []
        for shaft, arm, slips in zip(shafts, arms, slipping, strict=True):
            motor = shaft.motor
            grip = plain_sum([wheels[k].wheel_cof * loads[k] for k in shaft.wheels])
            drag = plain_sum([wheels[k].rolling_resistance * loads[k] for k in shaft.wheels])
            current = min(motor.stator_limit, NOMINAL_VOLTAGE * motor.conductance)
            force = max(0.0, motor.torque_driving * current - motor.friction) / shaft.radius
            own = shaft.inertia / shaft.radius**2
            drives.append((force, own, grip))
            if slips:
                push += (grip - drag) * arm
            else:
                push += (force - drag) * arm
                heavy += own * arm * arm
        accel = max(0.0, push / heavy)
        beyond = [
            slips or force - own * arm * accel > grip
            for (force, own, grip), arm, slips in zip(drives, arms, slipping, strict=True)
        ]
        if beyond == slipping or math.isinf(accel):
            return accel
        slipping = beyond


def normal_loads(
    config: RobotMass,
    touching: Sequence[bool],
    gravity_robot: Sequence[float],
    accel_robot: Sequence[float] = (0.0, 0.0, 0.0),
) -> list[float]:
    """Normal load of each wheel from gravity, acceleration and which wheels touch.

    The ground acts on the chassis with f = m (a - g). Its vertical part is shared so that the forces at the contact
    points make no moment about the center of mass (a rigid chassis that is not just tipping):

        sum N_i = f_z,   sum N_i x_i = -height f_x,   sum N_i y_i = -height f_y

    Speeding up puts load on the rear axle, a left turn on the right wheels, and a slope on the lower ones. See
    `simcore.loop.tires.share_loads` for robots with more than three wheels and those with a dropped center.

    Args:
        config: Positions of the wheels, mass, center of mass.
        touching: Per wheel, whether it is on the ground.
        gravity_robot: Acceleration of gravity, robot axes [m/s^2], shape (3,); level ground: (0, 0, -9.80665).
        accel_robot: Of the center of mass, robot axes, as seen from the field [m/s^2], shape (3,).

    Returns:
        Loads [N], each >= 0, 0 where nothing touches; they add up to f_z, or are all 0 in free fall.

    Raises:
        NonFiniteError: When an acceleration is NaN or infinite.
    """
    if not all(map(math.isfinite, (*gravity_robot, *accel_robot))):
        raise NonFiniteError(f"normal loads need finite numbers, got gravity={gravity_robot}, accel={accel_robot}")
    wheels = records(WHEEL, len(config.positions))
    wheels["x"], wheels["y"] = zip(*config.positions, strict=True)
    wheels["is_down"] = touching
    wheels["is_lowered"][list(config.lowered)] = 1
    height = config.center_of_mass[2] * config.mass
    share_loads(
        *(wheels, 0, len(wheels), config.mass * (accel_robot[2] - gravity_robot[2])),
        height * (gravity_robot[0] - accel_robot[0]),
        height * (gravity_robot[1] - accel_robot[1]),
    )
    loads: list[float] = wheels["load"].tolist()
    return loads


ConfigT = TypeVar("ConfigT", bound=DrivetrainConfig)

_NOWHERE = (  # no bumpers, nothing that stands on the field
    *(records(PART, 0), records(OUTLINE, 0), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.uint8)),
    *(records(SPRING, 0).reshape(0, 1), np.zeros(1, np.int64)),
)


def set_motor(row: Records, motor: LimitedMotor) -> None:
    """Put the constants of a motor into the record of its shaft, shape (1,)."""
    for name, value in {
        "emf": motor.emf,
        "resistance": motor.resistance,
        "winding": motor.winding,
        "driving": motor.torque_driving,
        "driven": motor.torque_driven,
        "friction": motor.friction,
        "stator_limit": motor.stator_limit,
        "supply_limit": motor.supply_limit,
        "count": motor.count,
        "lower": -math.inf,
        "upper": math.inf,
        "partner": -1,
    }.items():
        row[name] = value


class MotorReadout:
    """What the motors of one kind did in the last step, one entry per shaft; of several motors on it, one."""

    def __init__(self, drive: WheeledDrive[Any], rows: slice) -> None:
        self._drive, self._rows = drive, rows

    def _column(self, name: str) -> FloatArray:
        column: FloatArray = self._drive.shafts[name][self._rows]
        return column

    @property
    def volts(self) -> list[float]:
        """At the terminals [V]."""
        return list(self._column("volts").tolist())

    @property
    def current(self) -> list[float]:
        """Stator current [A]."""
        return list(self._column("current").tolist())

    @property
    def supply(self) -> list[float]:
        """Current from the battery; negative feeds back [A]."""
        bus = self._drive.bus_voltage
        if bus <= 0.0:
            return [0.0] * len(self._column("volts"))
        return list((self._column("volts") * self._column("current") / bus).tolist())

    @property
    def heat(self) -> list[float]:
        """Copper loss since the last reset [J]."""
        return list((self._column("winding") * self._column("charge2")).tolist())

    @property
    def energy(self) -> float:
        """Electrical energy that all motors took since the last reset: the integral of V I [J]."""
        return float(self._column("energy").sum())


class WheeledDrive(ABC, Generic[ConfigT]):
    """Base of `SwerveDrive`, `TankDrive` and `MecanumDrive`.

    A drive has wheels, motors, battery and encoders, not the pose: `step` takes the velocity that the chassis really
    has (walls and other robots have had their say) and returns the change that the tires make. In a world its records
    are among those of all robots there, and the world moves them. Several drives share nothing.
    """

    def __init__(
        self,
        config: ConfigT,
        *,
        battery: Battery | None,
        wheels: Sequence[WheelConfig],
        shafts: Sequence[DriveShaft],
        azimuths: int = 0,
        radii: Sequence[float],
    ) -> None:
        """At rest, not bound to a chassis yet.

        Args:
            config: The robot.
            battery: Its battery; None is a stiff 12 V supply.
            wheels: In the order of `config.positions`.
            shafts: What turns them; each wheel is on one shaft.
            azimuths: How many steer; their records follow those of the shafts.
            radii: Of the wheels, as robot code knows them [m]; a shaft has the true one.
        """
        self.config = config
        self.battery = battery if battery is not None else Battery(BatteryConfig.stiff(12.0))
        self._wheels = len(config.positions)
        self._driven = len(shafts)
        self.robot_record = records(ROBOT)
        """Of the robot, in the arrays of the loop, shape (1,)."""
        self.shafts = records(SHAFT, len(shafts) + azimuths)
        """Drive shafts, then azimuths."""
        self.wheel_records = records(WHEEL, self._wheels)
        """In the order of `config.positions`."""
        self._shafts, self._wheel_configs = tuple(shafts), tuple(wheels)
        self._motors_per_shaft = shafts[0].motor.count
        self._wheel_radii = list(radii)
        self._shaft_of_wheel = [0] * self._wheels
        for g, shaft in enumerate(shafts):
            if len({config.positions[k][1] for k in shaft.wheels}) > 1:
                raise ConfigError("a drive shaft's wheels must stand one behind the other, at the same y")
            row = self.shafts[g : g + 1]
            set_motor(row, shaft.motor)
            row["kind"], row["inertia"], row["cos"] = WHEELS, shaft.inertia, 1.0
            row["first"], row["last"] = shaft.wheels[0], shaft.wheels[-1] + 1
            row["radius"], row["grain"] = shaft.radius, shaft.grain
            row["slip_ratio"], row["slip_speed"] = shaft.slip_ratio, shaft.slip_speed
            for k in shaft.wheels:
                self._shaft_of_wheel[k] = g
        for k, wheel in enumerate(wheels):
            one = self.wheel_records[k : k + 1]
            one["cof"], one["rolling"], one["shaft"] = (
                wheel.wheel_cof,
                wheel.rolling_resistance,
                self._shaft_of_wheel[k],
            )
        self.wheel_records["is_down"] = 1
        self.wheel_records["is_lowered"][list(config.lowered)] = 1
        robot = self.robot_record
        robot["last_shaft"], robot["drive_shafts"] = len(self.shafts), len(shafts)
        robot["last_wheel"], robot["is_enabled"] = self._wheels, 1
        cx, cy, _ = config.center_of_mass
        self._wheel_places = [(x + cx, y + cy) for x, y in config.positions]
        self._robot: RobotMass = config
        self._static_loads: list[float] = []
        self._stand(config)
        self._free_speeds = [free_speed(s, self._wheel_configs, self._static_loads) for s in shafts]
        self._own_limits: Records | None = None
        self._kept_limits: list[tuple[float, float]] = []
        self.drive_motors = MotorReadout(self, slice(0, len(shafts)))
        """Of the drive shafts."""

    @property
    def shaft_angles(self) -> FloatArray:
        """Of the drive shafts since the reset, seen at the wheel, any number of turns [rad], shape (shafts,)."""
        angles: FloatArray = self.shafts["position"][: self._driven]
        return angles

    @property
    def shaft_speeds(self) -> FloatArray:
        """Of the drive shafts, seen at the wheel [rad/s], shape (shafts,)."""
        speeds: FloatArray = self.shafts["speed"][: self._driven]
        return speeds

    @property
    def other_current(self) -> float:
        """Drawn by everything but the robot's motors, set by the owner at any time [A]."""
        return float(self.robot_record["other_current"][0])

    @other_current.setter
    def other_current(self, amps: float) -> None:
        self.robot_record["other_current"] = amps

    @property
    def enabled(self) -> bool:
        """False: motors go to neutral, as a disabled robot's do."""
        return bool(self.robot_record["is_enabled"][0])

    @enabled.setter
    def enabled(self, enabled: bool) -> None:
        self.robot_record["is_enabled"] = enabled

    @property
    def time(self) -> float:
        """Simulated time since the reset [s]."""
        return float(self.robot_record["time"][0])

    def set_mass_properties(self, mass: float, yaw_inertia: float, center_of_mass: Vector) -> None:
        """What the robot weighs from the next step on, with what it holds and as its mechanisms stand.

        Robot code and its loops know nothing of it: `config` and what it says of speeds stay.

        Args:
            mass: Of the whole robot [kg].
            yaw_inertia: About the vertical axis through the center of mass [kg m^2].
            center_of_mass: From the robot center on the floor, robot axes [m]. `step` takes and gives the velocity of
                this point from now on.

        Raises:
            NonFiniteError: When a number is not finite, or mass or inertia not above zero; nothing has changed.
        """
        if not (all(map(math.isfinite, (mass, yaw_inertia, *center_of_mass))) and mass > 0.0 and yaw_inertia > 0.0):
            raise NonFiniteError(
                "drivetrain needs finite mass properties, mass and inertia above zero, got "
                f"mass={mass}, yaw_inertia={yaw_inertia}, center_of_mass={center_of_mass}"
            )
        cx, cy, cz = map(float, center_of_mass)
        self._robot = RobotMass(
            mass=float(mass),
            yaw_inertia=float(yaw_inertia),
            center_of_mass=(cx, cy, cz),
            positions=tuple((x - cx, y - cy) for x, y in self._wheel_places),
            lowered=self._robot.lowered,
        )
        self._stand(self._robot)

    def _stand(self, robot: RobotMass) -> None:
        """Put a mass and its wheels' places into the records."""
        record = self.robot_record
        record["mass"], record["center"] = robot.mass, robot.center_of_mass
        record["inertia"][:, 2] = robot.yaw_inertia
        self.wheel_records["x"], self.wheel_records["y"] = zip(*robot.positions, strict=True)
        self._static_loads = normal_loads(robot, [True] * self._wheels, (0.0, 0.0, -GRAVITY))

    def _rest(self, shaft_speeds: Sequence[float]) -> None:
        """Time at zero, battery rested, encoders at zero, drive shafts at these speeds [rad/s]."""
        for name in ("position", "speed", "volts", "current", "supply", "energy", "charge2"):
            self.shafts[name] = 0.0
        self.shafts["mode"] = NEUTRAL
        self.shaft_speeds[:] = shaft_speeds
        for name in ("slip", "force_x", "force_y", "mean_load", "mean_x", "mean_y"):
            self.wheel_records[name] = 0.0
        robot = self.robot_record
        for name in ("time", "followed", "tires", "felt", "end_change", "mean_change", "is_sliding"):
            robot[name] = 0
        self.battery.reset()
        robot["bus"] = self.battery.voltage

    # ---------------------------------------------------------------- the step

    def step(
        self,
        h: float,
        velocity: Vector,
        normal_loads: Sequence[float] | None = None,
        pull: Vector = (0.0, 0.0, 0.0),
    ) -> Vector:
        """Change of velocity that the tires make in `h` on a free planar body, for a drive that is in no world.

        All vectors are in the robot axes at the START of the step; the turn of the robot within the step is followed
        inside. It is force times time over mass, nothing else: add it to the field-frame velocity rotated by the yaw
        at the start of the step, and no term omega x v is needed.

        Args:
            h: Time step of the owner [s]; cut into parts of 1 ms or less.
            velocity: Over ground, of the point on the carpet under the center of mass: forward, to the left, yaw rate
                [m/s, m/s, rad/s].
            normal_loads: Per wheel [N], 0 off the ground; None is the robot at rest on level ground.
            pull: Acceleration that the owner adds itself in this step (a slope, a wall that pushes back)
                [m/s^2, m/s^2, rad/s^2]. Knowing it, the tires hold a parked robot on a ramp without creeping. It is
                not in the result.

        Returns:
            Change of the velocity [m/s, m/s, rad/s].

        Raises:
            NonFiniteError: When an argument is not finite, or h is not above zero; nothing has changed.
            ConfigError: When there is not one load per wheel.
        """
        loads = self._static_loads if normal_loads is None else normal_loads
        if len(loads) != self._wheels:
            raise ConfigError(f"drivetrain step needs {self._wheels} normal loads, got {len(loads)}")
        if not (h > 0.0 and all(map(math.isfinite, (h, *velocity, *pull, *loads)))):
            raise NonFiniteError(
                f"drivetrain step needs finite numbers and h > 0, got h={h}, velocity={velocity}, "
                f"acceleration={pull}, loads={list(loads)}"
            )
        robot = self.robot_record
        robot["has_fixed_loads"], robot["yaw"] = 1, 0.0
        self.wheel_records["load"] = loads
        robot["vx"], robot["vy"], robot["omega"] = velocity
        robot["pull"] = pull
        self.advance_alone(h)
        robot["has_fixed_loads"] = 0
        return self.change

    def advance_alone(self, h: float) -> None:
        """Let the loop move a drive that is in no world for h [s], from the velocity in its record."""
        prepare()
        move_robots(self.robot_record, self.shafts, self.wheel_records, self.battery.records, *_NOWHERE, h)
        self.battery.tell()

    @property
    def change(self) -> Vector:
        """Of the velocity, by the tires, in the last step, robot axes as it began [m/s, m/s, rad/s]."""
        return self._plan("end_change")

    @property
    def mean_change(self) -> Vector:
        """Mean over the last step of what the tires had changed until then, likewise.

        The velocity at the start plus this, times h, is the way that they moved the robot.
        """
        return self._plan("mean_change")

    def _plan(self, name: str) -> Vector:
        x, y, turn = self.robot_record[name][0].tolist()
        return x, y, turn

    @property
    def yaw_rate(self) -> float:
        """After the last step, as the tires leave it [rad/s]."""
        return float(self.robot_record["omega"][0])

    def set_requests(self, kinds: Sequence[int], values: Sequence[float]) -> None:
        """What motor controllers want of the motors, until the next time.

        Args:
            kinds: `VOLTS` or `DUTY` of `simcore.loop.robot_state`, of each shaft: wheels, then azimuths.
            values: Volts [V], or shares of the battery's voltage.

        Raises:
            NonFiniteError: A value is missing, NaN or infinite; it names the shaft, and nothing has changed.
        """
        name = type(self).__name__
        self._command(kinds, [checked_number(f"{name} request of shaft {k}", value) for k, value in enumerate(values)])

    def keep_limits(self, limits: Sequence[tuple[float, float]]) -> None:
        """Keep the current of each motor within limits of stator and supply [A], and within the configured ones.

        Args:
            limits: Of each shaft: wheels, then azimuths.
        """
        if limits != self._kept_limits:
            self._kept_limits = list(limits)
            if self._own_limits is None:
                self._own_limits = self.shafts[["stator_limit", "supply_limit"]].copy()
            stator, supply = zip(*limits, strict=True)
            self.shafts["stator_limit"] = np.minimum(self._own_limits["stator_limit"], stator)
            self.shafts["supply_limit"] = np.minimum(self._own_limits["supply_limit"], supply)

    def _command(self, mode: int | Sequence[int], requests: Sequence[float]) -> None:
        """Ask the motors of the first shafts for something."""
        shafts = self.shafts
        shafts["mode"][: len(requests)] = mode
        shafts["request"][: len(requests)] = requests

    # ---------------------------------------------------------------- readings

    @abstractmethod
    def wheel_angles(self) -> list[float]:
        """Azimuth of each wheel, in the order of `config.positions` [rad]; any number of turns."""

    @abstractmethod
    def motor_currents(self) -> dict[str, list[float]]:
        """Stator current of every motor in the last step, by group [A]."""

    @property
    @abstractmethod
    def gearing(self) -> dict[str, list[float]]:
        """Rotor turns per turn of the wheel or azimuth, of every motor, by group as in `motor_currents` [-]."""

    def wheel_distances(self) -> list[float]:
        """How far each wheel has rolled since the reset, by encoder and config, as `config.positions` has them [m]."""
        angles = self.shaft_angles.tolist()
        return [angles[g] * r for g, r in zip(self._shaft_of_wheel, self._wheel_radii, strict=True)]

    def wheel_speeds(self) -> list[float]:
        """Speed of each tread against the robot, by encoder and config, as `config.positions` has them [m/s]."""
        speeds = self.shaft_speeds.tolist()
        return [speeds[g] * r for g, r in zip(self._shaft_of_wheel, self._wheel_radii, strict=True)]

    @property
    def normal_loads(self) -> list[float]:
        """Load of each wheel, averaged over the last step [N]."""
        loads: list[float] = self.wheel_records["mean_load"].tolist()
        return loads if self.time > 0.0 else self._static_loads[:]

    @property
    def wheel_forces(self) -> FloatArray:
        """Ground on wheels, robot axes, averaged over the last step [N], shape (n, 2)."""
        return np.column_stack((self.wheel_records["mean_x"], self.wheel_records["mean_y"]))

    @property
    def wheel_slip(self) -> float:
        """Speed of the fastest sliding tire over the ground in the last step [m/s]; 0 while all of them hold."""
        return float(self.wheel_records["slip"].max()) if self.robot_record["is_sliding"][0] else 0.0

    @property
    def robot(self) -> RobotMass:
        """Mass and wheel positions now: `config`, until `set_mass_properties` changes them."""
        return self._robot

    @property
    def bus_voltage(self) -> float:
        """Battery voltage that the motors had in the last step [V]."""
        return float(self.robot_record["bus"][0])

    @property
    def browned_out(self) -> bool:
        """Whether the roboRIO holds the outputs off."""
        return self.battery.browned_out

    @property
    def supply_current(self) -> float:
        """From the battery in the last step, drivetrain only [A]."""
        return float(self.shafts["supply"].sum())

    @property
    def electrical_energy(self) -> float:
        """Taken by all motors since the reset: the integral of V I [J]."""
        return float(self.shafts["energy"].sum())

    @property
    def max_speed(self) -> float:
        """Straight ahead at 12 V, where motor torque meets friction and rolling drag [m/s]."""
        return min(self._free_speeds)

    @property
    def max_accel(self) -> float:
        """From rest on level ground at stiff 12 V: grip, motors and stator limits of every wheel counted [m/s^2]."""
        return launch_accel(
            self._shafts, self._wheel_configs, self._static_loads, [1.0] * self._driven, self._robot.mass
        )


class PlanarChassis:
    """Pose and velocity of a robot on a plane, level or sloped up along the field's x axis.

    Example:
        >>> from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
        >>> from simcore.robot.swerve_drive import SwerveDrive
        >>> drive = SwerveDrive(SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0)))
        >>> robot = PlanarChassis(drive)
        >>> drive.set_volts([12.0] * 4, [0.0] * 4)
        >>> robot.run(3.0)
        >>> 4.6 < robot.vx < 4.76
        True
    """

    def __init__(self, drive: WheeledDrive[Any], *, slope: float = 0.0) -> None:
        """Stand at the origin, facing along x.

        Args:
            drive: Any drivetrain.
            slope: Of the ground, up along x [rad].
        """
        require("planar chassis", "slope", slope, ANGLE)
        self.drive = drive
        self.slope = slope
        self.reset()

    def reset(
        self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0, *, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0
    ) -> None:
        """Put the robot somewhere, with a velocity in field axes."""
        self.x, self.y, self.yaw = x, y, yaw
        """Pose of the center of mass, along the ground [m, m, rad]."""
        self.vx, self.vy, self.omega = vx, vy, omega
        """Velocity, field axes along the ground [m/s, m/s, rad/s]."""
        self.ax, self.ay = 0.0, 0.0
        """Acceleration in the last step, field axes [m/s^2]."""
        self.time = 0.0
        self.loads: list[float] = []
        """Normal loads in the last step [N]."""
        for name in ("followed", "tires"):
            self.drive.robot_record[name] = 0.0

    def step(self, h: float, *, force: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        """Advance by `h` [s] with an outside force (x, y [N], torque [N m], field axes) on the center of mass."""
        config, record = self.drive.robot, self.drive.robot_record
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        g_along = -GRAVITY * math.sin(self.slope)
        ex = g_along + force[0] / config.mass
        ey = force[1] / config.mass
        spin_up = force[2] / config.yaw_inertia
        record["gravity"] = (c * g_along, -s * g_along, -GRAVITY * math.cos(self.slope))
        record["felt"] = (c * g_along, -s * g_along, 0.0)  # an outside force acts at the center: it shifts no load
        record["pull"] = (ex, ey, spin_up)
        record["yaw"], record["vx"], record["vy"], record["omega"] = self.yaw, self.vx, self.vy, self.omega
        self.drive.advance_alone(h)
        dx, dy, dw = self.drive.change
        self.loads = self.drive.normal_loads
        self.ax, self.ay = dx / h + ex, dy / h + ey
        spin = dw + spin_up * h
        mx, my, mw = self.drive.mean_change
        share = 1.0 - float(record["early"][0])  # of what outside forces change, in the mean of the loop's steps
        self.x += (self.vx + mx + share * ex * h) * h
        self.y += (self.vy + my + share * ey * h) * h
        self.yaw += (self.omega + mw + share * spin_up * h) * h
        self.vx += self.ax * h
        self.vy += self.ay * h
        self.omega += spin
        self.time += h

    def run(self, seconds: float, *, h: float = 0.005, each: Callable[[], None] | None = None) -> None:
        """Advance by a time in steps of `h` [s], calling `each` after every one."""
        require("planar chassis", "h", h, DURATION)
        for _ in range(round(seconds / h)):
            self.step(h)
            if each is not None:
                each()

    @property
    def speed(self) -> float:
        """Over ground [m/s]."""
        return math.hypot(self.vx, self.vy)

    @property
    def kinetic_energy(self) -> float:
        """Of the chassis, without its wheels [J]."""
        c = self.drive.robot
        return 0.5 * c.mass * (self.vx**2 + self.vy**2) + 0.5 * c.yaw_inertia * self.omega**2
