"""Which Talon SRX and Victor SPX the robot program builds, how it configures them and what it asks of them.

CTRE's library keeps most of this where its simulation alone can read it, so the methods that set it are watched. What
C++ sets, such as a `DifferentialDrive`, shows in `get()` and `getControlMode()` at once.
"""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable, Sequence
from typing import Any

import phoenix5
from phoenix5 import ControlMode, DemandType, FeedbackDevice, NeutralMode, TalonSRXControlMode

from simcore.devices.recorder import BuiltDevices, guard, record_class
from simcore.phoenix5.talon_loop import ControlMode as Mode
from simcore.phoenix5.talon_loop import Demand, SlotGains, TalonConfiguration
from simcore.quantities import DeviceAddress, DeviceKey

__all__ = ["MODELS", "TALONS", "TalonRecord", "record_of", "watch_simulations", "watch_talons"]

MODELS: dict[str, tuple[Any, ...]] = {
    "Talon SRX": (phoenix5.TalonSRX, phoenix5.WPI_TalonSRX),
    "Victor SPX": (phoenix5.VictorSPX, phoenix5.WPI_VictorSPX),
}
"""Classes of robot code by the name that CTRE prints on the box."""

_DEFAULTS: dict[str, Any] = {"Talon SRX": phoenix5.TalonSRXConfiguration, "Victor SPX": phoenix5.VictorSPXConfiguration}
_FIELDS = (
    *("configOpenloopRamp", "configClosedloopRamp", "configNeutralDeadband", "configVoltageCompSaturation"),
    *("configPeakOutputForward", "configPeakOutputReverse", "configNominalOutputForward", "configNominalOutputReverse"),
    *("configForwardSoftLimitEnable", "configForwardSoftLimitThreshold"),
    *("configReverseSoftLimitEnable", "configReverseSoftLimitThreshold"),
    *("configMotionCruiseVelocity", "configMotionAcceleration"),
    *("configContinuousCurrentLimit", "configPeakCurrentLimit", "configPeakCurrentDuration"),
)
"""Methods that set one field of the configuration, which is called alike."""
_SLOT_FIELDS = (
    *("config_kP", "config_kI", "config_kD", "config_kF", "config_IntegralZone"),
    *("configAllowableClosedloopError", "configMaxIntegralAccumulator", "configClosedLoopPeakOutput"),
)
"""The same of a slot."""


def _field(method: str) -> str:
    """The field that a method sets.

    >>> _field("configOpenloopRamp"), _field("config_kP"), _field("config_IntegralZone")
    ('openloopRamp', 'kP', 'integralZone')
    """
    name = method.removeprefix("config").lstrip("_")
    return name[0].lower() + name[1:]


class TalonRecord:
    """What one controller is configured with and told.

    Args:
        model: `Talon SRX` or `Victor SPX`.
        talon: Object of robot code.
    """

    def __init__(self, model: str, talon: Any) -> None:
        self.model = model
        self.leader: Any = None
        """Whom it follows; None: nobody."""
        self.settings: Any = _DEFAULTS[model]()
        """CTRE's own structure of it."""
        self.changes = 0
        """How often it has been configured."""
        self.is_wpi = hasattr(talon, "stopMotor")
        self.supply_limit: Any = None
        self._brakes = self._compensates = False
        self._has_limit = False
        self._slot = 0
        self._value = self._feed_forward = 0.0

    def note(self, name: str, values: Sequence[Any]) -> None:
        """A method of robot code, with its arguments."""
        self.changes += 1
        if name in _FIELDS:
            if hasattr(self.settings, _field(name)):
                setattr(self.settings, _field(name), values[0])
        elif name in _SLOT_FIELDS:
            setattr(getattr(self.settings, f"slot{int(values[0])}"), _field(name), values[1])
        else:
            _NOTES[name](self, *values)

    def demand(self, talon: Any) -> Demand:
        """What robot code asks for now."""
        mode = int(talon.getControlMode())
        if mode == Mode.PERCENT_OUTPUT and self.is_wpi and float(talon.get()) != self._value:
            self._value, self._feed_forward = float(talon.get()), 0.0  # set in C++
        return Demand(mode, self._value, self._slot, self._feed_forward)

    def configuration(self) -> TalonConfiguration:
        """In plain numbers."""
        s, limit = self.settings, self.supply_limit
        supply: tuple[float | None, float, float] = (None, 0.0, 0.0)
        if limit is not None and limit.enable:
            supply = float(limit.currentLimit), float(limit.triggerThresholdCurrent), float(limit.triggerThresholdTime)
        elif self._has_limit:
            supply = float(s.continuousCurrentLimit), float(s.peakCurrentLimit), s.peakCurrentDuration / 1000.0
        saturation = float(s.voltageCompSaturation)
        return TalonConfiguration(
            brakes=self._brakes,
            compensation=saturation if self._compensates and saturation > 0.0 else None,
            open_ramp=float(s.openloopRamp),
            closed_ramp=float(s.closedloopRamp),
            peak_forward=float(s.peakOutputForward),
            peak_reverse=float(s.peakOutputReverse),
            nominal_forward=float(s.nominalOutputForward),
            nominal_reverse=float(s.nominalOutputReverse),
            deadband=float(s.neutralDeadband),
            supply_limit=supply[0],
            supply_trigger=supply[1],
            supply_delay=supply[2],
            soft_forward=float(s.forwardSoftLimitThreshold) if s.forwardSoftLimitEnable else None,
            soft_reverse=float(s.reverseSoftLimitThreshold) if s.reverseSoftLimitEnable else None,
            cruise=float(s.motionCruiseVelocity),
            acceleration=float(s.motionAcceleration),
            slots=tuple(_gains(getattr(s, f"slot{k}")) for k in range(4)),
        )

    @property
    def is_analog(self) -> bool:
        """Whether the selected sensor is analog: 1024 units a turn instead of 4096."""
        return self._sensor == int(FeedbackDevice.Analog)

    @property
    def is_absolute(self) -> bool:
        """Whether the selected sensor knows its angle when it is switched on."""
        return self._sensor in (int(FeedbackDevice.CTRE_MagEncoder_Absolute), int(FeedbackDevice.Analog))

    @property
    def coefficient(self) -> float:
        """Of the selected sensor [-]."""
        return float(self.settings.primaryPID.selectedFeedbackCoefficient)

    @property
    def _sensor(self) -> int:
        pid = self.settings.primaryPID
        return int(getattr(pid, "selectedFeedbackSensor", FeedbackDevice.None_))

    # --- what single methods say ----------------------------------------------------------------------------------

    def _set(self, value: Any, *rest: Any) -> None:
        if isinstance(value, (ControlMode, TalonSRXControlMode, phoenix5.VictorSPXControlMode)):
            self._value = float(rest[0])
            self._feed_forward = 0.0
            if len(rest) == 3 and rest[1] == DemandType.ArbitraryFeedForward:
                self._feed_forward = float(rest[2])
        else:
            self._value, self._feed_forward = float(value), 0.0

    def _follow(self, leader: Any, *_: Any) -> None:
        self.leader = leader

    def _neutral_mode(self, mode: Any) -> None:
        if mode != NeutralMode.EEPROMSetting:
            self._brakes = mode == NeutralMode.Brake

    def _compensate(self, enable: bool) -> None:
        self._compensates = bool(enable)

    def _limit(self, enable: bool) -> None:
        self._has_limit = bool(enable)

    def _supply_limit(self, limit: Any, *_: Any) -> None:
        self.supply_limit = limit

    def _select_slot(self, slot: int, pid: int = 0) -> None:
        if pid == 0:
            self._slot = int(slot)

    def _all_settings(self, settings: Any, *_: Any) -> None:
        _copy(settings, self.settings)

    def _slot_settings(self, slot: Any, number: int = 0, *_: Any) -> None:
        _copy(slot, getattr(self.settings, f"slot{int(number)}"))

    def _sensor_of(self, device: Any, pid: int = 0, *_: Any) -> None:
        if pid == 0 and hasattr(self.settings.primaryPID, "selectedFeedbackSensor"):
            self.settings.primaryPID.selectedFeedbackSensor = FeedbackDevice(int(device))

    def _coefficient_of(self, coefficient: float, pid: int = 0, *_: Any) -> None:
        if pid == 0:
            self.settings.primaryPID.selectedFeedbackCoefficient = coefficient

    def _defaults(self, *_: Any) -> None:
        self.settings = _DEFAULTS[self.model]()
        self.supply_limit, self._has_limit = None, False


def _copy(source: Any, target: Any) -> None:
    """All fields of one of CTRE's structures."""
    for name in dir(target):
        value = getattr(source, name, None)
        if not name.startswith("_") and value is not None and not callable(value):
            setattr(target, name, value)


def _gains(slot: Any) -> SlotGains:
    return SlotGains(
        p=float(slot.kP),
        i=float(slot.kI),
        d=float(slot.kD),
        f=float(slot.kF),
        i_zone=float(slot.integralZone),
        i_most=float(slot.maxIntegralAccumulator),
        allowed_error=float(slot.allowableClosedloopError),
        peak=float(slot.closedLoopPeakOutput),
    )


_NOTES: dict[str, Callable[..., None]] = {
    "set": TalonRecord._set,
    "follow": TalonRecord._follow,
    "setNeutralMode": TalonRecord._neutral_mode,
    "enableVoltageCompensation": TalonRecord._compensate,
    "enableCurrentLimit": TalonRecord._limit,
    "configSupplyCurrentLimit": TalonRecord._supply_limit,
    "selectProfileSlot": TalonRecord._select_slot,
    "configAllSettings": TalonRecord._all_settings,
    "configureSlot": TalonRecord._slot_settings,
    "configSelectedFeedbackSensor": TalonRecord._sensor_of,
    "configSelectedFeedbackCoefficient": TalonRecord._coefficient_of,
    "configFactoryDefault": TalonRecord._defaults,
}

TALONS = BuiltDevices()
"""Those that the program has built."""
_records: weakref.WeakKeyDictionary[Any, TalonRecord] = weakref.WeakKeyDictionary()


def record_of(talon: Any) -> TalonRecord:
    """Of an object of robot code."""
    return _records[talon]


def watch_talons() -> None:
    """Note every controller built from now on, and what is set of it; again is harmless."""
    for model, classes in MODELS.items():
        for cls in classes:
            record_class(cls, _note_built)
            TALONS.record(cls, model, lambda made, args, settings: DeviceAddress(made.getDeviceID()))
            for name in (*_FIELDS, *_SLOT_FIELDS, *_NOTES):
                method = getattr(cls, name, None)
                if method is not None and not hasattr(method, "_notes"):
                    setattr(cls, name, _noting(method, name))


def _note_built(talon: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    model = next(model for model, classes in MODELS.items() if isinstance(talon, classes))
    _records.setdefault(talon, TalonRecord(model, talon))


def _noting(method: Any, name: str) -> Any:
    @functools.wraps(method)
    def noted(self: Any, *args: Any, **settings: Any) -> Any:
        values = (*args, *settings.values())
        record = _records.get(self)
        if name == "set" and len(values) > 1 and record is not None and record.is_wpi and not int(values[0]):
            answer = method(
                self, float(values[1])
            )  # percent output: so that `get()` knows it, as it does what C++ sets
        else:
            answer = method(self, *args, **settings)
        if record is not None:
            record.note(name, values)
        return answer

    noted._notes = True  # type: ignore[attr-defined]
    return noted


def watch_simulations(may_write: Callable[[DeviceKey], bool]) -> None:
    """Ask whenever a team's own simulation takes a controller's simulated side; see `Maker.watch_simulations`."""
    for classes in MODELS.values():
        for cls in classes:
            if "getSimCollection" in cls.__dict__:
                guard(cls, "getSimCollection", _key_of, may_write, drops=False)


def _key_of(talon: Any) -> DeviceKey:
    return record_of(talon).model, DeviceAddress(talon.getDeviceID())
