"""The native functions of devices, signals, configurations and simulation, by name, on emulated devices.

All of the Python library goes through `Native.instance()` (devices) and `Native.api_instance()` (swerve, see
`swerve_native`). A function that is missing here raises `NotImplementedError` with its plain name; no call reaches the
real library.
"""

from __future__ import annotations

import ctypes
import logging
import struct
from collections.abc import Callable
from typing import Any

from phoenix6.phoenix_native import ReturnValues, SignalValues
from phoenix6.spns.spn_value import SpnValue
from phoenix6.status_code import StatusCode

from simcore.errors import NonFiniteError
from simcore.phoenix6_emulator import config_text
from simcore.phoenix6_emulator.control_requests import REQUESTS, RequestKind
from simcore.phoenix6_emulator.emulated_device import COMPLIANCY, VERSION
from simcore.phoenix6_emulator.emulated_peripherals import LIGHT_REQUESTS, EmulatedCANdle
from simcore.phoenix6_emulator.emulator import MODELS, Emulator, hash_of
from simcore.phoenix6_emulator.library_services import LibraryServices
from simcore.phoenix6_emulator.native_library import always, target_of
from simcore.phoenix6_emulator.signal_units import UNITS
from simcore.phoenix6_emulator.versions import PREFIX

__all__ = ["EmulatedNative"]

_log = logging.getLogger(__name__)
_OK = StatusCode.OK.value
_WANTED = struct.Struct("@II")
"""`SignalValues`: device and number of a signal; in 26.70 the network is before them."""
_WANTED_AT = SignalValues.devicehash.offset
_WANTED_SIZE = ctypes.sizeof(SignalValues)
_RETURNED = struct.Struct("@dIPdddi")
"""`ReturnValues`: value, number of its units, their text (left out), three timestamps, status."""
_RETURNED_SIZE = ctypes.sizeof(ReturnValues)


def _serializer(letter: str, kind: Callable[[Any], Any]) -> Callable[..., int]:
    """Writes a setting of a kind into text."""

    def serialize(self: Any, spn: int, value: Any, out: Any) -> int:
        target_of(out).value = config_text.write(spn, letter, kind(value)).encode()
        return _OK

    return serialize


def _deserializer(meaning: Callable[[int], Any]) -> Callable[..., int]:
    """Reads a setting of a kind from text, by what the number in the text means."""

    def deserialize(self: Any, spn: int, text: Any, size: int, out: Any) -> int:
        key = f"{spn},s_"
        for line in text.value.decode().split():
            if line.startswith(key):
                target_of(out).value = meaning(int(line[len(key) :]))
                return _OK
        return StatusCode.INVALID_PARAM_VALUE.value

    return deserialize


class EmulatedNative(LibraryServices):
    """In place of the library that holds devices, signals, configurations and simulation.

    Args:
        emulator: The devices.
    """

    def __init__(self, emulator: Emulator) -> None:
        super().__init__(lambda: emulator.clock.now)
        self.emulator = emulator
        """The devices; with this attribute adapters recognise simulated time."""
        for kind in REQUESTS.values():
            setattr(self, f"{PREFIX}RequestControl{kind.name}", self._request(kind))
        for name in LIGHT_REQUESTS:
            setattr(self, f"{PREFIX}RequestControl{name}", self._light(name))

    def _request(self, kind: RequestKind) -> Callable[..., int]:
        by_hash = self.emulator.by_hash

        def send(network: Any, device_hash: int, *args: Any) -> int:
            device = by_hash.get(device_hash)
            if device is not None:
                device.receive(kind, args)
            return _OK

        return send

    def _light(self, name: str) -> Callable[..., int]:
        by_hash = self.emulator.by_hash

        def send(network: Any, device_hash: int, *args: Any) -> int:
            candle = by_hash.get(device_hash)
            if isinstance(candle, EmulatedCANdle):
                candle.show(name, args)
            return _OK

        return send

    # ---- time and enable

    c_ctre_phoenix6_is_simulation = always(True)
    c_ctre_phoenix6_is_replay = always(False)
    c_ctre_phoenix6_unmanaged_set_transmit_enable = always(None)
    c_ctre_phoenix6_unmanaged_get_transmit_enable = always(True)
    c_ctre_phoenix6_unmanaged_load_phoenix = always(None)
    c_Phoenix_Diagnostics_SetSecondsToStart = always(None)
    c_ctre_phoenix6_unmanaged_get_api_compliancy = always(COMPLIANCY)
    c_ctre_phoenix6_unmanaged_get_phoenix_version = always(int.from_bytes(bytes(VERSION[:3]), "big"))

    def c_ctre_phoenix6_get_current_time_seconds(self) -> float:
        return self.emulator.clock.ns * 1e-9

    def c_ctre_phoenix6_get_monotonic_time_seconds(self) -> float:
        return self.emulator.clock.ns * 1e-9

    def c_ctre_phoenix6_unmanaged_feed_enable(self, milliseconds: int) -> int:
        self.emulator.enable.feed(milliseconds)
        return _OK

    def c_ctre_phoenix6_unmanaged_get_enable_state(self) -> bool:
        return self.emulator.enable.is_fed

    # ---- devices

    c_ctre_phoenix6_platform_sim_get_last_error = always(_OK)
    c_ctre_phoenix6_platform_canbus_is_network_fd = always(True)

    def c_ctre_phoenix6_encode_device(self, device_id: int, model: Any, network: Any, out: Any) -> int:
        name = model.value.decode()
        if device_id == -1:
            target_of(out).value = 0
            return _OK
        if name.lower() not in MODELS:
            raise NotImplementedError(f"device '{name}' (id {device_id}) is not modelled in simulated time")
        device = self.emulator.create(MODELS[name.lower()], device_id)
        bus = network.value.decode()
        if device.bus is None:
            device.bus = bus
        elif device.bus != bus:
            _log.warning("%r is built on the buses %r and %r: simulated, they are one device", device, device.bus, bus)
        target_of(out).value = hash_of(MODELS[name.lower()], device_id)
        return _OK

    def c_ctre_phoenix6_platform_sim_create(self, type_number: int, device_id: int) -> int:
        if device_id != -1:
            self.emulator.create(type_number, device_id)
        return _OK

    def c_ctre_phoenix6_platform_sim_set_physics_input(
        self, type_number: int, device_id: int, name: Any, value: float
    ) -> int:
        text = name.value
        if value != value:
            raise NonFiniteError(f"device {device_id} (type {type_number}): sim_state {text.decode()} is not a number")
        if b":" not in text:  # with a colon it is the echo of a WPILib SimDevice, see `installation`
            self.emulator.devices[type_number, device_id].set_input(text.decode(), float(value))
        return _OK

    def c_ctre_phoenix6_platform_sim_get_physics_value(
        self, type_number: int, device_id: int, name: Any, out: Any
    ) -> int:
        value = self.emulator.devices[type_number, device_id].get_value(name.value.decode())
        if value is None:
            return -1
        target_of(out).value = value
        return _OK

    def c_ctre_phoenix6_platform_canbus_get_status(self, *values: Any) -> int:
        """Of a bus without traffic or errors: five numbers, in 26.70 one structure; network and flags follow."""
        for out in map(target_of, values[:1] if len(values) == 2 else values[:5]):
            ctypes.memset(ctypes.byref(out), 0, ctypes.sizeof(out))
        return _OK

    # ---- configuration

    def c_ctre_phoenix6_set_configs(
        self, context: int, network: Any, device_hash: int, timeout: float, text: Any, size: int, future_proof: bool,
        override: bool, extra: bool,
    ) -> int:  # fmt: skip
        device = self.emulator.by_hash.get(device_hash)
        if device is not None:
            device.configure(config_text.parse(text.value.decode()), reset_others=future_proof)
        return _OK

    def c_ctre_phoenix6_get_configs(
        self, context: int, network: Any, device_hash: int, timeout: float, out: Any, extra: bool
    ) -> int:
        target_of(out).value = config_text.answer(self.emulator.by_hash[device_hash].config).encode()
        return _OK

    def c_ctre_phoenix6_free_memory(self, out: Any) -> int:
        target_of(out).value = None
        return _OK

    c_ctre_phoenix6_serialize_double = _serializer("f", float)
    c_ctre_phoenix6_serialize_int = _serializer("s", int)
    c_ctre_phoenix6_serialize_bool = _serializer("b", bool)
    c_ctre_phoenix6_deserialize_double = _deserializer(config_text.number_of)
    c_ctre_phoenix6_deserialize_int = _deserializer(int)
    c_ctre_phoenix6_deserialize_bool = _deserializer(bool)

    # ---- signals

    def c_ctre_phoenix6_get_rets(self, spn: int, kind: int, out: Any) -> int:
        target_of(out).units = UNITS.get(spn, "").encode()
        return _OK

    def c_ctre_phoenix6_get_signal(self, count: int, wanted: Any, values: Any, *rest: Any) -> int:
        """`rest` ends with whether to wait and how long; in 26.3 the network is before them."""
        wait, timeout = rest[-2:]
        # Read and written as bytes: field by field through ctypes a signal takes three times as long.
        by_hash = self.emulator.by_hash
        wanted, values = target_of(wanted), target_of(values)
        fresh = wait and timeout > 0.0
        for k in range(count):
            device_hash, spn = _WANTED.unpack_from(wanted, k * _WANTED_SIZE + _WANTED_AT)
            device = by_hash.get(device_hash)
            if device is None:
                continue  # the devices of `TalonFX.none()`: zero and OK
            if fresh:
                device.send_frame()
            answer = device.read(spn)
            if answer is None:
                raise NotImplementedError(f"{device!r}: signal {SpnValue(spn).name} is not modelled in simulated time")
            value, stamp, units = answer
            _RETURNED.pack_into(values, k * _RETURNED_SIZE, value, units, 0, stamp, stamp, stamp, _OK)
        return _OK

    def c_ctre_phoenix6_SetUpdateFrequency(
        self, context: int, network: Any, device_hash: int, spn: int, hz: float, timeout: float
    ) -> int:
        device = self.emulator.by_hash.get(device_hash)
        if device is not None:
            device.ask_rate(spn, hz)
        return _OK

    def c_ctre_phoenix6_SetUpdateFrequencyForAll(
        self, context: int, signals: Any, count: int, hz: float, timeout: float
    ) -> int:
        for k in range(count):
            signal = getattr(signals[k], "signal", signals[k])  # 26.3 wraps it with its network
            self.c_ctre_phoenix6_SetUpdateFrequency(context, None, signal.devicehash, signal.spn, hz, timeout)
        return _OK

    def c_ctre_phoenix6_GetUpdateFrequency(self, network: Any, device_hash: int, spn: int) -> float:
        device = self.emulator.by_hash.get(device_hash)
        return 0.0 if device is None else device.rate

    def c_ctre_phoenix6_OptimizeUpdateFrequencies(
        self, context: int, network: Any, device_hash: int, hz: float, timeout: float
    ) -> int:
        device = self.emulator.by_hash.get(device_hash)
        if device is not None:
            device.optimize_rate(hz)
        return _OK

    def c_ctre_phoenix6_ResetUpdateFrequencies(
        self, context: int, network: Any, device_hash: int, timeout: float
    ) -> int:
        device = self.emulator.by_hash.get(device_hash)
        if device is not None:
            device.reset_rate()
        return _OK

    # ---- errors

    def c_ctre_phoenix_report_error(
        self, is_error: bool, code: int, flags: int, text: Any, location: Any, trace: Any
    ) -> None:
        _log.warning("%s: %s", location.value.decode(), text.value.decode())

    def c_ctre_phoenix6_report_error(
        self, is_error: bool, code: int, text: Any, location: Any, context: Any, trace: Any
    ) -> None:
        _log.warning("%s: %s", location.value.decode(), text.value.decode())

    def c_ctre_phoenix6_report_status_code(self, code: int, location: Any, context: Any, trace: Any) -> None:
        _log.warning("%s: %s", location.value.decode(), StatusCode(code).description)
