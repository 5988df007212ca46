"""The simulated side of a device: CTRE's `sim_state`, and the short way to an emulated device.

Both take the same calls with the same signs. To emulated devices values go from attribute to attribute: by name 60
values a step took 0.1 ms of a 20 ms tick, now 0.03 ms.
"""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

from phoenix6.phoenix_native import Native
from phoenix6.sim import ChassisReference

if TYPE_CHECKING:  # types only: a program on CTRE's own simulation loads no emulator
    from simcore.phoenix6_emulator.emulated_peripherals import EmulatedCANcoder, EmulatedPigeon2
    from simcore.phoenix6_emulator.emulated_talon import EmulatedTalon

__all__ = ["is_emulated", "own_writer", "sim_state_of"]


def is_emulated() -> bool:
    """Whether Phoenix 6 runs in simulated time, on `simcore.phoenix6_emulator`."""
    return _emulator() is not None


def sim_state_of(device: Any) -> Any:
    """What physics writes to and reads from.

    Args:
        device: Of the robot code. An emulated `TalonFX`, `CANcoder` or `Pigeon2` is reached the short way.
    """
    emulator = _emulator()
    for kind in type(device).__mro__ if emulator is not None else ():
        if kind.__name__ in _EMULATED_STATES:
            find, state = _EMULATED_STATES[kind.__name__]
            return state(getattr(emulator, find)(device.device_id))
    return device.sim_state


def own_writer(state: Any, name: str) -> Any:
    """A setter of a simulated state without what asks before it: what physics itself calls."""
    return inspect.unwrap(getattr(type(state), name)).__get__(state)


def _emulator() -> Any:
    """The emulated devices, an attribute of the emulated native library; None on CTRE's own."""
    return getattr(Native.instance(), "emulator", None)


class _Mounted:
    """The orientation of a device, as every `sim_state` has it."""

    def __init__(self) -> None:
        self._sign = 1.0
        self._orientation = ChassisReference.COUNTER_CLOCKWISE_POSITIVE

    @property
    def orientation(self) -> ChassisReference:
        """Which turn physics calls positive."""
        return self._orientation

    @orientation.setter
    def orientation(self, value: ChassisReference) -> None:
        self._orientation = value
        self._sign = -1.0 if value == ChassisReference.CLOCKWISE_POSITIVE else 1.0


class _EmulatedTalonState(_Mounted):
    """Of a TalonFX: volts at the motor [V], current in it [A]; rotations and rotations/s of the rotor."""

    def __init__(self, device: EmulatedTalon) -> None:
        super().__init__()
        self._device = device
        self._bridge = device.bridge

    @property
    def motor_voltage(self) -> float:
        return self._bridge.volts * self._device.turn * self._sign

    @property
    def torque_current(self) -> float:
        return self._bridge.current * self._sign

    def set_supply_voltage(self, volts: float) -> None:
        self._device.set_input("SupplyVoltage", volts)

    def write_rotor(self, rotations: float, rps: float) -> None:
        device, sign = self._device, self._sign
        device.raw = rotations * sign
        device.rotor_rps = rps * sign


class _EmulatedEncoderState(_Mounted):
    """Of a CANcoder [rotations, rotations/s]."""

    sensor_offset = 0.0

    def __init__(self, device: EmulatedCANcoder) -> None:
        super().__init__()
        self._device = device

    def set_supply_voltage(self, volts: float) -> None:
        self._device.set_input("SupplyVoltage", volts)

    def set_raw_position(self, rotations: float) -> None:
        self._device.raw = (rotations - self.sensor_offset) * self._sign

    def set_velocity(self, rps: float) -> None:
        self._device.raw_velocity = rps * self._sign


class _EmulatedPigeonState(_Mounted):
    """Of a Pigeon 2 [deg, deg/s]."""

    def __init__(self, device: EmulatedPigeon2) -> None:
        super().__init__()
        self._set = device.set_input

    def set_supply_voltage(self, volts: float) -> None:
        self._set("SupplyVoltage", volts)

    def set_raw_yaw(self, degrees: float) -> None:
        self._set("RawYaw", degrees)

    def set_pitch(self, degrees: float) -> None:
        self._set("Pitch", degrees)

    def set_roll(self, degrees: float) -> None:
        self._set("Roll", degrees)

    def set_angular_velocity_x(self, dps: float) -> None:
        self._set("AngularVelocityX", dps)

    def set_angular_velocity_y(self, dps: float) -> None:
        self._set("AngularVelocityY", dps)

    def set_angular_velocity_z(self, dps: float) -> None:
        self._set("AngularVelocityZ", dps)


_EMULATED_STATES: dict[str, tuple[str, Any]] = {
    "TalonFX": ("talon", _EmulatedTalonState),
    "CANcoder": ("cancoder", _EmulatedEncoderState),
    "Pigeon2": ("pigeon", _EmulatedPigeonState),
}
