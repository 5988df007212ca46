"""Emulated sensors and lights: CANcoder, CANdi (with sensors on its two pins), Pigeon 2, CANrange and CANdle.

The emulator ignores light requests to a CANdle. `simcore.robotcode.makers.phoenix6.candle_lights` records the colors.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.quantities import DeviceAddress
from simcore.robotcode.emulator.emulated_device import EmulatedDevice, Setting, SimulatedClock

__all__ = [
    "LIGHT_REQUESTS",
    "CANcoderFrame",
    "CANdiFrame",
    "CANrangeFrame",
    "EmulatedCANcoder",
    "EmulatedCANdi",
    "EmulatedCANdle",
    "EmulatedCANrange",
    "EmulatedPigeon2",
    "PigeonFrame",
]

_log = logging.getLogger(__name__)


class CANcoderFrame(NamedTuple):
    """Status frame of a CANcoder [rotations, rotations/s, V]."""

    position: float
    since_boot: float
    velocity: float
    supply: float
    health: int
    top: float
    """Configured discontinuity point: upper end of the absolute position range [rotations]."""

    @property
    def absolute(self) -> float:
        """Absolute position, within one turn below the discontinuity point [rotations].

        `set_position` also changes the absolute position, as in CTRE's simulation.
        """
        return self.position - math.floor(self.position - self.top + 1.0)


_new = tuple.__new__


class EmulatedCANcoder(EmulatedDevice):
    """Emulated CANcoder that receives the raw position and velocity from physics."""

    model = "cancoder"
    type_number = 5

    def __init__(self, address: DeviceAddress, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(address, clock, defaults)
        self.raw = 0.0
        """Angle written by physics, counter-clockwise positive [rotations]."""
        self.raw_velocity = 0.0
        """Velocity written by physics, counter-clockwise positive [rotations/s]."""
        self.health = 3
        self._shift = 0.0
        self.configured()
        self.send_frame()

    def configured(self) -> None:
        """Apply the configured direction, magnet offset and discontinuity point."""
        c = self.config
        self._sign = -1.0 if c[SpnValue.CANCODER_SENSOR_DIRECTION.value] else 1.0
        self._offset = c[SpnValue.CAN_CODER_MAGNET_OFFSET.value]
        self._top = c[SpnValue.CONFIG_ABSOLUTE_SENSOR_DISCONTINUITY_POINT.value]

    def command(self, spn: int, value: float) -> None:
        """Execute the `set_position` command, which sets the position that robot code reads [rotations].

        Raises:
            NotImplementedError: The command is not modelled.
        """
        if spn == SpnValue.CANCODER_SET_SENSOR_POSITION.value:
            self._shift = value - self._sign * self.raw - self._offset
        else:
            super().command(spn, value)

    def set_input(self, name: str, value: float) -> None:
        """Set a `sim_state` input: raw position [rotations], velocity [rotations/s], magnet health or supply [V]."""
        if name == "RawPosition":
            self.raw = value
        elif name == "Velocity":
            self.raw_velocity = value
        elif name == "AddPosition":
            self.raw += value
        elif name == "MagnetHealth":
            self.health = int(value)
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """Return the `sim_state` value `name` [rotations, rotations/s or V]; None for an unknown name."""
        if name == "Position":
            return self.position
        return {"RawPosition": self.raw, "Velocity": self.raw_velocity, "SupplyVoltage": self.supply}.get(name)

    @property
    def position(self) -> float:
        """Present position, continuous over turns [rotations]."""
        return self._sign * self.raw + self._offset + self._shift

    def sample(self) -> CANcoderFrame:
        """Return a status frame with the present readings.

        The method runs 250 times per second, and therefore avoids the slow `CANcoderFrame.__new__`.
        """
        raw, sign = self.raw, self._sign
        position = sign * raw + self._offset + self._shift
        return _new(CANcoderFrame, (position, raw, sign * self.raw_velocity, self.supply, self.health, self._top))

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANCODER_POSITION.value: lambda f: f.position,
        SpnValue.CANCODER_ABS_POSITION.value: lambda f: f.absolute,
        SpnValue.CANCODER_VELOCITY.value: lambda f: f.velocity,
        SpnValue.CAN_CODER_RAW_VEL.value: lambda f: f.velocity,
        SpnValue.CAN_CODER_RAW_POS.value: lambda f: f.since_boot,
        SpnValue.CAN_CODER_SUPPLY_VOLTAGE.value: lambda f: f.supply,
        SpnValue.CANCODER_MAG_HEALTH.value: lambda f: float(f.health),
    }


_FLOATING, _LOW, _HIGH = 0, 1, 2
_CLOSED: tuple[Callable[[int], bool], ...] = (
    lambda state: state != _FLOATING,
    lambda state: state == _FLOATING,
    lambda state: state != _HIGH,
    lambda state: state == _HIGH,
    lambda state: state != _LOW,
    lambda state: state == _LOW,
)
"""Functions that return whether a pin in a given state is closed, by `S1CloseStateValue`."""


class CANdiFrame(NamedTuple):
    """Status frame of a CANdi [rotations, rotations/s, us, V, A]. Each tuple contains the values of pins 1 and 2."""

    states: tuple[int, int]
    closed: tuple[bool, bool]
    positions: tuple[float, float]
    velocities: tuple[float, float]
    rises: tuple[float, float]
    quadrature: float
    quadrature_velocity: float
    supply: float
    current: float


class EmulatedCANdi(EmulatedDevice):
    """Emulated CANdi with a digital or pulse-width signal on each pin, or a quadrature encoder on both pins."""

    model = "candi"
    type_number = 9

    def __init__(self, address: DeviceAddress, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(address, clock, defaults)
        self.states = [_FLOATING, _FLOATING]
        """State of each pin (`S1StateValue`)."""
        self._positions = [0.0, 0.0]
        self._velocities = [0.0, 0.0]
        self._rises = [4000.0, 4000.0]
        self._edges = 0.0
        self._edge_rate = 0.0
        self._shift = 0.0
        self._current = 0.0
        self.configured()
        self.send_frame()

    def configured(self) -> None:
        """Apply the configured sensor directions, offsets and close states."""
        c = self.config
        self._signs = [
            -1.0 if c[spn.value] else 1.0
            for spn in (SpnValue.CONFIG_PWM1_SENSOR_DIRECTION, SpnValue.CONFIG_PWM2_SENSOR_DIRECTION)
        ]
        self._offsets = [
            c[SpnValue.CONFIG_PWM1_ABSOLUTE_SENSOR_OFFSET.value],
            c[SpnValue.CONFIG_PWM2_ABSOLUTE_SENSOR_OFFSET.value],
        ]
        self._close = [int(c[SpnValue.CONFIG_S1_CLOSE_STATE.value]), int(c[SpnValue.CONFIG_S2_CLOSE_STATE.value])]
        sign = -1.0 if c[SpnValue.CONFIG_QUAD_SENSOR_DIRECTION.value] else 1.0
        self._per_edge = sign / (c[SpnValue.CONFIG_QUADRATURE_EDGES_PER_ROTATION.value] or 4096)

    def command(self, spn: int, value: float) -> None:
        """Execute the command that sets the quadrature position [rotations].

        Raises:
            NotImplementedError: The command is not modelled.
        """
        if spn == SpnValue.CANDI_SET_QUAD_POSITION.value:
            self._shift = value - self._edges * self._per_edge
        else:
            super().command(spn, value)

    def set_input(self, name: str, value: float) -> None:
        """Set a `sim_state` input: a signal on the pins, the output current [A] or the supply voltage [V]."""
        if name.startswith("PWM"):
            pin, what = int(name[3]) - 1, name[4:]
            if what == "Position":
                self._positions[pin] = value
            elif what == "Velocity":
                self._velocities[pin] = value
            elif what == "RiseRise":
                self._rises[pin] = value * 1e6
            elif what not in ("RiseFall", "Connected"):  # no effect in CTRE's simulation either
                super().set_input(name, value)
        elif name in ("S1State", "S2State"):
            self.states[int(name[1]) - 1] = int(value)
        elif name == "RawQuadraturePosition":
            self._edges = value
        elif name == "AddQuadraturePosition":
            self._edges += value
        elif name == "QuadratureVelocity":
            self._edge_rate = value
        elif name == "RequestedOutputCurrent":
            self._current = value
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """Return the output current [A] for the name `OutputCurrent`; None for any other name."""
        return self._current if name == "OutputCurrent" else None

    def is_closed(self, pin: int) -> bool:
        """Return whether pin 0 or 1 is in the configured close state."""
        return _CLOSED[self._close[pin]](self.states[pin])

    def pwm_position(self, pin: int) -> float:
        """Return the present position of the pulse-width sensor on pin 0 or 1 [rotations]."""
        return self._signs[pin] * self._positions[pin] + self._offsets[pin]

    def pwm_velocity(self, pin: int) -> float:
        """Return the present velocity of the pulse-width sensor on pin 0 or 1 [rotations/s]."""
        return self._signs[pin] * self._velocities[pin]

    @property
    def quadrature(self) -> float:
        """Present quadrature position [rotations]."""
        return self._edges * self._per_edge + self._shift

    @property
    def quadrature_velocity(self) -> float:
        """Present quadrature velocity [rotations/s]."""
        return self._edge_rate * self._per_edge

    def sample(self) -> CANdiFrame:
        """Return a status frame with the present readings."""
        return CANdiFrame(
            (self.states[0], self.states[1]),
            (self.is_closed(0), self.is_closed(1)),
            (self.pwm_position(0), self.pwm_position(1)),
            (self.pwm_velocity(0), self.pwm_velocity(1)),
            (self._rises[0], self._rises[1]),
            self.quadrature,
            self.quadrature_velocity,
            self.supply,
            self._current,
        )

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANDI_PIN1_STATE.value: lambda f: f.states[0],
        SpnValue.CANDI_PIN2_STATE.value: lambda f: f.states[1],
        SpnValue.CANDI_S1_CLOSED.value: lambda f: f.closed[0],
        SpnValue.CANDI_S2_CLOSED.value: lambda f: f.closed[1],
        SpnValue.CANDI_PWM1_POSITION.value: lambda f: f.positions[0],
        SpnValue.CANDI_PWM2_POSITION.value: lambda f: f.positions[1],
        SpnValue.CANDI_PWM1_VELOCITY.value: lambda f: f.velocities[0],
        SpnValue.CANDI_PWM2_VELOCITY.value: lambda f: f.velocities[1],
        SpnValue.CANDI_PWM1_RISE_TO_RISE.value: lambda f: f.rises[0],
        SpnValue.CANDI_PWM2_RISE_TO_RISE.value: lambda f: f.rises[1],
        SpnValue.CANDI_QUAD_POSITION.value: lambda f: f.quadrature,
        SpnValue.CANDI_QUAD_VELOCITY.value: lambda f: f.quadrature_velocity,
        SpnValue.CANDI_V_SENSE.value: lambda f: f.supply,
        SpnValue.CANDI_OUTPUT_CURRENT.value: lambda f: f.current,
        SpnValue.CANDI_OVERCURRENT.value: lambda f: 0.0,
    }


class PigeonFrame(NamedTuple):
    """Status frame of a Pigeon 2 [deg, deg/s, V, ns]."""

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
        """Orientation quaternion (w, x, y, z) for intrinsic rotations by yaw, then pitch, then roll."""
        y, p, r = (math.radians(a) / 2.0 for a in (self.yaw, self.pitch, self.roll))
        cy, sy, cp, sp, cr, sr = math.cos(y), math.sin(y), math.cos(p), math.sin(p), math.cos(r), math.sin(r)
        return (
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        )


def _unmodelled(name: str) -> Callable[[Any], float]:
    """Return a function that returns zero and logs, at the first call, that signal `name` is not modelled."""

    def zero(frame: Any) -> float:
        if name not in _warned:
            _warned.add(name)
            _log.warning(
                "%s is not modelled: it reads 0 in simulation, as it does in CTRE's own", name.replace("_", " ").lower()
            )
        return 0.0

    return zero


_warned: set[str] = set()
_AT_REST: Mapping[int, Callable[[Any], float]] = {
    SpnValue[name].value: _unmodelled(name)
    for name in (
        *(f"PIGEON2_ACCELERATION_{axis}" for axis in "XYZ"),
        *(f"PIGEON2_ACCUM_GYRO_{axis}" for axis in "XYZ"),
        *(f"PIGEON2_GRAVITY_VECTOR_{axis}" for axis in "XYZ"),
        *(f"PIGEON2_MAGNETIC_FIELD_{axis}" for axis in "XYZ"),
        *(f"PIGEON2_RAW_MAGNETIC_FIELD_{axis}" for axis in "XYZ"),
        *("PIGEON2_NO_MOTION_COUNT", "PIGEON2_TEMPERATURE", "PIGEON2_TEMP_COMP_DISABLED"),
    )
}
"""Functions that return zero for the unmodelled signals, by signal number."""


class EmulatedPigeon2(EmulatedDevice):
    """Emulated Pigeon 2 that receives the angles and angular velocities from physics."""

    model = "pigeon 2"
    type_number = 6

    def __init__(self, address: DeviceAddress, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(address, clock, defaults)
        self.raw_yaw = 0.0
        """Yaw since power-up without the `set_yaw` offset, continuous over turns [deg]."""
        self.pitch = self.roll = 0.0
        self.rates = [0.0, 0.0, 0.0]
        """Angular velocities about the x, y and z axes [deg/s]."""
        self._offset = 0.0
        self.send_frame()

    def command(self, spn: int, value: float) -> None:
        """Execute the `set_yaw` command, which sets the yaw that robot code reads [deg].

        Raises:
            NotImplementedError: The command is not modelled.
        """
        if spn == SpnValue.PIGEON2_SET_YAW.value:
            self._offset = value - self.raw_yaw
        else:
            super().command(spn, value)

    def set_input(self, name: str, value: float) -> None:
        """Set a `sim_state` input: yaw, pitch or roll [deg], an angular velocity [deg/s] or the supply voltage [V]."""
        if name == "RawYaw":
            # The device turns in the shorter direction to a new yaw.
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
        """Return the `sim_state` value `name` [deg, deg/s or V]; None for an unknown name."""
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
        """Present yaw with the `set_yaw` offset, continuous over turns [deg]."""
        return self.raw_yaw + self._offset

    def sample(self) -> PigeonFrame:
        """Return a status frame with the present readings.

        The method runs 250 times per second, and therefore avoids the slow `PigeonFrame.__new__`.
        """
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
        # In CTRE's simulation, accelerometer, magnetometer and temperature also read zero.
        **_AT_REST,
        SpnValue.PIGEON2_NO_MOTION_CAL_ENABLED.value: lambda f: 1.0,
        SpnValue.PIGEON2_SUPPLY_VOLTAGE.value: lambda f: f.supply,
        SpnValue.PIGEON2_UP_TIME.value: lambda f: float(int(f.time_ns * 1e-9)),
    }


_STRONG = 3000.0
"""Constant signal strength that CTRE's simulated CANrange reports."""


class CANrangeFrame(NamedTuple):
    """Status frame of a CANrange [m, s, V]. `fov` contains the field of view's center x, y and range x, y [deg]."""

    distance: float
    detected: bool
    time: float
    supply: float
    fov: tuple[float, float, float, float]


class EmulatedCANrange(EmulatedDevice):
    """Emulated CANrange that receives the distance from physics."""

    model = "canrange"
    type_number = 8

    def __init__(self, address: DeviceAddress, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(address, clock, defaults)
        self.distance = 0.0
        """Distance to the object in front of the sensor [m]."""
        self.is_detected = True
        """Whether the CANrange detects an object within the proximity threshold, with the configured hysteresis."""
        self.configured()
        self.send_frame()

    def configured(self) -> None:
        """Apply the configured threshold, hysteresis and minimum signal strength, and update `is_detected`."""
        c = self.config
        self._threshold = c[SpnValue.CANRANGE_PROXIMITY_THRESHOLD.value]
        self._hysteresis = c[SpnValue.CANRANGE_PROXIMITY_HYSTERESIS.value]
        self._strength = c[SpnValue.CANRANGE_MIN_SIG_STRENGTH_FOR_VALID_MEAS.value]
        self._detect()

    def _detect(self) -> None:
        band = self._hysteresis if self.is_detected else -self._hysteresis
        self.is_detected = self._strength <= _STRONG and self.distance < self._threshold + band

    def set_input(self, name: str, value: float) -> None:
        """Set a `sim_state` input: the distance to the object in front of the sensor [m], or the supply voltage [V].

        A new distance updates `is_detected`.
        """
        if name == "Distance":
            self.distance = value
            self._detect()
        else:
            super().set_input(name, value)

    def sample(self) -> CANrangeFrame:
        """Return a status frame with the present readings."""
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
"""Phoenix 6 class names of a CANdle's control requests."""


class EmulatedCANdle(EmulatedDevice):
    """Emulated CANdle with a supply voltage and constant values for all other signals."""

    model = "candle"
    type_number = 10

    def __init__(self, address: DeviceAddress, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(address, clock, defaults)
        self.send_frame()

    def sample(self) -> float:
        """Return the present supply voltage [V], the only content of the status frame."""
        return self.supply

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANDLE_GENERAL_SUPPLY_VOLTAGE.value: lambda supply: supply,
        SpnValue.CANDLE_GENERAL_FIVE_V_RAIL_VOLTAGE.value: lambda supply: 5.0,
        SpnValue.CANDLE_GENERAL_OUTPUT_CURRENT.value: lambda supply: 0.0,
        SpnValue.CANDLE_GENERAL_DEVICE_TEMP.value: lambda supply: 25.0,
        SpnValue.CANDLE_GENERAL_V_BAT_MODULATION.value: lambda supply: 1.0,
        SpnValue.CANDLE_GENERAL_MAX_SIMUL_ANIM_COUNT.value: lambda supply: 8.0,
    }
