"""One Talon SRX or Victor SPX as robot code sees it: what it asks for, and what it reads."""

from __future__ import annotations

import math
from typing import Any

import phoenix5
from phoenix5 import ErrorCode
from wpilib import DriverStation

from simcore.devices.makers import known_device
from simcore.devices.recorder import Answers
from simcore.errors import NonFiniteError
from simcore.phoenix5.built_talons import MODELS, record_of
from simcore.phoenix5.talon_loop import ControlMode, TalonLoop

__all__ = ["TalonSRXPort", "answer_for_talons"]

_TURN, _ANALOG_TURN = 4096.0, 1024.0
"""Units per turn of a CTRE mag encoder; of a quadrature of 1024 pulses, which is a guess; of an analog encoder."""
_PER_100_MS = 0.1
_ROUNDING = 1e-6  # a whole number of units less an error of the last digit is that number


class TalonSRXPort:
    """The simulated side of one controller; a Victor SPX has no encoder and measures no current.

    An encoder that is wired to it counts up while its output is positive, as a sensor phase that is right makes it.

    Args:
        device: That robot code has built.
        sign: -1 where positive in robot code is negative for the mechanism.

    Raises:
        ConfigError: It was built before simcore was imported.
    """

    def __init__(self, device: Any, *, sign: float = 1.0) -> None:
        device = known_device(device)
        self.device = device
        self.loop = TalonLoop()
        self._talon = device.hardware
        self._record = record_of(device.hardware)
        self._seen = -1
        self._sign = sign
        self._turns = self._rate = self._shift = 0.0
        self.amps = 0.0
        """Of its motor, positive as its output [A]."""
        self.bus = self._bus_of_loop = 12.0
        """[V]"""
        self.applied = 0.0
        """Duty cycle on the motor, positive as robot code has it [-]."""
        self._over = 0.0  # for how long the supply current has been above its limit [s]
        self.configure()
        _answers.attach(device.hardware, self)

    @property
    def brakes(self) -> bool:
        """Whether it brakes in neutral."""
        self.configure()
        return self.loop.config.brakes

    @property
    def units(self) -> float:
        """Of the selected sensor per turn of its shaft."""
        return (_ANALOG_TURN if self._record.is_analog else _TURN) * self._record.coefficient

    @property
    def position(self) -> float:
        """Of the selected sensor, as robot code reads it [units]."""
        return float(math.floor(self._turns * self.units + self._shift + _ROUNDING))

    @property
    def velocity(self) -> float:
        """Its velocity [units/100 ms]."""
        return float(math.floor(self._rate * self.units * _PER_100_MS + _ROUNDING))

    def set_position(self, units: float) -> None:
        """What `setSelectedSensorPosition` does."""
        self._shift = float(units) - self._turns * self.units

    def configure(self) -> None:
        """Take over the configuration, if robot code has changed it since."""
        if self._record.changes != self._seen:
            self._seen = self._record.changes
            self.loop.config = self._record.configuration()

    def run(self, loops: int) -> None:
        """Let its control loop run for so many milliseconds."""
        self.configure()
        if not DriverStation.isEnabled():
            self.loop.rest()
            self._over = 0.0
            return
        demand = self._record.demand(self._talon)
        if demand.mode == ControlMode.FOLLOWER:
            leader = _answers.of(self._record.leader)
            self.loop.output = self.applied = 0.0 if leader is None else leader.loop.output
            return
        self._bus_of_loop = self.bus
        self.loop.run(loops, demand, self.position, self.velocity, abs(self.amps), self.bus)
        c = self.loop.config
        is_over = c.supply_limit is not None and self.supply_current > max(c.supply_trigger, c.supply_limit)
        if is_over or (c.supply_limit is not None and self._over >= c.supply_delay and self._is_limited):
            self._over += loops * 1e-3
        else:
            self._over = 0.0

    @property
    def supply_current(self) -> float:
        """From the battery [A]."""
        return self.applied * self.amps

    @property
    def _is_limited(self) -> bool:
        return abs(self.applied) < abs(self.loop.output) - 1e-9

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        self.bus = max(volts, 1.0)

    @property
    def duty_cycle(self) -> float | None:
        """See `LoopPort`."""
        return self.applied * self._sign if self.loop.config.compensation is None else None

    def volts(self, emf: float, resistance: float) -> float:
        """What it puts on the motor, positive as for the mechanism [V]; see `LoopPort.volts`."""
        output, limit = self.loop.output, self.loop.config.supply_limit
        volts = output * self._sign * (self.bus if self.loop.config.compensation is None else self._bus_of_loop)
        if limit is not None and self._over > 0.0 and self._over >= self.loop.config.supply_delay and output:
            # V (V - e) / R = I_supply V_bus has one root on the side of the output
            side = math.copysign(1.0, volts)
            most = 0.5 * (emf * side + math.sqrt(emf * emf + 4.0 * limit * self.bus * resistance))
            volts = side * min(abs(volts), most)
        self.applied = volts * self._sign / self.bus
        return volts

    def show_output(self, output: float) -> None:
        """Of a follower: the duty cycle that it applies, positive as for the mechanism [-]."""
        self.applied = output * self._sign

    def write(self, rotor: float, rotor_rps: float, encoder: float, encoder_rps: float, amps: float) -> None:
        """Set what its sensors read, positive as for the mechanism: its encoder sits on the mechanism, not the rotor.

        Raises:
            NonFiniteError: A value is not finite; nothing is written.
        """
        if not math.isfinite(encoder + encoder_rps + amps):
            raise NonFiniteError(
                f"{self.device}: want finite numbers, got {encoder} turns, {encoder_rps} rps, {amps} A"
            )
        self._turns, self._rate = self._sign * encoder, self._sign * encoder_rps
        self.amps = self._sign * amps

    def start_at_zero(self, encoder: float) -> None:
        """Count from here, unless the encoder knows its angle: turns of the encoder as it is switched on."""
        if not self._record.is_absolute:
            self._shift = -self._sign * encoder * self.units


_answers = Answers[TalonSRXPort]()
_OUTPUTS: dict[str, Any] = {
    "getMotorOutputPercent": lambda port: port.applied,
    "getMotorOutputVoltage": lambda port: port.applied * port.bus,
    "getBusVoltage": lambda port: port.bus,
    "getSelectedSensorPosition": lambda port, pid=0: port.position,
    "getSelectedSensorVelocity": lambda port, pid=0: port.velocity,
    "getClosedLoopError": lambda port, pid=0: port.loop.error,
    "getErrorDerivative": lambda port, pid=0: port.loop.error_slope,
    "getIntegralAccumulator": lambda port, pid=0: port.loop.integral,
    "getActiveTrajectoryPosition": lambda port, pid=0: port.loop.profile_position,
    "getActiveTrajectoryVelocity": lambda port, pid=0: port.loop.profile_velocity,
}
_CURRENTS: dict[str, Any] = {
    "getStatorCurrent": lambda port: abs(port.amps),
    "getOutputCurrent": lambda port: abs(port.amps),
    "getSupplyCurrent": lambda port: port.supply_current,
}


def _set_position(port: TalonSRXPort, units: float, *_: Any, **__: Any) -> Any:
    port.set_position(units)
    return ErrorCode.OK


class _Sensors:
    """What `getSensorCollection()` gives of a controller that is answered for."""

    def __init__(self, port: TalonSRXPort) -> None:
        self._port = port
        self._original = _sensor_collection(port.device.hardware)

    def _position(self) -> int:
        return int(self._port.position)

    def _velocity(self) -> int:
        return int(self._port.velocity)

    getQuadraturePosition = getPulseWidthPosition = getAnalogIn = _position
    getQuadratureVelocity = getPulseWidthVelocity = getAnalogInVel = _velocity

    def getAnalogInRaw(self) -> int:
        return self._position() % int(_ANALOG_TURN)

    def setQuadraturePosition(self, units: int, timeout_ms: int = 0) -> Any:
        return _set_position(self._port, units)

    setPulseWidthPosition = setAnalogPosition = setQuadraturePosition

    def __getattr__(self, name: str) -> Any:
        return getattr(self._original, name)


_sensor_collection = phoenix5.TalonSRX.getSensorCollection


def answer_for_talons() -> None:
    """Answer what robot code reads of those with a port; again is harmless."""
    for model, classes in MODELS.items():
        for cls in classes:
            _answers.wrap(cls, _OUTPUTS | {"setSelectedSensorPosition": _set_position})
            if model == "Talon SRX":
                _answers.wrap(cls, _CURRENTS | {"getSensorCollection": _Sensors})
