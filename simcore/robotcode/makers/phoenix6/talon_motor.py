"""A TalonFX or TalonFXS: volts from its simulation, rotor motion to it; and its connection to a mechanism."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from phoenix6.configs import MotorOutputConfigs
from phoenix6.hardware import TalonFX, TalonFXS
from phoenix6.signals import InvertedValue
from phoenix6.sim import ChassisReference, TalonFXSimState

from simcore.errors import ConfigError, NonFiniteError
from simcore.robot.mechanisms import ShaftSim
from simcore.robotcode.makers.phoenix6.built_devices import read_configuration
from simcore.robotcode.makers.phoenix6.sensor_ports import own_writer, sim_state_of
from simcore.robotcode.program.motor_ports import AnglePort, MotorPort, Setpoint
from simcore.robotcode.program.motor_sim import MotorSim

__all__ = ["MotorType", "Talon", "TalonFXMotorSim", "TalonPort", "is_configured_clockwise"]

_log = logging.getLogger(__name__)

Talon: TypeAlias = TalonFX | TalonFXS
"""CTRE's motor controllers."""

RotorWriter: TypeAlias = Callable[[float, float], None]
"""Takes rotations and rotations/s."""

_MAX_RPS = 159.9  # the simulated velocity wraps at +-160: 160 reads as -160
_HALF_RANGE = 16384.0  # [rotations]; the simulated position wraps here
_MIN_SUPPLY, _MAX_SUPPLY = 4.0, 16.0  # [V]; -1 V gives 173 V of output, 20 V no output


def is_configured_clockwise(talon: Talon) -> bool:
    """Read from the device whether it is configured `CLOCKWISE_POSITIVE`, which takes 50 ms.

    Raises:
        ConfigError: The device does not answer.
    """
    output = MotorOutputConfigs()  # type: ignore[no-untyped-call]
    try:
        read_configuration(talon, output)
    except ConfigError as error:
        raise ConfigError(f"{error}: its inversion is not known; pass inverted=True or False") from error
    return output.inverted == InvertedValue.CLOCKWISE_POSITIVE


class TalonPort(MotorPort):
    """Simulated side of one motor controller.

    The simulated state is in the chassis frame, whatever the inversion: sign(get_position) = invert x orientation.
    With the orientation equal to the configured inversion the two cancel, and positive is the same for robot code and
    physics.

    Args:
        talon: Device of robot code.
        clockwise: Whether a rotation that physics calls positive is clockwise, facing the shaft; None: as the device
            is configured, which is read once (50 ms).
        sensor_gearing: Rotor turns per turn of an encoder wired to a TalonFXS (quadrature, pulse width); None:
            without one.
    """

    def __init__(self, talon: Talon, *, clockwise: bool | None = None, sensor_gearing: float | None = None) -> None:
        if clockwise is None:
            clockwise = is_configured_clockwise(talon)
        self.device_id: int = talon.device_id
        state: Any = sim_state_of(talon)
        self._state = state
        self._write_rotor: RotorWriter = getattr(state, "write_rotor", None) or _writer(
            own_writer(state, "set_raw_rotor_position"), own_writer(state, "set_rotor_velocity")
        )
        self._show: Callable[[float, float], None] | None = getattr(state, "show_motor", None)
        self._sensor: list[tuple[Any, Any]] = []
        self._per_sensor = 1.0
        turn = ChassisReference.CLOCKWISE_POSITIVE if clockwise else ChassisReference.COUNTER_CLOCKWISE_POSITIVE
        if isinstance(talon, TalonFXS):
            state.motor_orientation = state.ext_sensor_orientation = turn
            if sensor_gearing is not None:
                self._per_sensor = 1.0 / sensor_gearing
                self._sensor = [
                    (own_writer(state, f"set_{position}_position"), own_writer(state, f"set_{kind}_velocity"))
                    for position, kind in (("raw_quadrature", "quadrature"), ("pulse_width", "pulse_width"))
                ]
        else:
            state.orientation = turn
        self._supply = math.nan
        self._rps = 0.0
        self._is_open = False
        self._was_clamped = False

    def set_supply(self, volts: float) -> None:
        """Set the voltage at the controller's terminals [V], clamped to the device model's range, 4 to 16 V."""
        if -0.01 < volts - self._supply < 0.01:
            return
        wanted = min(max(volts, _MIN_SUPPLY), _MAX_SUPPLY)
        if not abs(wanted - self._supply) < 0.01:  # also true for the first NaN; a write takes 2 us
            self._state.set_supply_voltage(wanted)
            self._supply = wanted

    def volts(self) -> float:
        """Return the controller's voltage on the motor, after its own limits [V]."""
        volts = float(self._state.motor_voltage)
        if volts != 0.0:
            self._is_open = False
        return volts

    def duty_cycle(self) -> float | None:
        """Return its duty cycle [-]; None: it commands volts, or is CTRE's own simulation, which does not report it."""
        return getattr(self._state, "duty_cycle", None)

    def limits(self) -> tuple[float, float]:
        """Return the limits of `MotorPort`; CTRE's own simulation applies its limits to its volts."""
        return getattr(self._state, "limits", super().limits())

    def setpoint(self) -> Setpoint | None:
        """Return the setpoint of `MotorPort`; CTRE's own simulation does not report it."""
        goal = getattr(self._state, "setpoint", None)
        return None if goal is None else Setpoint(*goal)

    def is_open(self) -> bool:
        """Return whether the circuit is open (coast) instead of shorted (brake).

        CTRE's own simulation shows 0 V for both, and current for a brake only. At rest the two cannot be told apart,
        and the last answer stays.
        """
        is_open: bool | None = getattr(self._state, "is_open", None)
        if is_open is not None:
            return is_open
        if abs(self._rps) > 0.05:
            # a shorted motor carries 5 A per turn a second, an open one none
            self._is_open = abs(self._state.torque_current) < min(0.5, 0.1 * abs(self._rps))
        return self._is_open

    def show_motor(self, volts: float, amps: float) -> None:
        """Show volts and current as in `MotorPort`; CTRE's own simulation computes its own current."""
        if self._show is not None:
            self._show(volts, amps)

    def write(self, rotations: float, rps: float) -> None:
        """Set position [rotations] and velocity [rotations/s] of the rotor, positive as in `volts`.

        Raises:
            NonFiniteError: A value is not finite; nothing is written.
        """
        if not math.isfinite(rotations + rps):
            raise NonFiniteError(
                f"Talon {self.device_id}: rotor needs finite numbers, got {rotations} rotations, {rps} rps"
            )
        if abs(rps) > _MAX_RPS:
            if not self._was_clamped:
                self._was_clamped = True
                _log.warning("Talon %d: rotor at %.0f rps; the device reads no more than 160", self.device_id, rps)
            rps = math.copysign(_MAX_RPS, rps)
        # Also at rest: a device still busy with its configuration loses a write, so one is not enough.
        self._rps = rps
        self._write_rotor((rotations + _HALF_RANGE) % (2.0 * _HALF_RANGE) - _HALF_RANGE, rps)
        for set_position, set_velocity in self._sensor:
            set_position(rotations * self._per_sensor)
            set_velocity(rps * self._per_sensor)


def _writer(set_position: Callable[[float], object], set_velocity: Callable[[float], object]) -> RotorWriter:
    def write(rotations: float, rps: float) -> None:
        set_position(rotations)
        set_velocity(rps)

    return write


MotorType = TalonFXSimState.MotorType
"""Motor of a device's own model: KRAKEN_X60 (also for a Falcon) or KRAKEN_X44."""


class TalonFXMotorSim(MotorSim):
    """Connection of a TalonFX and its followers to any mechanism: flywheel, roller, arm, elevator, rack.

    A TalonFXS as well; its motor is the one of its configuration.

    By default signs agree on both sides: volts that robot code calls positive, after any inversion that
    it has configured, push the mechanism in its positive direction, and a rising `get_position()` is a rising
    `mechanism.position`. That covers a clockwise shooter as well as a clockwise hood that goes up. Where signs differ
    (a robot that counts down while its arm goes up) pass `reversed=True`; negate nothing elsewhere.

    Args:
        talon: Device of robot code.
        mechanism: Mechanism that it turns.
        followers: Devices that follow it on the same shaft; their rotors are written too.
        opposed: Indices of followers mounted face to face with the leader (`Follower` with OPPOSED).
        inverted: Whether the device is configured `CLOCKWISE_POSITIVE`; None reads it from the device (50 ms, once).
        reversed: Whether positive in robot code is negative for the mechanism.
        zero_at: Angle of the mechanism when the rotor was switched on, so that it reads zero there
            [rad].
        motor_type: Motor of a TalonFX's device model; None leaves it a Kraken X60.
        encoder: Absolute encoder on the mechanism, e.g. the CANcoder that the device is fused with.
        encoder_gearing: Turns of that encoder per turn of the mechanism [-].
        sensor_gearing: Rotor turns per turn of an encoder wired to a TalonFXS; None: without one.

    Raises:
        ConfigError: The mechanism's gearbox and the devices differ in number, or an `opposed` index
            names no follower, or the device's inversion cannot be read.

    Example:
        shooter = TalonFXMotorSim(robot.shooter.leader, FlywheelSim(config), followers=robot.shooter.followers)
        shooter.update(0.005)  # every 5 ms, after the battery
    """

    def __init__(
        self,
        talon: Talon,
        mechanism: ShaftSim,
        *,
        followers: Sequence[Talon] = (),
        opposed: Sequence[int] = (),
        inverted: bool | None = None,
        reversed: bool = False,
        zero_at: float = 0.0,
        motor_type: TalonFXSimState.MotorType | None = None,
        encoder: AnglePort | None = None,
        encoder_gearing: float = 1.0,
        sensor_gearing: float | None = None,
    ) -> None:
        name = f"{type(talon).__name__} {talon.device_id}"
        super().__init__(name, mechanism, len(followers), opposed, zero_at=zero_at, encoder_gearing=encoder_gearing)
        clockwise = (is_configured_clockwise(talon) if inverted is None else inverted) != reversed
        # A follower's shaft direction is that of its mounting, whatever inversion is configured.
        self._ports = [
            TalonPort(talon, clockwise=clockwise, sensor_gearing=sensor_gearing),
            *(TalonPort(f, clockwise=clockwise != (k in opposed)) for k, f in enumerate(followers)),
        ]
        if motor_type is not None:
            for device in (talon, *followers):
                if not isinstance(device, TalonFX):
                    raise ConfigError(f"{name}: motor_type is of a TalonFX; a TalonFXS has it in its configuration")
                device.sim_state.set_motor_type(motor_type)
        self._encoder = encoder
        self.write()

    def write(self) -> None:
        """Write the sensors as in `MotorSim.write`, including the encoder."""
        super().write()
        if self._encoder is not None:
            m, gearing = self.mechanism, self._encoder_gearing
            self._encoder.write(m.position * gearing, m.velocity * gearing)
