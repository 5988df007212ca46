"""Tank (differential) and mecanum drives, with the motor and tire models of the swerve drive.

A tank drive has a row of coupled wheels on each side. A mecanum drive has four wheels, each with rollers that grip
along one diagonal. The roller on the floor turns freely about the roller axis, so the floor pushes the roller only
along this axis. The axis d is at 45 degrees to the wheel: d = (1, -1) / sqrt 2 at the front left and rear right wheel,
d = (1, 1) / sqrt 2 at the front right and rear left wheel. A wheel that turns at w moves the contact point at w r d_x
along d. The model of a mecanum wheel is therefore a wheel that points along d, with the radius r d_x and no lateral
grip:

    slip            s = r d_x w - d . v         v: velocity of the contact point over the ground
    tire force      F = mu N s / max(|s|, s0) along d, zero across d
    torque          r d_x F on the shaft

While no roller slides, w = (v_x -+ v_y -+ (|x| + |y|) omega) / r, as in WPILib's MecanumDriveKinematics. The traction
limit is mu N / sqrt 2 along each of the robot's axes. The model ignores the bearing friction of the rollers, so
strafing needs no more force than driving forward. A real robot loses some force in the rollers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from simcore.loop.robot_state import NEUTRAL, TARGET, VOLTS
from simcore.quantities import checked_number, require_count
from simcore.robot.battery import Battery
from simcore.robot.fixed_wheel_config import FixedWheelConfig, MecanumConfig, TankConfig
from simcore.robot.wheel_config import WheelConfig
from simcore.robot.wheeled_drive import DriveShaft, WheeledDrive, launch_accel

__all__ = ["FixedWheelDrive", "MecanumDrive", "TankDrive"]

FixedT = TypeVar("FixedT", bound=FixedWheelConfig)

_HALF = math.sqrt(0.5)
_AT_ONCE = 1e9
"""Slope of the friction feed-forward over the commanded speed [s/m], steep enough to act as a step."""
_SIDES = (-1.0, 1.0, 1.0, -1.0)
"""Sign of d_y for the front left, front right, rear left and rear right wheel."""


class FixedWheelDrive(WheeledDrive[FixedT]):
    """Base of `TankDrive` and `MecanumDrive`, with voltage, speed and neutral commands for each drive shaft.

    Args:
        config: Nominal drivetrain, as assumed by robot code and the on-board loops.
        battery: Battery of the robot; None for a stiff 12 V supply.
        wheels: Wheels as actually built, in the order of `config.positions`.
        shafts: Shafts that turn the wheels, as actually built.
        groups: Name of the motor group of each shaft, a key of `motor_currents`.
        directions: Cosine and sine of the direction in which the wheels of each shaft grip, robot frame.
    """

    def __init__(
        self,
        config: FixedT,
        *,
        battery: Battery | None,
        wheels: Sequence[WheelConfig],
        shafts: Sequence[DriveShaft],
        groups: Sequence[str],
        directions: Sequence[tuple[float, float]],
    ) -> None:
        self._share = directions[0][0]
        radii = [config.wheel_radius / self._share] * len(wheels)
        super().__init__(config, battery=battery, wheels=wheels, shafts=shafts, radii=radii)
        self._groups = groups
        rows, model = self.shafts, self.shafts["model"]
        rows["cos"], rows["sin"] = zip(*directions, strict=True)
        rows["request"]["brakes"], model["known_radius"] = config.brake, config.wheel_radius
        model["feedforward"], model["kp"] = config.shaft_motor(1).emf / config.wheel_radius, config.kp
        model["ks"], model["ks_slope"] = config.friction_volts, _AT_ONCE
        self._rest([0.0] * len(shafts))

    def reset(self, *, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0) -> None:
        """Zero encoders and time, reset the battery, command neutral, and set the wheel speeds for a chassis velocity.

        The wheels roll without slip at this velocity. The velocity of the chassis itself does not change.

        Args:
            vx: Forward velocity of the center of mass [m/s].
            vy: Leftward velocity of the center of mass [m/s]; no effect on a tank drive's wheels.
            omega: Yaw rate [rad/s].

        Raises:
            NonFiniteError: If an argument is not finite; the drive is left unchanged.
        """
        for name, value in (("vx", vx), ("vy", vy), ("omega", omega)):
            checked_number(f"reset {name}", value)
        self._rest([v / self.config.wheel_radius for v in self._treads(vx, vy, omega)])
        self.stop()

    def _treads(self, vx: float, vy: float, omega: float) -> list[float]:
        """Return the tread speed of each shaft at a chassis velocity without slip [m/s]."""
        raise NotImplementedError

    # ---------------------------------------------------------------- commands

    def stop(self) -> None:
        """Command neutral output; motors brake or coast, as configured."""
        self._command(NEUTRAL, [0.0] * self._driven)

    def set_shaft_volts(self, volts: Sequence[float]) -> None:
        """Command the voltage of each shaft [V].

        Args:
            volts: Voltages of left and right side, or of the front left, front right, rear left and rear right wheel.

        Raises:
            NonFiniteError: If a voltage is not a finite number; the old command stays in effect.
            ConfigError: If the number of voltages is not the number of shafts.
        """
        self._command(VOLTS, self._checked("volts", volts))

    def set_shaft_speeds(self, speeds: Sequence[float]) -> None:
        """Set the target tread speed of each shaft's on-board velocity loop [m/s].

        Raises the same errors as `set_shaft_volts`.
        """
        self._command(TARGET, self._checked("speed", speeds))

    def _checked(self, what: str, values: Sequence[float]) -> tuple[float, ...]:
        kind = type(self).__name__
        require_count(f"{kind} {what}", values, self._driven, "shafts")
        return tuple(checked_number(f"{kind} {what} of shaft {k} ({self._groups[k]})", v) for k, v in enumerate(values))

    # ---------------------------------------------------------------- readings

    def shaft_emf(self, shaft: int) -> float:
        """Return the back-EMF of each motor of a shaft: the voltage at which the motor carries no current [V]."""
        return float(self.shaft_speeds[shaft]) * self.config.shaft_motor(1).emf

    def wheel_angles(self) -> list[float]:
        """Return the direction in which each wheel grips, counter-clockwise from forward [rad].

        The order is that of `config.positions`.
        """
        sin, cos = self.shafts["sin"], self.shafts["cos"]
        return [math.atan2(sin[g], cos[g]) for g in self._shaft_of_wheel]

    def motor_currents(self) -> dict[str, list[float]]:
        """Return each motor's stator current in the last step [A], by group: `left` and `right`, or `drive`."""
        return self._by_group(self.drive_motors.current)

    @property
    def gearing(self) -> dict[str, list[float]]:
        """Gear ratio of each motor: rotor turns per wheel turn [-], by the groups of `motor_currents`."""
        return self._by_group([self.config.gearing] * self._driven)

    def _by_group(self, values: Sequence[float]) -> dict[str, list[float]]:
        found: dict[str, list[float]] = {}
        for name, value in zip(self._groups, values, strict=True):
            found.setdefault(name, []).extend([value] * self._motors_per_shaft)
        return found

    @property
    def max_speed(self) -> float:
        """Top speed straight ahead at 12 V [m/s]: the speed where the motor torque equals friction and rolling drag."""
        return super().max_speed / self._share

    @property
    def max_accel(self) -> float:
        """Acceleration straight ahead from rest at a stiff 12 V within traction and stator limits [m/s^2]."""
        arms = [self._share] * self._driven
        return launch_accel(self._shafts, self._wheel_configs, self.static_loads, arms, self.robot.mass)


class TankDrive(FixedWheelDrive[TankConfig]):
    """Tank drive of a robot, with commands per side.

    Example:
        >>> from simcore.testing.benches import hold
        >>> drive = TankDrive(TankConfig())
        >>> drive.set_volts(6.0, 6.0)
        >>> hold(drive, 0.005, (0.0, 0.0, 0.0))[0] > 0.0
        True
    """

    def __init__(
        self,
        config: TankConfig,
        *,
        battery: Battery | None = None,
        built: Sequence[FixedWheelConfig] | None = None,
    ) -> None:
        """Create the drive at rest, in neutral.

        Args:
            config: Nominal drivetrain, as assumed by robot code and the on-board loops.
            battery: Battery of the robot; None for a stiff 12 V supply.
            built: Motors and wheels of the left and right side as actually built; None for the values in the config.
        """
        n, motors = len(config.wheel_xs), config.motors_per_side
        sides: Sequence[FixedWheelConfig] = built or config.sides
        super().__init__(
            config,
            battery=battery,
            wheels=[sides[k // n] for k in range(2 * n)],
            shafts=[
                DriveShaft.of(c, inertia=c.shaft_inertia(n, motors), motor=c.shaft_motor(motors), wheels=wheels)
                for c, wheels in zip(sides, (tuple(range(n)), tuple(range(n, 2 * n))), strict=True)
            ],
            groups=("left", "right"),
            directions=[(1.0, 0.0)] * 2,
        )

    def set_volts(self, left: float, right: float) -> None:
        """Command the voltage of each side [V]; raises the same errors as `set_shaft_volts`."""
        self.set_shaft_volts((left, right))

    def set_speeds(self, left: float, right: float) -> None:
        """Set the target tread speed of each side's on-board velocity loop [m/s].

        Raises the same errors as `set_shaft_volts`.
        """
        self.set_shaft_speeds((left, right))

    def set_chassis_speeds(self, vx: float, omega: float) -> None:
        """Set the targets of the on-board velocity loops for a forward speed [m/s] and a yaw rate [rad/s].

        The conversion of the yaw rate to tread speeds ignores wheel scrub.

        Raises:
            NonFiniteError: If a speed is NaN or infinite; the old command is kept.
        """
        vx, omega = checked_number("chassis speed vx", vx), checked_number("chassis speed omega", omega)
        half = 0.5 * self.config.trackwidth * omega
        self.set_speeds(vx - half, vx + half)

    def _treads(self, vx: float, vy: float, omega: float) -> list[float]:
        return [vx - omega * self.robot.positions[row][1] for row in (0, -1)]


class MecanumDrive(FixedWheelDrive[MecanumConfig]):
    """Mecanum drive of a robot, with commands per wheel.

    Example:
        >>> from simcore.testing.benches import hold
        >>> drive = MecanumDrive(MecanumConfig())
        >>> drive.set_volts([-6.0, 6.0, 6.0, -6.0])  # to the left
        >>> dvx, dvy, _ = hold(drive, 0.005, (0.0, 0.0, 0.0))
        >>> abs(dvx) < 1e-9 < dvy
        True
    """

    def __init__(
        self,
        config: MecanumConfig,
        *,
        battery: Battery | None = None,
        built: Sequence[FixedWheelConfig] | None = None,
    ) -> None:
        """Create the drive at rest, in neutral.

        Args:
            config: Nominal drivetrain, as assumed by robot code and the on-board loops.
            battery: Battery of the robot; None for a stiff 12 V supply.
            built: Motors and tire of each wheel as actually built; None for the values in the config.
        """
        wheels: Sequence[FixedWheelConfig] = built or [config] * 4
        motors = config.motors_per_wheel
        shafts = [
            DriveShaft.of(c, inertia=c.shaft_inertia(1, motors), motor=c.shaft_motor(motors), wheels=(k,))
            for k, c in enumerate(wheels)
        ]
        super().__init__(
            config,
            battery=battery,
            wheels=wheels,
            shafts=[replace(s, radius=_HALF * s.radius, grain=0.0) for s in shafts],
            groups=("drive",) * 4,
            directions=[(_HALF, _HALF * side) for side in _SIDES],
        )

    def set_volts(self, volts: Sequence[float]) -> None:
        """Command the voltage of each wheel, in the order of `MecanumConfig.places` [V].

        Raises the same errors as `set_shaft_volts`.
        """
        self.set_shaft_volts(volts)

    def set_speeds(self, speeds: Sequence[float]) -> None:
        """Set the target tread speed of each wheel's on-board velocity loop [m/s], in the order of `places`.

        Raises the same errors as `set_shaft_volts`.
        """
        self.set_shaft_speeds(speeds)

    def set_chassis_speeds(self, vx: float, vy: float, omega: float) -> None:
        """Set the targets of the on-board velocity loops for robot-relative chassis speeds [m/s, m/s, rad/s].

        The method scales all wheel speeds down if a wheel would exceed `max_speed`.

        Raises:
            NonFiniteError: If a speed is NaN or infinite; the old command is kept.
        """
        for name, value in (("vx", vx), ("vy", vy), ("omega", omega)):
            checked_number(f"chassis speed {name}", value)
        x, y, _ = self.robot.center_of_mass
        speeds = self._treads(vx - omega * y, vy + omega * x, omega)
        scale = min(1.0, self.max_speed / max(max(map(abs, speeds)), 1e-9))
        self.set_speeds([scale * v for v in speeds])

    def _treads(self, vx: float, vy: float, omega: float) -> list[float]:
        places = self.robot.positions
        return [vx - omega * y + side * (vy + omega * x) for (x, y), side in zip(places, _SIDES, strict=True)]
