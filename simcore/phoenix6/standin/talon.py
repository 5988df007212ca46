"""A motor controller with its motor: TalonFX and TalonFXS."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from phoenix6.signals import ControlModeValue
from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6.standin import laws
from simcore.phoenix6.standin.bridge import Bridge
from simcore.phoenix6.standin.clock import LOOP_NS, SimulatedClock
from simcore.phoenix6.standin.device import Device, period_of
from simcore.phoenix6.standin.electrical import KRAKEN_X44, KRAKEN_X60
from simcore.phoenix6.standin.gains import gains_of
from simcore.phoenix6.standin.profile import Trapezoid
from simcore.phoenix6.standin.requests import REQUESTS, Axis, RequestKind, Unit
from simcore.phoenix6.standin.wire import Setting

if TYPE_CHECKING:
    from simcore.phoenix6.standin.world import StandIn

__all__ = ["Talon", "TalonFrame"]

_HALF_RANGE = 16384.0
CONTROL_PHASE_NS = 4_000_000
"""When in their period control frames go out: robot code at a multiple of the period waits this long."""
ONE_SHOT_NS = 100_000_000
"""How long a device obeys a request that is sent once."""


class TalonFrame(NamedTuple):
    """What a motor controller tells robot code, in robot code's signs."""

    position: float
    velocity: float
    acceleration: float
    rotor_position: float
    rotor_velocity: float
    volts: float
    current: float
    supply_current: float
    supply: float
    duty: float
    ref_p: float
    ref_v: float
    ref_a: float
    err: float
    derr: float
    integral: float


class Talon(Device):
    """One motor controller.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
        world: Where remote sensors and leaders are found.
    """

    model = "talon fx"
    type_number = 4

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting], world: StandIn) -> None:
        super().__init__(device_id, clock, defaults)
        self._world = world
        self.bridge = Bridge(KRAKEN_X60)
        self.raw = 0.0
        """Rotor position as physics writes it, counter-clockwise [rotations]."""
        self.rotor_rps = 0.0
        """Rotor velocity as physics writes it, counter-clockwise [rotations/s]."""
        self.rotor_acceleration = 0.0
        self.forward_closed = self.reverse_closed = False
        self.enabled = False
        self.pos = self.vel = self.acc = 0.0
        self.output = self.goal_p = self.goal_v = self.goal_a = self.feed_forward = 0.0
        self.integral = self.err = self.derr = 0.0
        self.ref_p = self.ref_v = self.ref_a = 0.0
        self.offset = 0.0
        self.profile = Trapezoid()
        self.kind: RequestKind = REQUESTS["Empty"]
        self.args: tuple[Any, ...] = (0.0,)
        self._pending: tuple[int, RequestKind, tuple[Any, ...]] | None = None
        self._expires: int | None = None
        self._laws: dict[Any, Any] = {}
        self._law = None
        self._stage = None
        self.configured()
        self.send_frame()

    # ---- configuration

    def configured(self) -> None:
        c = self.config
        self.sign = -1.0 if c[SpnValue.CONFIG_INVERTED.value] else 1.0
        self._sensor_to_mechanism = c[SpnValue.CONFIG_SENSOR_TO_MECHANISM_RATIO.value] or 1.0
        self._rotor_to_sensor = c[SpnValue.CONFIG_ROTOR_TO_SENSOR_RATIO.value] or 1.0
        source = c[SpnValue.CONFIG_FEEDBACK_SENSOR_SOURCE.value]
        self._remote = None
        self._ratio = self._sensor_to_mechanism
        if source in (1, 5, 6):
            self._remote = int(c[SpnValue.CONFIG_FEEDBACK_REMOTE_SENSOR_ID.value])
            self._ratio = self._rotor_to_sensor * self._sensor_to_mechanism
        elif source != 0:
            raise NotImplementedError(f"{self!r}: feedback sensor source {source} is not modelled in simulated time")
        self.bridge.configure(c)
        self._laws.clear()
        self._accept(self.kind, self.args)

    def command(self, spn: int, value: float) -> None:
        if spn == SpnValue.TALON_FX_SET_SENSOR_POSITION.value:
            self.set_position(value)
        else:
            super().command(spn, value)

    def set_position(self, position: float) -> None:
        """Call the present position this [mechanism rotations]."""
        self.offset = 0.0
        self.measure()
        self.offset = position - self.pos
        self.measure()

    # ---- physics

    def set_input(self, name: str, value: float) -> None:
        if name == "RawRotorPosition":
            self.raw = value
        elif name == "RotorVelocity":
            self.rotor_rps = value
        elif name == "RotorAcceleration":
            self.rotor_acceleration = value
        elif name == "SupplyVoltage":
            self.supply = self.bridge.supply = max(value, 4.0)
        elif name == "AddRotorPosition":
            self.raw += value
        elif name == "ForwardLimit":
            self.forward_closed = value != 0.0
        elif name == "ReverseLimit":
            self.reverse_closed = value != 0.0
        elif name == "MotorType":
            self.bridge.set_motor(KRAKEN_X44 if value == 1.0 else KRAKEN_X60)
            self.configured()
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        bridge = self.bridge
        if name == "MotorVoltage":
            return bridge.volts * self.sign
        if name == "TorqueCurrent":
            return bridge.current * self.sign
        if name == "SupplyCurrent":
            return bridge.supply_current
        return None

    # ---- control

    def receive(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        """A control request of robot code; it takes effect with the next control frame."""
        pending = self._pending
        if pending is None:
            if kind is self.kind and args == self.args and args[0] != 0.0:
                return
        elif pending[1] is kind and pending[2] == args:
            return
        now = self.clock.ns
        hz = args[0]
        if hz == 0.0:
            self._pending = (now, kind, args)
            return
        period = period_of(hz) * LOOP_NS
        phase = min(CONTROL_PHASE_NS, period - LOOP_NS)
        due = (now - phase + period - 1) // period * period + phase
        self._pending = (due, kind, args)

    def apply(self, kind: str, **values: float) -> None:
        """Obey a request at once, without the latency of a control frame; fields that are not named are zero."""
        request = REQUESTS[kind]
        args = tuple(values.get(field, 0.0) for field in request.fields)
        self._pending = None
        self._accept(request, args)

    def _accept(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        changed = kind is not self.kind
        self.kind, self.args = kind, args
        field = kind.slots
        get = lambda name, default=0.0: args[field[name]] if name in field else default  # noqa: E731
        self._expires = self.clock.ns + ONE_SHOT_NS if args[0] == 0.0 else None
        axis = kind.axis
        self.feed_forward = get("feed_forward")
        if axis is Axis.OPEN:
            self.output = float(get("output"))
        elif axis is Axis.VELOCITY:
            self.goal_v, self.goal_a = float(get("velocity")), float(get("acceleration"))
        elif axis is Axis.POSITION:
            self.goal_p, self.goal_v = float(get("position")), float(get("velocity"))
        elif axis is Axis.MOTION_MAGIC:
            self.goal_p = float(get("position"))
        slot = int(get("slot", 0))
        key = (kind.name, slot, bool(get("enable_foc", True)))
        if changed:
            self.integral = 0.0
            if axis is Axis.MOTION_MAGIC:
                self.measure()
                self.profile.start(self.pos, self.vel)
        built = self._laws.get(key)
        if built is None:
            built = self._laws[key] = self._build(kind, slot, key[2])
        self._law, self._stage = built

    def _build(self, kind: RequestKind, slot: int, foc: bool) -> tuple[Any, Any]:
        c = self.config
        gains = gains_of(c, slot)
        wrap = bool(c[SpnValue.CONFIG_CONTINUOUS_WRAP.value])
        law: laws.Law | None
        if kind.axis is Axis.OPEN:
            law = laws.open_loop(self)
        elif kind.axis is Axis.POSITION:
            law = laws.position(self, gains, wrap)
        elif kind.axis is Axis.VELOCITY:
            law = laws.velocity(self, gains)
        elif kind.axis is Axis.MOTION_MAGIC:
            cruise = c[SpnValue.CONFIG_MOTION_MAGIC_CRUISE_VELOCITY.value]
            acceleration = c[SpnValue.CONFIG_MOTION_MAGIC_ACCELERATION.value]
            law = laws.motion_magic(self, gains, wrap, self.profile, cruise, acceleration)
        elif kind.axis in (Axis.NEUTRAL, Axis.BRAKE, Axis.COAST, Axis.MUSIC):
            return None, None
        else:
            raise NotImplementedError(f"control request {kind.name} is not modelled in simulated time")
        return law, self.bridge.stage(
            kind.unit, closed=kind.axis is not Axis.OPEN, foc=foc or kind.unit is Unit.AMPERES
        )

    def measure(self) -> None:
        """Read the sensors."""
        if self._remote is None:
            scale = self.sign / self._sensor_to_mechanism
            self.pos = self.raw * scale + self.offset
        else:
            self.pos = self._world.cancoder(self._remote).position / self._sensor_to_mechanism + self.offset
        scale = self.sign / self._ratio
        self.vel = self.rotor_rps * scale
        self.acc = self.rotor_acceleration * scale

    def run(self, loops: int, enabled: bool) -> None:
        """Advance by this many control loops."""
        pending = self._pending
        if pending is not None:
            before = (pending[0] - self.clock.ns) // LOOP_NS
            if before < loops:
                self._pending = None
                if before > 0:
                    self.run(before, enabled)
                    loops -= before
                self.measure()
                self._accept(pending[1], pending[2])
        self.measure()
        bridge = self.bridge
        bridge.rps = self.rotor_rps * self.sign
        law = self._law
        if enabled and law is not None:
            self._stage(law(loops), loops)  # type: ignore[misc]
        else:
            bridge.neutral(self.kind.axis is Axis.BRAKE or (bridge.brake and self.kind.axis is not Axis.COAST))
            bridge.rest()

    # ---- status

    def sample(self) -> TalonFrame:
        b = self.bridge
        self.measure()
        return TalonFrame(
            self.pos,
            self.vel,
            self.acc,
            self.raw * self.sign,
            self.rotor_rps * self.sign,
            b.volts,
            b.current,
            b.supply_current,
            b.supply,
            b.duty,
            self.ref_p,
            self.ref_v,
            self.ref_a,
            self.err,
            self.derr,
            self.integral,
        )

    signals = {
        SpnValue.PRO_POS_AND_VEL_POSITION.value: lambda f: f.position,
        SpnValue.PRO_POS_AND_VEL_VELOCITY.value: lambda f: f.velocity,
        SpnValue.PRO_POS_AND_VEL_ACCELERATION.value: lambda f: f.acceleration,
        SpnValue.PRO_ROTOR_POS_AND_VEL_POSITION.value: lambda f: f.rotor_position,
        SpnValue.PRO_ROTOR_POS_AND_VEL_VELOCITY.value: lambda f: f.rotor_velocity,
        SpnValue.PRO_MOTOR_OUTPUT_MOTOR_VOLTAGE.value: lambda f: f.volts,
        SpnValue.PRO_MOTOR_OUTPUT_DUTY_CYCLE.value: lambda f: f.duty,
        SpnValue.PRO_MOTOR_OUTPUT_TORQUE_CURRENT.value: lambda f: f.current,
        SpnValue.PRO_SUPPLY_AND_TEMP_STATOR_CURRENT.value: lambda f: f.current,
        SpnValue.PRO_SUPPLY_AND_TEMP_SUPPLY_CURRENT.value: lambda f: f.supply_current,
        SpnValue.PRO_SUPPLY_AND_TEMP_SUPPLY_VOLTAGE.value: lambda f: f.supply,
        SpnValue.PRO_PID_REF_PID_ERR_PID_REF_POSITION.value: lambda f: f.ref_p,
        SpnValue.PRO_PID_REF_PID_ERR_PID_ERR_POSITION.value: lambda f: f.err,
    }


_ = ControlModeValue
