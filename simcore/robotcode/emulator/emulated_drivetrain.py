"""Emulation of `SwerveDrivetrain`: odometry, pose estimate and control, once per period of simulated time.

The module contains poses and kinematics in plain floats (WPILib's Pose2d and SwerveDriveKinematics without objects),
the pose estimator, the swerve module and its devices, the swerve requests, and the drivetrain.
"""

from __future__ import annotations

import dataclasses
import math
from bisect import bisect_left
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Protocol, TypeAlias

from phoenix6.spns.spn_value import SpnValue

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress
from simcore.robotcode.emulator.emulated_device import REQUESTS
from simcore.robotcode.emulator.emulated_peripherals import EmulatedPigeon2
from simcore.robotcode.emulator.emulator import Emulator
from simcore.robotcode.emulator.output_stage import KRAKEN_X60
from simcore.units import plain_sum

__all__ = [
    "DEFAULT_HZ",
    "Brake",
    "Centric",
    "DrivetrainRequest",
    "DrivetrainState",
    "EmulatedDrivetrain",
    "Idle",
    "Kinematics",
    "ModuleConstants",
    "ModuleDevices",
    "Point",
    "Pose",
    "PoseEstimator",
    "Speeds",
    "between",
    "desaturate",
    "discretize",
    "exp",
    "interpolate",
    "then",
    "wrap",
]

Pose: TypeAlias = tuple[float, float, float]


def wrap(angle: float) -> float:
    """Return the equivalent angle from -pi to pi [rad]."""
    return math.remainder(angle, math.tau)


def exp(start: Pose, dx: float, dy: float, turn: float) -> Pose:
    """Return the pose after a constant twist (dx, dy [m] and turn [rad], robot frame) from `start`.

    Source: WPILib's Pose2d.Exp; R. Murray et al., A Mathematical Introduction to Robotic Manipulation, 2.3.
    """
    if abs(turn) < 1e-9:
        s, c = 1.0 - turn * turn / 6.0, 0.5 * turn
    else:
        s, c = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn
    along, across = dx * s - dy * c, dx * c + dy * s
    cos, sin = math.cos(start[2]), math.sin(start[2])
    return start[0] + cos * along - sin * across, start[1] + sin * along + cos * across, start[2] + turn


def between(start: Pose, end: Pose) -> Pose:
    """Return the pose `end` in the frame of the pose `start`."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    cos, sin = math.cos(start[2]), math.sin(start[2])
    return cos * dx + sin * dy, cos * dy - sin * dx, wrap(end[2] - start[2])


def then(start: Pose, way: Pose) -> Pose:
    """Transform the pose `way` from the frame of `start` to the field frame, without wrapping the heading."""
    cos, sin = math.cos(start[2]), math.sin(start[2])
    return start[0] + cos * way[0] - sin * way[1], start[1] + sin * way[0] + cos * way[1], start[2] + way[2]


def interpolate(start: Pose, end: Pose, part: float) -> Pose:
    """Return the pose at fraction `part` of the constant twist from `start` to `end`.

    Source: WPILib's Pose2d.Interpolate.
    """
    x, y, turn = between(start, end)
    half = 0.5 * turn
    # inverse of `exp`: half the turn divided by the tangent of half the turn
    stretch = half * math.cos(half) / math.sin(half) if abs(half) > 1e-9 else 1.0 - half * half / 3.0
    dx, dy = x * stretch + y * half, y * stretch - x * half
    return exp(start, dx * part, dy * part, turn * part)


class Kinematics:
    """Inverse and forward kinematics of a swerve drive.

    Args:
        positions: Module positions (x, y) relative to the robot's center [m].
    """

    def __init__(self, positions: Sequence[tuple[float, float]]) -> None:
        self.positions = [(float(x), float(y)) for x, y in positions]
        n = len(self.positions)
        self._n = n
        self._cx = plain_sum([x for x, _ in self.positions]) / n
        self._cy = plain_sum([y for _, y in self.positions]) / n
        self._arms = [(x - self._cx, y - self._cy) for x, y in self.positions]
        self._spread = plain_sum([x * x + y * y for x, y in self._arms])
        self._headings = [0.0] * n

    def states(
        self, vx: float, vy: float, omega: float, center_x: float = 0.0, center_y: float = 0.0
    ) -> list[tuple[float, float]]:
        """Return the speed [m/s] and direction [rad] of every module for a robot-frame chassis velocity.

        A zero chassis velocity keeps the directions of the last call, as in WPILib.

        Args:
            vx: Forward velocity [m/s].
            vy: Leftward velocity [m/s].
            omega: Yaw rate, counter-clockwise positive [rad/s].
            center_x: x coordinate of the center of rotation, robot frame [m].
            center_y: y coordinate of the center of rotation, robot frame [m].
        """
        if vx == 0.0 and vy == 0.0 and omega == 0.0:
            return [(0.0, heading) for heading in self._headings]
        result = []
        for k, (x, y) in enumerate(self.positions):
            mx = vx - omega * (y - center_y)
            my = vy + omega * (x - center_x)
            speed = math.hypot(mx, my)
            angle = math.atan2(my, mx) if speed > 1e-6 else 0.0
            self._headings[k] = angle
            result.append((speed, angle))
        return result

    def chassis(self, moves: Sequence[tuple[float, float]]) -> tuple[float, float, float]:
        """Return the rigid motion that best fits the modules' motions (least squares).

        Args:
            moves: Velocity (x, y) [m/s] or travel (x, y) [m] of each module, robot frame.

        Returns:
            Velocity (x, y, yaw rate) [m/s, m/s, rad/s] or travel (x, y, turn) [m, m, rad] of the robot's center.
        """
        sx = sy = turn = 0.0
        for (mx, my), (ax, ay) in zip(moves, self._arms, strict=True):
            sx += mx
            sy += my
            turn += ax * my - ay * mx
        turn = turn / self._spread if self._spread > 0.0 else 0.0
        return sx / self._n + turn * self._cy, sy / self._n - turn * self._cx, turn


def desaturate(states: list[tuple[float, float]], limit: float) -> list[tuple[float, float]]:
    """Return the module states, with all speeds scaled down by one factor if any speed exceeds `limit` [m/s]."""
    fastest = max(abs(speed) for speed, _ in states)
    if fastest <= limit:
        return states
    return [(speed / fastest * limit, angle) for speed, angle in states]


def discretize(vx: float, vy: float, omega: float, period: float) -> tuple[float, float, float]:
    """Return the constant robot-frame velocity that leads to the same pose as a constant field-frame velocity.

    Args:
        vx: Forward component of the field-frame velocity at the start of the period [m/s].
        vy: Leftward component of the field-frame velocity at the start of the period [m/s].
        omega: Yaw rate, counter-clockwise positive [rad/s].
        period: Time after which the poses agree [s].

    Returns:
        Robot-frame velocity (x, y, yaw rate) [m/s, m/s, rad/s].

    Source: WPILib's ChassisSpeeds.Discretize.
    """
    half = 0.5 * omega * period
    stretch = half * math.cos(half) / math.sin(half) if abs(half) > 1e-9 else 1.0
    return vx * stretch + vy * half, vy * stretch - vx * half, omega


HISTORY = 1.5
"""Time span of the stored pose history [s]."""


class PoseEstimator:
    """WPILib's pose estimator in CTRE's version: wheel and gyro odometry, corrected by delayed vision measurements.

    The estimator computes each correction in the robot frame at the time of the measurement, and multiplies each axis
    by the gain q / (q + sqrt(q r)) of a steady-state Kalman filter, with the variances q of odometry and r of vision.
    The results match Phoenix 6 26.3.0 to the last printed digit.

    Args:
        state_std_devs: Standard deviations of odometry: x [m], y [m], heading [rad].
        vision_std_devs: Standard deviations of a vision measurement: x [m], y [m], heading [rad].
    """

    def __init__(
        self,
        state_std_devs: Sequence[float] = (0.1, 0.1, 0.1),
        vision_std_devs: Sequence[float] = (0.9, 0.9, 0.9),
    ) -> None:
        self._state_std_devs = [float(s) for s in state_std_devs]
        self._vision_std_devs = [float(s) for s in vision_std_devs]
        self._times: deque[float] = deque()
        self._poses: deque[Pose] = deque()
        self._updates: list[tuple[float, Pose, Pose]] = []  # time, corrected pose, odometry's pose
        self._odometry: Pose = (0.0, 0.0, 0.0)
        self._offset = 0.0
        self.pose: Pose = (0.0, 0.0, 0.0)
        """Estimated pose, field frame [m, m, rad]."""

    def set_state_std_devs(self, std_devs: Sequence[float]) -> None:
        """Set the standard deviations of odometry (x [m], y [m], heading [rad]) for all later vision measurements."""
        self._state_std_devs = [float(s) for s in std_devs]

    def set_vision_std_devs(self, std_devs: Sequence[float]) -> None:
        """Set the standard deviations of vision (x [m], y [m], heading [rad]) for all later vision measurements."""
        self._vision_std_devs = [float(s) for s in std_devs]

    def reset(self, pose: Pose, gyro_yaw: float) -> None:
        """Set the estimated pose, and clear the pose history and all vision corrections.

        Args:
            pose: New estimated pose, field frame [m, m, rad].
            gyro_yaw: Present continuous yaw of the gyro [rad].
        """
        self._offset = pose[2] - gyro_yaw
        self._odometry = self.pose = pose
        self._times.clear()
        self._poses.clear()
        self._updates.clear()

    def update(self, time: float, dx: float, dy: float, gyro_yaw: float) -> None:
        """Add the travel of one period to odometry, and update the estimated pose.

        Args:
            time: Time of the update [s].
            dx: Forward travel [m].
            dy: Leftward travel [m].
            gyro_yaw: Continuous yaw of the gyro [rad].
        """
        old = self._odometry
        new = exp(old, dx, dy, gyro_yaw + self._offset - old[2])
        self._odometry = new
        times = self._times
        times.append(time)
        self._poses.append(new)
        oldest = time - HISTORY
        while times[0] < oldest:
            times.popleft()
            self._poses.popleft()
        self.pose = self._corrected(new) if self._updates else new

    def add_vision(self, pose: Pose, time: float, std_devs: Sequence[float] | None = None) -> None:
        """Correct the estimated pose with a vision measurement of the robot pose at `time` [s].

        The estimator ignores the measurement if no pose is stored, or if `time` is over 1.5 s before the oldest stored
        pose. An accepted measurement discards all corrections from later times.

        Args:
            pose: Measured robot pose, field frame [m, m, rad].
            time: Time of the measurement [s].
            std_devs: Standard deviations of this and all later measurements (x [m], y [m], heading [rad]); None keeps
                the present standard deviations.
        """
        if std_devs is not None:
            self.set_vision_std_devs(std_devs)
        if not self._times or time < self._times[0] - HISTORY:
            return
        odometry = self._sample(time)
        believed = self._believed(time, odometry)
        way = between(believed, pose)
        gains = [_gain(q, r) for q, r in zip(self._state_std_devs, self._vision_std_devs, strict=True)]
        corrected = then(believed, (way[0] * gains[0], way[1] * gains[1], way[2] * gains[2]))
        oldest = self._times[0]
        kept = [u for u in self._updates if u[0] < time]
        # of all corrections older than the history, only the latest still matters
        while len(kept) > 1 and kept[1][0] < oldest:
            kept.pop(0)
        self._updates = [*kept, (time, corrected, odometry)]
        self.pose = self._corrected(self._odometry)

    def sample(self, time: float) -> Pose | None:
        """Return the estimated pose at `time` [s], clamped to the stored history; None if no pose is stored."""
        if not self._times:
            return None
        return self._believed(time, self._sample(time))

    # --- internals ----------------------------------------------------------------------------------------------

    def _sample(self, time: float) -> Pose:
        """Return the odometry pose at `time` [s], clamped to the oldest and newest stored poses."""
        times, poses = self._times, self._poses
        k = bisect_left(times, time)
        if k == 0:
            return poses[0]
        if k == len(times):
            return poses[-1]
        return interpolate(poses[k - 1], poses[k], (time - times[k - 1]) / (times[k] - times[k - 1]))

    def _believed(self, time: float, odometry: Pose) -> Pose:
        for at, corrected, then_odometry in reversed(self._updates):
            if at <= time:
                return then(corrected, between(then_odometry, odometry))
        return odometry

    def _corrected(self, odometry: Pose) -> Pose:
        _, corrected, then_odometry = self._updates[-1]
        x, y, heading = then(corrected, between(then_odometry, odometry))
        return x, y, wrap(heading)


def _gain(state: float, vision: float) -> float:
    """Return the steady-state Kalman gain [-] of one axis for the standard deviations of odometry and vision."""
    if state == 0.0:
        return 0.0
    if not math.isfinite(vision):
        return 0.0
    return state / (state + vision)


_FEEDBACK = (
    *("FUSED_CANCODER", "SYNC_CANCODER", "REMOTE_CANCODER"),
    *("FUSED_CANDI_PWM1", "FUSED_CANDI_PWM2", "SYNC_CANDI_PWM1", "SYNC_CANDI_PWM2"),
    *("REMOTE_CANDI_PWM1", "REMOTE_CANDI_PWM2", "TALON_FXS_PULSE_WIDTH"),
)
_CANCODERS = 3  # number of leading feedback sources that use a CANcoder


@dataclass(frozen=True, slots=True)
class ModuleConstants:
    """Constants of one swerve module, in the order of the native function's arguments."""

    steer_motor_id: int
    drive_motor_id: int
    encoder_id: int
    encoder_offset: float
    """Offset of the steer encoder [rotations]."""
    x: float
    """x coordinate of the module, robot frame [m]."""
    y: float
    drive_inverted: bool
    steer_inverted: bool
    encoder_inverted: bool
    drive_gearing: float
    """Drive rotor turns per wheel turn [-]."""
    steer_gearing: float
    coupling: float
    """Drive rotor turns that one turn of the steering axis causes [-]."""
    wheel_radius: float
    """Wheel radius [m]."""
    steer_output: int
    drive_output: int
    slip_current: float
    """Stator current at which the wheel slips [A]."""
    speed_at_12_volts: float
    """Robot speed at 12 V [m/s]."""
    drive_motor_type: int
    steer_motor_type: int
    feedback_source: int
    steer_inertia: float
    drive_inertia: float
    steer_friction_voltage: float
    drive_friction_voltage: float

    def __post_init__(self) -> None:
        where = f"swerve module with drive motor {self.drive_motor_id}"
        for name in ("drive_gearing", "wheel_radius", "speed_at_12_volts"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value != 0.0):
                raise ConfigError(f"{where}: {name} must be a finite number other than 0, got {value}")
        if self.drive_motor_type != 0 or self.steer_motor_type != 0:
            raise NotImplementedError(
                f"{where}: only TalonFX motors are modelled in simulated time, got motor arrangements "
                f"{self.drive_motor_type} (drive) and {self.steer_motor_type} (steer); use --phoenix=real"
            )
        if not 0 <= self.feedback_source < _CANCODERS:
            known = 0 <= self.feedback_source < len(_FEEDBACK)
            name = _FEEDBACK[self.feedback_source] if known else str(self.feedback_source)
            raise NotImplementedError(
                f"{where}: steer feedback {name} is not modelled in simulated time, "
                f"{', '.join(_FEEDBACK[:_CANCODERS])} are; use --phoenix=real"
            )

    @property
    def rotations_per_meter(self) -> float:
        """Drive rotor turns per meter of travel on the carpet [1/m]."""
        return self.drive_gearing / (math.tau * self.wheel_radius)


_TORQUE_CURRENT = 1  # value in `phoenix6.swerve.ClosedLoopOutputType`
_NEUTRAL_MODE = SpnValue.CONFIG_NEUTRAL_MODE.value
_VOLTS = REQUESTS["VoltageOut"]
_TORQUE_PER_AMPERE = 0.0198
"""Torque constant reported by a TalonFX for a Kraken X60 with FOC [N m/A]."""


class ModuleDevices:
    """Drive and steer TalonFX of a module, with closed-loop outputs in volts or amperes.

    The module constants select the output type of each motor.

    Physics writes the rotor sensors once per step, and the sensor values stay constant between two steps. The present
    reading therefore equals the latency-compensated reading. A repeated request changes only the setpoints. This
    shortcut reduced the time of eight requests at 250 Hz from 0.13 to 0.04 ms per tick.

    Args:
        emulator: Emulator that contains the devices.
        constants: Module constants, including CAN IDs and output types.
        bus: Name of the CAN bus of both motors.
    """

    def __init__(self, emulator: Emulator, constants: ModuleConstants, bus: str) -> None:
        self._drive = emulator.talon(constants.drive_motor_id, bus)
        self._steer = emulator.talon(constants.steer_motor_id, bus)
        drives_torque = constants.drive_output == _TORQUE_CURRENT
        steers_torque = constants.steer_output == _TORQUE_CURRENT
        self._drive_torque = drives_torque
        self._steer_torque = steers_torque
        self._velocity = REQUESTS["VelocityTorqueCurrentFOC" if drives_torque else "VelocityVoltage"]
        self._position = REQUESTS["PositionTorqueCurrentFOC" if steers_torque else "PositionVoltage"]

    def sample(self) -> tuple[float, float, float, float]:
        """Update the sensor readings of both motors, and return the positions and velocities.

        Returns:
            Drive position [rotor rotations], drive velocity [rotor rotations/s], steer position [rotations] and steer
            velocity [rotations/s].
        """
        drive, steer = self._drive, self._steer
        drive.measure()
        steer.measure()
        return drive.loop.pos, drive.loop.vel, steer.loop.pos, steer.loop.vel

    def drive_volts(self, volts: float, foc: bool) -> None:
        """Request an open-loop voltage [V] from the drive motor, with FOC if `foc` is true."""
        if self._drive.renew(_VOLTS, foc):
            self._drive.loop.output = volts
        else:
            self._drive.apply(_VOLTS.name, update_freq_hz=0.0, output=volts, enable_foc=foc)

    def drive_velocity(self, rps: float, amperes: float, volts: float, foc: bool) -> None:
        """Request closed-loop control of the drive velocity [rotor rotations/s].

        The feed-forward is `amperes` [A] for a torque-current loop, and `volts` [V] for a voltage loop. A voltage
        loop uses FOC if `foc` is true.
        """
        drive = self._drive
        if drive.renew(self._velocity, foc):
            drive.loop.goal_v = rps
            drive.loop.feed_forward = amperes if self._drive_torque else volts
        elif self._drive_torque:
            drive.apply(
                self._velocity.name,
                update_freq_hz=0.0,
                velocity=rps,
                feed_forward=amperes,
                override_coast_dur_neutral=True,
            )
        else:
            drive.apply(self._velocity.name, update_freq_hz=0.0, velocity=rps, feed_forward=volts, enable_foc=foc)

    def steer_position(self, rotations: float, rps: float, foc: bool) -> None:
        """Request a steer position [rotations] in the shorter direction, with a steer velocity [rotations/s]."""
        steer = self._steer
        if steer.renew(self._position, foc):
            steer.loop.goal_p = rotations
            steer.loop.goal_v = rps
        elif self._steer_torque:
            steer.apply(self._position.name, update_freq_hz=0.0, position=rotations, velocity=rps)
        else:
            steer.apply(self._position.name, update_freq_hz=0.0, position=rotations, velocity=rps, enable_foc=foc)

    def steer_profiled(self, rotations: float, foc: bool) -> None:
        """Request a steer position [rotations] in the shorter direction, with a Motion Magic Expo profile."""
        if self._steer_torque:
            self._steer.apply("MotionMagicExpoTorqueCurrentFOC", update_freq_hz=0.0, position=rotations)
        else:
            self._steer.apply("MotionMagicExpoVoltage", update_freq_hz=0.0, position=rotations, enable_foc=foc)

    def zero_drive(self) -> None:
        """Set the drive motor's present position to 0."""
        self._drive.set_position(0.0)

    def set_neutral(self, brake: bool) -> int:
        """Set the drive motor's neutral mode to brake or coast, and return the status code 0 (OK)."""
        self._drive.configure({_NEUTRAL_MODE: int(brake)})
        return 0

    def torque_constants(self) -> tuple[float, float]:
        """Return the drive motor's torque constant [N m/A] and winding resistance [ohm]."""
        return _TORQUE_PER_AMPERE, KRAKEN_X60.model.resistance


_COUPLING_GAIN = 1.0 - math.exp(-0.004 / 0.05)
"""Gain per call of the low-pass filter for the steer rate [-], with a time constant of 50 ms at 250 Hz."""


class EmulatedModule:
    """Emulated swerve module, with control rules derived from measured outputs of Phoenix 6 26.3.0.

    Args:
        constants: Module constants.
        devices: Motors of the module.
    """

    def __init__(self, constants: ModuleConstants, devices: ModuleDevices) -> None:
        self.constants = constants
        self.devices = devices
        self.distance = 0.0
        """Travel of the wheel, corrected for the drive rotation that steering causes [m]."""
        self.angle = 0.0
        """Continuous steer angle [rad]."""
        self.cos, self.sin = 1.0, 0.0
        """Cosine and sine of the steer angle."""
        self.speed = 0.0
        """Wheel speed, not corrected for the drive rotation that steering causes, as in `SwerveModuleState` [m/s]."""
        self.target = (0.0, 0.0)
        """Last target speed [m/s] and direction [rad]. The speed is negative for a reversed wheel."""
        self._per_meter = constants.rotations_per_meter
        self._coupling = constants.coupling
        self._volts_per_rps = 12.0 / (self._per_meter * constants.speed_at_12_volts)
        self._torque_per_force = constants.wheel_radius / constants.drive_gearing
        self._steer_rate = 0.0
        self._smooth_steer_rate = 0.0

    def refresh(self) -> float:
        """Update travel, steer angle and speed from the motors; return the travel since the last call [m]."""
        drive, drive_rate, azimuth, self._steer_rate = self.devices.sample()
        before = self.distance
        self.distance = (drive - azimuth * self._coupling) / self._per_meter
        self.angle = angle = azimuth * math.tau
        self.cos, self.sin = math.cos(angle), math.sin(angle)
        self.speed = drive_rate / self._per_meter
        return self.distance - before

    def present_position(self) -> tuple[float, float]:
        """Return the present travel [m] and steer angle [rad] without changing odometry."""
        drive, _, azimuth, _ = self.devices.sample()
        return (drive - azimuth * self._coupling) / self._per_meter, azimuth * math.tau

    def zero(self) -> None:
        """Set the drive motor's present position to 0, without adding travel to odometry."""
        self.devices.zero_drive()
        self.distance = self.present_position()[0]

    def apply(
        self,
        speed: float,
        angle: float,
        *,
        closed_loop: bool,
        profiled: bool,
        period: float = 0.0,
        force_x: float = 0.0,
        force_y: float = 0.0,
        foc: bool = True,
    ) -> None:
        """Drive at `speed` [m/s] in the direction `angle` [rad], reversing the wheel to shorten the steer move.

        The module scales the drive speed by the cosine of the steer error, and adds the drive rotation that the
        coupling of the steer and drive gears requires.

        Args:
            speed: Target speed [m/s].
            angle: Direction, robot frame [rad].
            closed_loop: Whether to control the drive velocity in closed loop; False for a voltage proportional to the
                speed.
            profiled: Whether to steer with Motion Magic Expo.
            period: Time since the last call, for the steer velocity feed-forward [s]; 0 for no feed-forward.
            force_x: Forward component of the feed-forward force on the carpet, robot frame [N].
            force_y: Leftward component of the feed-forward force on the carpet, robot frame [N].
            foc: Whether the motors use FOC for voltage outputs.
        """
        lack = wrap(angle - self.angle)
        if abs(lack) > 0.5 * math.pi:
            speed, angle, lack = -speed, angle + math.pi, wrap(lack + math.pi)
        angle = wrap(angle)
        rate = wrap(angle - self.target[1]) / (period * math.tau) if period > 0.0 else 0.0
        self.target = (speed, angle)
        devices = self.devices
        if profiled:
            devices.steer_profiled(angle / math.tau, foc)
        else:
            devices.steer_position(angle / math.tau, rate, foc)

        self._smooth_steer_rate += _COUPLING_GAIN * (self._steer_rate - self._smooth_steer_rate)
        rps = speed * self._per_meter * max(math.cos(lack), 0.0) + self._smooth_steer_rate * self._coupling
        amperes = volts = 0.0
        if force_x != 0.0 or force_y != 0.0:
            force = force_x * self.cos + force_y * self.sin
            per_ampere, ohms = devices.torque_constants()
            amperes = force * self._torque_per_force / per_ampere
            volts = amperes * ohms
        if closed_loop:
            devices.drive_velocity(rps, amperes, volts, foc)
        else:
            devices.drive_volts(rps * self._volts_per_rps + volts, foc)


_VELOCITY = 1  # value in SwerveModule.DriveRequestType
_EXPO = 0  # value in SwerveModule.SteerRequestType
_OPERATOR = 0  # value in ForwardPerspectiveValue


class DrivetrainRequest(Protocol):
    """Swerve request that controls the modules of a drivetrain once per period."""

    def apply(self, drivetrain: EmulatedDrivetrain) -> None:
        """Send the control requests for one period to the drivetrain's motors."""
        ...


@dataclass(frozen=True, slots=True)
class Idle:
    """Swerve request that sends no control requests. The motors' last requests then time out."""

    def apply(self, drivetrain: EmulatedDrivetrain) -> None:
        """Send no control requests."""


@dataclass(frozen=True, slots=True)
class Brake:
    """Swerve request that turns the wheels into an X pattern at zero speed."""

    drive: int
    steer: int

    def apply(self, drivetrain: EmulatedDrivetrain) -> None:
        """Request zero speed with every wheel pointed at the robot's center."""
        _send(self, drivetrain, [(0.0, math.atan2(y, x)) for x, y in drivetrain.kinematics.positions])


@dataclass(frozen=True, slots=True)
class Point:
    """Swerve request that points all wheels in one direction at zero speed."""

    angle: float
    """Direction of the wheels, robot frame [rad]."""
    drive: int
    steer: int

    def apply(self, drivetrain: EmulatedDrivetrain) -> None:
        """Request zero speed with every wheel in the requested direction."""
        _send(self, drivetrain, [(0.0, self.angle)] * len(drivetrain.modules))


@dataclass(frozen=True, slots=True)
class Speeds:
    """Swerve request ApplyRobotSpeeds, or ApplyFieldSpeeds if `is_field` is true.

    `is_field` applies to the chassis velocity and to the wheel forces.
    """

    vx: float
    vy: float
    omega: float
    forces_x: tuple[float, ...]
    forces_y: tuple[float, ...]
    center_x: float
    center_y: float
    drive: int
    steer: int
    desaturate: bool
    perspective: int = 1
    is_field: bool = dataclasses.field(default=False, kw_only=True)

    def apply(self, drivetrain: EmulatedDrivetrain) -> None:
        """Control the modules at the requested chassis velocity, with the wheel forces as feed-forward."""
        states, turn = _module_states(self, drivetrain, self.vx, self.vy, self.omega)
        forces = list(zip_longest(self.forces_x, self.forces_y, fillvalue=0.0))
        if self.is_field:
            forces = [_rotated(*force, turn) for force in forces]
        _send(self, drivetrain, states, forces)


@dataclass(frozen=True, slots=True)
class Centric:
    """Swerve request RobotCentric, or FieldCentric if `is_field` is true: a chassis velocity with deadbands."""

    vx: float
    vy: float
    omega: float
    deadband: float
    """Speed below which the translation is zero [m/s]."""
    rotational_deadband: float
    """Yaw rate below which the rotation is zero [rad/s]."""
    center_x: float
    center_y: float
    drive: int
    steer: int
    desaturate: bool
    perspective: int = 1
    is_field: bool = dataclasses.field(default=False, kw_only=True)

    def apply(self, drivetrain: EmulatedDrivetrain) -> None:
        """Control the modules at the requested chassis velocity, after applying the deadbands."""
        vx, vy, omega = self.vx, self.vy, self.omega
        if math.hypot(vx, vy) < self.deadband:
            vx = vy = 0.0
        if abs(omega) < self.rotational_deadband:
            omega = 0.0
        states, _ = _module_states(self, drivetrain, vx, vy, omega)
        _send(self, drivetrain, states)


def _send(
    request: Brake | Point | Speeds | Centric,
    drivetrain: EmulatedDrivetrain,
    states: Sequence[tuple[float, float]],
    forces: Sequence[tuple[float, float]] = (),
) -> None:
    """Send each module its robot-frame state [m/s, rad] and force feed-forward [N]. A missing force is zero."""
    for k, (module, (speed, angle)) in enumerate(zip(drivetrain.modules, states, strict=True)):
        fx, fy = forces[k] if k < len(forces) else (0.0, 0.0)
        module.apply(
            speed,
            angle,
            closed_loop=request.drive == _VELOCITY,
            profiled=request.steer == _EXPO,
            period=drivetrain.period,
            force_x=fx,
            force_y=fy,
        )


def _module_states(
    request: Speeds | Centric, drivetrain: EmulatedDrivetrain, vx: float, vy: float, omega: float
) -> tuple[list[tuple[float, float]], float]:
    """Return the module states [m/s, rad] for a chassis velocity in the request's frame [m/s, m/s, rad/s].

    The second return value is the angle that rotates vectors from the request's frame to the robot frame [rad]; 0 for a
    robot-centric request.
    """
    turn = 0.0
    if request.is_field:
        turn = -drivetrain.heading + (drivetrain.operator_forward if request.perspective == _OPERATOR else 0.0)
        vx, vy = _rotated(vx, vy, turn)
        vx, vy, omega = discretize(vx, vy, omega, drivetrain.period)
    states = drivetrain.kinematics.states(vx, vy, omega, request.center_x, request.center_y)
    if request.desaturate:
        states = desaturate(states, drivetrain.max_speed)
    return states, turn


def _rotated(x: float, y: float, angle: float) -> tuple[float, float]:
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


DEFAULT_HZ = 250.0
"""Default frequency of odometry and control on CAN FD, the type of every simulated bus [Hz]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivetrainState:
    """Contents of `SwerveDriveState` at the end of one period."""

    pose: Pose
    speeds: tuple[float, float, float]
    """Chassis velocity, robot frame [m/s, m/s, rad/s]."""
    states: list[tuple[float, float]]
    """Speed [m/s] and angle [rad] of each module."""
    targets: list[tuple[float, float]]
    positions: list[tuple[float, float]]
    """Travel [m] and angle [rad] of each module."""
    raw_heading: float
    """Yaw of the gyro [rad]."""
    timestamp: float
    """Simulated time of the sensor readings [s]."""
    period: float
    """Odometry period [s]."""
    samples: int


class EmulatedDrivetrain:
    """Emulated `SwerveDrivetrain` that runs odometry and the current swerve request once per period.

    Args:
        gyro: Address of the gyro. All devices of the drivetrain are on the gyro's bus.
        modules: Constants of each module.
        hz: Frequency of odometry and control [Hz]; 0 for 250 Hz.

    Raises:
        ConfigError: `modules` is empty, or the frequency is not within 1..1000 Hz.
    """

    def __init__(self, gyro: DeviceAddress, modules: Sequence[ModuleConstants], hz: float = DEFAULT_HZ) -> None:
        if not modules:
            raise ConfigError("SwerveDrivetrain: needs at least one module, got none")
        hz = hz or DEFAULT_HZ
        if not 1.0 <= hz <= 1000.0:
            raise ConfigError(f"SwerveDrivetrain: odometry_update_frequency must be 1..1000 Hz, got {hz}")
        self.gyro = gyro
        self.module_constants = tuple(modules)
        self.hz = hz
        self.period = 1.0 / hz
        self.estimator = PoseEstimator()
        self.kinematics = Kinematics([(m.x, m.y) for m in modules])
        self.modules: list[EmulatedModule] = []
        self.request: DrivetrainRequest = Idle()
        self.on_state: Callable[[DrivetrainState], None] | None = None
        """Function to call with the state at the end of each period; None for no call."""
        self.is_running = False
        """Whether odometry and control are running."""
        self.now = 0.0
        """Simulated time of the last update [s]."""
        self.chassis_speeds = (0.0, 0.0, 0.0)
        """Measured chassis velocity, robot frame [m/s, m/s, rad/s]."""
        self.max_speed = modules[0].speed_at_12_volts
        """Robot speed at 12 V, to which `desaturate` limits the module speeds [m/s]."""
        self.heading = 0.0
        """Estimated heading at the last update, field frame [rad]."""
        self.operator_forward = 0.0
        """Operator's forward direction, field frame [rad]."""
        self._gyro: EmulatedPigeon2 | None = None
        self._gyro_yaw = 0.0
        self._samples = 0

    def start(self, devices: Sequence[ModuleDevices], gyro: EmulatedPigeon2) -> None:
        """Start odometry and control.

        The first call creates the modules and sets the estimated pose to zero at the present wheel and gyro readings.
        Later calls ignore the arguments.
        """
        if not self.modules:
            self.modules.extend(EmulatedModule(c, d) for c, d in zip(self.module_constants, devices, strict=True))
            self._gyro = gyro
            yaw = self._refresh()
            self.estimator.reset((0.0, 0.0, 0.0), yaw)
        self.is_running = True

    def stop(self) -> None:
        """Stop odometry and control.

        The first update after the next `start` adds all travel during the stop in one step.
        """
        self.is_running = False

    def update(self, now: float) -> None:
        """Run one period: read the sensors, update the estimated pose, control the modules and report the state.

        While the drivetrain is stopped, this method does nothing.

        Args:
            now: Simulated time [s].
        """
        if not self.is_running or self._gyro is None:
            return
        yaw = self._yaw()
        modules = self.modules
        travels = [(m.refresh(), m) for m in modules]
        dx, dy, _ = self.kinematics.chassis([(d * m.cos, d * m.sin) for d, m in travels])
        estimator = self.estimator
        estimator.update(now, dx, dy, yaw)
        self.now = now
        self.chassis_speeds = self.kinematics.chassis([(m.speed * m.cos, m.speed * m.sin) for m in modules])
        self.heading = estimator.pose[2]
        self.request.apply(self)
        self._gyro_yaw = yaw
        self._samples += 1
        if self.on_state is not None:
            self.on_state(self.state)

    @property
    def state(self) -> DrivetrainState:
        """Present drivetrain state. All module values are zero before the first `start`."""
        modules = self.modules
        none = [(0.0, 0.0)] * len(self.module_constants)
        return DrivetrainState(
            pose=self.estimator.pose,
            speeds=self.chassis_speeds,
            states=[(m.speed, m.angle) for m in modules] or none,
            targets=[m.target for m in modules] or none,
            positions=[(m.distance, m.angle) for m in modules] or none,
            raw_heading=self._gyro_yaw,
            timestamp=self.now,
            period=self.period,
            samples=self._samples,
        )

    # --- resets ---------------------------------------------------------------------------------------------------

    def reset_pose(self, pose: Pose) -> None:
        """Set the estimated pose, field frame [m, m, rad], and clear the pose history."""
        self.estimator.reset((pose[0], pose[1], wrap(pose[2])), self._yaw())

    def reset_translation(self, x: float, y: float) -> None:
        """Set the estimated position, field frame [m], and keep the heading."""
        self.reset_pose((x, y, self.estimator.pose[2]))

    def reset_rotation(self, heading: float) -> None:
        """Set the estimated heading, field frame [rad], and keep the position."""
        x, y, _ = self.estimator.pose
        self.reset_pose((x, y, heading))

    def seed_field_centric(self, heading: float) -> None:
        """Set the estimated heading to an angle [rad] from the operator's forward direction, and keep the position."""
        self.reset_rotation(heading + self.operator_forward)

    def tare_everything(self) -> None:
        """Set the travel of all modules and the estimated pose to zero, without changing the gyro."""
        for module in self.modules:
            module.zero()
        yaw = self._refresh() if self.modules else 0.0
        self.estimator.reset((0.0, 0.0, 0.0), yaw)

    # --- internals ------------------------------------------------------------------------------------------------

    def _yaw(self) -> float:
        return 0.0 if self._gyro is None else math.radians(self._gyro.yaw)

    def _refresh(self) -> float:
        """Update all modules, so that the next travel starts at the present readings; return the gyro's yaw [rad]."""
        for module in self.modules:
            module.refresh()
        return self._yaw()
