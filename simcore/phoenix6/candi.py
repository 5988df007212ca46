"""Writes the simulated state of a CANdi: absolute encoders on its two pins, or switches."""

from __future__ import annotations

import math
from typing import Any

from phoenix6.configs import CANdiConfiguration
from phoenix6.hardware import CANdi
from phoenix6.signals import S1StateValue, S2StateValue
from phoenix6.sim import ChassisReference

from simcore.errors import ConfigError
from simcore.phoenix6.ownership import own_writer

__all__ = ["CANdiEncoderSim", "CANdiSwitchSim"]

_STATES: dict[int, Any] = {1: S1StateValue, 2: S2StateValue}


class CANdiEncoderSim:
    """An absolute encoder with a pulse-width output on pin S1 or S2: robot code reads the shaft's angle.

    Args:
        candi: The device of the robot code.
        pin: 1 or 2.
        inverted: Whether the pin's sensor is configured `CLOCKWISE_POSITIVE`; None asks the device (50 ms, once).
        offset: Absolute sensor offset as configured [rotations]; None asks the device.

    Raises:
        ConfigError: There is no such pin, or the device does not answer.
    """

    def __init__(self, candi: CANdi, pin: int, *, inverted: bool | None = None, offset: float | None = None) -> None:
        _check_pin(candi, pin)
        if inverted is None or offset is None:
            config = CANdiConfiguration()  # type: ignore[no-untyped-call]
            status = candi.configurator.refresh(config)
            if not status.is_ok():
                raise ConfigError(f"CANdi {candi.device_id}: could not read its configuration ({status.name})")
            sensor = config.pwm1 if pin == 1 else config.pwm2
            if inverted is None:
                inverted = bool(sensor.sensor_direction)  # of a CANdi it is a flag
            if offset is None:
                offset = sensor.absolute_sensor_offset
        self._state = state = candi.sim_state
        turn = ChassisReference.CLOCKWISE_POSITIVE if inverted else ChassisReference.COUNTER_CLOCKWISE_POSITIVE
        # The simulated device turns the position by its configured direction, but not the velocity (measured, 26.3).
        self._rate_sign = -1.0 if inverted else 1.0
        setattr(state, f"pwm{pin}_orientation", turn)
        setattr(state, f"pwm{pin}_sensor_offset", offset)
        getattr(state, f"set_pwm{pin}_connected")(True)
        self._set_position = own_writer(state, f"set_pwm{pin}_position")
        self._set_velocity = own_writer(state, f"set_pwm{pin}_velocity")

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        self._state.set_supply_voltage(min(max(volts, 4.0), 16.0))

    def write(self, angle: float, rate: float) -> None:
        """Say where the shaft is [rad] and how fast it turns [rad/s]."""
        self._set_position(angle / math.tau)
        self._set_velocity(self._rate_sign * rate / math.tau)


class CANdiSwitchSim:
    """A switch between a pin and ground: closed pulls it low, open leaves it floating.

    Args:
        candi: The device of the robot code.
        pin: 1 or 2.

    Raises:
        ConfigError: There is no such pin.
    """

    def __init__(self, candi: CANdi, pin: int) -> None:
        _check_pin(candi, pin)
        self._values = _STATES[pin]
        self._set = getattr(candi.sim_state, f"set_s{pin}_state")

    def write(self, closed: bool) -> None:
        """Say whether the switch is closed."""
        self._set(self._values.LOW if closed else self._values.FLOATING)


def _check_pin(candi: CANdi, pin: int) -> None:
    if pin not in _STATES:
        raise ConfigError(f"CANdi {candi.device_id}: pin must be 1 or 2, got {pin!r}")
