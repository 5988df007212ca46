"""SPARKs that the robot program builds, counts of configuration changes, and a check of simulation writes.

Recording starts at the import of this module, before the robot object is built.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

from simcore import season
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robotcode.program.recorder import BuiltDevices, after_call, guard

rev = season.rev

__all__ = [
    "MODELS", "SPARKS", "configuration_count", "is_zero_centered", "key_of", "spark_of_controller", "watch_simulations",
]  # fmt: skip

MODELS: dict[str, Any] = {"SPARK MAX": rev.SparkMax, "SPARK Flex": rev.SparkFlex}
"""Device class in robot code, by product name as in the names of SimDevices."""

SPARKS = BuiltDevices()
"""Record of the SPARKs that the program has built."""

_configured: dict[DeviceKey, int] = {}
_centered: dict[DeviceKey, bool] = {}
_CENTERED = f"{int(getattr(rev.SparkParameter, 'kDutyCycleZeroCentered', -1))},"  # readable from 2027 on
_controllers: weakref.WeakKeyDictionary[Any, DeviceKey] = weakref.WeakKeyDictionary()


def _address(spark: Any) -> DeviceAddress:
    bus = spark.get_can_port().name.lower() if hasattr(spark, "get_can_port") else ""  # from 2027 on, in CTRE's style
    return DeviceAddress(int(spark.get_device_id()), bus)


def key_of(spark: Any) -> DeviceKey:
    """Return model and address of a controller object in robot code."""
    return next(m for m, cls in MODELS.items() if isinstance(spark, cls)), _address(spark)


def _note_configuration(spark: Any, _: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    key = key_of(spark)
    _configured[key] = _configured.get(key, 0) + 1
    config, reset = (*args, *settings.values())[:2]
    said = [line for line in config.flatten().splitlines() if line.startswith(_CENTERED)]
    if said or reset == rev.ResetMode.RESET_SAFE_PARAMETERS:
        _centered[key] = bool(said) and said[-1] == f"{_CENTERED}1"


def _note_controller(spark: Any, controller: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    _controllers[controller] = key_of(spark)


for _model, _cls in MODELS.items():
    SPARKS.record(_cls, _model, lambda made, args, settings: _address(made))
    for _method in ("configure", "configure_async"):
        after_call(_cls, season.own_name(_cls, _method), _note_configuration)
    after_call(_cls, season.own_name(_cls, "get_closed_loop_controller"), _note_controller)


def configuration_count(key: DeviceKey) -> int:
    """Return the number of times that the program has configured a SPARK, for callers that cache the configuration."""
    return _configured.get(key, 0)


def is_zero_centered(key: DeviceKey) -> bool:
    """Return whether the program has configured a SPARK's absolute encoder to read -1/2 to 1/2 turn."""
    return _centered.get(key, False)


def spark_of_controller(controller: Any) -> DeviceKey | None:
    """Return model and address of the SPARK behind a `SparkClosedLoopController`; None for an unknown controller."""
    return _controllers.get(controller)


# --- a team's own simulation ------------------------------------------------------------------------------------------

_SIMS = [cls for name, cls in vars(rev).items() if name.startswith("Spark") and name.endswith("Sim")]
"""REVLib's simulation classes of controllers and of their sensors."""
_GETTERS = [
    f"get_{name}_sim"
    for name in ("relative_encoder", "absolute_encoder", "alternate_encoder", "external_encoder", "analog_sensor")
]
_WRITES = (
    *("iterate", "set_position", "set_velocity", "set_applied_output", "set_motor_current", "set_bus_voltage"),
    *("set_inverted", "set_zero_offset", "set_voltage"),
)
_simulated: weakref.WeakKeyDictionary[Any, DeviceKey] = weakref.WeakKeyDictionary()


def _note_simulation(sim: Any, _: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    _simulated[sim] = key_of(next(v for v in (*args, *settings.values()) if isinstance(v, rev.SparkBase)))


def _note_sensor(sim: Any, sensor: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    if sim in _simulated:
        _simulated[sensor] = _simulated[sim]


def watch_simulations(may_write: Callable[[DeviceKey], bool]) -> None:
    """Check each write of a team's own simulation to a SPARK with `may_write`; see `Maker.watch_simulations`."""
    for cls in _SIMS:
        after_call(cls, "__init__", _note_simulation)
        for name in (season.own_name(cls, write) for write in _WRITES):
            if hasattr(cls, name):
                guard(cls, name, _simulated.get, may_write)
        for name in (season.own_name(cls, getter) for getter in _GETTERS):
            if hasattr(cls, name):
                after_call(cls, name, _note_sensor)
