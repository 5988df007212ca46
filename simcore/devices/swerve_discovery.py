"""A swerve drivetrain of the program's own classes: modules, their places, and what they take their sensors for."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from simcore.devices.belief_probe import Belief, ModulePorts, probe_modules
from simcore.devices.found_drivetrain import DrivetrainNotFoundError, FoundDrivetrain, FoundWheel, Measure
from simcore.devices.makers import Maker, MotorFacts, maker_of, makers
from simcore.devices.motor_controllers import BuiltDevice
from simcore.devices.object_graph import Holder, ObjectGraph
from simcore.devices.recorder import built
from simcore.robot.cots import MODULES

__all__ = ["find_swerve", "free_speed_volts", "motor_measures", "with_beliefs"]

_STEER = re.compile(r"steer|turn|azimuth|angle|angular|rotat|pivot|direction", re.IGNORECASE)
_DRIVE = re.compile(r"driv|speed|propul|wheel|throttle|translat", re.IGNORECASE)
_MAXSWERVE = MODULES["REV MAXSwerve"]
_DEAF = (
    "{} says the same position whatever its sensors read, so zeros, signs and the wheel are guessed; if it reads them "
    "on the real robot alone (isReal, isSimulation), let it read them here too: simcore moves them"
)


def find_swerve(graph: ObjectGraph) -> FoundDrivetrain | None:
    """Modules that hold two motors each, as many as the program's kinematics has places; None: there are none.

    Raises:
        DrivetrainNotFoundError: There are kinematics but no modules that fit.
    """
    kinematics = graph.built("kinematics", "SwerveDrive")  # those that it keeps first: PathPlanner builds its own, too
    if not kinematics:
        return None
    holders = _module_holders(graph)
    for record in kinematics:
        places = [(float(t.x), float(t.y)) for t in record.made.get_modules()]
        modules = _matching(holders, places)
        if modules:
            wheels = tuple(_wheel(holder, place) for holder, place in zip(modules, places, strict=True))
            return FoundDrivetrain(
                kind="swerve",
                wheels=wheels,
                about=f"{len(wheels)} modules ({type(modules[0].made).__name__}) of {record.name}",
            )
    counts = " or ".join(str(len(b.made.get_modules())) for b in kinematics)
    raise DrivetrainNotFoundError(
        f"the program has kinematics of {counts} swerve modules, but no {counts} objects with two motors each"
    )


def _module_holders(graph: ObjectGraph) -> list[Holder]:
    """Objects with exactly two motors, innermost where one holds another."""
    found = []
    for holder in graph.holders():
        motors = {d.key for d in holder.devices.values() if _is_motor(d)}
        if len(motors) == 2:
            found.append(holder)
    return found


def _matching(holders: Sequence[Holder], places: Sequence[tuple[float, float]]) -> list[Holder]:
    """As many holders of one class as there are places, each with motors of its own, in the order of the places."""
    by_class: dict[type, list[Holder]] = {}
    for holder in holders:
        group = by_class.setdefault(type(holder.made), [])
        taken = {d.key for h in group for d in h.devices.values() if _is_motor(d)}
        if taken.isdisjoint(d.key for d in holder.devices.values() if _is_motor(d)):
            group.append(holder)
    groups = [g for g in by_class.values() if len(g) == len(places)]
    # a container that holds each module alone has the same motors; the module itself knows its position
    groups.sort(key=lambda g: type(g[0].made) in (dict, list, tuple))
    return _in_order(groups[0], places) if groups else []


def _in_order(holders: Sequence[Holder], places: Sequence[tuple[float, float]]) -> list[Holder]:
    """By their names where these say corners, else as they were found."""
    named: dict[tuple[int, int], Holder] = {}
    for holder in holders:
        corner = _corner(holder.name)
        if corner is None or corner in named:
            return list(holders)
        named[corner] = holder
    try:
        return [named[_sign(x), _sign(y)] for x, y in places]
    except KeyError:
        return list(holders)


def _corner(name: str) -> tuple[int, int] | None:
    """Front or back, left or right, from the last attribute that says both.

    >>> _corner("drive.frontLeft"), _corner("drivetrain.modules.BR"), _corner("swerve.modules.0")
    ((1, 1), (-1, -1), None)
    """
    for part in reversed(name.split(".")):
        words = re.sub(r"([a-z])([A-Z])", r"\1 \2", part).replace("_", " ").lower()
        x = 1 if "front" in words else -1 if re.search("back|rear", words) else 0
        y = 1 if "left" in words else -1 if "right" in words else 0
        if not (x and y):
            short = re.search(r"\b([fbr])([lr])\b", words)
            if short:
                x, y = (1 if short[1] == "f" else -1), (1 if short[2] == "l" else -1)
        if x and y:
            return x, y
    return None


def _sign(value: float) -> int:
    return (value > 1e-6) - (value < -1e-6)


def _is_motor(device: BuiltDevice) -> bool:
    return device.model in maker_of(device).motors


def _wheel(holder: Holder, place: tuple[float, float]) -> FoundWheel:
    motors = {d.key: (name, d) for name, d in reversed(holder.devices.items()) if _is_motor(d)}
    drive, steer = _drive_and_steer(list(motors.values()))
    encoder = wheel_encoder = None
    facts = maker_of(steer).facts(steer)
    for name, device in holder.devices.items():
        if device.model not in maker_of(device).encoders:
            continue
        if device.model == "Encoder" and not _STEER.search(name.split(".")[-1]):
            wheel_encoder = wheel_encoder or device
        else:
            encoder = encoder or device
    if encoder is None and facts.sensor is not None:
        encoder = next((d for maker in makers() for d in maker.built() if d.key == facts.sensor), None)
    return FoundWheel(
        name=holder.name, place=place, motors=(drive,), steer=steer, encoder=encoder, wheel_encoder=wheel_encoder
    )


def _drive_and_steer(motors: Sequence[tuple[str, BuiltDevice]]) -> tuple[BuiltDevice, BuiltDevice]:
    """By what their attributes are called, else by who closes a loop on an absolute encoder, else as they were built.

    `driveTurnMotor` says both and counts for neither.
    """
    (name_a, a), (name_b, b) = motors

    def steers(name: str) -> int:
        return bool(_STEER.search(name)) - bool(_DRIVE.search(name))

    lean = steers(name_a) - steers(name_b)
    if not lean:
        lean = bool(maker_of(a).facts(a).sensor) - bool(maker_of(b).facts(b).sensor)
    if not lean:
        order = [d.key for maker in makers() for d in maker.built()]
        lean = 1 if order.index(a.key) > order.index(b.key) else -1
    return (b, a) if lean > 0 else (a, b)


# --- what the program takes its sensors for ---------------------------------------------------------------------------


def with_beliefs(found: FoundDrivetrain, graph: ObjectGraph) -> FoundDrivetrain:
    """The same with signs, zeros and measures as the program has them, by moving its sensors once.

    Raises:
        ConfigError: A device does not answer.
    """
    asked: list[Maker] = list(dict.fromkeys(maker_of(d) for wheel in found.wheels for d in wheel.devices))
    by_name = {name: made for name, made in graph.objects()}
    modules = [
        [made for name, made in by_name.items() if name == w.name or name.startswith(f"{w.name}.")]
        for w in found.wheels
    ]

    def settle() -> None:
        for maker in asked:
            maker.settle()

    beliefs = probe_modules(modules, [_ports(wheel) for wheel in found.wheels], settle)
    zeros = _zeros_of_odometry(len(found.wheels))
    wheels = tuple(
        _believed(wheel, belief, zero) for wheel, belief, zero in zip(found.wheels, beliefs, zeros, strict=True)
    )
    first = found.wheels[0]
    assert first.steer is not None
    drive, steer = (maker_of(d).facts(d) for d in (first.motors[0], first.steer))
    measures = {
        **motor_measures("drive", first.motors[0]),
        **motor_measures("steer", first.steer),
        **_way(first, drive, beliefs[0]),
        **_turn(first, steer, beliefs[0]),
    }
    differences = (_DEAF.format(type(modules[0][0]).__name__),) if all(b.is_deaf for b in beliefs) else ()
    return replace(
        found,
        wheels=wheels,
        measures={**measures, **found.measures},
        free_speed_volts=free_speed_volts(first),
        differences=(*found.differences, *differences),
    )


def _ports(wheel: FoundWheel) -> ModulePorts:
    assert wheel.steer is not None
    steer = maker_of(wheel.steer).motor_port(wheel.steer)
    return ModulePorts(
        drive=maker_of(wheel.motors[0]).motor_port(wheel.motors[0]),
        steer=steer,
        encoder=None if wheel.encoder is None else maker_of(wheel.encoder).encoder_port(wheel.encoder, steer),
        wheel=None if wheel.wheel_encoder is None else maker_of(wheel.wheel_encoder).encoder_port(wheel.wheel_encoder),
    )


def _zeros_of_odometry(count: int) -> list[float | None]:
    """Angles of the modules with which the program has built its odometry, when its sensors read zero [rad]."""
    for record in reversed(built("odometry", "SwerveDrive")):
        for value in (*record.args, *record.settings.values()):
            if isinstance(value, (list, tuple)) and len(value) == count and hasattr(value[0], "angle"):
                return [float(v.angle.radians()) for v in value]
    return [None] * count


def _believed(wheel: FoundWheel, belief: Belief, zero: float | None) -> FoundWheel:
    angle = belief.zero if belief.zero is not None else zero
    by_encoder, by_rotor = belief.angle_per_encoder_turn, belief.angle_per_rotor_turn
    assert wheel.steer is not None
    is_own_sensor = maker_of(wheel.steer).facts(wheel.steer).sensor is not None
    # where the controller closes its loop on the encoder, its output turns that encoder up
    steers = by_rotor if by_rotor else by_encoder if is_own_sensor else 0.0
    return replace(
        wheel,
        zero=0.0 if angle is None else math.remainder(angle, math.tau),
        drive_sign=_way_of(belief.meters_per_rotor_turn),
        steer_sign=_way_of(steers),
        is_steer_sign_known=steers != 0.0,
        encoder_sign=_way_of(by_encoder),
        encoder_turns=math.tau / abs(by_encoder) if by_encoder and _counts_pulses(wheel.encoder) else 1.0,
        meters_per_encoder_turn=belief.meters_per_wheel_turn or None,
    )


def _counts_pulses(encoder: BuiltDevice | None) -> bool:
    return encoder is not None and encoder.model in maker_of(encoder).pulse_encoders


def _way_of(change: float) -> float:
    return -1.0 if change < 0.0 else 1.0


def motor_measures(role: str, device: BuiltDevice) -> Mapping[str, Measure]:
    """What a controller is configured with, by the names of a drivetrain's measures.

    Args:
        role: `drive` or `steer`.
        device: The first of its kind.
    """
    facts = maker_of(device).facts(device)
    found = {f"{role}_motor": Measure(facts.motor, f"usual on a {device.model}", facts.is_guess)}
    for name, limit in (("stator_limit", facts.stator_limit), ("supply_limit", facts.supply_limit)):
        if limit is not None:
            found[f"{role}_{name}"] = Measure(limit, f"configured in {device}")
    found[f"{role}_loop"] = Measure("controller" if facts.has_gains else "roboRIO", f"gains of {device}")
    return found


def free_speed_volts(wheel: FoundWheel) -> tuple[Measure, ...]:
    """See `FoundDrivetrain.free_speed_volts`; of one wheel's drive and steer motor."""
    devices = (wheel.motors[0], *(() if wheel.steer is None else (wheel.steer,)))
    said = [(maker_of(device).facts(device).free_speed_volts, str(device)) for device in devices]
    return tuple(Measure(volts, source) for volts, source in said if volts is not None)


def _way(wheel: FoundWheel, facts: MotorFacts, belief: Belief) -> Mapping[str, Measure]:
    """Way of one turn of the drive motor's rotor [m], as the program takes it."""
    if belief.meters_per_rotor_turn:
        return {"meters_per_rotor_turn": Measure(abs(belief.meters_per_rotor_turn), "the program's own positions")}
    if wheel.wheel_encoder is None and facts.units_per_rotor_turn not in (0.0, 1.0):
        return {
            "meters_per_rotor_turn": Measure(abs(facts.units_per_rotor_turn), f"conversion factor of {wheel.motors[0]}")
        }
    return {}


def _turn(wheel: FoundWheel, facts: MotorFacts, belief: Belief) -> Mapping[str, Measure]:
    """Gearing of the azimuth."""
    device = wheel.steer
    if belief.angle_per_rotor_turn:
        return {"steer_gearing": Measure(math.tau / abs(belief.angle_per_rotor_turn), "the program's own angles")}
    if facts.rotor_per_sensor is not None:
        return {"steer_gearing": Measure(facts.rotor_per_sensor, f"configured in {device}")}
    units = abs(facts.units_per_rotor_turn)
    for turn in (math.tau, 360.0, 1.0):
        if units not in (0.0, 1.0) and 5.0 < turn / units < 80.0:
            return {"steer_gearing": Measure(turn / units, f"conversion factor of {device}")}
    return {}
