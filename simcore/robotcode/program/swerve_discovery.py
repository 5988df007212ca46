"""Discovery of a swerve drivetrain in the program's own classes: modules, positions, sensor signs and zeros."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from simcore.quantities import DeviceKey
from simcore.robotcode.program.belief_probe import Belief, ModulePorts, probe_modules
from simcore.robotcode.program.found_drivetrain import DrivetrainNotFoundError, FoundDrivetrain, FoundWheel, Measure
from simcore.robotcode.program.makers import Maker, MotorFacts, maker_of, makers
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.object_graph import Holder, ObjectGraph, is_foreign
from simcore.robotcode.program.place_names import corner_of
from simcore.robotcode.program.recorder import built

__all__ = ["find_swerve", "free_speed_volts", "motor_measures", "with_beliefs"]

_STEER = re.compile(r"steer|turn|azimuth|angle|angular|rotat|pivot|direction", re.IGNORECASE)
_DRIVE = re.compile(r"driv|speed|propul|wheel|throttle|translat", re.IGNORECASE)
_DEAF = (
    "{} report the same positions whatever their sensors read, so zeros, signs and the wheel are guessed; if the "
    "program reads the sensors only on the real robot (isReal, isSimulation), let it read them in simulation too: "
    "simcore moves them"
)


_OFFSET = re.compile(r"(?<!magnet)(?<!magnet_)offset|zero_?(angle|position|point)|^_*zero$", re.IGNORECASE)
"""Pattern of the offsets that a program subtracts from encoder readings, without magnet offsets of encoders."""
_HALF = 0.28  # [m], x and y distance from the center to a wheel without a known position
_UNPLACED = "no kinematics or settings give the module positions"


def find_swerve(graph: ObjectGraph) -> FoundDrivetrain | None:
    """Find a swerve drive: an object with two motors for each kinematics position, or four steered objects.

    Four objects are enough if the program has no kinematics and no drive class of WPILib.

    Returns:
        Drivetrain, or None if the program has no swerve drive.

    Raises:
        DrivetrainNotFoundError: The program has swerve kinematics but no matching modules.
    """
    kinematics = graph.built("kinematics", "SwerveDrive")  # reachable objects first: PathPlanner builds kinematics, too
    groups = _module_groups(graph)
    for record in kinematics:
        places = [(float(t.x), float(t.y)) for t in record.made.get_modules()]
        modules = next((group for group in groups if len(group) == len(places)), None)
        if modules is not None:
            return _drivetrain(modules, places, record.name)
    if kinematics:
        counts = " or ".join(sorted({str(len(record.made.get_modules())) for record in kinematics}))
        raise DrivetrainNotFoundError(
            f"the program's kinematics have {counts} swerve modules, but no {counts} objects of one class hold two "
            "motors each, nor do names of members tell corner and purpose (front_left_drive, front_left_steer)"
        )
    if any(graph.built(kind, "") for kind in ("drive", "kinematics")):
        return None  # a drivetrain of another kind
    modules = next((group for group in groups if len(group) == 4 and all(map(_is_steered, group))), None)
    return None if modules is None else _drivetrain(modules, [(x, y) for x in (_HALF, -_HALF) for y in (_HALF, -_HALF)])


def _drivetrain(
    modules: Sequence[Holder], places: Sequence[tuple[float, float]], kinematics: str = ""
) -> FoundDrivetrain:
    """Return the drivetrain, with positions assigned to modules by corner names if these are unique, else in order."""
    ordered, is_named = _in_order(modules, places)
    wheels = tuple(_wheel(holder, place) for holder, place in zip(ordered, places, strict=True))
    measures: dict[str, Measure] = {}
    order = f"{' '.join(w.name.split('.')[-1] for w in wheels)}, in the order of the kinematics"
    if not kinematics:
        measures["x and y"] = Measure("0.56 x 0.56 m" + (", by corner" if is_named else ""), _UNPLACED, is_guess=True)
    elif not is_named and not all(holder.name.split(".")[-1].isdigit() for holder in modules):
        measures["x and y"] = Measure(order, "no name gives a corner", is_guess=True)
    about = f"{len(wheels)} modules ({type(modules[0].made).__name__})"
    return FoundDrivetrain(
        kind="swerve",
        wheels=wheels,
        measures=measures,
        kinematics=kinematics,
        about=f"{about} of {kinematics}" if kinematics else f"{about}, without kinematics",
    )


def _module_groups(graph: ObjectGraph) -> list[list[Holder]]:
    """List candidate groups of modules, likeliest first: objects of one class with two motors, or members by corner."""
    holders = graph.holders()
    by_class: dict[tuple[bool, type], list[Holder]] = {}
    for holder in holders:
        motors = _motor_keys(holder)
        if len(motors) != 2:
            continue
        own = type(holder.made)
        bases = [cls for cls in own.__mro__[1:] if not is_foreign(cls)]
        for key in ((False, own), *((True, base) for base in bases)):
            group = by_class.setdefault(key, [])
            if motors.isdisjoint(k for h in group for k in _motor_keys(h)):  # of two with one motor, keep the nearer
                group.append(holder)
    groups = [(is_base, group) for (is_base, _), group in by_class.items()]
    # A container around each module has the module's motors, but only the module gives its position; a program's
    # simulated module may have its own motors, but no encoders.
    groups.sort(key=lambda g: (type(g[1][0].made) in (dict, list, tuple), g[0], -sum(len(h.devices) for h in g[1])))
    return [group for _, group in groups] + [flat for h in reversed(holders) if (flat := _flat_modules(h))]


def _motor_keys(holder: Holder) -> set[DeviceKey]:
    return {d.key for d in holder.devices.values() if _is_motor(d)}


def _flat_modules(holder: Holder) -> list[Holder]:
    """List modules whose motors are members of one object: `front_left_drive`, `drive_motors[0]`, `steer2`."""
    parts: dict[object, dict[str, BuiltDevice]] = {}
    for name, device in holder.devices.items():
        number = re.search(r"\d+", name.split(".")[-1])
        key: object = corner_of(name) or (number[0] if number else None)
        if key is not None and device.key not in {d.key for d in parts.get(key, {}).values()}:
            parts.setdefault(key, {})[name] = device
    modules = []
    for part in parts.values():
        names = [name for name, device in part.items() if _is_motor(device)]
        if len(names) == 2 and {_steers(name) for name in names} in ({1, -1}, {1, 0}, {0, -1}):
            drive = min(names, key=_steers)
            modules.append(Holder(holder.made, f"{holder.name}.{drive}" if holder.name else drive, part))
    return modules if len(modules) > 1 else []


def _is_steered(holder: Holder) -> bool:
    """Return whether an object with two motors is a swerve module, by the name of a steer motor or by an encoder."""
    motors = [name for name, device in holder.devices.items() if _is_motor(device)]
    return any(_steers(name) > 0 for name in motors) or len(motors) < len(holder.devices)


def _steers(name: str) -> int:
    """Return 1 if the attribute path of a motor suggests steering, -1 for driving, 0 for both or neither.

    >>> _steers("turn_motor"), _steers("drive.motor"), _steers("driveTurnMotor")
    (1, -1, 0)
    """
    return bool(_STEER.search(name)) - bool(_DRIVE.search(name))


def _in_order(holders: Sequence[Holder], places: Sequence[tuple[float, float]]) -> tuple[list[Holder], bool]:
    """Return the modules in the order of `places` and True if module names give corners, else as found and False."""
    named = {corner_of(holder.name): holder for holder in holders}
    corners = [(_sign(x), _sign(y)) for x, y in places]
    is_named = len({*corners}) == len(holders) and {*corners} == {*named}
    return ([named[corner] for corner in corners] if is_named else list(holders)), is_named


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
        if device.model == "Encoder" and not _STEER.search(name):
            wheel_encoder = wheel_encoder or device
        else:
            encoder = encoder or device
    if encoder is None and facts.sensor is not None:
        encoder = next((d for maker in makers() for d in maker.built() if d.key == facts.sensor), None)
    return FoundWheel(
        name=holder.name, place=place, motors=(drive,), steer=steer, encoder=encoder, wheel_encoder=wheel_encoder
    )


def _drive_and_steer(motors: Sequence[tuple[str, BuiltDevice]]) -> tuple[BuiltDevice, BuiltDevice]:
    """Return drive and steer motor: by attribute name, else by a loop on an absolute encoder, else in build order."""
    (name_a, a), (name_b, b) = motors

    lean = _steers(name_a) - _steers(name_b)
    if not lean:
        lean = bool(maker_of(a).facts(a).sensor) - bool(maker_of(b).facts(b).sensor)
    if not lean:
        order = [d.key for maker in makers() for d in maker.built()]
        lean = 1 if order.index(a.key) > order.index(b.key) else -1
    return (b, a) if lean > 0 else (a, b)


# --- the program's reading of its sensors -----------------------------------------------------------------------------


def with_beliefs(found: FoundDrivetrain, graph: ObjectGraph) -> FoundDrivetrain:
    """Return the drivetrain with the signs, zeros and measures of robot code, found by moving the sensors.

    Raises:
        ConfigError: A device does not respond.
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

    path = found.wheels[0].name.split(".")
    above = [by_name[name] for k in range(len(path) - 1, -1, -1) if (name := ".".join(path[:k])) in by_name]
    above += graph.modules if len(path) == 1 else []
    beliefs = probe_modules(modules, [_ports(wheel) for wheel in found.wheels], settle, above)
    zeros = _zeros_of_odometry(len(found.wheels))
    guesses: dict[str, Measure] = {}
    if all(belief.zero is None for belief in beliefs) and None in zeros:
        zeros, guesses = _guessed_zeros(modules)
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
        **guesses,
    }
    differences = (_DEAF.format(found.about),) if all(b.is_deaf for b in beliefs) else ()
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
    """Return the module angles passed to the odometry's constructor at zero sensor readings [rad]; None if unknown."""
    for record in reversed(built("odometry", "SwerveDrive")):
        for value in (*record.args, *record.settings.values()):
            if isinstance(value, (list, tuple)) and len(value) == count and hasattr(value[0], "angle"):
                return [float(v.angle.radians()) for v in value]
    return [None] * count


def _guessed_zeros(modules: Sequence[Sequence[Any]]) -> tuple[list[float | None], dict[str, Measure]]:
    """Guess the module angles at zero encoder readings [rad] from offset attributes; 0 without these attributes.

    Returns:
        Angle of each module, and the measure `zeros_deg` with the source of the guess.
    """
    rows = [
        [(n, v) for made in objects for n, v in getattr(made, "__dict__", {}).items() if _OFFSET.search(n)]
        for objects in modules
    ]
    found = [next(((n, v) for n, v in row if hasattr(v, "radians") or type(v) in (int, float)), None) for row in rows]
    if None in found:
        why = "no method returns a module's angle, and no attribute holds its offset"
        return [0.0] * len(modules), {"zeros_deg": Measure("0", why, is_guess=True)}
    name = found[0][0]  # type: ignore[index]
    values = [v.radians() if hasattr(v, "radians") else float(v) for _, v in found]  # type: ignore[misc]
    most = max(map(abs, values))
    if hasattr(found[0][1], "radians") or "rad" in name:  # type: ignore[index]
        unit = 1.0
    else:
        unit = math.radians(1.0) if "deg" in name or most > math.tau else 1.0 if most > 1.0 else math.tau
    zeros = [-v * unit for v in values]
    text = ", ".join(f"{math.degrees(zero):.1f}" for zero in zeros)
    return list(zeros), {"zeros_deg": Measure(text, f"reading minus {name}", is_guess=True)}


def _believed(wheel: FoundWheel, belief: Belief, zero: float | None) -> FoundWheel:
    angle = belief.zero if belief.zero is not None else zero
    by_encoder, by_rotor = belief.angle_per_encoder_turn, belief.angle_per_rotor_turn
    assert wheel.steer is not None
    is_own_sensor = maker_of(wheel.steer).facts(wheel.steer).sensor is not None
    # if the controller closes its loop on the encoder, positive output increases the encoder reading
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
    """Return the configuration of a motor controller as drivetrain measures, by name.

    Args:
        role: `drive` or `steer`, the first word of each name.
        device: Motor controller that represents all controllers of this role.
    """
    facts = maker_of(device).facts(device)
    found = {f"{role}_motor": Measure(facts.motor, f"usual on a {device.model}", facts.is_guess)}
    for name, limit in (("stator_limit", facts.stator_limit), ("supply_limit", facts.supply_limit)):
        if limit is not None:
            found[f"{role}_{name}"] = Measure(limit, f"configured in {device}")
    found[f"{role}_loop"] = Measure("controller" if facts.has_gains else "roboRIO", f"gains of {device}")
    return found


def free_speed_volts(wheel: FoundWheel) -> tuple[Measure, ...]:
    """Return the configured velocity feedforward of a wheel's drive and steer motors at free speed [V]."""
    devices = (wheel.motors[0], *(() if wheel.steer is None else (wheel.steer,)))
    said = [(maker_of(device).facts(device).free_speed_volts, str(device)) for device in devices]
    return tuple(Measure(volts, source) for volts, source in said if volts is not None)


def _way(wheel: FoundWheel, facts: MotorFacts, belief: Belief) -> Mapping[str, Measure]:
    """Return `meters_per_rotor_turn`, the program's distance per turn of the drive motor [m]; empty if unknown."""
    if belief.meters_per_rotor_turn:
        return {"meters_per_rotor_turn": Measure(abs(belief.meters_per_rotor_turn), "the program's own positions")}
    if wheel.wheel_encoder is None and facts.units_per_rotor_turn not in (0.0, 1.0):
        return {
            "meters_per_rotor_turn": Measure(abs(facts.units_per_rotor_turn), f"conversion factor of {wheel.motors[0]}")
        }
    return {}


def _turn(wheel: FoundWheel, facts: MotorFacts, belief: Belief) -> Mapping[str, Measure]:
    """Return the steer gearing from the program or the steer controller's configuration; empty if unknown."""
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
