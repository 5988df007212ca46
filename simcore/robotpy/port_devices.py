"""Devices on roboRIO ports and pneumatics modules, connected with mechanisms: what moves them, and what they show.

Each has `read` and `write` as `MotorDevices` wants them. Found by channel in the HAL's simulation data, so it makes no
difference where robot code keeps its objects. Nothing here lives on the wall clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from simcore import season
from simcore.robot.motor_ports import AnglePort, MotorPort
from simcore.robot.positioned_mechanisms import PistonSim, ServoSim
from simcore.robot.shaft import ShaftSim

RobotState = season.wpilib.RobotState
AnalogInputSim = season.wpilib_simulation.AnalogInputSim
DIOSim = season.wpilib_simulation.DIOSim
DutyCycleSim = season.wpilib_simulation.DutyCycleSim
EncoderSim = season.wpilib_simulation.EncoderSim
PWMSim = season.wpilib_simulation.PWMSim
RelaySim = season.class_before_2027("wpilib.simulation", "RelaySim")
SimDeviceSim = season.wpilib_simulation.SimDeviceSim

__all__ = [
    "AbsoluteEncoderInput",
    "DigitalSwitch",
    "LimitSwitchInput",
    "PWMChannelPort",
    "PistonValve",
    "PortMotorSim",
    "PotentiometerInput",
    "QuadratureInput",
    "RelayPort",
    "ServoSignal",
    "Switch",
]

_RAIL = 5.0  # [V] at the roboRIO's analog inputs


class _ChannelPort:
    """What ports without a sensor or a configuration have in common.

    Args:
        coasts: Whether zero opens the circuit instead of braking.
    """

    def __init__(self, *, coasts: bool) -> None:
        self._coasts = coasts
        self._supply = 12.0

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        self._supply = volts

    def is_open(self) -> bool:
        """Whether the circuit is open at zero."""
        return self._coasts

    def write(self, rotations: float, rps: float) -> None:
        """Nobody reads it."""


class PWMChannelPort(_ChannelPort):
    """Whatever controls a motor on a PWM channel, whose output the roboRIO resolves to 0.4 %.

    Args:
        channel: Of the roboRIO.
        leader: The robot code's object of the first controller on the shaft: its inversion says which way robot code
            calls positive. None: the way that comes out of the channel.
        coasts: Whether zero opens the circuit instead of braking.
    """

    def __init__(self, channel: int, leader: Any = None, *, coasts: bool = False) -> None:
        super().__init__(coasts=coasts)
        self._sim = PWMSim(channel)
        self._leader = leader

    def volts(self) -> float:
        """Its duty cycle of the supply [V]; the roboRIO holds PWM neutral while disabled, its simulation does not."""
        if not RobotState.is_enabled():
            return 0.0
        volts = season.pwm_speed(self._sim) * self._supply
        return -volts if self._leader is not None and self._leader.get_inverted() else volts


class RelayPort(_ChannelPort):
    """A Spike on a relay channel: the whole battery one way or the other, or nothing.

    Args:
        channel: Of the roboRIO.
        coasts: Whether nothing opens the circuit instead of braking.
    """

    def __init__(self, channel: int, *, coasts: bool = False) -> None:
        super().__init__(coasts=coasts)
        self._sim = RelaySim(channel)

    def volts(self) -> float:
        """What it puts on the motor [V]."""
        if not RobotState.is_enabled():
            return 0.0
        return self._supply * (float(self._sim.getForward()) - float(self._sim.getReverse()))


class PortMotorSim:
    """Motor controllers of any maker on one mechanism; each drives one motor of its gearbox.

    Motors on one shaft share its speed, so their currents together are those of as many motors at the mean voltage.

    Args:
        ports: Leader first.
        mechanism: What they turn.
        signs: -1 for each whose positive volts push the mechanism the negative way, else 1.
        encoder: A CANcoder on the mechanism.
        encoder_gearing: Turns of that encoder per turn of the mechanism [-].
    """

    def __init__(
        self,
        ports: Sequence[MotorPort],
        mechanism: ShaftSim,
        *,
        signs: Sequence[float],
        encoder: AnglePort | None = None,
        encoder_gearing: float = 1.0,
    ) -> None:
        self.mechanism = mechanism
        """What the motors turn."""
        self._ports = tuple(zip(ports, signs, strict=True))
        self._encoder = encoder
        self._gearing = encoder_gearing

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Supply in, volts out to the mechanism [V]."""
        total = 0.0
        is_open = True
        for port, sign in self._ports:
            port.set_supply(battery_voltage)
            volts = port.volts()
            total += sign * volts
            is_open = is_open and volts == 0.0 and port.is_open()
        if is_open or not powered:
            self.mechanism.coast()
        else:
            self.mechanism.set_volts(total / len(self._ports))

    def write(self) -> None:
        """The mechanism's motion to the CANcoder, if there is one."""
        m = self.mechanism
        if self._encoder is not None:
            self._encoder.write(m.position * self._gearing, m.velocity * self._gearing)


class ServoSignal:
    """A servo on a PWM channel. Without a pulse, disabled or browned out, it holds still.

    Args:
        channel: Of the roboRIO.
        servo: What it turns; the ends of its travel are those of the signal, 0 and 1.
        reversed: Whether 1 is the lower end.
    """

    def __init__(self, channel: int, servo: ServoSim, *, reversed: bool) -> None:
        self._pwm = PWMSim(channel)
        self._servo = servo
        low, high = servo.stops
        self._from, self._way = (high, low - high) if reversed else (low, high - low)

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """The signal to the servo."""
        if powered and RobotState.is_enabled() and self._pwm.get_pulse_microsecond() > 0:
            self._servo.set_goal(self._from + self._way * season.pwm_position(self._pwm))
        else:
            self._servo.coast()

    def write(self) -> None:
        """A servo shows nothing."""


class PistonValve:
    """A cylinder's solenoid valve on a pneumatics module, which switches it off while the robot is disabled.

    Args:
        module: Its simulation.
        channels: One, or the forward and the reverse one.
        piston: What it moves.
        reversed: Whether power on the forward coil, or the only one, pulls the rod in.
    """

    def __init__(self, module: Any, channels: Sequence[int], piston: PistonSim, *, reversed: bool) -> None:
        self._module = module
        self._channels = tuple(channels)
        self._piston = piston
        self._out = -12.0 if reversed else 12.0

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """The coils to the valve."""
        on = [bool(self._module.get_solenoid_output(channel)) for channel in self._channels]
        if not (powered and RobotState.is_enabled()):
            on = [False] * len(on)
        self._piston.set_volts(self._out * (float(on[0]) - float(on[1:] == [True])))

    def write(self) -> None:
        """A valve shows nothing."""


# --- what a mechanism shows ---------------------------------------------------------------------------------------


class QuadratureInput:
    """A quadrature `Encoder`; it reads zero where the mechanism is at first, and where robot code resets it.

    Args:
        sim: Of the encoder, e.g. `EncoderSim.create_for_channel(a)`.
        pulses_per_turn: Of the encoder, per turn of itself.
        gearing: Turns of the encoder per turn of the mechanism; negative if it counts down [-].
        start: Position of the mechanism at first [rad].
    """

    def __init__(self, sim: Any, *, pulses_per_turn: float, gearing: float, start: float = 0.0) -> None:
        self._sim = sim
        self._per_rad = pulses_per_turn * gearing / math.tau
        self._base = self._written = start * self._per_rad

    def write(self, position: float, velocity: float) -> None:
        """See `AnglePort`; counts are whole."""
        if self._sim.get_reset():
            self._base = self._written
        pulses = position * self._per_rad
        self._sim.set_count(round(pulses - self._base))
        self._sim.set_rate(velocity * self._per_rad * self._sim.get_distance_per_pulse())
        self._sim.set_direction(velocity * self._per_rad > 0.0)
        self._written = pulses


class AbsoluteEncoderInput:
    """A duty cycle encoder on a DIO channel or an analog one, by whichever class robot code reads it.

    `DutyCycleEncoder` and `AnalogEncoder` read a position of their own in simulation; a bare `DutyCycle` reads the
    share of the pulse and an `AnalogInput` or `AnalogPotentiometer` volts, which are those of the same angle.

    Args:
        model: `DIO` or `Analog`.
        channel: Of the roboRIO.
        gearing: Turns of the encoder per turn of the mechanism; negative if it counts down [-].
        zero: What it reads with the mechanism at its zero, in the unit of robot code.
        full_range: What a turn is in that unit.
    """

    def __init__(self, model: str, channel: int, *, gearing: float, zero: float, full_range: float) -> None:
        device = f"DutyCycle:DutyCycleEncoder[{channel}]" if model == "DIO" else f"AnalogEncoder[{channel}]"
        self._position = None
        if device in SimDeviceSim.enumerate_devices():
            self._position = SimDeviceSim(device).get_double("Position")
        self._show: Callable[[float], object]
        if model == "DIO":
            self._show, self._per_turn = DutyCycleSim.create_for_channel(channel).set_output, 1.0
        else:
            self._show, self._per_turn = AnalogInputSim(channel).set_voltage, _RAIL
        self._turns_per_rad = gearing / math.tau
        self._zero = zero / full_range
        self._range = full_range

    def write(self, position: float, velocity: float) -> None:
        """See `AnglePort`; within one turn."""
        turns = (self._zero + position * self._turns_per_rad) % 1.0
        if self._position is not None:
            self._position.set(turns * self._range)
        self._show(turns * self._per_turn)


class PotentiometerInput:
    """A potentiometer on an analog channel, linear between the stops of a mechanism.

    Args:
        channel: Of the roboRIO.
        stops: Lower and upper, as positions [rad], of a piston [m].
        volts: At the lower and at the upper stop [V].
    """

    def __init__(self, channel: int, *, stops: tuple[float, float], volts: tuple[float, float]) -> None:
        self._sim = AnalogInputSim(channel)
        self._low = stops[0]
        self._volts = volts[0]
        self._per_unit = (volts[1] - volts[0]) / (stops[1] - stops[0])

    def write(self, position: float, velocity: float) -> None:
        """See `AnglePort`."""
        self._sim.set_voltage(self._volts + (position - self._low) * self._per_unit)


class DigitalSwitch:
    """A switch or light barrier between a DIO channel and ground; an open contact reads True.

    Args:
        channel: Of the roboRIO.
        normally_closed: Whether its contact is closed while nothing acts on it.
    """

    def __init__(self, channel: int, *, normally_closed: bool) -> None:
        self._sim = DIOSim(channel)
        self._normally_closed = normally_closed
        self.set_active(False)

    def set_active(self, active: bool) -> None:
        """See `Switch`."""
        self._sim.set_value(active == self._normally_closed)


class Switch(Protocol):
    """An input that robot code reads as on or off: `DigitalSwitch`, `CANdiSwitchSim`."""

    def set_active(self, active: bool) -> None:
        """Whether something presses the switch, or breaks the beam."""
        ...


class LimitSwitchInput:
    """A switch that a mechanism presses in a part of its way.

    Args:
        switch: Where it is wired to.
        low: Position from which on it is pressed [rad], of a piston [m].
        high: Up to which.
    """

    def __init__(self, switch: Switch, *, low: float, high: float) -> None:
        self._switch = switch
        self._low = low
        self._high = high
        self.is_pressed = False
        """At the last look."""

    def write(self, position: float, velocity: float) -> None:
        """See `AnglePort`."""
        self.is_pressed = self._low <= position <= self._high
        self._switch.set_active(self.is_pressed)
