"""Where a motor controller takes its position and velocity from: its rotor, or a sensor on the bus.

Source: measured on CTRE's simulation 26.3. With a remote or fused sensor position and velocity are the sensor's, and
the rotor's are not looked at. They come with the sensor's status frames, at 100 Hz unless robot code asks for more, so
that a stiff loop overshoots (up to 6.5 % for the steering of a swerve module with kP = 100 V/rotation). The loop runs
once a frame: its output stays until the next one comes, a new set point waits for it, and a request of another kind
begins with no output. A synced sensor gives the rotor's its zero; that is what CTRE documents, its simulation does not
have it.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.candi import CANdi
from simcore.phoenix6_emulator.device import Device
from simcore.phoenix6_emulator.wire import Setting

if TYPE_CHECKING:
    from simcore.phoenix6_emulator.talon import Talon

__all__ = ["Feedback", "Source", "feedback_of", "within_range"]

_HALF_RANGE = 16384.0


class Source(enum.IntEnum):
    """`FeedbackSensorSourceValue` and `ExternalFeedbackSensorSourceValue`."""

    ROTOR = 0
    REMOTE_CANCODER = 1
    PIGEON_YAW = 2
    PIGEON_PITCH = 3
    PIGEON_ROLL = 4
    FUSED_CANCODER = 5
    SYNC_CANCODER = 6
    QUADRATURE = 7
    PULSE_WIDTH = 8
    CANDI_PWM1 = 9
    CANDI_PWM2 = 10
    CANDI_QUADRATURE = 11
    FUSED_CANDI_PWM1 = 12
    FUSED_CANDI_PWM2 = 13
    FUSED_CANDI_QUADRATURE = 14
    SYNC_CANDI_PWM1 = 15
    SYNC_CANDI_PWM2 = 16


def within_range(turns: float) -> float:
    """A rotor position as a device tells it, within +-16384 [rotations]."""
    if -_HALF_RANGE <= turns < _HALF_RANGE:
        return turns
    return math.remainder(turns, 2.0 * _HALF_RANGE)


class Feedback:
    """The sensor that a controller is configured to use.

    Args:
        measure: Writes its present reading to the controller's `pos`, `vel` and `acc`.
        is_rotor: Whether that is the rotor's, so that a new position can be set.
        is_missing: Whether robot code has no device with the configured id.
        remote: The device on the bus whose frames bring the readings; None where they are always new.
    """

    __slots__ = ("is_missing", "is_rotor", "measure", "remote")

    def __init__(
        self, measure: Callable[[], None], *, is_rotor: bool, is_missing: bool = False, remote: Device | None = None
    ) -> None:
        self.measure = measure
        self.is_rotor = is_rotor
        self.is_missing = is_missing
        self.remote = remote


def _remote(talon: Talon, source: Source, sensor_id: int) -> tuple[Device, Callable[[], tuple[float, float]]] | None:
    """A sensor on the bus, and its position and velocity; None when robot code has not built it."""
    devices = talon.world.devices
    if source in (Source.REMOTE_CANCODER, Source.FUSED_CANCODER, Source.SYNC_CANCODER):
        encoder = devices.get((5, sensor_id))
        return None if encoder is None else (encoder, lambda: (encoder.frame.position, encoder.frame.velocity))
    if source in (Source.PIGEON_YAW, Source.PIGEON_PITCH, Source.PIGEON_ROLL):
        gyro = devices.get((6, sensor_id))
        axis, rate = {2: ("yaw", "rate_z"), 3: ("pitch", "rate_y"), 4: ("roll", "rate_x")}[source]
        if gyro is None:
            return None
        return gyro, lambda: (getattr(gyro.frame, axis) / 360.0, getattr(gyro.frame, rate) / 360.0)
    candi = devices.get((9, sensor_id))
    if not isinstance(candi, CANdi):
        return None
    if source in (Source.CANDI_QUADRATURE, Source.FUSED_CANDI_QUADRATURE):
        return candi, lambda: (candi.frame.quadrature, candi.frame.quadrature_velocity)
    pin = 1 if source in (Source.CANDI_PWM2, Source.FUSED_CANDI_PWM2, Source.SYNC_CANDI_PWM2) else 0
    return candi, lambda: (candi.frame.positions[pin], candi.frame.velocities[pin])


def feedback_of(talon: Talon, config: Mapping[int, Setting]) -> Feedback:
    """The sensor named in a controller's configuration.

    Raises:
        NotImplementedError: The stand-in has no such sensor.
    """
    get = config.get
    source = Source(
        int(
            get(
                SpnValue.CONFIG_FEEDBACK_SENSOR_SOURCE.value,
                get(SpnValue.CONFIG_EXTERNAL_FEEDBACK_SENSOR_SOURCE.value, 0),
            )
        )
    )
    mechanism = get(SpnValue.CONFIG_SENSOR_TO_MECHANISM_RATIO.value, 1.0) or 1.0
    rotor = get(SpnValue.CONFIG_ROTOR_TO_SENSOR_RATIO.value, 1.0) or 1.0

    def on_rotor(ratio: float, zero: float = 0.0) -> Callable[[], None]:
        def measure() -> None:
            turn = talon.turn
            turns = turn * (talon.raw + talon.shift) + talon.rotor_offset  # `rotor_position`, without the call
            if not -_HALF_RANGE <= turns < _HALF_RANGE:
                turns = within_range(turns)
            scale = turn / ratio
            talon.pos = turns / ratio + zero
            talon.vel = talon.rotor_rps * scale
            talon.acc = talon.rotor_acceleration * scale

        return measure

    if source is Source.ROTOR:
        return Feedback(on_rotor(mechanism), is_rotor=True)
    if source in (Source.QUADRATURE, Source.PULSE_WIDTH):
        raise NotImplementedError(f"{talon!r}: feedback from {source.name} is not modelled in simulated time")
    sensor_id = int(get(SpnValue.CONFIG_FEEDBACK_REMOTE_SENSOR_ID.value, 0))
    found = _remote(talon, source, sensor_id)
    if found is None:
        return Feedback(lambda: _rest(talon), is_rotor=False, is_missing=True)
    device, sensor = found
    if source in (Source.SYNC_CANCODER, Source.SYNC_CANDI_PWM1, Source.SYNC_CANDI_PWM2):
        ratio = rotor * mechanism
        return Feedback(on_rotor(ratio, sensor()[0] / mechanism - talon.rotor_position / ratio), is_rotor=False)

    def measure() -> None:
        p, v = sensor()
        talon.pos = p / mechanism
        talon.vel = v / mechanism
        talon.acc = 0.0

    return Feedback(measure, is_rotor=False, remote=device)


def _rest(talon: Talon) -> None:
    talon.pos = talon.vel = talon.acc = 0.0
