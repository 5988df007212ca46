"""Base of all wheeled drivetrains: current limits, battery, wheels, tires and common readings.

`simcore.loop` steps the drivetrain. This module writes constants and commands to the arrays of the loop, and reads the
results from these arrays.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.loop.robot_state import NEUTRAL, ROBOT, SHAFT, WHEEL, WHEELS, Records, records
from simcore.loop.tires import share_loads
from simcore.quantities import checked_number
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.wheel_config import DrivetrainConfig, LimitedMotor, RobotMass, WheelConfig
from simcore.typing import FloatArray
from simcore.units import GRAVITY, plain_sum
from simcore.world.rotation import Vector

__all__ = [
    "DriveShaft",
    "MotorReadout",
    "WheeledDrive",
    "free_speed",
    "launch_accel",
    "set_motor",
    "static_loads",
]

NOMINAL_VOLTAGE = 12.0
"""Nominal battery voltage of FRC motor data [V]."""


@dataclass(frozen=True, slots=True)
class DriveShaft:
    """Shaft that drives the wheel of a swerve module, one mecanum wheel, or the wheels on one side of a tank drive."""

    inertia: float
    """Moment of inertia of wheels, gears and rotors about the axle [kg m^2]."""
    motor: LimitedMotor
    radius: float
    """Radius of the wheels [m]; for a mecanum wheel, the radius times cos 45 degrees."""
    slip_ratio: float
    """Ratio of slip speed to rolling speed at which the tires begin to slide [-]."""
    slip_speed: float
    """Slip speed at which tires at rest begin to slide [m/s]."""
    wheels: tuple[int, ...]
    """Indices of the wheels in `config.positions`."""
    grain: float = 1.0
    """Ratio of friction across the treads to friction along the treads [-]; 0 for mecanum rollers."""

    @staticmethod
    def of(wheel: WheelConfig, *, inertia: float, motor: LimitedMotor, wheels: tuple[int, ...]) -> DriveShaft:
        """Build a shaft with identical wheels.

        Args:
            wheel: Config of each wheel on the shaft.
            inertia: Moment of inertia of wheels, gears and rotors about the axle [kg m^2].
            motor: Motors on the shaft.
            wheels: Indices of the wheels in `config.positions`.
        """
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
    """Compute the top wheel speed of a drive shaft at 12 V, where motor torque equals friction and rolling drag.

    Args:
        shaft: Drive shaft.
        wheels: All wheels of the robot.
        loads: Normal forces on all wheels [N].

    Returns:
        Angular velocity times wheel radius [m/s]; 0 if the motors cannot overcome friction and drag.
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
    """Compute the acceleration from rest at 12 V within the stator limits, straight ahead or in yaw.

    The motor torque on a shaft below the traction limit also accelerates rotors and wheels. The thrust of a shaft at
    the traction limit is mu N. Friction and rolling drag reduce the acceleration. The acceleration determines which
    shafts are at the traction limit, so the function iterates. In the iteration, each shaft reaches the limit at most
    once.

    Args:
        shafts: All drive shafts.
        wheels: All wheels.
        loads: Normal forces on the wheels [N].
        arms: Lever arm of each shaft: 1 [-] for linear acceleration, distance from the center of mass [m] for yaw.
        inertia: Mass [kg] for linear acceleration, or yaw moment of inertia [kg m^2] for yaw.

    Returns:
        Linear acceleration [m/s^2] or yaw acceleration [rad/s^2]; 0 if friction and drag exceed the thrust.
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


def static_loads(robot: RobotMass) -> list[float]:
    """Compute the normal force on each wheel of a robot on level ground [N]; see `simcore.loop.tires.share_loads`."""
    wheels = records(WHEEL, len(robot.positions))
    model = wheels["model"]
    model["x"], model["y"] = zip(*robot.positions, strict=True)
    model["is_lowered"][list(robot.lowered)] = 1
    share_loads(wheels, 0, len(wheels), robot.mass * GRAVITY, 0.0, 0.0)
    loads: list[float] = wheels["load"].tolist()
    return loads


ConfigT = TypeVar("ConfigT", bound=DrivetrainConfig)


def set_motor(row: Records, motor: LimitedMotor) -> None:
    """Write the constants and current limits of a shaft's motors to the record of the shaft.

    The shaft gets no hard stops and no partner shaft.

    Args:
        row: Record of the shaft, shape (1,).
        motor: Constants of the motors.
    """
    model, request = row["model"], row["request"]
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
        model[name] = value
    request["stator_limit"], request["supply_limit"] = motor.stator_limit, motor.supply_limit


class MotorReadout:
    """Readings of all drive motors, or of all steer motors.

    Volts and currents are the values in the last step; heat and energy are totals since the last reset. Each list
    contains the value of one motor per shaft; the motors on one shaft are identical. `energy` is the total of all
    motors.
    """

    def __init__(self, drive: WheeledDrive[Any], rows: slice) -> None:
        self._drive, self._rows = drive, rows

    def _column(self, name: str) -> Records:
        return self._drive.shafts[name][self._rows]

    @property
    def volts(self) -> list[float]:
        """Voltage at the terminals of one motor per shaft [V]."""
        return list(self._column("volts").tolist())

    @property
    def current(self) -> list[float]:
        """Stator current of one motor per shaft [A]."""
        return list(self._column("current").tolist())

    @property
    def supply(self) -> list[float]:
        """Supply current of one motor per shaft [A]; negative while regenerating, 0 without bus voltage."""
        bus = self._drive.bus_voltage
        if bus <= 0.0:
            return [0.0] * len(self._column("volts"))
        return list((self._column("volts") * self._column("current") / bus).tolist())

    @property
    def heat(self) -> list[float]:
        """Energy lost as heat in the windings of one motor per shaft since the last reset [J]."""
        return list((self._column("model")["winding"] * self._column("charge2")).tolist())

    @property
    def energy(self) -> float:
        """Electrical energy drawn by all motors since the last reset, the integral of V I [J]."""
        return float(self._column("energy").sum())


class WheeledDrive(ABC, Generic[ConfigT]):
    """Base of `SwerveDrive`, `TankDrive` and `MecanumDrive`.

    A drive has wheels, motors, a battery and encoders, but no pose. In a world, the records of the drive are part of
    the arrays of the loop, and the loop steps the drive together with the robot.
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
        """Create the drive at rest, without a chassis.

        Args:
            config: Nominal drivetrain, as assumed by robot code and the on-board loops.
            battery: Battery of the robot; None for a stiff 12 V supply.
            wheels: Wheels as actually built, in the order of `config.positions`.
            shafts: Drive shafts as actually built, with the true wheel radii; each wheel is on one shaft.
            azimuths: Number of steer shafts; their records follow those of the drive shafts in the attribute `shafts`.
            radii: Nominal radius of each wheel, as assumed by robot code [m].

        Raises:
            ConfigError: If the wheels of a shaft do not have the same y coordinate.
        """
        self.config = config
        self.battery = battery if battery is not None else Battery(BatteryConfig.stiff(12.0))
        self._wheels = len(config.positions)
        self._driven = len(shafts)
        self.robot_record = records(ROBOT)
        """Record of the robot in the arrays of the loop, shape (1,)."""
        self.shafts = records(SHAFT, len(shafts) + azimuths)
        """Records of the drive shafts, followed by the records of the steer shafts, in the arrays of the loop."""
        self.wheel_records = records(WHEEL, self._wheels)
        """Records of the wheels, in the order of `config.positions`."""
        self._shafts, self._wheel_configs = tuple(shafts), tuple(wheels)
        self._motors_per_shaft = shafts[0].motor.count
        self._wheel_radii = list(radii)
        self._shaft_of_wheel = [0] * self._wheels
        for g, shaft in enumerate(shafts):
            if len({config.positions[k][1] for k in shaft.wheels}) > 1:
                raise ConfigError("a drive shaft's wheels must stand one behind the other, at the same y")
            row = self.shafts[g : g + 1]
            set_motor(row, shaft.motor)
            row["cos"], model = 1.0, row["model"]
            model["kind"], model["inertia"] = WHEELS, shaft.inertia
            model["first"], model["last"] = shaft.wheels[0], shaft.wheels[-1] + 1
            model["radius"], model["grain"] = shaft.radius, shaft.grain
            model["slip_ratio"], model["slip_speed"] = shaft.slip_ratio, shaft.slip_speed
            for k in shaft.wheels:
                self._shaft_of_wheel[k] = g
        model = self.wheel_records["model"]
        model["cof"] = [wheel.wheel_cof for wheel in wheels]
        model["rolling"] = [wheel.rolling_resistance for wheel in wheels]
        model["is_lowered"][list(config.lowered)] = 1
        robot = self.robot_record["model"]
        robot["last_shaft"], robot["drive_shafts"], robot["last_wheel"] = len(self.shafts), len(shafts), self._wheels
        self.robot_record["request"]["is_enabled"] = 1
        cx, cy, _ = config.center_of_mass
        self._wheel_places = [(x + cx, y + cy) for x, y in config.positions]
        self._robot: RobotMass = config
        self._stand(config)
        self._free_speeds = [free_speed(s, self._wheel_configs, self.static_loads) for s in shafts]
        self._kept_limits: list[tuple[float, float]] = []
        self.drive_motors = MotorReadout(self, slice(0, len(shafts)))
        """Readings of the drive motors in the last step."""

    @property
    def shaft_angles(self) -> FloatArray:
        """Angles of the drive shafts since the reset, on the wheel side of the gears [rad], shape (shafts,).

        The angles are continuous over turns.
        """
        angles: FloatArray = self.shafts["position"][: self._driven]
        return angles

    @property
    def shaft_speeds(self) -> FloatArray:
        """Angular velocities of the drive shafts, on the wheel side of the gears [rad/s], shape (shafts,)."""
        speeds: FloatArray = self.shafts["speed"][: self._driven]
        return speeds

    @property
    def other_current(self) -> float:
        """Battery current of consumers other than the robot's motors [A]; a new value applies from the next step on."""
        return float(self.robot_record["request"]["other_current"][0])

    @other_current.setter
    def other_current(self, amps: float) -> None:
        self.robot_record["request"]["other_current"] = amps

    @property
    def enabled(self) -> bool:
        """Whether the robot is enabled; the drive and steer motors of a disabled robot are in neutral."""
        return bool(self.robot_record["request"]["is_enabled"][0])

    @enabled.setter
    def enabled(self, enabled: bool) -> None:
        self.robot_record["request"]["is_enabled"] = enabled

    @property
    def time(self) -> float:
        """Simulated time since the reset [s]."""
        return float(self.robot_record["time"][0])

    def set_mass_properties(self, mass: float, yaw_inertia: float, center_of_mass: Vector) -> None:
        """Set the robot's current mass properties, with held pieces and moving masses, from the next step on.

        The nominal values in `config`, which robot code and on-board loops use, and `max_speed` do not change.

        Args:
            mass: Mass of the whole robot [kg].
            yaw_inertia: Moment of inertia about the vertical axis through the center of mass [kg m^2].
            center_of_mass: Center of mass in the robot frame [m].

        Raises:
            NonFiniteError: If a value is not finite, or mass or inertia is not above zero; the old values stay in
                effect.
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
        """Write the wheel positions to the records and compute the static loads."""
        model = self.wheel_records["model"]
        model["x"], model["y"] = zip(*robot.positions, strict=True)
        self.static_loads = static_loads(robot)
        """Normal force on each wheel while the robot stands on level ground [N]."""

    def _rest(self, shaft_speeds: Sequence[float]) -> None:
        """Zero time, encoders and energy, reset the battery, command neutral, and set drive shaft speeds [rad/s]."""
        for name in ("position", "speed", "volts", "current", "supply", "energy", "charge2"):
            self.shafts[name] = 0.0
        self.shafts["request"]["mode"] = NEUTRAL
        self.shaft_speeds[:] = shaft_speeds
        for name in ("slip", "force_x", "force_y", "mean_load", "mean_x", "mean_y"):
            self.wheel_records[name] = 0.0
        robot = self.robot_record
        for name in ("time", "yaw_rate", "is_sliding"):
            robot[name] = 0
        self.battery.reset()
        robot["bus"] = self.battery.voltage

    # ---------------------------------------------------------------- requests

    @property
    def yaw_rate(self) -> float:
        """Yaw rate after the last step [rad/s]."""
        return float(self.robot_record["yaw_rate"][0])

    def set_requests(self, kinds: Sequence[int], values: Sequence[float]) -> None:
        """Command the output of each motor controller until the next command.

        Args:
            kinds: `VOLTS` or `DUTY` of `simcore.loop.robot_state` for each drive shaft, then each steer shaft.
            values: Voltage [V] or duty cycle, -1 to 1, for each shaft in the same order.

        Raises:
            NonFiniteError: If a value is not a finite number; the message names the shaft, and the old command stays in
                effect.
        """
        name = type(self).__name__
        self._command(kinds, [checked_number(f"{name} request of shaft {k}", value) for k, value in enumerate(values)])

    def keep_limits(self, limits: Sequence[tuple[float, float]]) -> None:
        """Limit the stator and supply current of each motor from the next step on; configured limits still apply.

        Args:
            limits: Stator and supply limit of each drive shaft, then of each steer shaft, per motor [A].
        """
        if limits != self._kept_limits:
            self._kept_limits = list(limits)
            model, request = self.shafts["model"], self.shafts["request"]
            stator, supply = zip(*limits, strict=True)
            request["stator_limit"] = np.minimum(model["stator_limit"], stator)
            request["supply_limit"] = np.minimum(model["supply_limit"], supply)

    def _command(self, mode: int | Sequence[int], requests: Sequence[float]) -> None:
        """Write a common mode, or a mode per shaft, and values to the requests of the first `len(requests)` shafts."""
        request = self.shafts["request"][: len(requests)]
        request["mode"], request["value"] = mode, requests

    # ---------------------------------------------------------------- readings

    @abstractmethod
    def wheel_angles(self) -> list[float]:
        """Return the direction of each wheel, counter-clockwise from forward, continuous over turns [rad].

        The order is that of `config.positions`. The direction is the steer angle of a swerve module, 0 for the wheels
        of a tank drive, and the direction in which a mecanum wheel grips.
        """

    @abstractmethod
    def motor_currents(self) -> dict[str, list[float]]:
        """Return the stator current of every motor in the last step [A], by group, such as `drive` and `steer`."""

    @property
    @abstractmethod
    def gearing(self) -> dict[str, list[float]]:
        """Gear ratio of every motor: rotor turns per turn of wheel or module [-], by the groups of `motor_currents`."""

    def wheel_distances(self) -> list[float]:
        """Return the distance that each wheel has rolled since the reset, in the order of `config.positions` [m].

        The distance is the encoder angle times the nominal wheel radius, even for a wheel that slips.
        """
        angles = self.shaft_angles.tolist()
        return [angles[g] * r for g, r in zip(self._shaft_of_wheel, self._wheel_radii, strict=True)]

    def wheel_speeds(self) -> list[float]:
        """Return the tread speed of each wheel relative to the robot, in the order of `config.positions` [m/s].

        The speed is the encoder speed times the nominal wheel radius.
        """
        speeds = self.shaft_speeds.tolist()
        return [speeds[g] * r for g, r in zip(self._shaft_of_wheel, self._wheel_radii, strict=True)]

    @property
    def normal_loads(self) -> list[float]:
        """Mean normal force on each wheel in the last call of the loop [N]; static loads before the first call."""
        loads: list[float] = self.wheel_records["mean_load"].tolist()
        return loads if self.time > 0.0 else self.static_loads[:]

    @property
    def wheel_forces(self) -> FloatArray:
        """Mean horizontal ground force on each wheel in the last call of the loop, robot axes [N], shape (n, 2)."""
        return np.column_stack((self.wheel_records["mean_x"], self.wheel_records["mean_y"]))

    @property
    def wheel_slip(self) -> float:
        """Slip speed of the fastest sliding tire in the last step [m/s]; 0 while no tire slides."""
        return float(self.wheel_records["slip"].max()) if self.robot_record["is_sliding"][0] else 0.0

    @property
    def robot(self) -> RobotMass:
        """Current mass properties and wheel positions; equal to `config` before a call of `set_mass_properties`."""
        return self._robot

    @property
    def bus_voltage(self) -> float:
        """Battery voltage at the motors in the last step [V]."""
        return float(self.robot_record["bus"][0])

    @property
    def browned_out(self) -> bool:
        """Whether motor outputs are off because of a brownout or a reset of the roboRIO."""
        return self.battery.browned_out

    @property
    def supply_current(self) -> float:
        """Supply current of all motors of the drivetrain in the last step [A]; negative while regenerating."""
        return float(self.shafts["supply"].sum())

    @property
    def electrical_energy(self) -> float:
        """Electrical energy drawn by all motors since the reset, the integral of V I [J]."""
        return float(self.shafts["energy"].sum())

    @property
    def max_speed(self) -> float:
        """Top speed straight ahead at 12 V [m/s]: the lowest `free_speed` of the drive shafts."""
        return min(self._free_speeds)

    @property
    def max_accel(self) -> float:
        """Acceleration from rest on level ground at a stiff 12 V within traction, motor and stator limits [m/s^2]."""
        return launch_accel(
            self._shafts, self._wheel_configs, self.static_loads, [1.0] * self._driven, self._robot.mass
        )
