"""A TalonFX or TalonFXS on a mechanism: the controller's volts move the mechanism, and the rotor follows."""

from __future__ import annotations

import math
from collections.abc import Sequence

from phoenix6.hardware import TalonFX
from phoenix6.sim import TalonFXSimState

from simcore.devices.motor_sim import MotorSim
from simcore.errors import ConfigError
from simcore.phoenix6.talon_port import Talon, TalonPort, is_configured_clockwise
from simcore.robot.gearbox import SimMotor
from simcore.robot.motor_ports import AnglePort
from simcore.robot.shaft import ShaftSim

__all__ = ["MotorType", "TalonFXMotorSim"]

MotorType = TalonFXSimState.MotorType
"""The motor of a device's own model: KRAKEN_X60 (also for a Falcon) or KRAKEN_X44."""


class TalonFXMotorSim(MotorSim):
    """Connects a TalonFX, and those that follow it, with any mechanism: flywheel, roller, arm, elevator, rack.

    A TalonFXS as well; its motor is the one of its configuration.

    By default positive is the same thing on both sides: volts that robot code calls positive, after whatever inversion
    it has configured, push the mechanism in its positive direction, and a rising `get_position()` is a rising
    `mechanism.position`. That covers a clockwise shooter as well as a clockwise hood that goes up. Where it is not so
    (a robot that counts down while its arm goes up) say `reversed=True`; never negate anything elsewhere.

    Args:
        talon: The device of the robot code.
        mechanism: What it turns.
        followers: Devices that follow it mechanically and electrically; their rotors are written too.
        opposed: Which of the followers are mounted face to face with the leader (`Follower` with OPPOSED), by index.
        inverted: Whether the device is configured `CLOCKWISE_POSITIVE`; None asks the device (50 ms, once).
        reversed: Whether positive in robot code is negative for the mechanism.
        zero_at: Angle of the mechanism at which the rotor was when it was switched on, so that it reads zero there
            [rad].
        motor_type: What the device model of a TalonFX turns; None leaves it a Kraken X60.
        encoder: An absolute encoder on the mechanism, e.g. the CANcoder that the device is fused with.
        encoder_gearing: Turns of that encoder per turn of the mechanism [-].
        sensor_gearing: Rotor turns per turn of an encoder that is wired to a TalonFXS; None: there is none.

    Raises:
        ConfigError: The mechanism's gearbox has another number of motors than there are devices, or an `opposed` index
            names no follower, or the device's inversion cannot be read.

    Example:
        shooter = TalonFXMotorSim(robot.shooter.leader, FlywheelSim(config), followers=robot.shooter.followers)
        shooter.update(0.005)  # every 5 ms, after the battery
    """

    def __init__(
        self,
        talon: Talon,
        mechanism: SimMotor,
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
        if not isinstance(mechanism, SimMotor):
            raise ConfigError(f"{name}: mechanism must be a SimMotor such as FlywheelSim, got {mechanism!r}")
        super().__init__(name, mechanism, len(followers), opposed, zero_at=zero_at)
        clockwise = (is_configured_clockwise(talon) if inverted is None else inverted) != reversed
        self._leader = TalonPort(talon, clockwise=clockwise, sensor_gearing=sensor_gearing)
        # The direction of a follower's shaft is that of its mounting, whatever inversion it is configured with.
        self._ports = [
            self._leader,
            *(TalonPort(f, clockwise=clockwise != (k in opposed)) for k, f in enumerate(followers)),
        ]
        if motor_type is not None:
            for device in (talon, *followers):
                if not isinstance(device, TalonFX):
                    raise ConfigError(f"{name}: motor_type is of a TalonFX; a TalonFXS has it in its configuration")
                device.sim_state.set_motor_type(motor_type)
        self._encoder = encoder
        self._encoder_gearing = encoder_gearing
        self.write()

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """See `MotorSim.read`."""
        for port in self._ports:
            port.set_supply(battery_voltage)
        if not powered:
            self.mechanism.coast()
            return
        volts = self._leader.volts()
        if volts == 0.0 and self._leader.is_open():
            self.mechanism.coast()
        elif isinstance(self.mechanism, ShaftSim) and (share := self._leader.duty_cycle()) is not None:
            self.mechanism.set_duty_cycle(share)
        else:
            self.mechanism.set_volts(volts)

    def write(self) -> None:
        """See `MotorSim.write`: position and velocity of the rotors."""
        m = self.mechanism
        rotations = (m.position - self._zero_at) * m.gearing / math.tau
        rps = m.velocity * m.gearing / math.tau
        for port in self._ports:
            port.write(rotations, rps)
        if self._encoder is not None:
            self._encoder.write(m.position * self._encoder_gearing, m.velocity * self._encoder_gearing)
