"""Phoenix 6's native functions, implemented for emulated devices under the functions' C names.

The Python library makes all native calls through `Native.instance()` (devices, signals, configurations, simulation)
and `Native.api_instance()` (swerve). The methods in this module have the function names of 26.70 (2027). `RENAMED` maps
the names of 26.3 (2026) to the names of 26.70. A call of a missing function raises `NotImplementedError` with the
function's name. No call reaches the real library. The functions of the hoot log, the orchestra and CANdle lights accept
all arguments and do nothing. The functions of hoot replay return the results of CTRE's simulation library.
"""

from __future__ import annotations

import ctypes
import gc
import itertools
import logging
import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Any, TypeAlias

from phoenix6 import phoenix_native
from phoenix6.phoenix_native import ReturnValues, SignalValues
from phoenix6.spns.spn_value import SpnValue
from phoenix6.status_code import StatusCode

from simcore.errors import NonFiniteError
from simcore.quantities import DeviceAddress
from simcore.robotcode.emulator.emulated_device import (
    COMPLIANCY,
    REQUESTS,
    VERSION,
    RequestKind,
    config_answer,
    config_line,
    number_of,
    parse_config,
)
from simcore.robotcode.emulator.emulated_drivetrain import (
    Brake,
    Centric,
    DrivetrainRequest,
    DrivetrainState,
    EmulatedDrivetrain,
    Idle,
    ModuleConstants,
    ModuleDevices,
    Point,
    Speeds,
    wrap,
)
from simcore.robotcode.emulator.emulated_peripherals import LIGHT_REQUESTS
from simcore.robotcode.emulator.emulator import MODELS, Emulator

__all__ = ["ADDED", "GONE", "IS_2027", "PREFIX", "RENAMED", "EmulatedNative", "SwerveNative"]

IS_2027 = hasattr(phoenix_native, "CANBusStatus_t")
"""Whether the installed phoenix6 is a 2027 version."""

PREFIX = "c_ctre_phoenix6_"
"""Prefix of nearly all native function names."""

_SWERVE = PREFIX + "swerve_"
RENAMED = {
    # 26.3: 26.70
    PREFIX + "get_system_time_seconds": PREFIX + "get_monotonic_time_seconds",
    _SWERVE + "drivetrain_set_operator_perspective_forward": _SWERVE + "drivetrain_set_operator_forward_direction",
    _SWERVE + "module_get_current_state": _SWERVE + "module_get_current_velocity",
    _SWERVE + "module_get_target_state": _SWERVE + "module_get_target_velocity",
    **{
        f"{_SWERVE}{what}_apply_{frame}_speeds": f"{_SWERVE}{what}_apply_{frame}_velocity"
        for what in ("drivetrain_set_control", "request_apply")
        for frame in ("robot", "field")
    },
}
"""Names in phoenix6 26.70 of functions that were renamed with unchanged arguments, by name in 26.3."""
GONE = frozenset({"c_ctre_phoenix_report_error"})
"""Names of the functions that exist in phoenix6 26.3 but not in 26.70."""
ADDED = frozenset(
    PREFIX + name
    for name in (
        "report_error",
        "report_status_code",
        "unmanaged_set_transmit_enable",
        "unmanaged_get_transmit_enable",
        *(f"{kind}_{what}" for kind in ("alert", "multi_alert") for what in ("create", "set_debounce")),
        *(f"{kind}_{what}" for kind in ("alert", "multi_alert") for what in ("set_active", "set_inactive")),
        "swerve_module_reset_target_velocity",
    )
)
"""Names of the functions that exist in phoenix6 26.70 but not in 26.3."""


@dataclass(frozen=True, slots=True)
class Fields:
    """Field names in the native swerve structures. The names differ between phoenix6 26.3 and 26.70."""

    chassis: str
    """Field name of the chassis velocity in the drivetrain state."""
    modules: str
    """Field name of the module states in the drivetrain state."""
    module: str
    """Field name of the wheel speed [m/s] in a module state."""
    wanted: str
    """Field name of the module state in a module request."""
    current: str
    """Field name of the chassis velocity in the parameters of a swerve request."""


FIELDS = (
    Fields("velocity", "moduleVelocities", "velocity", "velocity", "currentChassisVelocity")
    if IS_2027
    else Fields("speeds", "moduleStates", "speed", "state", "currentChassisSpeed")
)
"""Field names of the native swerve structures in the installed phoenix6."""


def record(named: dict[str, Any], **same: Any) -> SimpleNamespace:
    """Return an object in place of a native structure, with version-specific (`named`) and common (`same`) fields."""
    return SimpleNamespace(**named, **same)


_C_FUNCTION = type(ctypes.CFUNCTYPE(None))


class NativeLibrary:
    """Base class of the replacements for native libraries.

    A call of a function that is not modelled raises NotImplementedError.
    """

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if name in RENAMED:
            return getattr(self, RENAMED[name])
        plain = name.removeprefix(PREFIX).removeprefix("RequestControl")
        raise NotImplementedError(
            f"Phoenix 6 function {plain} is not modelled in simulated time; --phoenix=real runs the test on CTRE's own "
            "simulation, on the wall clock"
        )


def always(answer: Any) -> Callable[..., Any]:
    """Return a method that accepts any arguments and always returns `answer`."""

    def function(self: NativeLibrary, *values: Any) -> Any:
        return answer

    return function


class Held:
    """Stand-in for the ctypes pointer that a callback receives; `contents` is the Python object."""

    __slots__ = ("contents",)

    def __init__(self, contents: Any) -> None:
        self.contents = contents


def target_of(reference: Any) -> Any:
    """Return the object `x` of a ctypes argument `byref(x)`; return an array unchanged."""
    return getattr(reference, "_obj", reference)


def python_function(callback: Any) -> Callable[..., Any]:
    """Return the Python function that a ctypes callback wraps.

    A ctypes callback prints an exception and continues. An exception in a request or telemetry function must reach the
    test. The emulator therefore calls the Python function directly instead of the C function from ctypes.

    Args:
        callback: Callback from `ctypes.CFUNCTYPE(...)(function)`; any other object is returned unchanged.

    Raises:
        TypeError: The callback does not wrap a Python function.
    """
    if not isinstance(type(callback), _C_FUNCTION):
        return callback  # type: ignore[no-any-return]
    # callback -> its keep-alive table -> ctypes' thunk -> the function
    for thunk in (callback._objects or {}).values():
        for found in gc.get_referents(thunk):
            if callable(found) and not isinstance(found, type):
                return found  # type: ignore[no-any-return]
    raise TypeError(f"{callback!r} has no Python function inside; the simulated drivetrain cannot call it")


_OK = StatusCode.OK.value
_NOT_SUPPORTED = StatusCode.NOT_SUPPORTED.value

_LOGGED = (
    *(f"write_{kind}{many}" for kind in ("boolean", "integer", "float", "double", "string") for many in ("", "_array")),
    *("write_raw", "write_schema_value", "add_schema", "add_schema_string", "enable_auto_logging"),
    *("set_logger_path", "start_logger", "stop_logger"),
)
"""Functions of `SignalLogger` that do nothing, because a hoot log would contain wall-clock times."""
_MUSIC = ("Close", "AddDevice", "AddDeviceWithTrack", "ClearDevices", "LoadMusic", "Play", "Pause", "Stop", "IsPlaying",
          "GetCurrentTime")  # fmt: skip
"""Functions of `Orchestra` that do nothing."""
_REPLAYED = (
    *(f"get_{kind}{many}" for kind in ("boolean", "integer", "float", "double", "string") for many in ("", "_array")),
    *("get_raw", "get_schema_value", "load_file", "play", "pause", "stop", "step_timing"),
)
"""Functions of `HootReplay` that return NOT_SUPPORTED, as in CTRE's simulation library."""


_NAMES = {
    "deg": (
        "PIGEON2_MOUNT_POSE_YAW PIGEON2_MOUNT_POSE_PITCH PIGEON2_MOUNT_POSE_ROLL PIGEON2_YAW PIGEON2_PITCH "
        "PIGEON2_ROLL PIGEON2_ACCUM_GYRO_X PIGEON2_ACCUM_GYRO_Y PIGEON2_ACCUM_GYRO_Z PIGEON2_SET_YAW "
        "CANRANGE_REAL_FOV_CENTER_X CANRANGE_REAL_FOV_CENTER_Y CANRANGE_REAL_FOV_RANGE_X "
        "CANRANGE_REAL_FOV_RANGE_Y CANRANGE_FOV_CENTER_X CANRANGE_FOV_CENTER_Y CANRANGE_FOV_RANGE_X "
        "CANRANGE_FOV_RANGE_Y"
    ),
    "deg per rotation": ("PIGEON2_GYRO_SCALAR_X PIGEON2_GYRO_SCALAR_Y PIGEON2_GYRO_SCALAR_Z"),
    "℃": (
        "PIGEON2_TEMPERATURE PRO_SUPPLY_AND_TEMP_DEVICE_TEMP PRO_SUPPLY_AND_TEMP_PROCESSOR_TEMP "
        "EXTERNAL_MOTOR_TEMP PRO_SUPPLY_AND_TEMP_DEVICE_TEMP2 CANDLE_GENERAL_DEVICE_TEMP "
        "CONFIG_CUSTOM_MOT_THERMISTOR_MAX_TEMP"
    ),
    "s": ("PIGEON2_UP_TIME CANRANGE_MEAS_TIME"),
    "dps": (
        "PIGEON2_ANGULAR_VELOCITY_X_WORLD PIGEON2_ANGULAR_VELOCITY_Y_WORLD PIGEON2_ANGULAR_VELOCITY_Z_WORLD "
        "PIGEON2_ANGULAR_VELOCITY_X PIGEON2_ANGULAR_VELOCITY_Y PIGEON2_ANGULAR_VELOCITY_Z"
    ),
    "g": ("PIGEON2_ACCELERATION_X PIGEON2_ACCELERATION_Y PIGEON2_ACCELERATION_Z"),
    "V": (
        "PIGEON2_SUPPLY_VOLTAGE PRO_MOTOR_OUTPUT_MOTOR_VOLTAGE PRO_SUPPLY_AND_TEMP_SUPPLY_VOLTAGE "
        "PRO_PID_STATE_ENABLES_INTEGRATED_ACCUM_V PRO_PID_STATE_ENABLES_FEED_FORWARD_V "
        "PRO_PID_OUTPUT_PROPORTIONAL_OUTPUT_V PRO_PID_OUTPUT_DERIVATIVE_OUTPUT_V PRO_PID_OUTPUT_OUTPUT_V "
        "PRO_MOTOR_OUTPUT_PID_STATE_DIFF_VOLTAGE PRO_MOTOR_OUTPUT_PID_STATE_DIFF_INTEGRATED_ACCUM_V "
        "PRO_MOTOR_OUTPUT_PID_STATE_DIFF_FEED_FORWARD_V PRO_DIFF_PID_OUTPUT_PROPORTIONAL_OUTPUT_V "
        "PRO_DIFF_PID_OUTPUT_DERIVATIVE_OUTPUT_V PRO_DIFF_PID_OUTPUT_OUTPUT_V CONFIG_PEAK_FORWARD_V "
        "CONFIG_PEAK_REVERSE_V CONFIG_PEAK_DIFF_V CAN_CODER_SUPPLY_VOLTAGE CANRANGE_SUPPLY_VOLTAGE CANDI_V_SENSE "
        "CANDLE_GENERAL_SUPPLY_VOLTAGE CANDLE_GENERAL_FIVE_V_RAIL_VOLTAGE"
    ),
    "uT": (
        "PIGEON2_MAGNETIC_FIELD_X PIGEON2_MAGNETIC_FIELD_Y PIGEON2_MAGNETIC_FIELD_Z PIGEON2_RAW_MAGNETIC_FIELD_X "
        "PIGEON2_RAW_MAGNETIC_FIELD_Y PIGEON2_RAW_MAGNETIC_FIELD_Z"
    ),
    "rotations": (
        "CAN_CODER_MAGNET_OFFSET TALON_FX_SET_SENSOR_POSITION CANCODER_SET_SENSOR_POSITION "
        "PRO_ROTOR_POS_AND_VEL_POSITION PRO_POS_AND_VEL_POSITION PRO_PID_REF_PID_ERR_PID_REF_POSITION "
        "PRO_PID_REF_PID_ERR_PID_ERR_POSITION PRO_AVG_POS_AND_VEL_POSITION PRO_DIFF_POS_AND_VEL_POSITION "
        "PRO_DIFF_PID_REF_PID_ERR_PID_REF_POSITION PRO_DIFF_PID_REF_PID_ERR_PID_ERR_POSITION "
        "CONFIG_FEEDBACK_ROTOR_OFFSET CONFIG_FORWARD_LIMIT_AUTOSET_POS_VALUE "
        "CONFIG_REVERSE_LIMIT_AUTOSET_POS_VALUE CONFIG_FORWARD_SOFT_LIMIT_THRESHOLD "
        "CONFIG_REVERSE_SOFT_LIMIT_THRESHOLD CANCODER_POSITION CANCODER_ABS_POSITION CAN_CODER_RAW_POS "
        "CANDI_QUAD_POSITION CANDI_PWM1_POSITION CANDI_PWM2_POSITION CONFIG_ABSOLUTE_SENSOR_OFFSET "
        "CONFIG_ABSOLUTE_SENSOR_DISCONTINUITY_POINT CONFIG_PWM1_ABSOLUTE_SENSOR_OFFSET "
        "CONFIG_PWM1_ABSOLUTE_SENSOR_DISCONTINUITY_POINT CONFIG_PWM2_ABSOLUTE_SENSOR_OFFSET "
        "CONFIG_PWM2_ABSOLUTE_SENSOR_DISCONTINUITY_POINT CANDI_SET_QUAD_POSITION "
        "PRO_GADGETEER_QUAD_RAW_QUADRATURE_POSITION PRO_GADGETEER_PWM_RAW_PWM_POSITION SLOT0_K_G_POS_OFFSET "
        "SLOT1_K_G_POS_OFFSET SLOT2_K_G_POS_OFFSET CONFIG_GAIN_SCHED_ERROR_THRESHOLD"
    ),
    "fractional": (
        "PRO_MOTOR_OUTPUT_DUTY_CYCLE PRO_PID_STATE_ENABLES_INTEGRATED_ACCUM_DC "
        "PRO_PID_STATE_ENABLES_FEED_FORWARD_DC PRO_PID_OUTPUT_PROPORTIONAL_OUTPUT_DC "
        "PRO_PID_OUTPUT_DERIVATIVE_OUTPUT_DC PRO_PID_OUTPUT_OUTPUT_DC PRO_MOTOR_OUTPUT_PID_STATE_DIFF_DUTY_CYCLE "
        "PRO_MOTOR_OUTPUT_PID_STATE_DIFF_INTEGRATED_ACCUM_DC PRO_MOTOR_OUTPUT_PID_STATE_DIFF_FEED_FORWARD_DC "
        "PRO_DIFF_PID_OUTPUT_PROPORTIONAL_OUTPUT_DC PRO_DIFF_PID_OUTPUT_DERIVATIVE_OUTPUT_DC "
        "PRO_DIFF_PID_OUTPUT_OUTPUT_DC CONFIG_DUTY_CYCLE_NEUTRAL_DB CONFIG_PEAK_FORWARD_DC CONFIG_PEAK_REVERSE_DC "
        "CONFIG_PEAK_DIFF_DC"
    ),
    "A": (
        "PRO_MOTOR_OUTPUT_TORQUE_CURRENT PRO_SUPPLY_AND_TEMP_STATOR_CURRENT PRO_SUPPLY_AND_TEMP_SUPPLY_CURRENT "
        "PRO_PID_STATE_ENABLES_INTEGRATED_ACCUM_A PRO_PID_STATE_ENABLES_FEED_FORWARD_A "
        "PRO_PID_OUTPUT_PROPORTIONAL_OUTPUT_A PRO_PID_OUTPUT_DERIVATIVE_OUTPUT_A PRO_PID_OUTPUT_OUTPUT_A "
        "PRO_MOTOR_OUTPUT_PID_STATE_DIFF_TORQUE_CURRENT PRO_MOTOR_OUTPUT_PID_STATE_DIFF_INTEGRATED_ACCUM_A "
        "PRO_MOTOR_OUTPUT_PID_STATE_DIFF_FEED_FORWARD_A PRO_DIFF_PID_OUTPUT_PROPORTIONAL_OUTPUT_A "
        "PRO_DIFF_PID_OUTPUT_DERIVATIVE_OUTPUT_A PRO_DIFF_PID_OUTPUT_OUTPUT_A "
        "TALON_FX_MOTOR_CONSTANTS_STALL_CURRENT CONFIG_STATOR_CURRENT_LIMIT CONFIG_SUPPLY_CURRENT_LIMIT "
        "CONFIG_PEAK_FOR_TORQ_CURR CONFIG_PEAK_REV_TORQ_CURR CONFIG_TORQUE_NEUTRAL_DB CONFIG_PEAK_DIFF_TORQ_CURR "
        "CONFIG_SUPPLY_CURRENT_LOWER_LIMIT CANDI_OUTPUT_CURRENT CANDLE_GENERAL_OUTPUT_CURRENT"
    ),
    "rotations per second": (
        "PRO_ROTOR_POS_AND_VEL_VELOCITY PRO_POS_AND_VEL_VELOCITY PRO_PID_REF_PID_ERR_PID_REF_VELOCITY "
        "PRO_PID_REF_PID_ERR_PID_ERR_VELOCITY PRO_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_POSITION "
        "PRO_AVG_POS_AND_VEL_VELOCITY PRO_DIFF_POS_AND_VEL_VELOCITY PRO_DIFF_PID_REF_PID_ERR_PID_REF_VELOCITY "
        "PRO_DIFF_PID_REF_PID_ERR_PID_ERR_VELOCITY PRO_DIFF_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_POSITION "
        "CANCODER_VELOCITY CAN_CODER_RAW_VEL CANDI_PWM1_VELOCITY CANDI_PWM2_VELOCITY CANDI_QUAD_VELOCITY "
        "PRO_GADGETEER_QUAD_RAW_QUADRATURE_VELOCITY PRO_GADGETEER_PWM_RAW_PWM_VELOCITY"
    ),
    "rotations per second²": (
        "PRO_POS_AND_VEL_ACCELERATION PRO_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_VELOCITY "
        "PRO_DIFF_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_VELOCITY"
    ),
    "Nm/A": ("TALON_FX_MOTOR_CONSTANTS_K_T"),
    "RPM/V": ("TALON_FX_MOTOR_CONSTANTS_K_V CONFIG_CUSTOM_MOT_KV"),
    "seconds": (
        "CONFIG_SUPPLY_V_LOWPASS_TAU CONFIG_DUTY_CYCLE_OPEN_LOOP_RAMP_PERIOD "
        "CONFIG_VOLTAGE_OPEN_LOOP_RAMP_PERIOD CONFIG_TORQUE_OPEN_LOOP_RAMP_PERIOD "
        "CONFIG_DUTY_CYCLE_CLOSED_LOOP_RAMP_PERIOD CONFIG_VOLTAGE_CLOSED_LOOP_RAMP_PERIOD "
        "CONFIG_TORQUE_CLOSED_LOOP_RAMP_PERIOD CONFIG_SUPPLY_CURRENT_LOWER_TIME "
        "CONFIG_VELOCITY_FILTER_TIME_CONSTANT"
    ),
    "scalar": (
        "CONFIG_SENSOR_TO_MECHANISM_RATIO CONFIG_ROTOR_TO_SENSOR_RATIO CONFIG_SENSOR_TO_DIFFERENTIAL_RATIO "
        "CONFIG_LED_BRIGHTNESS_SCALAR"
    ),
    "rot per sec": ("CONFIG_MOTION_MAGIC_CRUISE_VELOCITY"),
    "rot per sec²": ("CONFIG_MOTION_MAGIC_ACCELERATION"),
    "rot per sec³": ("CONFIG_MOTION_MAGIC_JERK"),
    "V/rps": ("CONFIG_MOTION_MAGIC_EXPO_K_V"),
    "V/rps²": ("CONFIG_MOTION_MAGIC_EXPO_K_A"),
    "m": (
        "CANRANGE_DISTANCE_METERS CANRANGE_DISTANCE_STD_DEV CANRANGE_PROXIMITY_THRESHOLD CANRANGE_PROXIMITY_HYSTERESIS"
    ),
    "Hz": ("CANRANGE_UPDATE_FREQ CONFIG_CONTROL_TIMESYNC_FREQ"),
    "us": ("CANDI_PWM1_RISE_TO_RISE CANDI_PWM2_RISE_TO_RISE"),
    "Volts": ("TALON_FXS_5_V_RAIL_VOLTAGE TALON_FXS_GADGETEER_G3"),
    "frac": ("CANDLE_GENERAL_V_BAT_MODULATION"),
    "K": ("CONFIG_CUSTOM_MOT_THERMISTOR_BETA"),
    "kOhm": ("CONFIG_CUSTOM_MOT_THERMISTOR_R0"),
}


def _table() -> dict[int, str]:
    known = SpnValue.__members__
    return {known[name].value: unit for unit, names in _NAMES.items() for name in names.split() if name in known}


UNITS: dict[int, str] = _table()
"""Unit text of each signal and setting, by number. Values without a unit have no entry."""


_log = logging.getLogger(__name__)
_WANTED = struct.Struct("@II")
"""Layout of the device hash and signal number in `SignalValues`. In 26.70, the network precedes these fields."""
_WANTED_AT = SignalValues.devicehash.offset
_WANTED_SIZE = ctypes.sizeof(SignalValues)
_RETURNED = struct.Struct("@dIPdddi")
"""Layout of `ReturnValues`: value, number of the units signal, units text (null pointer), three timestamps, status."""
_RETURNED_SIZE = ctypes.sizeof(ReturnValues)


def _serializer(letter: str, kind: Callable[[Any], Any]) -> Callable[..., int]:
    """Return a native function that converts a setting with `kind` and writes the setting as a configuration line."""

    def serialize(self: Any, spn: int, value: Any, out: Any) -> int:
        target_of(out).value = config_line(spn, letter, kind(value)).encode()
        return _OK

    return serialize


def _deserializer(meaning: Callable[[int], Any]) -> Callable[..., int]:
    """Return a native function that reads a setting from configuration lines.

    The function converts the integer in the line with `meaning`. If no line contains the setting, the function returns
    the status code INVALID_PARAM_VALUE.
    """

    def deserialize(self: Any, spn: int, text: Any, size: int, out: Any) -> int:
        key = f"{spn},s_"
        for line in text.value.decode().split():
            if line.startswith(key):
                target_of(out).value = meaning(int(line[len(key) :]))
                return _OK
        return StatusCode.INVALID_PARAM_VALUE.value

    return deserialize


class EmulatedNative(NativeLibrary):
    """Replacement for the native library behind devices, signals, configurations and simulation.

    Args:
        emulator: Emulator that contains the devices.
    """

    def __init__(self, emulator: Emulator) -> None:
        self.emulator = emulator
        """Emulator that contains the devices. Adapters test for this attribute to detect simulated time."""
        for kind in REQUESTS.values():
            setattr(self, f"{PREFIX}RequestControl{kind.name}", self._request(kind))
        for name in LIGHT_REQUESTS:
            setattr(self, f"{PREFIX}RequestControl{name}", lambda *values: _OK)
        self._numbers = itertools.count(1)
        for name in _LOGGED:
            setattr(self, f"{PREFIX}platform_{name}", lambda *values: _OK)
        for name in _MUSIC:
            setattr(self, f"{PREFIX}orchestra_{name}", lambda *values: _OK)
        for name in _REPLAYED:
            setattr(self, f"{PREFIX}platform_replay_{name}", lambda *values: _NOT_SUPPORTED)
        for alert in ("alert", "multi_alert"):
            setattr(self, f"{PREFIX}{alert}_create", lambda *values: next(self._numbers))
            for what in ("set_debounce", "set_active", "set_inactive"):
                setattr(self, f"{PREFIX}{alert}_{what}", lambda *values: None)

    def _request(self, kind: RequestKind) -> Callable[..., int]:
        by_hash = self.emulator.by_hash

        def send(network: Any, device_hash: int, *args: Any) -> int:
            device = by_hash.get(device_hash)
            if device is not None:
                device.receive(kind, args)
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

    c_ctre_phoenix6_platform_sim_create = always(_OK)
    c_ctre_phoenix6_platform_sim_get_last_error = always(_OK)
    c_ctre_phoenix6_platform_canbus_is_network_fd = always(True)

    def c_ctre_phoenix6_encode_device(self, device_id: int, model: Any, network: Any, out: Any) -> int:
        name = model.value.decode()
        if device_id == -1:
            target_of(out).value = 0
            return _OK
        if name.lower() not in MODELS:
            raise NotImplementedError(f"device '{name}' (id {device_id}) is not modelled in simulated time")
        device = self.emulator.create(MODELS[name.lower()], DeviceAddress(device_id, network.value.decode()))
        target_of(out).value = self.emulator.hash_of(device)
        return _OK

    def c_ctre_phoenix6_platform_sim_set_physics_input(
        self, type_number: int, device_id: int, name: Any, value: float
    ) -> int:
        text = name.value
        if value != value:
            raise NonFiniteError(f"device {device_id} (type {type_number}): sim_state {text.decode()} is not a number")
        if b":" not in text:  # an input name with a colon is a copy of a WPILib SimDevice value, see `installation`
            self.emulator.simulated(type_number, device_id).set_input(text.decode(), float(value))
        return _OK

    def c_ctre_phoenix6_platform_sim_get_physics_value(
        self, type_number: int, device_id: int, name: Any, out: Any
    ) -> int:
        value = self.emulator.simulated(type_number, device_id).get_value(name.value.decode())
        if value is None:
            return -1
        target_of(out).value = value
        return _OK

    def c_ctre_phoenix6_platform_canbus_get_status(self, *values: Any) -> int:
        """Write zeros to all fields of the bus status: five numbers in 26.3, one structure in 26.70."""
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
            device.configure(parse_config(text.value.decode()), reset_others=future_proof)
        return _OK

    def c_ctre_phoenix6_get_configs(
        self, context: int, network: Any, device_hash: int, timeout: float, out: Any, extra: bool
    ) -> int:
        target_of(out).value = config_answer(self.emulator.by_hash[device_hash].config).encode()
        return _OK

    def c_ctre_phoenix6_free_memory(self, out: Any) -> int:
        target_of(out).value = None
        return _OK

    c_ctre_phoenix6_serialize_double = _serializer("f", float)
    c_ctre_phoenix6_serialize_int = _serializer("s", int)
    c_ctre_phoenix6_serialize_bool = _serializer("b", bool)
    c_ctre_phoenix6_deserialize_double = _deserializer(number_of)
    c_ctre_phoenix6_deserialize_int = _deserializer(int)
    c_ctre_phoenix6_deserialize_bool = _deserializer(bool)

    # ---- signals

    def c_ctre_phoenix6_get_rets(self, spn: int, kind: int, out: Any) -> int:
        target_of(out).units = UNITS.get(spn, "").encode()
        return _OK

    def c_ctre_phoenix6_get_signal(self, count: int, wanted: Any, values: Any, *rest: Any) -> int:
        """Write the values, timestamps and units of signals to `values`, after a new status frame if the caller waits.

        The last two items of `rest` are the wait flag and the timeout [s]. In 26.3, the network precedes these items.

        Raises:
            NotImplementedError: A signal is not modelled.
        """
        wait, timeout = rest[-2:]
        # Read and write whole structures as bytes, because access through ctypes fields takes three times as long.
        by_hash = self.emulator.by_hash
        wanted, values = target_of(wanted), target_of(values)
        fresh = wait and timeout > 0.0
        for k in range(count):
            device_hash, spn = _WANTED.unpack_from(wanted, k * _WANTED_SIZE + _WANTED_AT)
            device = by_hash.get(device_hash)
            if device is None:
                continue  # devices of `TalonFX.none()` read zero with status OK
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
            signal = getattr(signals[k], "signal", signals[k])  # 26.3 wraps the signal together with a network
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

    # ---- signal logger

    c_ctre_phoenix6_platform_has_schema = always(True)

    # ---- hoot replay: `CANBus(name, "logs/example.hoot")` in generated constants requests a replay (unsupported)

    c_ctre_phoenix6_platform_replay_is_file_loaded = always(False)
    c_ctre_phoenix6_platform_replay_is_running = always(True)  # as in CTRE's simulation library, even without replay
    c_ctre_phoenix6_platform_replay_is_finished = always(True)
    c_ctre_phoenix6_platform_replay_close_file = always(None)
    c_ctre_phoenix6_platform_replay_set_speed = always(None)

    # ---- orchestra

    def c_ctre_phoenix6_orchestra_Create(self, out: Any) -> int:
        target_of(out).value = next(self._numbers)
        return _OK


_PREFIX = PREFIX + "swerve_"
_INVALID = -11100  # arbitrary error code for a closed drivetrain


class _Custom:
    """Swerve request that calls a Python function from robot code or phoenix6."""

    def __init__(self, callback: Any) -> None:
        self._function = python_function(callback)

    def apply(self, drivetrain: EmulatedDrivetrain) -> None:
        vx, vy, omega = drivetrain.chassis_speeds
        x, y, theta = drivetrain.estimator.pose
        parameters = record(
            {FIELDS.current: SimpleNamespace(vx=vx, vy=vy, omega=omega)},
            kMaxSpeedMps=drivetrain.max_speed,
            operatorForwardDirection=drivetrain.operator_forward,
            currentPose=SimpleNamespace(x=x, y=y, theta=theta),
            timestamp=drivetrain.now,
            updatePeriod=drivetrain.period,
        )
        self._function(None, Held(parameters))


class SwerveNative(NativeLibrary):
    """Replacement for the native swerve library, with all drivetrains and the functions that phoenix6 calls.

    Args:
        emulator: Emulator that creates the motors and gyros and runs the odometry updates.
    """

    def __init__(self, emulator: Emulator) -> None:
        self._emulator = emulator
        self._drivetrains: dict[int, EmulatedDrivetrain] = {}
        self._constants: dict[int, Any] = {}
        self._handles = itertools.count(1)
        self._ids = itertools.count(1)
        self._cancel: dict[int, Callable[[], None]] = {}
        for name in dir(type(self)):
            if name.startswith(_FAMILIES):
                setattr(self, _PREFIX + name, getattr(self, name))
        for name, make in _REQUESTS.items():
            setattr(self, f"{_PREFIX}drivetrain_set_control_{name}", partial(self._set, make))
            setattr(self, f"{_PREFIX}request_apply_{name}", partial(self._apply, make))

    def reset(self) -> None:
        """Remove all drivetrains and stored constants for a new test."""
        self._drivetrains.clear()
        self._constants.clear()
        self._cancel.clear()

    # ---- building

    def create_drivetrain_constants(self, can_bus: Any, pigeon_id: int) -> int:
        handle = next(self._handles)
        self._constants[handle] = DeviceAddress(pigeon_id, can_bus.value.decode())
        return handle

    def create_module_constants_arr(self, count: int) -> int:
        handle = next(self._handles)
        self._constants[handle] = [None] * count
        return handle

    def set_module_constants(self, handle: int, index: int, *values: Any) -> None:
        self._constants[handle][index] = ModuleConstants(*values)

    def create_drivetrain(self, constants: int, modules: int, count: int) -> int:
        return self._create(constants, modules, 0.0)

    def create_drivetrain_with_freq(self, constants: int, hz: float, modules: int, count: int) -> int:
        return self._create(constants, modules, hz)

    def create_drivetrain_with_stddev(
        self, constants: int, hz: float, state: Any, vision: Any, modules: int, count: int
    ) -> int:
        number = self._create(constants, modules, hz)
        self._drivetrains[number].estimator.set_state_std_devs(target_of(state)[:3])
        self._drivetrains[number].estimator.set_vision_std_devs(target_of(vision)[:3])
        return number

    def _create(self, constants: int, modules: int, hz: float) -> int:
        number = next(self._ids)
        self._drivetrains[number] = EmulatedDrivetrain(self._constants.pop(constants), self._constants.pop(modules), hz)
        return number

    def destroy_drivetrain(self, number: int) -> None:
        self.drivetrain_odom_stop(number)
        self._drivetrains.pop(number, None)

    # ---- odometry

    def drivetrain_odom_start(self, number: int) -> None:
        drivetrain = self._drivetrains[number]
        number_of_gyro, bus = drivetrain.gyro.number, drivetrain.gyro.bus
        modules = [ModuleDevices(self._emulator, c, bus) for c in drivetrain.module_constants]
        drivetrain.start(modules, self._emulator.pigeon(number_of_gyro, bus))
        if number not in self._cancel:
            clock = self._emulator.clock
            self._cancel[number] = self._emulator.every(drivetrain.period, lambda: drivetrain.update(clock.now))

    def drivetrain_odom_stop(self, number: int) -> None:
        if number in self._cancel:
            self._cancel.pop(number)()
            self._drivetrains[number].stop()

    def drivetrain_odom_set_thread_priority(self, number: int, priority: int) -> None:
        """Do nothing, because the emulator runs odometry without a thread."""

    def drivetrain_is_on_can_fd(self, number: int) -> bool:
        return True

    def drivetrain_get_odometry_frequency(self, number: int) -> float:
        return self._drivetrains[number].hz

    def drivetrain_is_odometry_valid(self, number: int) -> bool:
        return self._drivetrains[number].is_running

    def drivetrain_get_state(self, number: int, out: Any) -> None:
        _fill(target_of(out), self._drivetrains[number].state)

    def drivetrain_register_telemetry(self, number: int, context: Any, callback: Any = None) -> None:
        drivetrain = self._drivetrains[number]
        if callback is None:
            drivetrain.on_state = None
            return
        function = python_function(callback)
        drivetrain.on_state = lambda state: function(None, Held(_native_state(state)))

    # ---- resets and vision

    def drivetrain_tare_everything(self, number: int) -> None:
        self._drivetrains[number].tare_everything()

    def drivetrain_seed_field_centric(self, number: int, heading: float) -> None:
        self._drivetrains[number].seed_field_centric(heading)

    def drivetrain_reset_pose(self, number: int, x: float, y: float, heading: float) -> None:
        self._drivetrains[number].reset_pose((x, y, heading))

    def drivetrain_reset_translation(self, number: int, x: float, y: float) -> None:
        self._drivetrains[number].reset_translation(x, y)

    def drivetrain_reset_rotation(self, number: int, heading: float) -> None:
        self._drivetrains[number].reset_rotation(heading)

    def drivetrain_set_operator_forward_direction(self, number: int, direction: float) -> None:
        self._drivetrains[number].operator_forward = direction

    def drivetrain_get_operator_forward_direction(self, number: int) -> float:
        return self._drivetrains[number].operator_forward

    def drivetrain_add_vision_measurement(self, number: int, x: float, y: float, heading: float, time: float) -> None:
        self._drivetrains[number].estimator.add_vision((x, y, heading), time)

    def drivetrain_add_vision_measurement_with_stddev(
        self, number: int, x: float, y: float, heading: float, time: float, std_devs: Any
    ) -> None:
        self._drivetrains[number].estimator.add_vision((x, y, heading), time, target_of(std_devs)[:3])

    def drivetrain_set_vision_measurement_stddevs(self, number: int, std_devs: Any) -> None:
        self._drivetrains[number].estimator.set_vision_std_devs(target_of(std_devs)[:3])

    def drivetrain_set_state_stddevs(self, number: int, std_devs: Any) -> None:
        self._drivetrains[number].estimator.set_state_std_devs(target_of(std_devs)[:3])

    def drivetrain_sample_pose_at(self, number: int, time: float, out: Any) -> bool:
        pose = self._drivetrains[number].estimator.sample(time)
        if pose is None:
            return False
        target = target_of(out)
        target.x, target.y, target.theta = pose[0], pose[1], wrap(pose[2])
        return True

    # ---- modules

    def drivetrain_config_neutral_mode(self, number: int, mode: int) -> int:
        return max((m.devices.set_neutral(mode == 1) for m in self._drivetrains[number].modules), default=_OK)

    def drivetrain_config_neutral_mode_with_timeout(self, number: int, mode: int, timeout: float) -> int:
        return self.drivetrain_config_neutral_mode(number, mode)

    def module_apply(self, number: int, index: int, request: Any) -> None:
        r = target_of(request)
        wanted = getattr(r, FIELDS.wanted)
        self._drivetrains[number].modules[index].apply(
            getattr(wanted, FIELDS.module),
            wanted.angle,
            closed_loop=r.driveRequest == 1,
            profiled=r.steerRequest == 0,
            period=r.updatePeriod,
            force_x=r.wheelForceFeedforwardX,
            force_y=r.wheelForceFeedforwardY,
            foc=r.enableFOC,
        )

    def module_get_position(self, number: int, index: int, refresh: bool) -> Any:
        """Return the present position, or the position at the last update if `refresh` is false.

        The method does not change odometry.
        """
        module = self._drivetrains[number].modules[index]
        if not refresh:
            return self.module_get_cached_position(number, index)
        distance, angle = module.present_position()
        return SimpleNamespace(distance=distance, angle=angle)

    def module_get_cached_position(self, number: int, index: int) -> Any:
        module = self._drivetrains[number].modules[index]
        return SimpleNamespace(distance=module.distance, angle=module.angle)

    def module_get_current_velocity(self, number: int, index: int) -> Any:
        module = self._drivetrains[number].modules[index]
        return _velocity(module.speed, module.angle)

    def module_get_target_velocity(self, number: int, index: int) -> Any:
        return _velocity(*self._drivetrains[number].modules[index].target)

    def module_reset_target_velocity(self, number: int, index: int) -> None:
        self._drivetrains[number].modules[index].target = (0.0, 0.0)

    def module_reset_position(self, number: int, index: int) -> None:
        self._drivetrains[number].modules[index].zero()

    # ---- requests

    def drivetrain_set_control(self, number: int, context: Any, callback: Any = None) -> None:
        self._drivetrains[number].request = Idle() if callback is None else _Custom(callback)

    def _set(self, make: _MakeRequest, number: int, *values: Any) -> None:
        self._drivetrains[number].request = make(*values)

    def _apply(self, make: _MakeRequest, number: int, *values: Any) -> int:
        drivetrain = self._drivetrains.get(number)
        if drivetrain is None:
            return _INVALID
        make(*values).apply(drivetrain)
        return _OK


_FAMILIES = ("create_", "set_module", "destroy_", "drivetrain_", "module_")


def _speeds(values: tuple[Any, ...], *, is_field: bool) -> Speeds:
    vx, vy, omega, forces_x, count_x, forces_y, count_y, *rest = values
    return Speeds(vx, vy, omega, tuple(forces_x[:count_x]), tuple(forces_y[:count_y]), *rest, is_field=is_field)


_MakeRequest: TypeAlias = Callable[..., DrivetrainRequest]
_REQUESTS: dict[str, _MakeRequest] = {
    "idle": Idle,
    "swerve_drive_brake": Brake,
    "field_centric": partial(Centric, is_field=True),
    "robot_centric": Centric,
    "point_wheels_at": Point,
    "apply_robot_velocity": lambda *values: _speeds(values, is_field=False),
    "apply_field_velocity": lambda *values: _speeds(values, is_field=True),
}
"""Functions that build a swerve request from native arguments, by the suffix of the native function name."""


def _velocity(speed: float, angle: float) -> SimpleNamespace:
    return record({FIELDS.module: speed}, angle=angle)


def _native_state(state: DrivetrainState) -> SimpleNamespace:
    """Return an object with the fields of the native drivetrain state, for telemetry callbacks."""
    vx, vy, omega = state.speeds
    return record(
        {
            FIELDS.chassis: SimpleNamespace(vx=vx, vy=vy, omega=omega),
            FIELDS.modules: [_velocity(s, a) for s, a in state.states],
        },
        pose=SimpleNamespace(x=state.pose[0], y=state.pose[1], theta=state.pose[2]),
        moduleTargets=[_velocity(s, a) for s, a in state.targets],
        modulePositions=[SimpleNamespace(distance=d, angle=a) for d, a in state.positions],
        rawHeading=state.raw_heading,
        timestamp=state.timestamp,
        odometryPeriod=state.period,
        successfulDaqs=state.samples,
        failedDaqs=0,
    )


def _fill(out: Any, state: DrivetrainState) -> None:
    """Write the drivetrain state to the native structure `SwerveDriveState_t`."""
    pose, speeds = out.pose, getattr(out, FIELDS.chassis)
    pose.x, pose.y, pose.theta = state.pose
    speeds.vx, speeds.vy, speeds.omega = state.speeds
    states, targets, positions = getattr(out, FIELDS.modules), out.moduleTargets, out.modulePositions
    for items, values in ((states, state.states), (targets, state.targets)):
        for k, (speed, angle) in enumerate(values):
            item = items[k]
            setattr(item, FIELDS.module, speed)
            item.angle = angle
    for k, (distance, angle) in enumerate(state.positions):
        item = positions[k]
        item.distance, item.angle = distance, angle
    out.rawHeading = state.raw_heading
    out.timestamp = state.timestamp
    out.odometryPeriod = state.period
    out.successfulDaqs = state.samples
    out.failedDaqs = 0
