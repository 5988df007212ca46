"""A differential (tank) drive: two chained sides on the same motors, tires and solver as the swerve."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simcore.robot.battery import Battery
from simcore.robot.drive_shaft import DriveShaft, WheelContact
from simcore.robot.tank_config import TankConfig
from simcore.robot.wheeled_drive import WheeledDrive, checked_number

__all__ = ["TankDrive"]


class TankDrive(WheeledDrive[TankConfig]):
    """One robot's tank drive; stepped like `SwerveDrive`, commanded by side.

    Example:
        >>> drive = TankDrive(TankConfig())
        >>> drive.set_volts(6.0, 6.0)
        >>> drive.step(0.005, 0.0, 0.0, 0.0)[0] > 0.0
        True
    """

    def __init__(
        self,
        config: TankConfig,
        *,
        battery: Battery | None = None,
        built: tuple[TankConfig, TankConfig] | None = None,
    ) -> None:
        """Stand at rest.

        Args:
            config: The robot, as robot code and the loops on board know it.
            battery: Its battery; None is a stiff 12 V supply.
            built: What motors and wheels of the left and of the right side really are; None: what the config says.
        """
        n = len(config.wheel_xs)
        sides = built or (config, config)
        super().__init__(
            config,
            battery=battery,
            wheels=[WheelContact.of(sides[k // n], place) for k, place in enumerate(config.positions)],
            shafts=[
                DriveShaft.of(
                    c,
                    inertia=n * c.wheel_inertia + c.motors_per_side * c.motor.rotor_inertia * c.gearing**2,
                    motor=c.side_motor,
                    wheels=wheels,
                )
                for c, wheels in zip(sides, (tuple(range(n)), tuple(range(n, 2 * n))), strict=True)
            ],
            radii=[config.wheel_radius] * (2 * n),
        )
        self._known_emf = config.side_motor.emf
        self._volts: tuple[float, float] = (0.0, 0.0)
        self._targets: tuple[float, float] | None = None

    def reset(self, *, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0) -> None:
        """Everything as new: encoders at zero, battery rested, time at zero, sides rolling with the chassis.

        Args:
            vx: Velocity of the center of mass with which the wheels roll, forward [m/s]. The chassis has its own.
            vy: To the left; wheels cannot roll that way [m/s].
            omega: Yaw rate [rad/s].

        Raises:
            NonFiniteError: When a number is not finite; nothing has changed.
        """
        for name, value in (("vx", vx), ("vy", vy), ("omega", omega)):
            checked_number(f"reset {name}", value)
        sides = (self.robot.positions[0][1], self.robot.positions[-1][1])
        self._rest([(vx - omega * y) / self.config.wheel_radius for y in sides])
        self.stop()

    # ---------------------------------------------------------------- commands

    def set_volts(self, left: float, right: float) -> None:
        """Raw voltage per side [V].

        Raises:
            NonFiniteError: When one is missing, NaN or infinite; nothing has changed.
        """
        self._command(_pair("volts", left, right), None)

    def set_speeds(self, left: float, right: float) -> None:
        """Closed loop on board: ground speed per side [m/s]; see `set_volts` for errors."""
        self._command(self._volts, _pair("speed", left, right))

    def set_chassis_speeds(self, vx: float, omega: float) -> None:
        """Closed loop on board: forward speed [m/s] and yaw rate [rad/s], if the wheels did not scrub."""
        vx, omega = _pair("chassis speed", vx, omega)
        half = 0.5 * self.config.trackwidth * omega
        self.set_speeds(vx - half, vx + half)

    def stop(self) -> None:
        """Zero command: brake or coast."""
        self._command((0.0, 0.0), None)

    def _command(self, volts: tuple[float, float], targets: tuple[float, float] | None) -> None:
        is_other = volts != self._volts or targets != self._targets
        self._volts, self._targets = volts, targets
        self._new_command(is_other)

    def _requests(self, h: float, bus: float, neutral: bool) -> tuple[Sequence[float | None], Sequence[float]]:
        c = self.config
        request: list[float | None] = list(self._volts)
        if neutral:
            request = [0.0, 0.0]
        elif self._targets is not None:
            request = [
                self._known_emf * v / c.wheel_radius + _sign(v) * c.friction_volts + c.kp * (v - w * c.wheel_radius)
                for v, w in zip(self._targets, self.shaft_speeds, strict=True)
            ]
        if not c.brake:
            request = [v if v != 0.0 else None for v in request]
        return request, self._stator_limits

    # ---------------------------------------------------------------- readings

    def wheel_angles(self) -> list[float]:
        """Azimuth of each wheel: always forward [rad]."""
        return [0.0] * self._wheels

    def motor_currents(self) -> dict[str, list[float]]:
        """Stator currents in the last inner step, motor by motor: `left` and `right` [A]."""
        left, right = self.drive_motors.current
        return {"left": [left] * self._motors_per_shaft, "right": [right] * self._motors_per_shaft}

    @property
    def gearing(self) -> dict[str, list[float]]:
        """Rotor turns per wheel turn, motor by motor: `left` and `right` [-]."""
        ratios = [self.config.gearing] * self._motors_per_shaft
        return {"left": ratios, "right": ratios[:]}

    def side_distances(self) -> tuple[float, float]:
        """How far left and right wheels have rolled since the reset [m]."""
        left, right = self.shaft_angles
        return left * self.config.wheel_radius, right * self.config.wheel_radius

    def side_speeds(self) -> tuple[float, float]:
        """Speed of the treads against the robot, left and right [m/s]."""
        left, right = self.shaft_speeds
        return left * self.config.wheel_radius, right * self.config.wheel_radius


def _sign(value: float) -> float:
    return math.copysign(1.0, value) if value != 0.0 else 0.0


def _pair(what: str, left: float, right: float) -> tuple[float, float]:
    return checked_number(f"tank {what}, left,", left), checked_number(f"tank {what}, right,", right)
