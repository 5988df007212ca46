"""Swerve modules, one row per module: their state, the step of their azimuths, and what their motor controllers do.

Between two commands controllers run their loops: kinematics, on-board control, neutral modes.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.robot.limited_motor import end_weight, solve_limited
from simcore.robot.motor_bus import MotorReadout
from simcore.robot.swerve_config import SwerveModuleConfig

__all__ = ["DriveMode", "ModuleController", "ModuleState", "SteerBank", "desaturate", "module_targets", "optimize"]


@dataclass(slots=True)
class ModuleState:
    """Angles and speeds of n modules. Lists, not arrays: the inner loop reads single numbers."""

    wheel_angle: list[float]
    """Of the wheel about its axle, any number of turns [rad]."""
    wheel_speed: list[float]
    """[rad/s]"""
    steer_angle: list[float]
    """Of the azimuth as its encoder shows it, counter-clockwise from forward, any number of turns [rad]."""
    steer_speed: list[float]
    """[rad/s]"""
    cos: list[float]
    """Of the angle at which the wheel truly stands."""
    sin: list[float]
    """Of the same."""
    mid_cos: list[float]
    """Of the same in the middle of the last inner step."""
    mid_sin: list[float]
    """Of the same in the middle of the last inner step."""


class SteerBank:
    """All azimuths: motor, gears, friction, scrub of the tire, and the pull of the coupled drive motor."""

    def __init__(self, modules: Sequence[SwerveModuleConfig]) -> None:
        self.motors = [m.limited_steer_motor for m in modules]
        self._rows = [
            (
                *(motor, motor.emf, motor.conductance, motor.torque_driving, motor.torque_driven, motor.friction),
                *(motor.stator_limit, motor.supply_limit, m.azimuth_inertia, m.wheel_cof * m.scrub_radius),
                m.coupling_ratio * m.drive_motor.kt,
            )
            for motor, m in zip(self.motors, modules, strict=True)
        ]
        self._has_supply = any(motor.winding != motor.resistance for motor in self.motors)
        self._zeros = [m.steer_offset for m in modules]
        self._weighted = 0.0  # step that the weights are of [s]
        self._end_weights: list[float] = []

    def step(
        self,
        h: float,
        state: ModuleState,
        volts: Sequence[float | None],
        loads: Sequence[float],
        drive_current: Sequence[float],
        bus: float,
        readout: MotorReadout,
    ) -> float:
        """Exponential fitting for each azimuth: second order, stable at any inertia; a spin-up ends where it must.

        Args:
            h: Time step [s].
            state: Changed: steer angle and speed, and the cosines and sines.
            volts: Wanted per steer motor [V]; None is an open circuit.
            loads: On the wheels, for the scrub [N].
            drive_current: Of the drive motors in the last step, for the coupling [A].
            bus: Battery voltage, which no motor can exceed [V].
            readout: Of the steer motors; written.

        Returns:
            Current from the battery [A].
        """
        speed = state.steer_speed
        steer_angle = state.steer_angle
        state.mid_cos, state.mid_sin = state.cos[:], state.sin[:]
        terminal = [0.0] * len(speed)
        currents = [0.0] * len(speed)
        if h != self._weighted:
            self._weighted = h
            self._end_weights = [
                end_weight(h, driven * emf * conductance / inertia)
                for _, emf, conductance, _, driven, _, _, _, inertia, _, _ in self._rows
            ]
        weights = self._end_weights
        row = -1
        for m, emf, conductance, driving, driven, friction, limit, supply, inertia, scrub, coupling in self._rows:
            row += 1
            w = speed[row]
            v = volts[row]
            resistance = m.resistance
            a = coupling * drive_current[row]
            if w == 0.0 and a == 0.0 and not v:
                continue
            i0 = i1 = 0.0
            if v is not None:
                if v > bus:
                    v = bus
                elif v < -bus:
                    v = -bus
                if self._has_supply:
                    v, resistance = m.line_in_force(v, bus, emf * w, limit)
                    conductance = 1.0 / resistance
                # Back-EMF of the mean speed, from that at the end of the step.
                i1 = weights[row] * emf * conductance
                i0 = (v - (1.0 - weights[row]) * emf * w) * conductance
            holds = friction + scrub * loads[row]
            power = supply * bus
            if w == 0.0 and a == 0.0 and -holds <= driven * i0 <= holds and -limit <= i0 <= limit:
                volts_held = i0 * resistance
                if volts_held * i0 <= power:  # held by friction, as azimuths are most of the time (5.0 -> 3.5 us)
                    terminal[row] = volts_held
                    currents[row] = i0
                    continue
            k = inertia / h
            a += k * w
            emf_end = weights[row] * emf
            constants = (emf_end, resistance, driving, driven, holds)
            end, i, at, _, _ = solve_limited(k, a, i0, i1, limit, constants, (emf - emf_end) * w, w, power)
            speed[row] = end
            turn = 0.5 * (w + end) * h
            if turn != 0.0:
                zero = self._zeros[row]
                angle = steer_angle[row] + 0.5 * turn + zero
                state.mid_cos[row] = math.cos(angle)
                state.mid_sin[row] = math.sin(angle)
                steer_angle[row] = angle = steer_angle[row] + turn
                angle += zero
                state.cos[row] = math.cos(angle)
                state.sin[row] = math.sin(angle)
            terminal[row] = at
            currents[row] = i
        return readout.accumulate(terminal, currents, bus, h)


def optimize(speed: float, angle: float, present: float) -> tuple[float, float]:
    """Reach a module state with less than a quarter turn: drive backwards where that is nearer.

    Args:
        speed: Wanted [m/s].
        angle: Wanted steer angle [rad].
        present: Steer angle now, any number of turns [rad].

    Returns:
        Signed speed [m/s], scaled by the cosine of the steer error so that a wheel on its way does not scrub
        sideways, and the error to steer away [rad], within -pi/2..pi/2.
    """
    error = math.remainder(angle - present, math.tau)
    if error > 0.5 * math.pi:
        error -= math.pi
        speed = -speed
    elif error < -0.5 * math.pi:
        error += math.pi
        speed = -speed
    return speed * math.cos(error), error


def desaturate(speeds: list[float], limit: float) -> list[float]:
    """Scale all speeds by one factor so that none exceeds the limit: the direction of travel stays."""
    top = max(map(abs, speeds), default=0.0)
    if top <= limit:
        return speeds
    return [s * (limit / top) for s in speeds]


def module_targets(
    positions: Sequence[tuple[float, float]],
    vx: float,
    vy: float,
    omega: float,
    limit: float,
    present: Sequence[float],
) -> tuple[list[float], list[float]]:
    """Speed and direction of every module for a chassis velocity.

    Args:
        positions: Of the modules [m].
        vx: Forward [m/s].
        vy: To the left [m/s].
        omega: Counter-clockwise [rad/s].
        limit: Top speed of a module; faster wishes are scaled down together [m/s].
        present: Angles that stay where a module has nothing to do [rad].

    Returns:
        Speeds [m/s] and steer angles [rad].
    """
    speeds: list[float] = []
    angles: list[float] = []
    for (x, y), held in zip(positions, present, strict=True):
        wx = vx - omega * y
        wy = vy + omega * x
        speed = math.hypot(wx, wy)
        speeds.append(speed)
        angles.append(math.atan2(wy, wx) if speed > 1e-6 else held)
    return desaturate(speeds, limit), angles


class DriveMode(enum.Enum):
    """What the last command asks of the drive motors."""

    NEUTRAL = "neutral"
    VOLTS = "volts"
    DUTY = "duty"
    TORQUE_CURRENT = "torque current"
    STATES = "states"


class ModuleController:
    """Turns the last command into voltages, every inner step, as motor controllers do between two robot loops."""

    def __init__(self, modules: Sequence[SwerveModuleConfig], loads: Sequence[float]) -> None:
        """Start in neutral.

        Args:
            modules: Gains, limits, neutral modes, and motors for the feed-forward.
            loads: Of the robot at rest, for rolling drag and scrub [N].
        """
        self._modules = modules
        drives = [m.limited_drive_motor for m in modules]
        steers = [m.limited_steer_motor for m in modules]
        self._stator_limits = [motor.stator_limit for motor in drives]
        self._coasting = any(not (m.drive_brake and m.steer_brake) for m in modules)
        # Feed-forward against friction, rolling drag and scrub, as a team's kS would hold [V].
        self._gains = [
            (
                m.wheel_radius,
                drive.emf,
                m.coupling_ratio / m.drive_motor.kv,
                m.drive_kp,
                (drive.friction + m.rolling_resistance * load * m.wheel_radius) / drive.torque_driving * drive.winding,
                m.steer_kp,
                (steer.friction + m.wheel_cof * m.scrub_radius * load) / steer.torque_driving * steer.winding,
            )
            for m, drive, steer, load in zip(modules, drives, steers, loads, strict=True)
        ]
        self.reset()

    def reset(self) -> None:
        """Back to neutral."""
        n = len(self._modules)
        self._before = [0.0] * n  # wheel speeds at the start of the last inner step [rad/s]
        self._h_before = 1.0
        self.mode, self.drive, self.steer = DriveMode.NEUTRAL, [0.0] * n, [0.0] * n

    def command(self, mode: DriveMode, drive: list[float], steer: list[float]) -> bool:
        """Take a command: one checked number per drive and per steer motor; their unit depends on the mode.

        Returns:
            Whether it is another one than the last.
        """
        is_other = mode is not self.mode or drive != self.drive or steer != self.steer
        self.mode, self.drive, self.steer = mode, drive, steer
        return is_other

    def requests(
        self, h: float, state: ModuleState, bus: float, neutral: bool
    ) -> tuple[list[float | None], list[float | None], list[float]]:
        """Voltages for one inner step, of on-board loops as they are in its middle if speeds go on as they did.

        Args:
            h: Time step [s].
            state: Wheels and azimuths now.
            bus: Battery voltage [V].
            neutral: Whether the robot is disabled: motors then brake or coast as configured.

        Returns:
            Voltage wanted from every drive and from every steer motor [V], None for an open circuit, and the stator
            limits of the drive motors [A].
        """
        modules = self._modules
        limits = self._stator_limits
        mode = self.mode
        drive: list[float | None]
        steer: list[float | None]
        if neutral or mode is DriveMode.NEUTRAL:
            drive = [0.0 if m.drive_brake else None for m in modules]
            return drive, [0.0 if m.steer_brake else None for m in modules], limits
        before, ahead = self._before, 0.5 * h / self._h_before
        self._before, self._h_before = state.wheel_speed[:], h
        if mode is DriveMode.STATES:
            n = len(modules)
            drive, steer = [0.0] * n, [0.0] * n
            for k, (radius, emf, coupled_emf, drive_kp, drive_ks, steer_kp, steer_ks) in enumerate(self._gains):
                moving = state.steer_speed[k]
                speed, error = optimize(self.drive[k], self.steer[k], state.steer_angle[k] + 0.5 * h * moving)
                w = state.wheel_speed[k]
                w += ahead * (w - before[k])
                lift = 20.0 * speed
                ease = 100.0 * error
                drive[k] = (
                    emf * speed / radius
                    + drive_kp * (speed - w * radius)
                    + drive_ks * (1.0 if lift > 1.0 else -1.0 if lift < -1.0 else lift)
                    + coupled_emf * moving
                )
                steer[k] = steer_kp * error + steer_ks * (1.0 if ease > 1.0 else -1.0 if ease < -1.0 else ease)
        elif mode is DriveMode.DUTY:
            drive = [d * bus for d in self.drive]
            steer = [d * bus for d in self.steer]
        elif mode is DriveMode.TORQUE_CURRENT:
            # As much voltage as there is, with the wanted current as the limit.
            drive = [math.copysign(math.inf, i) if i != 0.0 else None for i in self.drive]
            limits = [min(abs(i), limit) for i, limit in zip(self.drive, limits, strict=True)]
            steer = list(self.steer)
        else:
            drive = list(self.drive)
            steer = list(self.steer)
        if self._coasting:
            for k, m in enumerate(modules):
                if drive[k] == 0.0 and not m.drive_brake:
                    drive[k] = None
                if steer[k] == 0.0 and not m.steer_brake:
                    steer[k] = None
        return drive, steer, limits
