"""State of the swerve modules, one row per module, and the step of their azimuths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from simcore.drivetrain.config import SwerveModuleConfig
from simcore.drivetrain.electrical import ShaftMotor, solve_limited

__all__ = ["ModuleState", "MotorReadout", "SteerBank"]


@dataclass(slots=True)
class MotorReadout:
    """What the motors of one kind did in the last inner step, one entry per motor."""

    volts: list[float]
    """At the terminals [V]."""
    current: list[float]
    """Stator current [A]."""
    supply: list[float]
    """Current from the battery; negative feeds back [A]."""
    heat: list[float]
    """Copper loss since the last reset [J]."""
    energy: list[float]
    """Electrical energy taken since the last reset [J]."""

    @staticmethod
    def zeros(n: int) -> MotorReadout:
        """All at rest."""
        return MotorReadout(*([0.0] * n for _ in range(5)))

    def note(self, row: int, volts: float, current: float, resistance: float, bus: float, h: float, count: int) -> None:
        """Book one motor's inner step; `count` equal motors sit on the shaft."""
        power = volts * current
        self.volts[row] = volts
        self.current[row] = current
        self.supply[row] = power / bus if bus > 0.0 else 0.0
        self.heat[row] += current * current * resistance * h * count
        self.energy[row] += power * h * count


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
    cos: list[float] = field(default_factory=list)
    """Of the steer angle."""
    sin: list[float] = field(default_factory=list)
    """Of the steer angle."""

    @staticmethod
    def zeros(n: int) -> ModuleState:
        """All wheels at rest, pointing forward."""
        return ModuleState([0.0] * n, [0.0] * n, [0.0] * n, [0.0] * n, [1.0] * n, [0.0] * n)


class SteerBank:
    """All azimuths: motor, gears, friction, scrub of the tire, and the pull of the coupled drive motor."""

    def __init__(self, modules: Sequence[SwerveModuleConfig]) -> None:
        self.motors = [
            ShaftMotor.of(
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
            (motor, m.azimuth_inertia, m.tread * m.scrub_radius, m.coupling_ratio * m.drive_motor.kt)
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
    ) -> None:
        """Backward Euler for each azimuth: stable at any inertia, and exact in where a spin-up ends.

        Args:
            h: Time step [s].
            state: Changed: steer angle and speed, cos and sin.
            volts: Applied per steer motor, within the bus voltage [V]; None is an open circuit.
            loads: On the wheels, for the scrub [N].
            drive_current: Of the drive motors in the last step, for the coupling [A].
            bus: Battery voltage, for the supply limit [V].
            readout: Of the steer motors; written.
        """
        speed = state.steer_speed
        row = 0
        for motor, inertia, scrub, coupling in self._rows:
            w = speed[row]
            v = volts[row]
            i0 = i1 = 0.0
            if v is not None:
                i0 = v * motor.conductance
                i1 = motor.emf * motor.conductance
            k = inertia / h
            a = k * w
            if coupling != 0.0:
                a += coupling * drive_current[row]
            new, current, _, _ = solve_limited(
                *(motor, k, a, i0, i1, motor.stator_limit, motor.friction + scrub * loads[row]),
                *(0.0, w, motor.supply_limit * bus),
            )
            speed[row] = new
            if new != 0.0:
                angle = state.steer_angle[row] + new * h
                state.steer_angle[row] = angle
                state.cos[row] = math.cos(angle)
                state.sin[row] = math.sin(angle)
            readout.note(row, motor.emf * new + current * motor.resistance, current, motor.resistance, bus, h, 1)
            row += 1
