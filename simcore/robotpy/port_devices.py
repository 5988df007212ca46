"""Devices on roboRIO ports and pneumatics modules, connected with mechanisms: what moves them, and what they show.

Each has `read` and `write` as `MotorDevices` wants them. Found by channel in the HAL's simulation data, so it makes no
difference where robot code keeps its objects. Nothing here lives on the wall clock.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from simcore import season
from simcore.devices.motor_ports import AnglePort, MotorPort
from simcore.robot.mechanisms import PistonSim, ServoSim, ShaftSim

RobotState = season.wpilib.RobotState
AnalogInputSim = season.wpilib_simulation.AnalogInputSim
DIOSim = season.wpilib_simulation.DIOSim
PWMSim = season.wpilib_simulation.PWMSim

__all__ = [
    "DigitalSwitch",
    "LimitSwitchInput",
    "PistonValve",
    "PortMotorSim",
    "PotentiometerInput",
    "ServoSignal",
    "Switch",
]


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
