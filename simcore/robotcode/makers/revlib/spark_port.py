"""Port to one SPARK through WPILib's SimDevices: requests of robot code, encoder and current readings."""

from __future__ import annotations

import math
from typing import Any

from simcore import season
from simcore.errors import NonFiniteError
from simcore.quantities import DeviceKey
from simcore.robotcode.makers.revlib.built_sparks import configuration_count, spark_of_controller
from simcore.robotcode.makers.revlib.spark_configuration import read_spark_configuration
from simcore.robotcode.makers.revlib.spark_loop import (
    LOOP,
    Command,
    ControlMode,
    Feedback,
    SparkConfiguration,
    SparkLoop,
)
from simcore.robotcode.program.makers import known_device
from simcore.robotcode.program.motor_ports import MotorPort, Setpoint

rev = season.rev
RobotState = season.wpilib.RobotState
SimDeviceSim = season.wpilib_simulation.SimDeviceSim

__all__ = ["ANALOG_SPAN", "SparkPort"]

ANALOG_SPAN = 3.3
"""Voltage span of one turn of an absolute encoder on the data port's analog pin [V]."""


class _Sensor:
    """Access to the SimDevice of a sensor that is wired to a SPARK.

    Args:
        name: Name of the sensor's SimDevice.
    """

    def __init__(self, name: str) -> None:
        self._device = SimDeviceSim(name)
        self._position = self._device.get_double("Position")
        self._velocity = self._device.get_double("Velocity")

    def _show(self, position: float, velocity: float) -> tuple[float, float]:
        self._position.set(position)
        self._velocity.set(velocity)
        return position, velocity


class _Encoder(_Sensor):
    """Relative encoder, which continues from a position that robot code sets."""

    _shown = 0.0  # last reading written; a different value has been set by robot code
    _shift = _turns = 0.0

    def write(self, turns: float, rps: float, factors: tuple[float, float]) -> tuple[float, float]:
        """Write the shaft's position [rotations] and rate [rotations/s]; return both in robot code's units."""
        of_position, of_velocity = factors
        present = self._position.get()
        if present != self._shown and of_position:  # robot code has set the position
            self._shift = present / of_position - self._turns
        self._turns = turns
        seen = self._show((turns + self._shift) * of_position, rps * 60.0 * of_velocity)
        self._shown = self._position.get()
        return seen


class _AbsoluteEncoder(_Sensor):
    """Absolute encoder with a range of one turn."""

    def write(
        self, turns: float, rps: float, factors: tuple[float, float], *, is_centered: bool = False
    ) -> tuple[float, float]:
        """Write the shaft's position [rotations] and rate [rotations/s]; return both in robot code's units."""
        turn = (turns + 0.5) % 1.0 - 0.5 if is_centered else turns % 1.0
        return self._show(turn * factors[0], rps * 60.0 * factors[1])


class _AnalogSensor(_Sensor):
    """Absolute encoder on the data port's analog pin: 0 to 3.3 V per turn."""

    def write(self, turns: float, rps: float, factors: tuple[float, float]) -> tuple[float, float]:
        """Write the shaft's position [rotations] and rate [rotations/s]; return both in robot code's units."""
        volts = (turns % 1.0) * ANALOG_SPAN
        self._device.get_double("Voltage").set(volts)
        return self._show(volts * factors[0], rps * ANALOG_SPAN * factors[1])


class SparkPort(MotorPort):
    """Port of one SPARK: control loops, requests of robot code and sensor readings.

    Physics calls `run` for the loops, reads `volts` and calls `write` for the sensors. The loops run on the physics
    clock, in real time and in simulated time. On a mechanism, the port is part of a `SparkMotorSim`.

    Args:
        device: `SparkMax` or `SparkFlex` of the robot program.
        sign: -1 if the positive direction in robot code is the mechanism's negative direction, else 1.

    Raises:
        ConfigError: The device was built before simcore was imported.

    Example:
        port = SparkPort(robot.arm)
        port.set_supply(12.0)
        port.run(0.005)
        volts = port.volts(emf=0.0, resistance=0.11)
        port.show_motor(0.33, 3.0)
        port.write(1.5, 0.2, encoder=(0.1, 0.01))
    """

    def __init__(self, device: Any, *, sign: float = 1.0) -> None:
        device = known_device(device)
        name = season.spark_sim_name(device.hardware, device.model)
        self.device = device
        self.loop = SparkLoop()
        self._sign = sign
        sim = SimDeviceSim(name)
        self._mode = sim.get_int("Control Mode")
        self._slot = sim.get_int("Closed Loop Slot")
        self._units = sim.get_int("ArbFF Units")
        self._setpoint, self._feed_forward = sim.get_double("Setpoint"), sim.get_double("Arbitrary Feedforward")
        self._output, self._current = sim.get_double("Applied Output"), sim.get_double("Motor Current")
        self._bus, self._shown_position = sim.get_double("Bus Voltage"), sim.get_double("Position")
        self._shown_velocity = sim.get_double("Velocity")
        self._forward = SimDeviceSim(f"{name} LIMIT SWITCH (FORWARD)").get_boolean("Is Pressed")
        self._reverse = SimDeviceSim(f"{name} LIMIT SWITCH (REVERSE)").get_boolean("Is Pressed")
        external = "ALTERNATE" if device.model == "SPARK MAX" else "EXTERNAL"
        self._primary = _Encoder(f"{name} RELATIVE ENCODER")
        self._absolute = _AbsoluteEncoder(f"{name} ABSOLUTE ENCODER")
        self._external = _Encoder(f"{name} {external} ENCODER")
        self._analog = _AnalogSensor(f"{name} ANALOG SENSOR")
        self._at_start: float | None = None  # turns of an encoder on the data port at power-on
        self._seen = -1
        self._pending_time = 0.0  # time not yet simulated by loops [s]
        self._position = self._velocity = self._amps = 0.0
        self._rotor = self._encoder = (0.0, 0.0)
        self._supply = self._supply_of_loop = 12.0
        _ports[device.key] = self
        self.configure()

    @property
    def config(self) -> SparkConfiguration:
        """Current configuration of the controller."""
        return self.loop.config

    def is_open(self) -> bool:
        """Return whether the idle mode is coast."""
        return not self.loop.config.brakes

    def configure(self) -> None:
        """Read the configuration again if robot code has configured the device since the last read."""
        count = configuration_count(self.device.key)
        if count != self._seen:
            self._seen = count
            self.loop.config = read_spark_configuration(self.device.hardware)

    def run(self, dt: float) -> None:
        """Run the controller's 1 kHz loop for dt [s] with constant sensor readings; while disabled, reset the loop."""
        self._pending_time += dt
        loops = int(self._pending_time / LOOP + 0.5)
        self._pending_time -= loops * LOOP
        if loops == 0:
            return
        self.configure()
        if not RobotState.is_enabled():
            self.loop.rest()
            return
        command = Command(
            self._mode.get(), self._setpoint.get(), self._slot.get(), self._feed_forward.get(), self._units.get() == 1
        )
        self._supply_of_loop = self._supply
        self.loop.run(loops, command, self._position, self._velocity, self._amps, self._supply)

    def set_supply(self, volts: float) -> None:
        """Set the supply voltage of the controller [V], at least 1 V."""
        self._supply = max(volts, 1.0)
        self._bus.set(self._supply)

    def duty_cycle(self) -> float | None:
        """Return the duty cycle with the mechanism's sign [-], or None if the controller commands volts."""
        return None if self._holds_volts else self._output.get() * self._sign

    def setpoint(self) -> Setpoint | None:
        """Return the position or velocity set-point with the mechanism's sign; None in other modes or if disabled."""
        mode, goal, config = self._mode.get(), self._setpoint.get(), self.config
        span = ANALOG_SPAN if config.feedback is Feedback.ANALOG else 1.0
        per_turn, per_rpm = (span * factor for factor in config.factors)
        is_rotor = config.feedback is Feedback.PRIMARY and not config.is_brushed
        if not RobotState.is_enabled():
            return None
        if mode in (ControlMode.VELOCITY, ControlMode.MAXMOTION_VELOCITY) and per_rpm:
            return Setpoint(True, is_rotor, self._sign * goal / (60.0 * per_rpm))
        if mode in (ControlMode.POSITION, ControlMode.MAXMOTION_POSITION) and per_turn:
            return Setpoint(False, is_rotor, self._sign * self.loop.wrapped(goal - self._position) / per_turn)
        return None

    @property
    def _holds_volts(self) -> bool:
        return self._mode.get() == ControlMode.VOLTAGE or self.config.compensation is not None

    def volts(self, emf: float = 0.0, resistance: float = math.inf) -> float:
        """Return the limited motor voltage with the mechanism's sign [V], and write the duty cycle for robot code.

        Args:
            emf: Back-EMF of the motor with the mechanism's sign [V].
            resistance: Winding resistance of one motor [ohm], for the current limit; infinite if the motor model
                applies the limit.
        """
        config = self.config
        output = self.loop.output
        if output > 0.0 and self._is_stopped(config.soft_forward, config.stops_forward, self._forward, 1.0):
            output = 0.0
        if output < 0.0 and self._is_stopped(config.soft_reverse, config.stops_reverse, self._reverse, -1.0):
            output = 0.0
        volts = output * self._sign * (self._supply_of_loop if self._holds_volts else self._supply)
        if volts != 0.0 and config.current_limit > 0.0:
            most = config.current_limit * resistance
            # The limiter reduces the output but never reverses it.
            limited = min(max(volts, emf - most), emf + most)
            volts = min(max(limited, 0.0), volts) if volts > 0.0 else max(min(limited, 0.0), volts)
        self._output.set(volts * self._sign / self._supply)
        return volts

    def show_output(self, output: float) -> None:
        """Write a follower's duty cycle with the mechanism's sign [-]."""
        self._output.set(output * self._sign)

    def _is_stopped(self, soft: float | None, stops: bool, switch: Any, sign: float) -> bool:
        return (soft is not None and (self._position - soft) * sign >= 0.0) or (stops and bool(switch.get()))

    def show_motor(self, volts: float, amps: float) -> None:
        """Write the current of one motor with the mechanism's sign [A]; `volts` is not used."""
        self._amps = amps * self._sign
        self._current.set(abs(amps))

    def write(self, rotations: float, rps: float, encoder: tuple[float, float] | None = None) -> None:
        """Write the sensor readings, given with the mechanism's sign.

        Args:
            rotations: Rotor position since power-on [rotations].
            rps: Rotor velocity [rotations/s].
            encoder: Position [rotations] and velocity [rotations/s] of an absolute, alternate or external encoder on
                the mechanism; None to keep the previous values.

        Raises:
            NonFiniteError: A value is not finite; nothing is written.
        """
        self._rotor, self._encoder = (rotations, rps), encoder or self._encoder
        self._show()

    def write_encoder(self, turns: float, rps: float) -> None:
        """Write position [rotations] and velocity [rotations/s] of the mechanism's encoder, but not of the rotor."""
        self._encoder = turns, rps
        self._show()

    def _show(self) -> None:
        (rotor, rotor_rps), (encoder, encoder_rps) = self._rotor, self._encoder
        if not math.isfinite(rotor + rotor_rps + encoder + encoder_rps):
            raise NonFiniteError(f"{self.device}: values must be finite numbers, got {rotor} turns, {rotor_rps} rps")
        config, sign = self.config, self._sign
        if config.is_brushed:
            if self._at_start is None:
                self._at_start = encoder
            rotor, rotor_rps = encoder - self._at_start, encoder_rps
        turns, rate = sign * encoder, sign * encoder_rps
        primary = self._primary.write(sign * rotor, sign * rotor_rps, config.primary)
        others = {
            Feedback.ABSOLUTE: self._absolute.write(turns, rate, config.absolute, is_centered=config.is_centered),
            Feedback.EXTERNAL: self._external.write(turns, rate, config.external),
            Feedback.ANALOG: self._analog.write(turns, rate, config.analog),
        }
        seen = others.get(config.feedback, primary)
        self._position, self._velocity = seen
        self._shown_position.set(seen[0])
        self._shown_velocity.set(seen[1])


_ports: dict[DeviceKey, SparkPort] = {}


def _loop_of(controller: Any) -> SparkLoop | None:
    key = spark_of_controller(controller)
    port = None if key is None else _ports.get(key)
    return None if port is None else port.loop


def _answer_from_loops() -> None:
    """Replace methods of closed-loop controllers to return state, integral and profile set-point of `SparkLoop`."""
    cls: Any = rev.SparkClosedLoopController
    for name, read in (
        ("is_at_setpoint", lambda loop: loop.is_at_setpoint),
        ("get_i_accum", lambda loop: loop.integral),
        ("get_max_motion_setpoint_position", lambda loop: loop.profile_position),
        ("get_max_motion_setpoint_velocity", lambda loop: loop.profile_velocity),
    ):
        name = season.own_name(cls, name, season.camel_case(name).replace("MaxMotion", "MAXMotion"))
        original = getattr(cls, name)

        def answer(self: Any, original: Any = original, read: Any = read) -> Any:
            loop = _loop_of(self)
            return original(self) if loop is None else season.spark_answer(lambda: original(self), read(loop))

        setattr(cls, name, answer)


_answer_from_loops()
