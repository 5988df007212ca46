"""Measurement of the signs, zeros and distances that robot code assumes for the sensors of swerve modules.

Robot code contains these values only in its arithmetic. Before the first loop, the probe moves each sensor a little and
compares the angles and distances that the swerve modules in robot code return before and after the move. If a module
does not respond, the probe calls the module's `update` and `periodic` methods before each query. If a module still does
not respond, the probe calls the program's loop as well, as on a disabled robot.
"""

from __future__ import annotations

import inspect
import logging
import math
import re
import types
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from simcore.robotcode.program.motor_ports import AnglePort, MotorPort
from simcore.robotcode.program.object_graph import is_foreign

__all__ = ["Belief", "ModulePorts", "probe_modules"]

_log = logging.getLogger(__name__)

_NAME = re.compile(r"(get|module|swerve|current|measured)*(position|state)s?")
_ANGLE = re.compile(
    r"(get|module|swerve|current|measured|absolute|steer(ing)?|turn(ing)?|rotation|azimuth|wheel|encoder)*"
    r"(angle|rotation|rotation2d|azimuth|heading|(steer(ing)?|turn(ing)?|rotation)position)(rad(ians?)?|deg(rees?)?)?"
)
_WAY = re.compile(r"(get|module|swerve|current|measured|drive|wheel)*(distance|driveposition)(m|meters)?")
_READS = re.compile(
    r"(update|refresh|read|poll)((inputs?|sensors?|signals?|encoders?|states?|positions?|module))*|(robot)?periodic"
)
"""Pattern of the names of methods that read sensors, in lower case without underscores."""
_TURNS = (math.tau, 360.0, 1.0)
"""Size of one turn in each unit that programs use for angles: radians, degrees, turns."""
_ANNOTATIONS = ("SwerveModulePosition", "SwerveModuleState")
_TURN = 1.0 / 64.0  # [turns], movement of a steer encoder: less than a turn, and exact for coarse encoders
_LEAST = 1e-6  # smallest change of a returned value that counts


@dataclass(frozen=True, slots=True)
class ModulePorts:
    """Sensor ports of one swerve module; None for a missing encoder."""

    drive: MotorPort
    steer: MotorPort
    encoder: AnglePort | None
    wheel: AnglePort | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Belief:
    """Response of a swerve module's angle and distance in robot code to the module's sensors."""

    zero: float | None = None
    """Module angle while all sensors read zero [rad]; None if the module returns no angle."""
    angle_per_encoder_turn: float = 0.0
    """Module angle per turn of the steer encoder [rad]; 0 if the angle does not depend on the encoder."""
    angle_per_rotor_turn: float = 0.0
    """Module angle per rotor turn of the steer motor [rad]; 0 if the angle does not depend on the rotor."""
    meters_per_rotor_turn: float = 0.0
    """Distance per rotor turn of the drive motor [m]; 0 if the module returns no distance or ignores the rotor."""
    meters_per_wheel_turn: float = 0.0
    """Distance per turn of the wheel encoder [m]; 0 if the module returns no distance or ignores the encoder."""
    says_way: bool = False
    """Whether the module returns a distance."""

    @property
    def hears_angle(self) -> bool:
        """Whether the module's angle in robot code changes with the sensors."""
        return bool(self.angle_per_encoder_turn or self.angle_per_rotor_turn)

    @property
    def hears_way(self) -> bool:
        """Whether the module's distance in robot code changes with the sensors."""
        return bool(self.meters_per_rotor_turn or self.meters_per_wheel_turn)

    @property
    def is_deaf(self) -> bool:
        """Whether the module returns an angle, but no returned value changes with the sensors."""
        return self.zero is not None and not (self.hears_angle or self.hears_way)

    @property
    def is_half_deaf(self) -> bool:
        """Whether the module returns an angle, and a returned angle or distance does not change with the sensors."""
        return self.zero is not None and not (self.hears_angle and (self.hears_way or not self.says_way))


class _Question:
    """Query for the distance and angle of one module in robot code.

    Args:
        ask: Function that returns distance [m] and angle; None for a value that the module does not return.
        turn: One turn in the unit of the angle [-]; None if the unit is unknown.
    """

    def __init__(self, ask: Callable[[], tuple[float | None, float | None]], turn: float | None = math.tau) -> None:
        self.ask = ask
        self.turn = turn


def probe_modules(
    modules: Sequence[Sequence[Any]],
    ports: Sequence[ModulePorts],
    settle: Callable[[], None],
    above: Sequence[Any] = (),
) -> list[Belief]:
    """Return the response of each module's angle and distance in robot code to the sensors; leave the sensors at zero.

    Args:
        modules: For each module, objects that may return the module's position.
        ports: Ports of each module's sensors.
        settle: Function that makes written values visible to robot code.
        above: Objects that contain all modules, innermost first, up to the robot object. An object may return the
            positions of all modules, and its loop may read the sensors.
    """
    questions = [_question(objects) for objects in modules]
    if not all(questions):
        questions = _shared_questions(above, len(modules)) or questions
    reads = [read for objects in modules for made in reversed(objects) for read in _methods(made, _READS)]
    loops = [read for made in above for read in _methods(made, _READS)]
    beliefs = _probe(questions, ports, settle)
    for calls in ([reads] if reads else []) + ([[*reads, *loops]] if loops else []):
        if not any(belief.is_half_deaf for belief in beliefs):
            break

        def settle_and_read(calls: Sequence[Callable[[], Any]] = calls) -> None:
            settle()
            for call in calls:
                _answer(call)

        beliefs = _probe(questions, ports, settle_and_read)
    return beliefs


def _probe(
    questions: Sequence[_Question | None], ports: Sequence[ModulePorts], settle: Callable[[], None]
) -> list[Belief]:
    def read() -> list[tuple[float | None, float | None]]:
        settle()
        return [(None, None) if question is None else question.ask() for question in questions]

    def moved(write: Callable[[ModulePorts, float], None], turns: float) -> list[tuple[float, float]]:
        for port in ports:
            write(port, turns)
        after = read()
        for port in ports:
            write(port, 0.0)
        return [
            (_change(a[0], b[0], None) / turns, _change(a[1], b[1], None if q is None else q.turn) / turns)
            for a, b, q in zip(base, after, questions, strict=True)
        ]

    for port in ports:
        for write in (_drive, _steer, _encoder, _wheel):
            write(port, 0.0)
    base = read()
    by_drive, by_wheel = moved(_drive, 1.0), moved(_wheel, 1.0)
    by_steer, by_encoder = moved(_steer, 1.0), moved(_encoder, _TURN)
    read()
    beliefs = []
    for at, d, w, s, e, question in zip(base, by_drive, by_wheel, by_steer, by_encoder, questions, strict=True):
        turn = None if question is None else question.turn
        radians = math.tau / (_turn_of_number(e[1], s[1]) if turn is None else turn)
        beliefs.append(
            Belief(
                zero=None if at[1] is None else at[1] * radians,
                angle_per_encoder_turn=e[1] * radians,
                angle_per_rotor_turn=s[1] * radians,
                meters_per_rotor_turn=d[0],
                meters_per_wheel_turn=w[0],
                says_way=at[0] is not None,
            )
        )
    return beliefs


def _turn_of_number(per_encoder_turn: float, per_rotor_turn: float) -> float:
    """Return the size of one turn in an angle's unit, inferred from the change per sensor turn; 2 pi if undecided."""
    for turn in _TURNS:
        if math.isclose(abs(per_encoder_turn), turn, rel_tol=0.05):
            return turn
    return next((turn for turn in _TURNS if per_rotor_turn and 5.0 < abs(turn / per_rotor_turn) < 80.0), math.tau)


def _drive(port: ModulePorts, turns: float) -> None:
    port.drive.write(turns, 0.0)


def _steer(port: ModulePorts, turns: float) -> None:
    port.steer.write(turns, 0.0)


def _encoder(port: ModulePorts, turns: float) -> None:
    if port.encoder is not None:
        port.encoder.write(turns * math.tau, 0.0)


def _wheel(port: ModulePorts, turns: float) -> None:
    if port.wheel is not None:
        port.wheel.write(turns * math.tau, 0.0)


def _change(before: float | None, after: float | None, turn: float | None) -> float:
    if before is None or after is None:
        return 0.0
    change = after - before if turn is None else math.remainder(after - before, turn)
    return change if abs(change) > _LEAST else 0.0


def _question(objects: Sequence[Any]) -> _Question | None:
    """Return the query for a module's position or state, else for an angle and a distance; None without an angle."""
    asked = [ask for made in objects for ask in _questions(made, _NAME, _ANNOTATIONS)]
    positions = [ask for ask in asked if _has(ask, "distance")]
    states = [ask for ask in asked if _has(ask, "angle")]
    if states:
        ask = (positions or states)[0]
        return _Question(lambda: _distance_and_angle(ask()))
    angles = [ask for made in objects for ask in _questions(made, _ANGLE, ())]
    turned = [ask for ask in angles if _is_rotation(_answer(ask))]
    numbers = [ask for ask in angles if _is_number(_answer(ask))]
    if not (turned or numbers):
        return None
    ask_angle = (turned or numbers)[0]
    ways = [ask for made in objects for ask in _questions(made, _WAY, ()) if _is_number(_answer(ask))]

    def where() -> tuple[float | None, float | None]:
        angle = ask_angle()
        return float(ways[0]()) if ways else None, float(angle.radians() if turned else angle)

    return _Question(where, math.tau if turned else None)


def _shared_questions(above: Sequence[Any], count: int) -> list[_Question | None]:
    """Return a query per module through a method that returns all positions; empty without such a method."""
    for made in above:
        for ask in _questions(made, _NAME, ()):
            answer = _answer(ask)
            if isinstance(answer, (list, tuple)) and len(answer) == count and _has_position(answer[0]):
                return [_Question(lambda k=k, ask=ask: _distance_and_angle(ask()[k])) for k in range(count)]  # type: ignore[misc]
    return []


def _distance_and_angle(answer: Any) -> tuple[float | None, float | None]:
    distance = getattr(answer, "distance", None)
    return None if distance is None else float(distance), float(answer.angle.radians())


def _has_position(answer: Any) -> bool:
    return type(answer).__name__ in _ANNOTATIONS


def _has(ask: Callable[[], Any], name: str) -> bool:
    answer = _answer(ask)
    return _has_position(answer) and hasattr(answer, name)


def _is_rotation(answer: Any) -> bool:
    return type(answer).__name__ == "Rotation2d"


def _is_number(answer: Any) -> bool:
    return isinstance(answer, (int, float)) and not isinstance(answer, bool)


def _answer(ask: Callable[[], Any]) -> Any:
    """Return the result of a call to robot code, or None if the call raises."""
    try:
        return ask()
    except Exception as error:  # any exception of robot code
        _log.debug("%r does not answer: %s", ask, error)
        return None


def _questions(made: Any, names: re.Pattern[str], annotations: Sequence[str]) -> list[Callable[[], Any]]:
    """List the methods and properties of an object in robot code with a matching name or return annotation."""
    found: list[Callable[[], Any]] = []
    for home in _homes(made):
        for name, part in vars(home).items():
            is_asked = names.fullmatch(_plain(name)) is not None
            if isinstance(part, property) and (is_asked or _is_annotated(part.fget, annotations)):
                found.append(lambda n=name: getattr(made, n))  # type: ignore[misc]
            elif inspect.isfunction(part) and (is_asked or _is_annotated(part, annotations)):
                found += _without_arguments(made, name)
    return found


def _plain(name: str) -> str:
    return name.replace("_", "").lower()


def _methods(made: Any, names: re.Pattern[str]) -> list[Callable[[], Any]]:
    """List methods of an object, or functions of a module, with a matching name and no required argument."""
    found = {
        name: part
        for home in reversed(_homes(made))
        for name, part in vars(home).items()
        if inspect.isfunction(part) and names.fullmatch(_plain(name))
    }
    return [ask for name in found for ask in _without_arguments(made, name)]


def _homes(made: Any) -> list[Any]:
    """Return the classes of an object that belong to the program; for a module, return the module itself."""
    return [made] if isinstance(made, types.ModuleType) else [cls for cls in type(made).__mro__ if not is_foreign(cls)]


def _without_arguments(made: Any, name: str) -> list[Callable[[], Any]]:
    ask = getattr(made, name)
    parameters = inspect.signature(ask).parameters.values()
    is_complete = all(p.default is not p.empty or p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in parameters)
    return [ask] if is_complete else []


def _is_annotated(function: Any, annotations: Sequence[str]) -> bool:
    answer = getattr(function, "__annotations__", {}).get("return", "")
    return (answer if isinstance(answer, str) else getattr(answer, "__name__", "")).split(".")[-1] in annotations
