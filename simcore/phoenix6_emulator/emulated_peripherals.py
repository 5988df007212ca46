"""Emulated Pigeon 2, CANrange and CANdle: a gyro, a distance sensor, and lights.

The lights of a CANdle move nothing; the requests of robot code are recorded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.emulated_device import EmulatedDevice, Setting, SimulatedClock

__all__ = ["LIGHT_REQUESTS", "CANrangeFrame", "EmulatedCANdle", "EmulatedCANrange", "EmulatedPigeon2", "PigeonFrame"]


class PigeonFrame(NamedTuple):
    """Status frame of a Pigeon 2 [deg, deg/s]."""

    yaw: float
    pitch: float
    roll: float
    rate_x: float
    rate_y: float
    rate_z: float
    supply: float
    time_ns: int

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """Attitude (w, x, y, z): yaw, then pitch, then roll."""
        y, p, r = (math.radians(a) / 2.0 for a in (self.yaw, self.pitch, self.roll))
        cy, sy, cp, sp, cr, sr = math.cos(y), math.sin(y), math.cos(p), math.sin(p), math.cos(r), math.sin(r)
        return (
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        )


_new = tuple.__new__


def _zero(frame: Any) -> float:
    return 0.0


_AT_REST: Mapping[int, Callable[[Any], float]] = {
    SpnValue[name].value: _zero
    for name in (
        *(f"PIGEON2_ACCELERATION_{axis}" for axis in "XYZ"),
        *(f"PIGEON2_ACCUM_GYRO_{axis}" for axis in "XYZ"),
        *(f"PIGEON2_GRAVITY_VECTOR_{axis}" for axis in "XYZ"),
        *(f"PIGEON2_MAGNETIC_FIELD_{axis}" for axis in "XYZ"),
        *(f"PIGEON2_RAW_MAGNETIC_FIELD_{axis}" for axis in "XYZ"),
        *("PIGEON2_NO_MOTION_COUNT", "PIGEON2_TEMPERATURE", "PIGEON2_TEMP_COMP_DISABLED"),
    )
}
"""Signals that read zero."""


class EmulatedPigeon2(EmulatedDevice):
    """One Pigeon 2."""

    model = "pigeon 2"
    type_number = 6

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(device_id, clock, defaults)
        self.raw_yaw = 0.0
        """Yaw since switched on, continuous over turns [deg]."""
        self.pitch = self.roll = 0.0
        self.rates = [0.0, 0.0, 0.0]
        """About x, y and z [deg/s]."""
        self._offset = 0.0
        self.send_frame()

    def command(self, spn: int, value: float) -> None:
        """A new yaw."""
        if spn == SpnValue.PIGEON2_SET_YAW.value:
            self._offset = value - self.raw_yaw
        else:
            super().command(spn, value)

    def set_input(self, name: str, value: float) -> None:
        """What it measures."""
        if name == "RawYaw":
            # The device takes the short way round.
            self.raw_yaw += math.remainder(value - self.raw_yaw, 360.0)
        elif name == "AddYaw":
            self.raw_yaw += value
        elif name == "Pitch":
            self.pitch = value
        elif name == "Roll":
            self.roll = value
        elif name.startswith("AngularVelocity"):
            self.rates["XYZ".index(name[-1])] = value
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """What SimDevices read."""
        if name.startswith("AngularVelocity"):
            return self.rates["XYZ".index(name[-1])]
        return {
            "Yaw": self.yaw,
            "RawYaw": self.raw_yaw,
            "Pitch": self.pitch,
            "Roll": self.roll,
            "SupplyVoltage": self.supply,
        }.get(name)

    @property
    def yaw(self) -> float:
        """Yaw now, as robot code reads it [deg]."""
        return self.raw_yaw + self._offset

    def sample(self) -> PigeonFrame:
        """A frame of this moment; 250 a second, so without PigeonFrame.__new__, which is a Python function."""
        yaw, rates = self.raw_yaw + self._offset, self.rates
        return _new(PigeonFrame, (yaw, self.pitch, self.roll, rates[0], rates[1], rates[2], self.supply, self.clock.ns))

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.PIGEON2_YAW.value: lambda f: f.yaw,
        SpnValue.PIGEON2_PITCH.value: lambda f: f.pitch,
        SpnValue.PIGEON2_ROLL.value: lambda f: f.roll,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_X.value: lambda f: f.rate_x,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_Y.value: lambda f: f.rate_y,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_Z.value: lambda f: f.rate_z,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_X_WORLD.value: lambda f: f.rate_x,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_Y_WORLD.value: lambda f: f.rate_y,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_Z_WORLD.value: lambda f: f.rate_z,
        SpnValue.PIGEON2_QUAT_W.value: lambda f: f.quaternion[0],
        SpnValue.PIGEON2_QUAT_X.value: lambda f: f.quaternion[1],
        SpnValue.PIGEON2_QUAT_Y.value: lambda f: f.quaternion[2],
        SpnValue.PIGEON2_QUAT_Z.value: lambda f: f.quaternion[3],
        # CTRE's simulation has no accelerometer, magnetometer or temperature either, and answers zero.
        **_AT_REST,
        SpnValue.PIGEON2_NO_MOTION_CAL_ENABLED.value: lambda f: 1.0,
        SpnValue.PIGEON2_SUPPLY_VOLTAGE.value: lambda f: f.supply,
        SpnValue.PIGEON2_UP_TIME.value: lambda f: float(int(f.time_ns * 1e-9)),
    }


_STRONG = 3000.0
"""Signal strength that the simulated sensor always reports."""


class CANrangeFrame(NamedTuple):
    """Status frame of a CANrange."""

    distance: float
    detected: bool
    time: float
    supply: float
    fov: tuple[float, float, float, float]


class EmulatedCANrange(EmulatedDevice):
    """One CANrange."""

    model = "canrange"
    type_number = 8

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(device_id, clock, defaults)
        self.distance = 0.0
        """To what is in front of it [m]."""
        self.is_detected = True
        """Whether something is nearer than the configured threshold."""
        self.configured()
        self.send_frame()

    def configured(self) -> None:
        """Apply the threshold."""
        c = self.config
        self._threshold = c[SpnValue.CANRANGE_PROXIMITY_THRESHOLD.value]
        self._hysteresis = c[SpnValue.CANRANGE_PROXIMITY_HYSTERESIS.value]
        self._strength = c[SpnValue.CANRANGE_MIN_SIG_STRENGTH_FOR_VALID_MEAS.value]
        self._detect()

    def _detect(self) -> None:
        band = self._hysteresis if self.is_detected else -self._hysteresis
        self.is_detected = self._strength <= _STRONG and self.distance < self._threshold + band

    def set_input(self, name: str, value: float) -> None:
        """What is in front of it."""
        if name == "Distance":
            self.distance = value
            self._detect()
        else:
            super().set_input(name, value)

    def sample(self) -> CANrangeFrame:
        """A frame of this moment."""
        c = self.config
        fov = tuple(
            float(c[spn.value])
            for spn in (
                SpnValue.CANRANGE_FOV_CENTER_X,
                SpnValue.CANRANGE_FOV_CENTER_Y,
                SpnValue.CANRANGE_FOV_RANGE_X,
                SpnValue.CANRANGE_FOV_RANGE_Y,
            )
        )
        return CANrangeFrame(self.distance, self.is_detected, self.clock.now, self.supply, fov)  # type: ignore[arg-type]

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANRANGE_DISTANCE_METERS.value: lambda f: f.distance,
        SpnValue.CANRANGE_PROXIMITY_DETECTED.value: lambda f: f.detected,
        SpnValue.CANRANGE_MEAS_TIME.value: lambda f: f.time,
        SpnValue.CANRANGE_SIGNAL_STRENGTH.value: lambda f: _STRONG,
        SpnValue.CANRANGE_MEAS_STATE.value: lambda f: 0.0,
        SpnValue.CANRANGE_AMBIENT_SIGNAL.value: lambda f: 0.0,
        SpnValue.CANRANGE_DISTANCE_STD_DEV.value: lambda f: 0.0,
        SpnValue.CANRANGE_SUPPLY_VOLTAGE.value: lambda f: f.supply,
        SpnValue.CANRANGE_REAL_FOV_CENTER_X.value: lambda f: f.fov[0],
        SpnValue.CANRANGE_REAL_FOV_CENTER_Y.value: lambda f: f.fov[1],
        SpnValue.CANRANGE_REAL_FOV_RANGE_X.value: lambda f: f.fov[2],
        SpnValue.CANRANGE_REAL_FOV_RANGE_Y.value: lambda f: f.fov[3],
    }


LIGHT_REQUESTS = (
    "ColorFlowAnimation",
    "EmptyAnimation",
    "FireAnimation",
    "LarsonAnimation",
    "ModulateVBatOut",
    "RainbowAnimation",
    "RgbFadeAnimation",
    "SingleFadeAnimation",
    "SolidColor",
    "StrobeAnimation",
    "TwinkleAnimation",
    "TwinkleOffAnimation",
)
"""Requests of a CANdle."""


class EmulatedCANdle(EmulatedDevice):
    """One CANdle."""

    model = "candle"
    type_number = 10

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(device_id, clock, defaults)
        self.shows: list[tuple[str, tuple[Any, ...]]] = []
        """Requests since the device was built, with their numbers as the library sends them; the newest 100."""
        self.send_frame()

    def show(self, name: str, args: tuple[Any, ...]) -> None:
        """A request of robot code."""
        self.shows = [*self.shows[-99:], (name, args)]

    def sample(self) -> float:
        """Supply at this moment [V]."""
        return self.supply

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANDLE_GENERAL_SUPPLY_VOLTAGE.value: lambda supply: supply,
        SpnValue.CANDLE_GENERAL_FIVE_V_RAIL_VOLTAGE.value: lambda supply: 5.0,
        SpnValue.CANDLE_GENERAL_OUTPUT_CURRENT.value: lambda supply: 0.0,
        SpnValue.CANDLE_GENERAL_DEVICE_TEMP.value: lambda supply: 25.0,
        SpnValue.CANDLE_GENERAL_V_BAT_MODULATION.value: lambda supply: 1.0,
        SpnValue.CANDLE_GENERAL_MAX_SIMUL_ANIM_COUNT.value: lambda supply: 8.0,
    }
