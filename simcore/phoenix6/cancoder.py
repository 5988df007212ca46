"""Writes the simulated state of a CANcoder."""

from __future__ import annotations

import math

from phoenix6.configs import MagnetSensorConfigs
from phoenix6.hardware import CANcoder
from phoenix6.signals import SensorDirectionValue
from phoenix6.sim import ChassisReference

from simcore.errors import ConfigError
from simcore.phoenix6.ownership import own_writer
from simcore.phoenix6.sim_states import sim_state_of

__all__ = ["CANcoderSim"]

_PATIENCE = 1.0  # [s]; a device answers in 50 ms, but not on a computer that is busy starting


class CANcoderSim:
    """A CANcoder on a shaft: robot code reads the shaft's angle, whatever direction and offset it has configured.

    Args:
        encoder: The device of the robot code.
        inverted: Whether it is configured `CLOCKWISE_POSITIVE`; None asks the device (50 ms, once).
        magnet_offset: As configured [rotations]; None asks the device.

    Raises:
        ConfigError: The device does not answer.
    """

    def __init__(self, encoder: CANcoder, *, inverted: bool | None = None, magnet_offset: float | None = None) -> None:
        if inverted is None or magnet_offset is None:
            sensor = MagnetSensorConfigs()  # type: ignore[no-untyped-call]
            status = encoder.configurator.refresh(sensor, _PATIENCE)
            if not status.is_ok():
                raise ConfigError(f"CANcoder {encoder.device_id}: could not read its configuration ({status.name})")
            if inverted is None:
                inverted = sensor.sensor_direction == SensorDirectionValue.CLOCKWISE_POSITIVE
            if magnet_offset is None:
                magnet_offset = sensor.magnet_offset
        self._state = sim_state_of(encoder)
        self._set_position = own_writer(self._state, "set_raw_position")
        self._set_velocity = own_writer(self._state, "set_velocity")
        self._state.orientation = (
            ChassisReference.CLOCKWISE_POSITIVE if inverted else ChassisReference.COUNTER_CLOCKWISE_POSITIVE
        )
        # The device adds its magnet offset to the raw angle; told of it here, it takes it off again.
        self._state.sensor_offset = magnet_offset

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        self._state.set_supply_voltage(min(max(volts, 4.0), 16.0))

    def write(self, angle: float, rate: float) -> None:
        """Say where the shaft is [rad] and how fast it turns [rad/s]."""
        self._set_position(angle / math.tau)
        self._set_velocity(rate / math.tau)
