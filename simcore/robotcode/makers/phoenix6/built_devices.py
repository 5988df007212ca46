"""CTRE devices that the robot program builds, with addresses and configurations, and a check of simulation writes.

Recording starts at the import of this module, before the robot object is built.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from phoenix6 import configs, hardware
from phoenix6.sim import CANcoderSimState, CANdiSimState, Pigeon2SimState, TalonFXSimState, TalonFXSSimState
from phoenix6.status_code import StatusCode

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.recorder import BuiltDevices, after_call, guard

__all__ = [
    "DEVICES",
    "MODELS",
    "MOTORS_OF_TALON_FXS",
    "PATIENCE",
    "Feedback",
    "address_of",
    "feedback_of",
    "key_of",
    "read_configuration",
    "require_distinct",
    "talon_configuration",
    "watch_simulations",
]

MODELS: dict[str, Any] = {
    model: getattr(hardware, model)
    for model in ("TalonFX", "TalonFXS", "CANcoder", "CANdi", "CANdle", "CANrange", "Pigeon2")
}
"""Phoenix 6 class of each model of device."""
DEVICES = BuiltDevices()
"""Devices that the program has built, without placeholders such as `TalonFX.none()`, whose ID is negative."""
MOTORS_OF_TALON_FXS = {
    "MINION_JST": "Minion",
    "NEO_JST": "NEO",
    "NEO550_JST": "NEO 550",
    "VORTEX_JST": "NEO Vortex",
    "BRUSHED_DC": "CIM",
}
"""Motor of a TalonFXS by the configured motor arrangement; simcore models every brushed motor as a CIM."""


_ROTOR = ("set_raw_rotor_position", "add_rotor_position", "set_rotor_velocity")
_SETTERS: dict[str, tuple[Any, tuple[str, ...]]] = {
    "TalonFX": (TalonFXSimState, _ROTOR),
    "TalonFXS": (
        TalonFXSSimState,
        (
            *_ROTOR,
            *("set_raw_quadrature_position", "set_quadrature_velocity"),
            *("set_pulse_width_position", "set_pulse_width_velocity"),
        ),
    ),
    "CANcoder": (CANcoderSimState, ("set_raw_position", "add_position", "set_velocity")),
    "CANdi": (
        CANdiSimState,
        ("set_pwm1_position", "set_pwm1_velocity", "set_pwm2_position", "set_pwm2_velocity"),
    ),
    "Pigeon2": (
        Pigeon2SimState,
        (
            *("set_raw_yaw", "add_yaw", "set_pitch", "set_roll"),
            *("set_angular_velocity_x", "set_angular_velocity_y", "set_angular_velocity_z"),
        ),
    ),
}
"""Simulated state class of each model, and the setters that a team's own simulation may call."""


_simulated: weakref.WeakKeyDictionary[Any, DeviceKey] = weakref.WeakKeyDictionary()


def watch_simulations(may_write: Callable[[DeviceKey], bool]) -> None:
    """Check each write of a team's own simulation to a device with `may_write`; see `Maker.watch_simulations`."""
    for cls, names in _SETTERS.values():
        after_call(cls, "__init__", _note_simulation)
        for name in names:
            guard(cls, name, _simulated.get, may_write, dropped=StatusCode.OK)


def _note_simulation(state: Any, _: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    _simulated[state] = key_of(next(iter((*args, *settings.values()))))


def key_of(made: Any) -> DeviceKey:
    """Return model and address of a device object, which may be an instance of a derived class."""
    return next(model for model, cls in MODELS.items() if isinstance(made, cls)), address_of(made)


def address_of(made: Any) -> DeviceAddress:
    """Return the CAN ID and bus of a device object."""
    return DeviceAddress(int(made.device_id), made.network.name)


for _model, _cls in MODELS.items():
    DEVICES.record(_cls, _model, lambda made, args, settings: address_of(made))


def require_distinct() -> None:
    """Check that all devices differ in model or ID, because CTRE's own simulation ignores the bus.

    Raises:
        ConfigError: Two devices of one model on different buses have the same ID.
    """
    known: dict[tuple[str, int], BuiltDevice] = {}
    for device in DEVICES.devices():
        other = known.setdefault((device.model, device.address.number), device)
        if other is not device:
            raise ConfigError(
                f"{other} and {device}, on two CAN buses, are one device in CTRE's own simulation, which only "
                "distinguishes models and ids: give one of them another id, or set SIMCORE_PHOENIX=simulated in the "
                "environment to use simcore's emulator, which tells them apart"
            )


PATIENCE = (0.05, 0.1, 0.25, 0.5, 1.0)
"""Timeouts of successive read attempts [s]; a device that is not starting responds in 50 ms on an idle computer."""


def read_configuration(device: Any, config: Any) -> None:
    """Fill a configuration, or one group of settings, from the device; retry if the device does not respond.

    Args:
        device: Device object of robot code.
        config: Configuration to fill, for example `TalonFXConfiguration()` or `MotorOutputConfigs()`.

    Raises:
        ConfigError: The device does not respond.
    """
    for timeout in PATIENCE:
        status = device.configurator.refresh(config, timeout)
        if status.is_ok():
            return
    raise ConfigError(
        f"{type(device).__name__} {device.device_id}: could not read its configuration ({status.name}, asked "
        f"{len(PATIENCE)} times)"
    )


def talon_configuration(device: Any, model: str) -> Any:
    """Return the complete configuration of a motor controller.

    Args:
        device: Device object of robot code, possibly of a derived class.
        model: Model of the controller: `TalonFX` or `TalonFXS`.

    Raises:
        ConfigError: The device does not respond.
    """
    make: Any = configs.TalonFXConfiguration if model == "TalonFX" else configs.TalonFXSConfiguration
    config = make()
    read_configuration(device, config)
    return config


@dataclass(frozen=True, slots=True, kw_only=True)
class Feedback:
    """Settings of the sensor that a motor controller uses for feedback."""

    source: str
    """Feedback source in CTRE's spelling: `ROTOR_SENSOR`, `FUSED_CANCODER`."""
    rotor_per_sensor: float
    """Rotor turns per sensor turn [-]; 1 for the rotor sensor."""
    sensor_per_mechanism: float
    """Sensor turns per turn of the mechanism, which robot code reads as one rotation [-]."""
    remote_id: int
    """CAN ID of a remote sensor; not used with other feedback sources."""

    @property
    def on_rotor(self) -> bool:
        """Whether the feedback source is the rotor sensor, or a TalonFXS's commutation sensor."""
        return self.source in ("ROTOR_SENSOR", "COMMUTATION")

    @property
    def ratio(self) -> float:
        """Rotor turns per turn of the mechanism, which robot code reads as one rotation [-]."""
        return self.rotor_per_sensor * self.sensor_per_mechanism


def feedback_of(config: Any) -> Feedback:
    """Return the feedback settings of a `TalonFXConfiguration` or `TalonFXSConfiguration`."""
    is_fx = hasattr(config, "feedback")
    group = config.feedback if is_fx else config.external_feedback
    source = str((group.feedback_sensor_source if is_fx else group.external_feedback_sensor_source).name)
    on_rotor = source in ("ROTOR_SENSOR", "COMMUTATION")
    return Feedback(
        source=source,
        rotor_per_sensor=1.0 if on_rotor else abs(float(group.rotor_to_sensor_ratio)) or 1.0,
        sensor_per_mechanism=abs(float(group.sensor_to_mechanism_ratio)) or 1.0,
        remote_id=int(group.feedback_remote_sensor_id),
    )
