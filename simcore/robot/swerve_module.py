"""State of the swerve modules, one row per module, and the step of their azimuths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.robot.limited_motor import end_weight, solve_limited, within
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
        terminal: list[float] = []
        currents: list[float] = []
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
                terminal.append(0.0)
                currents.append(0.0)
                continue
            i0 = i1 = 0.0
            if v is not None:
                v = within(v, bus)
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
                    terminal.append(volts_held)
                    currents.append(i0)
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
            terminal.append(at)
            currents.append(i)
        return readout.accumulate(terminal, currents, bus, h)
