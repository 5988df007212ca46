"""Where a motor controller takes its position and velocity from: its rotor, or a sensor on the bus.

Source: measured on CTRE's simulation 26.3. With a remote or fused sensor position and velocity are the sensor's, and
the rotor's are not read. They come with the sensor's status frames, at 100 Hz unless robot code asks for more, so
that a stiff loop overshoots (up to 6.5 % for the steering of a swerve module with kP = 100 V/rotation). The loop runs
once a frame: its output stays until the next one comes, a new set point waits for it, and a request of another kind
begins with no output. A synced sensor gives the rotor's its zero; that is what CTRE documents, its simulation does not
have it.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.config_text import Setting
from simcore.phoenix6_emulator.emulated_device import EmulatedDevice
from simcore.phoenix6_emulator.emulated_encoders import EmulatedCANdi
from simcore.phoenix6_emulator.talon_state import HALF_RANGE, TalonState, within_range

__all__ = ["Feedback", "FeedbackSource", "feedback_of"]


class FeedbackSource(enum.IntEnum):
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
        self,
        measure: Callable[[], None],
        *,
        is_rotor: bool,
        is_missing: bool = False,
        remote: EmulatedDevice | None = None,
    ) -> None:
        self.measure = measure
        self.is_rotor = is_rotor
        self.is_missing = is_missing
        self.remote = remote


def _remote(
    talon: TalonState, source: FeedbackSource, sensor_id: int
) -> tuple[EmulatedDevice, Callable[[], tuple[float, float]]] | None:
    """A sensor on the bus, and its position and velocity; None when robot code has not built it."""
    devices = talon.devices
    if source in (FeedbackSource.REMOTE_CANCODER, FeedbackSource.FUSED_CANCODER, FeedbackSource.SYNC_CANCODER):
        encoder = devices.get((5, sensor_id))
        return None if encoder is None else (encoder, lambda: (encoder.frame.position, encoder.frame.velocity))
    if source in (FeedbackSource.PIGEON_YAW, FeedbackSource.PIGEON_PITCH, FeedbackSource.PIGEON_ROLL):
        gyro = devices.get((6, sensor_id))
        axis, rate = {2: ("yaw", "rate_z"), 3: ("pitch", "rate_y"), 4: ("roll", "rate_x")}[source]
        if gyro is None:
            return None
        return gyro, lambda: (getattr(gyro.frame, axis) / 360.0, getattr(gyro.frame, rate) / 360.0)
    candi = devices.get((9, sensor_id))
    if not isinstance(candi, EmulatedCANdi):
        return None
    if source in (FeedbackSource.CANDI_QUADRATURE, FeedbackSource.FUSED_CANDI_QUADRATURE):
        return candi, lambda: (candi.frame.quadrature, candi.frame.quadrature_velocity)
    pin = (
        1
        if source in (FeedbackSource.CANDI_PWM2, FeedbackSource.FUSED_CANDI_PWM2, FeedbackSource.SYNC_CANDI_PWM2)
        else 0
    )
    return candi, lambda: (candi.frame.positions[pin], candi.frame.velocities[pin])


def feedback_of(talon: TalonState, config: Mapping[int, Setting]) -> Feedback:
    """The sensor named in a controller's configuration.

    Raises:
        NotImplementedError: The sensor is not modelled.
    """
    get = config.get
    source = FeedbackSource(
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
            if not -HALF_RANGE <= turns < HALF_RANGE:
                turns = within_range(turns)
            scale = turn / ratio
            talon.pos = turns / ratio + zero
            talon.vel = talon.rotor_rps * scale
            talon.acc = talon.rotor_acceleration * scale

        return measure

    if source is FeedbackSource.ROTOR:
        return Feedback(on_rotor(mechanism), is_rotor=True)
    if source in (FeedbackSource.QUADRATURE, FeedbackSource.PULSE_WIDTH):
        raise NotImplementedError(f"{talon!r}: feedback from {source.name} is not modelled in simulated time")
    sensor_id = int(get(SpnValue.CONFIG_FEEDBACK_REMOTE_SENSOR_ID.value, 0))
    found = _remote(talon, source, sensor_id)
    if found is None:
        return Feedback(lambda: _rest(talon), is_rotor=False, is_missing=True)
    device, sensor = found
    if source in (FeedbackSource.SYNC_CANCODER, FeedbackSource.SYNC_CANDI_PWM1, FeedbackSource.SYNC_CANDI_PWM2):
        ratio = rotor * mechanism
        return Feedback(on_rotor(ratio, sensor()[0] / mechanism - talon.rotor_position / ratio), is_rotor=False)

    def measure() -> None:
        p, v = sensor()
        talon.pos = p / mechanism
        talon.vel = v / mechanism
        talon.acc = 0.0

    return Feedback(measure, is_rotor=False, remote=device)


def _rest(talon: TalonState) -> None:
    talon.pos = talon.vel = talon.acc = 0.0
