"""Ports of TalonFX and TalonFXS for motor voltage and rotor motion, and their connection to a mechanism."""

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
"""Device object of a CTRE motor controller in robot code."""

RotorWriter: TypeAlias = Callable[[float, float], None]
"""Function that takes the rotor position [rotations] and velocity [rotations/s]."""

_MAX_RPS = 159.9  # [rotations/s]; the simulated velocity wraps at +-160: 160 reads as -160
_HALF_RANGE = 16384.0  # [rotations]; the simulated position wraps at +-16384
_MIN_SUPPLY, _MAX_SUPPLY = 4.0, 16.0  # [V], valid range; -1 V gives 173 V of output, 20 V gives none


def is_configured_clockwise(talon: Talon) -> bool:
    """Return whether the device is configured `CLOCKWISE_POSITIVE`; the read takes 50 ms.

    Raises:
        ConfigError: The device does not respond.
    """
    output = MotorOutputConfigs()  # type: ignore[no-untyped-call]
    try:
        read_configuration(talon, output)
    except ConfigError as error:
        raise ConfigError(f"{error}: its inversion is not known; pass inverted=True or False") from error
    return output.inverted == InvertedValue.CLOCKWISE_POSITIVE


class TalonPort(MotorPort):
    """Port of one TalonFX or TalonFXS.

    `get_position` has the sign of the raw rotor position if the simulated orientation and the configured inversion are
    equal, else the opposite sign. Robot code and physics therefore agree on the positive direction with equal settings.

    Args:
        talon: Device object of robot code.
        clockwise: Whether positive rotation in physics is clockwise, facing the shaft; None for the configured
            inversion, read from the device once (50 ms).
        sensor_gearing: Rotor turns per turn of a quadrature or pulse-width encoder wired to a TalonFXS; None without
            an encoder.
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
        """Set the supply voltage of the controller [V], clamped to the device model's range of 4 to 16 V."""
        if -0.01 < volts - self._supply < 0.01:
            return
        wanted = min(max(volts, _MIN_SUPPLY), _MAX_SUPPLY)
        if not abs(wanted - self._supply) < 0.01:  # also true for the initial NaN; a write takes 2 us
            self._state.set_supply_voltage(wanted)
            self._supply = wanted

    def volts(self) -> float:
        """Return the motor voltage [V].

        The emulator returns the requested voltage, and CTRE's own simulation the voltage after current limits.
        """
        volts = float(self._state.motor_voltage)
        if volts != 0.0:
            self._is_open = False
        return volts

    def duty_cycle(self) -> float | None:
        """Return the duty cycle [-], or None if the controller commands volts or runs on CTRE's own simulation."""
        return getattr(self._state, "duty_cycle", None)

    def limits(self) -> tuple[float, float]:
        """Return the stator and supply current limits [A]; infinite if CTRE's own simulation applies the limits."""
        return getattr(self._state, "limits", super().limits())

    def setpoint(self) -> Setpoint | None:
        """Return the set-point of the closed loop; None without a closed loop or with CTRE's own simulation."""
        goal = getattr(self._state, "setpoint", None)
        return None if goal is None else Setpoint(*goal)

    def is_open(self) -> bool:
        """Return whether the motor circuit is open (coast) instead of shorted (brake).

        CTRE's own simulation reports 0 V for both neutral modes, but a current only for brake. At rest the modes cannot
        be distinguished, so the method returns the last result.
        """
        is_open: bool | None = getattr(self._state, "is_open", None)
        if is_open is not None:
            return is_open
        if abs(self._rps) > 0.05:
            # a shorted motor carries 5 A per rotation/s, an open motor carries no current
            self._is_open = abs(self._state.torque_current) < min(0.5, 0.1 * abs(self._rps))
        return self._is_open

    def show_motor(self, volts: float, amps: float) -> None:
        """Write the modelled voltage [V] and current [A].

        The method has no effect on CTRE's own simulation, which has its own model.
        """
        if self._show is not None:
            self._show(volts, amps)

    def write(self, rotations: float, rps: float) -> None:
        """Write the rotor position [rotations] and velocity [rotations/s], with the sign of `volts`.

        The method also writes an encoder wired to a TalonFXS, and clamps the velocity to just below 160 rotations/s.

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
        # Write at rest, too: a device that is still applying its configuration loses writes.
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
"""Motor of a TalonFX in the simulated device: KRAKEN_X60 (also for a Falcon) or KRAKEN_X44."""


class TalonFXMotorSim(MotorSim):
    """Connection of a TalonFX or TalonFXS and its followers to a mechanism: flywheel, roller, arm, elevator, rack.

    By default, robot code and mechanism have the same sign: positive volts in robot code, with any configured
    inversion, push the mechanism in the positive direction, and `get_position()` rises with `mechanism.position`. This
    holds for a clockwise shooter as well as for a clockwise hood that goes up. If the signs differ (robot code counts
    down while the arm goes up), pass `reversed=True` and negate nothing elsewhere. A simulated
    TalonFXS has the motor of the configured motor arrangement.

    Args:
        talon: Device object of the leader in robot code.
        mechanism: Mechanism that the motors turn.
        followers: Followers on the same shaft; `write` also writes their rotors.
        opposed: Indices of followers mounted face to face with the leader (`Follower` with OPPOSED).
        inverted: Whether the leader is configured `CLOCKWISE_POSITIVE`; None to read the inversion from the device,
            which takes 50 ms.
        reversed: Whether positive output in robot code moves the mechanism in its negative direction.
        zero_at: Angle of the mechanism at which the rotor position reads zero [rad].
        motor_type: Motor of a TalonFX in the simulated device; None for the default Kraken X60.
        encoder: Absolute encoder on the mechanism, for example a fused CANcoder.
        encoder_gearing: Turns of `encoder` per turn of the mechanism [-].
        sensor_gearing: Rotor turns per turn of an encoder wired to a TalonFXS; None without an encoder.

    Raises:
        ConfigError: The number of devices differs from the number of motors in the mechanism's gearbox, an index in
            `opposed` is out of range, or the leader's inversion cannot be read.

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
        # A follower's shaft direction depends on its mounting, not on its configured inversion.
        self._ports = [
            TalonPort(talon, clockwise=clockwise, sensor_gearing=sensor_gearing),
            *(TalonPort(f, clockwise=clockwise != (k in opposed)) for k, f in enumerate(followers)),
        ]
        if motor_type is not None:
            for device in (talon, *followers):
                if not isinstance(device, TalonFX):
                    raise ConfigError(f"{name}: motor_type is for a TalonFX; a TalonFXS has it in its configuration")
                device.sim_state.set_motor_type(motor_type)
        self._encoder = encoder
        self.write()

    def write(self) -> None:
        """Write the mechanism's motion to the rotors, as in `MotorSim.write`, and to the encoder."""
        super().write()
        if self._encoder is not None:
            m, gearing = self.mechanism, self._encoder_gearing
            self._encoder.write(m.position * gearing, m.velocity * gearing)
