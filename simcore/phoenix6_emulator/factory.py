"""Makes devices, with the factory configuration of their type."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from phoenix6 import configs

from simcore.phoenix6_emulator import wire
from simcore.phoenix6_emulator.cancoder import CANcoder
from simcore.phoenix6_emulator.candi import CANdi
from simcore.phoenix6_emulator.candle import CANdle
from simcore.phoenix6_emulator.canrange import CANrange
from simcore.phoenix6_emulator.device import Device
from simcore.phoenix6_emulator.pigeon import Pigeon2
from simcore.phoenix6_emulator.talon import Talon
from simcore.phoenix6_emulator.talon_fxs import TalonFXS

if TYPE_CHECKING:
    from simcore.phoenix6_emulator.world import StandIn

__all__ = ["MODELS", "build", "hash_of"]

_CLASSES: dict[int, type[Device]] = {
    cls.type_number: cls for cls in (Talon, CANcoder, Pigeon2, TalonFXS, CANrange, CANdi, CANdle)
}
MODELS: dict[str, int] = {cls.model: number for number, cls in _CLASSES.items()}
"""`DeviceType` number by the name under which the library makes a device."""
_HASH_BASE = {4: 0x80, 5: 0x4140, 6: 0x8540, 7: 0xC080, 8: 0x10280, 9: 0x142C0, 10: 0x18580}
_CONFIGS = {
    4: configs.TalonFXConfiguration,
    5: configs.CANcoderConfiguration,
    6: configs.Pigeon2Configuration,
    7: configs.TalonFXSConfiguration,
    8: configs.CANrangeConfiguration,
    9: configs.CANdiConfiguration,
    10: configs.CANdleConfiguration,
}


def hash_of(type_number: int, device_id: int) -> int:
    """Number by which the library names a device; the same for every bus."""
    return _HASH_BASE[type_number] | device_id


@cache
def _defaults(type_number: int) -> dict[int, wire.Setting]:
    make: Any = _CONFIGS[type_number]
    return wire.parse(make().serialize())


def build(type_number: int, device_id: int, world: StandIn) -> Device:
    """A new device.

    Raises:
        NotImplementedError: Devices of this type are not modelled.
    """
    if type_number not in _CONFIGS:
        raise NotImplementedError(f"devices of type {type_number} (id {device_id}) are not modelled in simulated time")
    defaults, cls = _defaults(type_number), _CLASSES[type_number]
    if issubclass(cls, Talon):
        return cls(device_id, world.clock, defaults, world)
    return cls(device_id, world.clock, defaults)
