"""Emulated TalonFX and TalonFXS, with limits, feedback sensor, followers, requests, control loop and status frames."""

from __future__ import annotations

import enum
import logging
import math
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from typing import Any, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.errors import NonFiniteError
from simcore.quantities import DeviceAddress
from simcore.robotcode.emulator.control_laws import (
    REQ_BRAKE,
    REQ_COAST,
    ControlPlan,
    LoopState,
    build_plan,
    limits_of,
)
from simcore.robotcode.emulator.emulated_device import (
    FAULTS,
    LOOP_NS,
    REQUESTS,
    Axis,
    Devices,
    EmulatedDevice,
    RequestKind,
    Setting,
    SimulatedClock,
    Unit,
    period_of,
)
from simcore.robotcode.emulator.emulated_peripherals import EmulatedCANdi, EmulatedCANrange
from simcore.robotcode.emulator.output_stage import (
    ARRANGEMENTS,
    KRAKEN_X44,
    KRAKEN_X60,
    OVER_VOLTAGE,
    Bridge,
    ConnectedMotor,
    Stage,
    duty,
    supply_current,
)

__all__ = ["EmulatedTalon", "EmulatedTalonFXS"]

_PIN, _TALON, _DISABLED, _CANCODER, _CANRANGE, _CANDI_S1, _CANDI_S2 = 0, 1, 3, 4, 6, 7, 8


class TalonLimit:
    """Soft limit and limit switch for one direction of motion.

    Args:
        controller: Name of the controller, for error messages.
        forward: Whether the limit blocks forward motion; False for reverse motion.
    """

    __slots__ = (
        "_autoset",
        "_autoset_value",
        "_controller",
        "_forward",
        "_hard",
        "_normally_closed",
        "_remote",
        "_soft",
        "_source",
        "_threshold",
        "_was_closed",
        "closed",
        "is_plain",
    )

    def __init__(self, controller: str, *, forward: bool) -> None:
        self._controller = controller
        self._forward = forward
        self.closed = False
        """Whether the limit switch wired to the controller is closed. `sim_state` sets this value."""
        self._was_closed = False
        self.is_plain = True
        """Whether the limit is off or uses only a normally open switch wired to the controller."""

    def configure(self, config: Mapping[int, Setting]) -> None:
        """Apply the configured soft limit and limit switch for this limit's direction.

        Raises:
            NotImplementedError: The limit source is not modelled.
        """
        way = "FORWARD" if self._forward else "REVERSE"

        def get(name: str) -> Setting:
            return config[SpnValue[name.format(way)].value]

        self._soft = bool(get("CONFIG_{}_SOFT_LIMIT_ENABLE"))
        self._threshold = get("CONFIG_{}_SOFT_LIMIT_THRESHOLD")
        self._source = int(get("CONFIG_{}_LIMIT_SOURCE"))
        self._remote = int(get("CONFIG_{}_LIMIT_REMOTE_SENSOR_ID"))
        self._hard = bool(get("CONFIG_{}_LIMIT_ENABLE")) and self._source != _DISABLED
        self._normally_closed = get("CONFIG_{}_LIMIT_TYPE") == 1
        self._autoset = bool(get("CONFIG_{}_LIMIT_AUTOSET_POS_ENABLE"))
        self._autoset_value = get("CONFIG_{}_LIMIT_AUTOSET_POS_VALUE")
        self.is_plain = not self._soft and (not self._hard or (self._source == _PIN and not self._normally_closed))
        if self._hard and self._source not in (_PIN, _TALON, _CANRANGE, _CANDI_S1, _CANDI_S2):
            raise NotImplementedError(
                f"{self._controller}: limit source {self._source} is not modelled in simulated time"
            )

    def is_closed(self, devices: Devices) -> bool:
        """Return whether the configured switch or remote sensor is closed now; False for a missing remote device."""
        if self._source == _PIN:
            return self.closed
        if self._source == _TALON:
            talon = devices.get((4, self._remote))
            limit = getattr(talon, "forward" if self._forward else "reverse", None)
            return limit is not None and limit.closed
        if self._source == _CANRANGE:
            near = devices.get((8, self._remote))
            return isinstance(near, EmulatedCANrange) and near.is_detected
        candi = devices.get((9, self._remote))
        return isinstance(candi, EmulatedCANdi) and candi.is_closed(0 if self._source == _CANDI_S1 else 1)

    def autoset(self, devices: Devices) -> float | None:
        """Return the configured autoset position [mechanism rotations] if the switch became active since the last call.

        The method returns None if the switch did not become active, or if autoset is off.
        """
        if not self._autoset:
            return None
        hit = self.is_closed(devices) != self._normally_closed
        fresh = hit and not self._was_closed
        self._was_closed = hit
        return self._autoset_value if fresh else None

    def stops(self, devices: Devices, position: float, ignore_soft: bool, ignore_hard: bool) -> tuple[bool, bool]:
        """Return whether the soft limit is active, and whether the limit switch is active.

        Args:
            devices: Devices on the controller's bus.
            position: Position of the controller [mechanism rotations].
            ignore_soft: Whether to ignore the soft limit.
            ignore_hard: Whether to ignore the limit switch.
        """
        soft = False
        if self._soft and not ignore_soft:
            soft = position > self._threshold if self._forward else position < self._threshold
        hard = self._hard and not ignore_hard and self.is_closed(devices) != self._normally_closed
        return soft, hard


HALF_RANGE = 16384.0
"""Largest magnitude of the rotor position that a device reports [rotations]."""
IDLE = REQUESTS["Empty"]
"""Request that is active until the first request, and again after a one-shot request has expired."""


def within_range(turns: float) -> float:
    """Return the rotor position wrapped to the range that a device reports, from -16384 to 16384 [rotations]."""
    if -HALF_RANGE <= turns < HALF_RANGE:
        return turns
    return math.remainder(turns, 2.0 * HALF_RANGE)


class FeedbackSource(enum.IntEnum):
    """Feedback source, numbered as in `FeedbackSensorSourceValue` and `ExternalFeedbackSensorSourceValue`."""

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


@dataclass(frozen=True, slots=True)
class Feedback:
    """Configured feedback sensor of a controller: the rotor sensor or a sensor on the bus.

    With a remote or fused sensor, the controller uses this sensor's position and velocity instead of the rotor's.
    The readings arrive in the sensor's status frames, at 100 Hz unless robot code sets another rate. A stiff loop
    therefore overshoots, by up to 6.5 % for the steering of a swerve module with kP = 100 V/rotation. The loop runs
    once per frame: the output is constant until the next frame, and a new setpoint takes effect at the next frame. A
    request of another kind starts with zero output. A synced sensor sets the zero of the rotor sensor, as CTRE
    documents but does not simulate.

    Source: measurements of CTRE's simulation 26.3.
    """

    measure: Callable[[], None]
    """Function that writes the sensor's last reading to `pos`, `vel` and `acc` in the controller's `LoopState`."""
    is_rotor: bool
    """Whether the feedback sensor is the rotor sensor. `set_position` works only for the rotor sensor."""
    ratio: float = 1.0
    """Rotor turns, or sensor turns for a remote or fused sensor, per mechanism rotation [-]."""
    present: Callable[[], float] = float
    """Function that returns the present position without the delay of status frames [mechanism rotations]."""
    is_missing: bool = False
    """Whether robot code has not built the sensor with the configured ID."""
    remote: EmulatedDevice | None = None
    """Device that sends the readings in status frames; None for the rotor, a synced sensor or a missing sensor."""


def _remote(
    talon: EmulatedTalon, source: FeedbackSource, sensor_id: int
) -> tuple[EmulatedDevice, Callable[[Any], tuple[float, float]]] | None:
    """Return the sensor on the bus, and a function that reads the sensor from a status frame.

    The second item returns position [rotations] and velocity [rotations/s] for a status frame. If robot code has not
    built the sensor, `_remote` returns None.
    """
    devices = talon.devices
    if source in (FeedbackSource.REMOTE_CANCODER, FeedbackSource.FUSED_CANCODER, FeedbackSource.SYNC_CANCODER):
        encoder = devices.get((5, sensor_id))
        return None if encoder is None else (encoder, lambda frame: (frame.position, frame.velocity))
    if source in (FeedbackSource.PIGEON_YAW, FeedbackSource.PIGEON_PITCH, FeedbackSource.PIGEON_ROLL):
        gyro = devices.get((6, sensor_id))
        axis, rate = {2: ("yaw", "rate_z"), 3: ("pitch", "rate_y"), 4: ("roll", "rate_x")}[source]
        if gyro is None:
            return None
        return gyro, lambda frame: (getattr(frame, axis) / 360.0, getattr(frame, rate) / 360.0)
    candi = devices.get((9, sensor_id))
    if not isinstance(candi, EmulatedCANdi):
        return None
    if source in (FeedbackSource.CANDI_QUADRATURE, FeedbackSource.FUSED_CANDI_QUADRATURE):
        return candi, lambda frame: (frame.quadrature, frame.quadrature_velocity)
    pin = (
        1
        if source in (FeedbackSource.CANDI_PWM2, FeedbackSource.FUSED_CANDI_PWM2, FeedbackSource.SYNC_CANDI_PWM2)
        else 0
    )
    return candi, lambda frame: (frame.positions[pin], frame.velocities[pin])


def feedback_of(talon: EmulatedTalon, config: Mapping[int, Setting]) -> Feedback:
    """Return the feedback sensor that a controller's configuration selects.

    `is_missing` is true in the result if robot code has not built the sensor.

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

    def on_rotor(ratio: float, zero: float = 0.0, *, is_rotor: bool) -> Feedback:
        def measure() -> None:
            turn = talon.turn
            turns = turn * (talon.raw + talon.shift) + talon.rotor_offset  # `rotor_position`, inlined for speed
            if not -HALF_RANGE <= turns < HALF_RANGE:
                turns = within_range(turns)
            scale = turn / ratio
            talon.loop.pos = turns / ratio + zero
            talon.loop.vel = talon.rotor_rps * scale
            talon.loop.acc = talon.rotor_acceleration * scale

        def present() -> float:
            measure()
            return talon.loop.pos

        return Feedback(measure, is_rotor=is_rotor, ratio=ratio, present=present)

    if source is FeedbackSource.ROTOR:
        return on_rotor(mechanism, is_rotor=True)
    if source in (FeedbackSource.QUADRATURE, FeedbackSource.PULSE_WIDTH):
        raise NotImplementedError(f"{talon!r}: feedback from {source.name} is not modelled in simulated time")
    sensor_id = int(get(SpnValue.CONFIG_FEEDBACK_REMOTE_SENSOR_ID.value, 0))
    found = _remote(talon, source, sensor_id)
    if found is None:
        return Feedback(lambda: _rest(talon), is_rotor=False, is_missing=True)
    device, sensor = found
    if source in (FeedbackSource.SYNC_CANCODER, FeedbackSource.SYNC_CANDI_PWM1, FeedbackSource.SYNC_CANDI_PWM2):
        ratio = rotor * mechanism
        return on_rotor(ratio, sensor(device.frame)[0] / mechanism - talon.rotor_position / ratio, is_rotor=False)

    def measure() -> None:
        p, v = sensor(device.frame)
        talon.loop.pos = p / mechanism
        talon.loop.vel = v / mechanism
        talon.loop.acc = 0.0

    def present() -> float:
        return sensor(device.sample())[0] / mechanism

    return Feedback(measure, is_rotor=False, remote=device, ratio=mechanism, present=present)


def _rest(talon: EmulatedTalon) -> None:
    talon.loop.pos = talon.loop.vel = talon.loop.acc = 0.0


_OPPOSED = 1


def _leader(talon: EmulatedTalon) -> EmulatedTalon | None:
    leader = talon.devices.get((talon.type_number, int(talon.args[1])))
    return leader if isinstance(leader, EmulatedTalon) and leader is not talon else None


def _opposes(talon: EmulatedTalon) -> bool:
    return bool(talon.args[2] == _OPPOSED)


def turning(talon: EmulatedTalon) -> float:
    """Return the direction of rotation for a positive output: 1 for counter-clockwise, -1 for clockwise.

    A `Follower` uses the leader's direction, reversed if opposed. A `StrictFollower` uses the follower's configured
    direction.

    Source: measurements of CTRE's simulation 26.3.
    """
    if talon.kind.axis is not Axis.FOLLOW or talon.kind.name == "StrictFollower":
        return talon.sign
    leader = _leader(talon)
    if leader is None:
        return talon.sign
    return -leader.turn if _opposes(talon) else leader.turn


def following(talon: EmulatedTalon) -> Callable[[int], None] | None:
    """Return a function that advances a follower by a number of control loops; None if the request is not a follower.

    The returned function applies the output in the leader's last status frame, in the unit of the leader's request.
    Without a leader, the function applies the configured neutral mode. The controller calls `following` after each
    change of request, configuration or devices, because a search for the leader in each step would double the cost.
    """
    if talon.kind.axis is not Axis.FOLLOW:
        return None
    bridge, leader = talon.bridge, _leader(talon)
    if leader is None:
        return lambda loops: _alone(talon)
    found = leader
    is_strict = talon.kind.name == "StrictFollower"
    sign = -1.0 if not is_strict and _opposes(talon) else 1.0
    unit: Unit | None = None
    stage: Stage | None = None

    def drive(loops: int) -> None:
        nonlocal unit, stage
        talon.turn = turn = talon.sign if is_strict else sign * found.turn
        bridge.rps = talon.rotor_rps * turn
        frame: TalonFrame = found.frame
        if frame.is_neutral:
            bridge.neutral(frame.is_braking)
            return
        if stage is None or unit is not found.kind.unit:
            unit = found.kind.unit
            stage = bridge.stage(unit, closed=True, foc=True)
            bridge.override, bridge.deadband, bridge.max_duty = False, 0.0, 1.0
            bridge.blocked_forward = bridge.blocked_reverse = False
        stage(frame.volts if unit is Unit.VOLTS else (duty(frame) if unit is Unit.DUTY else frame.current), loops)

    return drive


def _alone(talon: EmulatedTalon) -> None:
    talon.bridge.rest()
    talon.bridge.neutral(talon.bridge.brake)


_OFF, _BRAKING, _MOTORING, _DISCORDANT, _REGENERATING = 1, 2, 3, 4, 5  # MotorOutputStatusValue


class TalonFrame(NamedTuple):
    """Status frame of a motor controller, in which all values have robot code's sign."""

    position: float
    velocity: float
    acceleration: float
    turns: float
    """Rotor position without wrapping [rotations]."""
    rotor_velocity: float
    volts: float
    current: float
    supply: float
    is_neutral: bool
    is_braking: bool
    bridge_rps: float
    """Rotor velocity when the output stage last ran [rotations/s]."""
    ref: float
    slope: float
    err: float
    err_rate: float
    i_out: float
    ff_out: float
    pid_out: float
    slot: int
    enabled: bool
    forward_closed: bool
    reverse_closed: bool
    turn: float
    """Direction of positive rotation: 1 for counter-clockwise, -1 for clockwise."""
    has_arrived: bool
    """Whether the profile's setpoint has reached the goal."""
    plan: ControlPlan
    motor: ConnectedMotor

    @property
    def rotor_position(self) -> float:
        """Rotor position wrapped to the range from -16384 to 16384 [rotations]."""
        return within_range(self.turns)

    @property
    def bridge(self) -> int:
        """Reported bridge state, a `BridgeOutputValue`."""
        if not self.is_neutral:
            return self.plan.drives
        return REQ_BRAKE if self.is_braking else REQ_COAST

    @property
    def status(self) -> int:
        """Reported motor output status, a `MotorOutputStatusValue`."""
        if self.is_neutral:
            return _BRAKING if self.is_braking else _OFF
        if supply_current(self) < 0.0:
            return _REGENERATING
        return _DISCORDANT if self.current * self.bridge_rps < 0.0 else _MOTORING

    @property
    def profiled(self) -> bool:
        """Whether the controller is enabled with a Motion Magic request."""
        return self.enabled and self.plan.profile is not None


def _constant(value: float) -> Callable[[Any], float]:
    return lambda frame: value


_DIFFERENTIAL = tuple(
    spn
    for spn in SpnValue
    if spn.name.startswith(("PRO_DIFF_", "PRO_AVG_", "PRO_MOTOR_OUTPUT_PID_STATE_DIFF_"))
    or spn.name == "TALON_FX_DIFFERENTIAL_CONTROL_MODE"
)
_RAW_INPUTS = (  # raw encoder readings of a TalonFXS, which CTRE's simulation does not send
    SpnValue.TALON_FXS_GADGETEER_G3,
    SpnValue.PRO_GADGETEER_PWM_RAW_PWM_POSITION,
    SpnValue.PRO_GADGETEER_PWM_RAW_PWM_VELOCITY,
    SpnValue.PRO_GADGETEER_QUAD_RAW_QUADRATURE_POSITION,
    SpnValue.PRO_GADGETEER_QUAD_RAW_QUADRATURE_VELOCITY,
)

SIGNALS: Mapping[int, Callable[[Any], float]] = {
    SpnValue.PRO_POS_AND_VEL_POSITION.value: lambda f: f.position,
    SpnValue.PRO_POS_AND_VEL_VELOCITY.value: lambda f: f.velocity,
    SpnValue.PRO_POS_AND_VEL_ACCELERATION.value: lambda f: f.acceleration,
    SpnValue.PRO_ROTOR_POS_AND_VEL_POSITION.value: lambda f: f.rotor_position,
    SpnValue.PRO_ROTOR_POS_AND_VEL_VELOCITY.value: lambda f: f.rotor_velocity,
    SpnValue.PRO_MOTOR_OUTPUT_MOTOR_VOLTAGE.value: lambda f: f.volts,
    SpnValue.PRO_MOTOR_OUTPUT_DUTY_CYCLE.value: duty,
    SpnValue.PRO_MOTOR_OUTPUT_TORQUE_CURRENT.value: lambda f: f.current,
    SpnValue.PRO_MOTOR_OUTPUT_ROTOR_POLARITY.value: lambda f: int(f.turn < 0.0),
    SpnValue.PRO_MOTOR_OUTPUT_BRIDGE_TYPE_PUBLIC.value: lambda f: f.bridge,
    SpnValue.TALON_FX_MOTOR_OUTPUT_STATUS.value: lambda f: f.status,
    SpnValue.TALON_FX_CONTROL_MODE.value: lambda f: f.plan.mode if f.enabled else 0,
    SpnValue.PRO_SUPPLY_AND_TEMP_STATOR_CURRENT.value: lambda f: f.current,
    SpnValue.PRO_SUPPLY_AND_TEMP_SUPPLY_CURRENT.value: supply_current,
    SpnValue.PRO_SUPPLY_AND_TEMP_SUPPLY_VOLTAGE.value: lambda f: f.supply,
    # CTRE's simulated device reports these constant temperatures.
    SpnValue.PRO_SUPPLY_AND_TEMP_DEVICE_TEMP.value: _constant(24.0),
    SpnValue.PRO_SUPPLY_AND_TEMP_DEVICE_TEMP2.value: _constant(0.0),
    SpnValue.PRO_SUPPLY_AND_TEMP_PROCESSOR_TEMP.value: _constant(20.0),
    SpnValue.EXTERNAL_MOTOR_TEMP.value: _constant(20.0),
    SpnValue.EXTERNAL_MOTOR_TEMP_STATUS.value: _constant(3.0),
    SpnValue.TALON_FXS_5_V_RAIL_VOLTAGE.value: _constant(5.0),
    SpnValue.FORWARD_LIMIT.value: lambda f: not f.forward_closed,
    SpnValue.REVERSE_LIMIT.value: lambda f: not f.reverse_closed,
    SpnValue.PRO_PID_STATE_ENABLES_ROBOT_ENABLE.value: lambda f: f.enabled,
    SpnValue.PRO_PID_STATE_ENABLES_DEVICE_ENABLE.value: lambda f: f.enabled,
    SpnValue.PRO_PID_STATE_ENABLES_IS_MOTION_MAGIC_RUNNING.value: lambda f: f.profiled,
    SpnValue.PRO_PID_STATE_ENABLES_MOTION_MAGIC_AT_TARGET.value: lambda f: f.profiled and f.has_arrived,
    SpnValue.PRO_PID_REF_PID_ERR_PID_REF_POSITION.value: lambda f: f.ref,
    SpnValue.PRO_PID_REF_PID_ERR_PID_ERR_POSITION.value: lambda f: f.err,
    SpnValue.PRO_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_POSITION.value: lambda f: f.slope,
    SpnValue.PRO_PID_OUTPUT_OUTPUT_DC.value: lambda f: f.pid_out,
    SpnValue.PRO_PID_OUTPUT_PROPORTIONAL_OUTPUT_DC.value: lambda f: f.plan.gains.kp * f.err,
    SpnValue.PRO_PID_OUTPUT_DERIVATIVE_OUTPUT_DC.value: lambda f: f.plan.gains.kd * f.err_rate,
    SpnValue.PRO_PID_STATE_ENABLES_INTEGRATED_ACCUM_DC.value: lambda f: f.i_out,
    SpnValue.PRO_PID_STATE_ENABLES_FEED_FORWARD_DC.value: lambda f: f.ff_out,
    SpnValue.PRO_PID_OUTPUT_SLOT.value: lambda f: f.slot,
    SpnValue.TALON_FX_MOTOR_CONSTANTS_K_T.value: lambda f: f.motor.kt,
    SpnValue.TALON_FX_MOTOR_CONSTANTS_K_V.value: lambda f: f.motor.kv,
    SpnValue.TALON_FX_MOTOR_CONSTANTS_STALL_CURRENT.value: lambda f: f.motor.stall_current,
    SpnValue.TALON_FX_CONNECTED_MOTOR.value: lambda f: f.motor.number,
    # The emulator rejects differential requests, so these signals keep the value they have without a request.
    **{spn.value: _constant(0.0) for spn in _DIFFERENTIAL},
    **{spn.value: _constant(0.0) for spn in _RAW_INPUTS},
}
"""Functions that return a signal's value from a status frame, by signal number."""

_BY_AXIS = {
    SpnValue.PRO_PID_REF_PID_ERR_PID_REF_POSITION.value,
    SpnValue.PRO_PID_REF_PID_ERR_PID_ERR_POSITION.value,
    SpnValue.PRO_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_POSITION.value,
}
_BY_UNIT = {
    SpnValue.PRO_PID_OUTPUT_OUTPUT_DC.value,
    SpnValue.PRO_PID_OUTPUT_PROPORTIONAL_OUTPUT_DC.value,
    SpnValue.PRO_PID_OUTPUT_DERIVATIVE_OUTPUT_DC.value,
    SpnValue.PRO_PID_STATE_ENABLES_INTEGRATED_ACCUM_DC.value,
    SpnValue.PRO_PID_STATE_ENABLES_FEED_FORWARD_DC.value,
}


def units_number(spn: int, frame: TalonFrame) -> int:
    """Return the number of the signal that defines the units of signal `spn` for the frame's request."""
    if spn in _BY_AXIS:
        return spn + frame.plan.on_velocity
    return spn + frame.plan.unit_number if spn in _BY_UNIT else spn


_NO_FAULTS: frozenset[int] = frozenset()
_new = tuple.__new__


def active_faults(talon: EmulatedTalon, is_sensor_missing: bool) -> Set[int]:
    """Return the signal numbers of the active faults.

    The faults are active current limits, a supply overvoltage, a missing remote sensor, and active soft and hard limits
    that block the output.
    """
    bridge = talon.bridge
    limited = bridge.is_stator_limited or bridge.is_supply_limited or bridge.is_blocked
    if not limited and bridge.supply <= OVER_VOLTAGE and not is_sensor_missing:
        return _NO_FAULTS
    found = set()
    if bridge.is_stator_limited:
        found.add(FAULTS["TALONFX_STATOR_CURR_LIMIT"])
    if bridge.is_supply_limited:
        found.add(FAULTS["TALONFX_SUPPLY_CURR_LIMIT"])
    if bridge.supply > OVER_VOLTAGE:
        found.add(FAULTS["TALONFX_OVER_SUPPLY_V"])
    if is_sensor_missing:
        found.add(FAULTS["TALONFX_MISSING_REMOTE_SENSOR"])
    if bridge.is_blocked:
        names = ("FORWARD_SOFT_LIMIT", "REVERSE_SOFT_LIMIT", "FORWARD_HARD_LIMIT", "REVERSE_HARD_LIMIT")
        found |= {FAULTS[f"TALONFX_{name}"] for name, hit in zip(names, talon.limits_hit, strict=True) if hit}
    return found


def frame_of(talon: EmulatedTalon) -> TalonFrame:
    """Return a status frame with the present state of a controller."""
    b, m, plan, turn, devices = talon.bridge, talon.loop, talon.plan, talon.turn, talon.devices
    profile = plan.profile
    # 0.9 us per frame instead of 7 us, because this code bypasses TalonFrame.__new__, and the frame's properties
    # compute rarely read values on demand. 17 motors send 34 frames per tick.
    return _new(TalonFrame, (
        m.pos, m.vel, m.acc, turn * (talon.raw + talon.shift) + talon.rotor_offset, talon.rotor_rps * turn,
        b.volts, b.current, b.supply, b.is_neutral, b.is_braking, b.rps,
        m.ref, m.slope, m.err, m.derr, m.integral, m.feed_forward, m.pid_out,
        talon.slot, talon.enabled, talon.forward.is_closed(devices), talon.reverse.is_closed(devices), turn,
        profile is not None and profile.done, plan, b.motor,
    ))  # fmt: skip


_log = logging.getLogger(__name__)

_CONTROL_PHASE_NS = 4_000_000
"""Delay of a control frame after a multiple of the frame period [ns].

In CTRE's simulation in real time, the delay of a request is between 0 and one period, with a median of 4.4 ms.
"""
_ONE_SHOT_NS = 100_000_000
"""Lifetime of a one-shot request (`update_freq_hz=0`) [ns]."""
_DEFAULTS = {"enable_foc": True, "max_abs_duty_cycle": 1.0, "update_freq_hz": 100.0}
"""Library defaults of the request fields with a default other than 0."""


class EmulatedTalon(EmulatedDevice):
    """Emulated TalonFX with limits, feedback sensor, control loop and status frames.

    All values have robot code's sign, unless the description of the value says otherwise.

    Args:
        address: CAN ID and bus.
        clock: Clock of simulated time.
        defaults: Factory configuration, by setting number.
        devices: Devices on the same bus, by (`DeviceType` number, CAN ID), including remote sensors and leaders.
    """

    model = "talon fx"
    type_number = 4
    signals = SIGNALS

    def __init__(
        self, address: DeviceAddress, clock: SimulatedClock, defaults: Mapping[int, Setting], devices: Devices
    ) -> None:
        super().__init__(address, clock, defaults)
        self.devices = devices
        self.bridge = Bridge(KRAKEN_X60)
        self.forward = TalonLimit(repr(self), forward=True)
        self.reverse = TalonLimit(repr(self), forward=False)
        # rotor
        self.raw = 0.0
        """Rotor position written by physics, counter-clockwise positive [rotations]."""
        self.rotor_rps = 0.0
        """Rotor velocity written by physics, counter-clockwise positive [rotations/s]."""
        self.rotor_acceleration = 0.0
        """Rotor acceleration from physics or from `set_velocity`, counter-clockwise positive [rotations/s^2]."""
        self._written_ns = clock.ns
        self.shift = 0.0
        """Offset of the rotor position from `set_position`, counter-clockwise positive [rotations]."""
        self.rotor_offset = 0.0
        """Configured rotor offset [rotations]."""
        self.sign = 1.0
        """Configured direction of positive rotation: 1 for counter-clockwise, -1 for clockwise."""
        self.turn = 1.0
        """Direction of positive rotation from the configuration or the leader: 1 counter-clockwise, -1 clockwise."""
        self.loop = LoopState()
        """Sensor reading, setpoints and output of the control loop."""
        # request
        self.kind: RequestKind = IDLE
        """Kind of the active request."""
        self.args: tuple[Any, ...] = (0.0,)
        """Values of the active request's fields, in the order of `kind.fields`."""
        self.plan: ControlPlan
        """Control law and output stage of the active request."""
        self.slot = 0
        self.enabled = False
        self.limits_hit = (False, False, False, False)
        """Whether each limit is active: forward soft limit, reverse soft limit, forward switch and reverse switch."""
        self._pending: tuple[int, RequestKind, tuple[Any, ...]] | None = None
        """Send time [ns], request kind and field values of the pending control frame; None if no frame is pending."""
        self._expires: int | None = None
        """Time at which a one-shot request expires [ns]; None for other requests."""
        self._plans: dict[tuple[str, int, bool], ControlPlan] = {}
        self._follow: Callable[[int], None] | None = None
        self._seen_ns = -1
        """Time of the last remote sensor frame used by the control law [ns]."""
        self._unseen = 0
        """Number of control loops since the last remote sensor frame."""
        self._limit_flags: tuple[bool, ...] = (False, False, False, False)
        self._has_warned = False
        self.configured()
        self.send_frame()

    # ---- configuration

    def configured(self) -> None:
        """Apply the configuration to the bridge, limits and feedback sensor, and apply the active request again."""
        self.sign = self.turn = -1.0 if self.config[SpnValue.CONFIG_INVERTED.value] else 1.0
        self.rotor_offset = self.config.get(SpnValue.CONFIG_FEEDBACK_ROTOR_OFFSET.value, 0.0)
        self._autosets = any(
            self.config[spn.value]
            for spn in (
                SpnValue.CONFIG_FORWARD_LIMIT_AUTOSET_POS_ENABLE,
                SpnValue.CONFIG_REVERSE_LIMIT_AUTOSET_POS_ENABLE,
            )
        )
        self.bridge.configure(self.config)
        self.forward.configure(self.config)
        self.reverse.configure(self.config)
        self._limits_are_plain = self.forward.is_plain and self.reverse.is_plain
        self._plans.clear()
        self.resolve()
        self._accept(self.kind, self.args)

    def resolve(self) -> None:
        """Find the configured feedback sensor and the leader.

        The emulator calls this method after each new device, because robot code may build a sensor or leader later.
        """
        self.feedback = feedback_of(self, self.config)
        self.measure = self.feedback.measure
        self._follow = following(self)

    def command(self, spn: int, value: float) -> None:
        """Execute the `set_position` command, with the new position in mechanism rotations.

        Raises:
            NotImplementedError: The command is not modelled.
        """
        if spn == SpnValue.TALON_FX_SET_SENSOR_POSITION.value:
            self.set_position(value)
        else:
            super().command(spn, value)

    def set_position(self, position: float) -> None:
        """Set the present position that robot code reads [mechanism rotations].

        With a remote, fused or synced sensor, the method has no effect except for a warning at the first call.
        """
        if not self.feedback.is_rotor:
            if not self._has_warned:
                _log.warning("%r: set_position() does nothing with a remote sensor, as in CTRE's simulation", self)
            self._has_warned = True
            return
        ratio = self.config[SpnValue.CONFIG_SENSOR_TO_MECHANISM_RATIO.value] or 1.0
        self.shift += self.turn * (position * ratio - self.rotor_position)
        self.measure()

    # ---- requests

    def receive(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        """Store a control request for the next control frame, or a one-shot request for the next step.

        Raises:
            NonFiniteError: A field is NaN.
        """
        total = sum(args)
        if total != total:
            wrong = ", ".join(name for name, at in kind.slots.items() if args[at] != args[at])
            raise NonFiniteError(f"{self!r}: {kind.name}: {wrong or 'a field'} must be a number, got nan")
        pending = self._pending
        hz = args[0]
        if pending is None:
            if kind is self.kind and args == self.args and hz != 0.0:
                return
        elif pending[1] is kind and pending[2] == args:
            return
        now = self.clock.ns
        if hz == 0.0:
            self._pending = (now, kind, args)
            return
        if pending is not None and pending[1].name == kind.name:
            self._pending = (pending[0], kind, args)  # the pending frame carries the newest values
            return
        period = period_of(hz) * LOOP_NS
        phase = min(_CONTROL_PHASE_NS, period - LOOP_NS)
        self._pending = ((now - phase + period - 1) // period * period + phase, kind, args)

    def apply(self, kind: str, **values: float) -> None:
        """Apply a request immediately, without the latency of a control frame, and discard any pending request.

        Args:
            kind: Name of the request, for example "VelocityVoltage".
            **values: Request fields; omitted fields get the library's defaults.
        """
        request = REQUESTS[kind]
        self._pending = None
        self._accept(request, tuple(values.get(f, _DEFAULTS.get(f, 0.0)) for f in request.fields))

    def renew(self, kind: RequestKind, foc: bool) -> bool:
        """Renew the lifetime of the active one-shot request if the kind and the FOC setting match.

        Args:
            kind: Kind of the repeated request.
            foc: Whether the repeated request enables FOC.

        Returns:
            Whether the method renewed the request. If so, the caller may change the setpoints in `loop` directly.
        """
        if self.kind is not kind or self._pending is not None or self._expires is None:
            return False
        place = kind.slots.get("enable_foc")
        if place is not None and bool(self.args[place]) != foc:
            return False
        self._expires = self.clock.ns + _ONE_SHOT_NS
        return True

    def _accept(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        """Make a request the active request, and restart the control loop if the kind of request changes.

        Raises:
            NotImplementedError: The slot uses gain scheduling.
        """
        changed = kind is not self.kind
        self.kind, self.args = kind, args
        self.turn = turning(self)
        field = kind.slots
        self._expires = self.clock.ns + _ONE_SHOT_NS if args[0] == 0.0 and kind is not IDLE else None
        self.slot = slot = int(args[field["slot"]]) if "slot" in field else 0
        foc = bool(args[field["enable_foc"]]) if "enable_foc" in field else True
        plan = self._plans.get((kind.name, slot, foc))
        if plan is None:
            if "slot" in field and self.config[SpnValue.SLOT0_GAIN_SCHED_BEHAVIOR.value + slot]:
                raise NotImplementedError(f"{self!r}: gain scheduling (slot{slot}) is not modelled in simulated time")
            plan = build_plan(self.loop, self.bridge, self.config, kind, slot, foc)
            self._plans[kind.name, slot, foc] = plan
        self.plan = plan
        self._follow = following(self)
        self._take_goals(plan)
        if plan.law is not None:
            self._take_options()
        if changed:
            self.bridge.carry(kind.unit)
            self._begin()

    def _take_goals(self, plan: ControlPlan) -> None:
        """Copy the setpoints and profile limits of the active request to `loop`."""
        axis, args = self.kind.axis, self.args
        if axis is Axis.OPEN:
            self.loop.output = float(args[1])
        elif axis in (Axis.VELOCITY, Axis.MOTION_MAGIC_VELOCITY):
            self.loop.goal_v, self.loop.goal_a = float(args[1]), float(args[2])
        elif axis is Axis.POSITION:
            self.loop.goal_p, self.loop.goal_v = float(args[1]), float(args[2])
        elif plan.profile is not None:
            self.loop.goal_p = float(args[1])
        if plan.profile is not None:
            self.loop.limits = limits_of(self.config, self.kind, args)

    def _take_options(self) -> None:
        """Copy feed-forward, neutral override, deadband, largest duty cycle and limit flags from the active request."""
        bridge, args, field = self.bridge, self.args, self.kind.slots
        self.loop.feed_forward = float(args[field["feed_forward"]]) if "feed_forward" in field else 0.0
        torque = self.kind.unit is Unit.AMPERES
        bridge.override = bool(args[field["override_coast_dur_neutral" if torque else "override_brake_dur_neutral"]])
        bridge.deadband = float(args[field["deadband"]]) if "deadband" in field else 0.0
        bridge.max_duty = float(args[field["max_abs_duty_cycle"]]) if "max_abs_duty_cycle" in field else 1.0
        # the last six fields are the same for every request with output
        self._limit_flags = tuple(bool(flag) for flag in args[-5:-1])

    def _begin(self) -> None:
        """Restart the control loop and all profiles from the present sensor reading."""
        self._unseen = 0
        if self.feedback.remote is not None:
            self._seen_ns = self.feedback.remote.frame_ns
        self.measure()
        self.loop.start()

    # ---- physics

    @property
    def rotor_position(self) -> float:
        """Rotor position with robot code's sign, wrapped to the range from -16384 to 16384 [rotations]."""
        return within_range(self.turn * (self.raw + self.shift) + self.rotor_offset)

    def set_velocity(self, rps: float) -> None:
        """Set the rotor velocity [rotations/s], and derive the acceleration from the previous velocity."""
        elapsed = self.clock.ns - self._written_ns
        if elapsed > 0:
            self.rotor_acceleration = 1e9 * (rps - self.rotor_rps) / elapsed
            self._written_ns += elapsed
        self.rotor_rps = rps

    def set_input(self, name: str, value: float) -> None:
        """Set a `sim_state` or SimDevice input by CTRE's name, with counter-clockwise positive rotor values.

        The units are rotations, rotations/s, rotations/s^2 and V. A new motor type applies the configuration again.

        Raises:
            NotImplementedError: The input is not modelled.
        """
        if name == "RawRotorPosition":
            self.raw = value
        elif name == "RotorVelocity":
            self.set_velocity(value)
        elif name == "RotorAcceleration":
            self.rotor_acceleration = value
        elif name == "SupplyVoltage":
            self.supply = self.bridge.supply = max(value, 4.0)
        elif name == "AddRotorPosition":
            self.raw += value
        elif name == "ForwardLimit":
            self.forward.closed = value != 0.0
        elif name == "ReverseLimit":
            self.reverse.closed = value != 0.0
        elif name == "MotorType":
            self.bridge.motor = KRAKEN_X44 if value == 1.0 else KRAKEN_X60
            self.configured()
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """Return a `sim_state` value by CTRE's name; None for an unknown name.

        Rotor values and motor voltage are counter-clockwise positive. Torque current and duty cycle have robot code's
        sign.
        """
        bridge = self.bridge
        if name == "MotorVoltage":
            return bridge.volts * self.turn
        if name == "TorqueCurrent":
            return bridge.current
        if name == "SupplyCurrent":
            return supply_current(bridge)
        if name == "DutyCycle":
            return duty(bridge)
        if name == "SupplyVoltage":
            return self.supply
        if name == "RotorPosition":
            return self.turn * self.rotor_position
        if name == "RawRotorPosition":
            return self.raw
        if name == "RotorVelocity":
            return self.rotor_rps
        if name == "RotorAcceleration":
            return self.rotor_acceleration
        if name in ("ForwardLimit", "ReverseLimit"):
            return float((self.forward if name == "ForwardLimit" else self.reverse).closed)
        return None

    # ---- control loop

    def run(self, loops: int, enabled: bool) -> None:
        """Advance by a number of control loops, and apply a pending request when its send time is reached."""
        pending = self._pending
        if pending is not None:
            before = (pending[0] - self.clock.loop_ns + LOOP_NS - 1) // LOOP_NS
            if before < loops:
                self._pending = None
                if before > 0:
                    self._loop(before, enabled)
                    loops -= before
                self._accept(pending[1], pending[2])
        self._loop(loops, enabled)

    def _loop(self, loops: int, enabled: bool) -> None:
        bridge, loop = self.bridge, self.loop
        bridge.rps = self.rotor_rps * self.turn
        if self._expires is not None and self.clock.loop_ns >= self._expires:
            self._accept(IDLE, (0.0,))
        if self._autosets:
            for limit in (self.forward, self.reverse):
                value = limit.autoset(self.devices)
                if value is not None:
                    self.set_position(value)
        if enabled is not self.enabled:
            self.enabled = enabled
            if not enabled:
                bridge.rest()
            self._begin()
        law, stage = self.plan.law, self.plan.stage
        if law is None or stage is None or not enabled:
            self._neutral_or_follow(loops)
            return
        remote = self.feedback.remote
        is_stale = remote is not None and remote.frame_ns == self._seen_ns
        if not is_stale:
            self.measure()
        if self._limits_are_plain and not self.forward.closed and not self.reverse.closed:
            bridge.blocked_forward, bridge.blocked_reverse = self._limit_flags[:2]
        else:
            self._check_limits()
        if self.kind.axis is Axis.OPEN:
            loop.pid_out = law(loops)
        elif self.feedback.is_missing:
            loop.pid_out = 0.0
        elif is_stale:
            self._unseen += loops
        else:
            if remote is not None:
                self._seen_ns = remote.frame_ns
            loop.pid_out = law(loops + self._unseen)
            self._unseen = 0
        stage(loop.pid_out, loops)

    def _neutral_or_follow(self, loops: int) -> None:
        """Apply the leader's output for an enabled follower, and the neutral mode in all other cases."""
        bridge, axis = self.bridge, self.kind.axis
        if not self.enabled:
            coasts = axis is Axis.COAST or (self.kind.unit is Unit.AMPERES and bridge.override)
            bridge.neutral(bridge.brake and not coasts)
        elif self._follow is not None:
            self._follow(loops)
        else:
            bridge.rest()
            bridge.neutral(axis is Axis.BRAKE or (bridge.brake and axis is not Axis.COAST))

    def _check_limits(self) -> None:
        forward, reverse, bridge = self.forward, self.reverse, self.bridge
        no_forward, no_reverse, ignore_hard, ignore_soft = self._limit_flags
        soft_f, hard_f = forward.stops(self.devices, self.loop.pos, ignore_soft, ignore_hard)
        soft_r, hard_r = reverse.stops(self.devices, self.loop.pos, ignore_soft, ignore_hard)
        bridge.blocked_forward = no_forward or soft_f or hard_f
        bridge.blocked_reverse = no_reverse or soft_r or hard_r
        self.limits_hit = (soft_f, soft_r, hard_f, hard_r)

    # ---- status

    def setpoint(self) -> tuple[bool, bool, float] | None:
        """Return the goal of the active closed loop; None without an active closed loop.

        Returns:
            Whether the goal is a velocity, whether the goal is for the rotor instead of a sensor on the bus, and the
            goal. The goal is a velocity [rotations/s] or the distance to the position setpoint [rotations] of the rotor
            or sensor. Rotor goals are counter-clockwise positive.
        """
        feedback, axis = self.feedback, self.kind.axis
        if not self.enabled or feedback.is_missing or self.plan.law is None or axis is Axis.OPEN:
            return None
        is_rotor, turns = feedback.remote is None, self.loop.goal_v
        if not self.plan.on_velocity:
            turns = self.loop.goal_p - feedback.present()
            if self.config[SpnValue.CONFIG_CONTINUOUS_WRAP.value]:
                turns -= math.floor(turns + 0.5)
        return self.plan.on_velocity, is_rotor, turns * feedback.ratio * (self.turn if is_rotor else 1.0)

    def sample(self) -> TalonFrame:
        """Update the sensor reading, and return a status frame with the present state."""
        self.measure()
        return frame_of(self)

    def send_frame(self) -> None:
        """Update the active faults, and store a new status frame for robot code to read."""
        self.fault_flags.set_active(active_faults(self, self.feedback.is_missing))
        super().send_frame()

    def units_of(self, spn: int) -> int:
        """Return the number of the signal that defines the units of signal `spn` in the last frame."""
        return units_number(spn, self.frame)


class EmulatedTalonFXS(EmulatedTalon):
    """Emulated TalonFXS, with neutral output until robot code configures a motor arrangement."""

    model = "talon fxs"
    type_number = 7

    def configured(self) -> None:
        """Apply the configuration, including the motor arrangement.

        Raises:
            NotImplementedError: The motor arrangement is not modelled (a custom brushless motor).
        """
        arrangement = int(self.config[SpnValue.CONFIG_MOTOR_TYPE.value])
        if arrangement and arrangement not in ARRANGEMENTS:
            raise NotImplementedError(f"{self!r}: motor arrangement {arrangement} is not modelled in simulated time")
        self.bridge.motor = ARRANGEMENTS.get(arrangement, KRAKEN_X60)
        self._has_motor = arrangement != 0
        super().configured()

    def set_input(self, name: str, value: float) -> None:
        """Set a `sim_state` input of the TalonFX, except for the motor type.

        Raises:
            NotImplementedError: The input is not modelled, or is the motor type, which the configuration sets.
        """
        if name == "MotorType":
            raise NotImplementedError(f"{self!r}: sim_state input {name!r} is not modelled in simulated time")
        super().set_input(name, value)

    def _loop(self, loops: int, enabled: bool) -> None:
        super()._loop(loops, enabled and self._has_motor)
