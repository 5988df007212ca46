"""State of the swerve modules, one row per module, and the step of their azimuths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.robot.limited_motor import LimitedMotor, solve_shaft, solve_supply, within
from simcore.robot.motor_bus import MotorReadout
from simcore.robot.swerve_config import SwerveModuleConfig

__all__ = ["ModuleState", "SteerBank"]


@dataclass(slots=True)
class ModuleState:
    """Angles and speeds of n modules. Lists, not arrays: the inner loop reads single numbers."""

    wheel_angle: list[float]
    """Of the wheel about its axle, any number of turns [rad]."""
    wheel_speed: list[float]
    """[rad/s]"""
    steer_angle: list[float]
    """Of the azimuth, counter-clockwise from forward, any number of turns [rad]."""
    steer_speed: list[float]
    """[rad/s]"""
    cos: list[float]
    """Of the steer angle."""
    sin: list[float]
    """Of the steer angle."""


class SteerBank:
    """All azimuths: motor, gears, friction, scrub of the tire, and the pull of the coupled drive motor."""

    def __init__(self, modules: Sequence[SwerveModuleConfig]) -> None:
        self.motors = [
            LimitedMotor.of(
                m.steer_motor,
                gearing=m.steer_gearing,
                efficiency=m.steer_efficiency,
                friction_volts=m.steer_friction_volts,
                stator_limit=m.steer_stator_limit,
                supply_limit=m.steer_supply_limit,
            )
            for m in modules
        ]
        self._rows = [
            (
                *(motor, motor.emf, motor.conductance, motor.torque_driving, motor.torque_driven, motor.friction),
                *(motor.stator_limit, motor.supply_limit, m.azimuth_inertia, m.wheel_cof * m.scrub_radius),
                m.coupling_ratio * m.drive_motor.kt,
            )
            for motor, m in zip(self.motors, modules, strict=True)
        ]

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
        """Backward Euler for each azimuth: stable at any inertia, and exact in where a spin-up ends.

        Args:
            h: Time step [s].
            state: Changed: steer angle and speed, cos and sin.
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
        terminal: list[float] = []
        currents: list[float] = []
        row = -1
        for m, emf, conductance, driving, driven, friction, limit, supply, inertia, scrub, coupling in self._rows:
            row += 1
            w = speed[row]
            v = volts[row]
            a = coupling * drive_current[row]
            if w == 0.0 and a == 0.0 and not v:
                terminal.append(0.0)
                currents.append(0.0)
                continue
            i0 = i1 = 0.0
            if v is not None:
                v = within(v, bus)
                i0 = v * conductance
                i1 = emf * conductance
            holds = friction + scrub * loads[row]
            if w == 0.0 and a == 0.0 and -holds <= driven * i0 <= holds and -limit <= i0 <= limit:
                # Held by friction, as azimuths are most of the time (5.0 -> 3.5 us for four).
                terminal.append(i0 * m.resistance)
                currents.append(i0)
                continue
            k = inertia / h
            a += k * w
            power = supply * bus
            end, i, _, _ = solve_shaft(k, a, i0, i1, limit, driving, driven, holds)
            p = (emf * end + i * m.resistance) * i
            if p > power or p < -power:
                constants = (emf, m.resistance, driving, driven, holds)
                end, i, _, _ = solve_supply(k, a, i, p, limit, constants, 0.0, w, power)
            w = end
            speed[row] = w
            if w != 0.0:
                steer_angle[row] = angle = steer_angle[row] + w * h
                state.cos[row] = math.cos(angle)
                state.sin[row] = math.sin(angle)
            terminal.append(emf * w + i * m.resistance)
            currents.append(i)
        return readout.accumulate(terminal, currents, bus, h)
