"""What robot code makes of its sensors: which way it counts, what it takes for zero, and how far it takes a turn.

A program keeps signs, offsets and wheel sizes in its own arithmetic. So they are asked of the program itself: each
sensor is moved a little before the first loop, and what the module says of its angle and its way is compared. A module
that says what its `update` or `periodic` has read last is asked to read anew.
"""

from __future__ import annotations

import inspect
import logging
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from simcore.devices.motor_ports import AnglePort, MotorPort
from simcore.devices.object_graph import is_foreign

__all__ = ["Belief", "ModulePorts", "probe_modules"]

_log = logging.getLogger(__name__)

_NAME = re.compile(r"(get_?|module_?|swerve_?|current_?|measured_?)*(position|state)s?", re.IGNORECASE)
_READS = re.compile(
    r"(update|refresh|read|poll)(_?(inputs?|sensors?|signals?|encoders?|states?|positions?|module))*|periodic",
    re.IGNORECASE,
)
"""Names of methods after which a module knows what its sensors read."""
_ANNOTATIONS = ("SwerveModulePosition", "SwerveModuleState")
_TURN = 1.0 / 64.0  # [turns] of an encoder on the azimuth: not round it where it counts coarsely
_LEAST = 1e-6


@dataclass(frozen=True, slots=True)
class ModulePorts:
    """The simulated side of one module's sensors."""

    drive: MotorPort
    steer: MotorPort
    encoder: AnglePort | None
    wheel: AnglePort | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Belief:
    """What one module says of its sensors; None: it does not say."""

    zero: float | None = None
    """Angle while all sensors read zero [rad]."""
    angle_per_encoder_turn: float = 0.0
    """[rad]; 0: its angle comes from elsewhere."""
    angle_per_rotor_turn: float = 0.0
    """Of the steer motor [rad]."""
    meters_per_rotor_turn: float = 0.0
    """Of the drive motor [m]; 0: the module does not say how far it has rolled, or not by the rotor."""
    meters_per_wheel_turn: float = 0.0
    """Of an encoder on the wheel [m]."""

    @property
    def is_deaf(self) -> bool:
        """Whether the module says where it is, and the same whatever its sensors read."""
        changes = self.angle_per_encoder_turn, self.angle_per_rotor_turn
        return self.zero is not None and not any((*changes, self.meters_per_rotor_turn, self.meters_per_wheel_turn))


def probe_modules(
    modules: Sequence[Sequence[Any]], ports: Sequence[ModulePorts], settle: Callable[[], None]
) -> list[Belief]:
    """Move the sensors of modules and ask the program what that means; they read zero afterwards.

    Args:
        modules: For each module the objects that may know its position.
        ports: Its sensors.
        settle: Lets robot code see what was written.
    """
    getters = [_getter(objects) for objects in modules]
    beliefs = _probe(getters, ports, settle)
    reads = [read for objects in modules for made in reversed(objects) for read in _methods(made, _READS)]
    if not reads or not all(belief.is_deaf for belief in beliefs):
        return beliefs

    def settle_and_read() -> None:
        settle()
        for read in reads:
            _answer(read)

    return _probe(getters, ports, settle_and_read)


def _probe(
    getters: Sequence[Callable[[], tuple[float | None, float | None]] | None],
    ports: Sequence[ModulePorts],
    settle: Callable[[], None],
) -> list[Belief]:
    def read() -> list[tuple[float | None, float | None]]:
        settle()
        return [(None, None) if get is None else get() for get in getters]

    def moved(write: Callable[[ModulePorts, float], None], turns: float) -> list[tuple[float, float]]:
        for port in ports:
            write(port, turns)
        after = read()
        for port in ports:
            write(port, 0.0)
        return [
            (_change(a[0], b[0], wrap=False) / turns, _change(a[1], b[1], wrap=True) / turns)
            for a, b in zip(base, after, strict=True)
        ]

    for port in ports:
        for write in (_drive, _steer, _encoder, _wheel):
            write(port, 0.0)
    base = read()
    by_drive, by_wheel = moved(_drive, 1.0), moved(_wheel, 1.0)
    by_steer, by_encoder = moved(_steer, 1.0), moved(_encoder, _TURN)
    read()
    return [
        Belief(
            zero=at[1],
            angle_per_encoder_turn=e[1],
            angle_per_rotor_turn=s[1],
            meters_per_rotor_turn=d[0],
            meters_per_wheel_turn=w[0],
        )
        for at, d, w, s, e in zip(base, by_drive, by_wheel, by_steer, by_encoder, strict=True)
    ]


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


def _change(before: float | None, after: float | None, *, wrap: bool) -> float:
    if before is None or after is None:
        return 0.0
    change = math.remainder(after - before, math.tau) if wrap else after - before
    return change if abs(change) > _LEAST else 0.0


def _getter(objects: Sequence[Any]) -> Callable[[], tuple[float | None, float | None]] | None:
    """What says where a module is: way [m] and angle [rad]; None: nothing does."""
    asked = [ask for made in objects for ask in _questions(made)]
    positions = [ask for ask in asked if _has(ask, "distance")]
    states = [ask for ask in asked if _has(ask, "angle")]
    if not states:
        return None
    ask = (positions or states)[0]

    def get() -> tuple[float | None, float | None]:
        answer = ask()
        distance = getattr(answer, "distance", None)
        return None if distance is None else float(distance), float(answer.angle.radians())

    return get


def _has(ask: Callable[[], Any], name: str) -> bool:
    answer = _answer(ask)
    return type(answer).__name__ in _ANNOTATIONS and hasattr(answer, name)


def _answer(ask: Callable[[], Any]) -> Any:
    """What robot code answers; None: it raises."""
    try:
        return ask()
    except Exception as error:  # whatever robot code raises
        _log.debug("%r does not answer: %s", ask, error)
        return None


def _questions(made: Any) -> list[Callable[[], Any]]:
    """Methods and properties of an object of robot code that ask for a position or state, and change nothing."""
    found: list[Callable[[], Any]] = []
    for cls in type(made).__mro__:
        for name, part in vars(cls).items():
            if isinstance(part, property) and (_NAME.fullmatch(name.strip("_")) or _is_annotated(part.fget)):
                found.append(lambda n=name: getattr(made, n))  # type: ignore[misc]
            elif inspect.isfunction(part) and (_NAME.fullmatch(name.strip("_")) or _is_annotated(part)):
                found += _without_arguments(made, name, part)
    return found


def _methods(made: Any, names: re.Pattern[str]) -> list[Callable[[], Any]]:
    """Methods of the program's own class that have such names and need no argument."""
    found = {
        name: part
        for cls in reversed(type(made).__mro__)
        if not is_foreign(cls)
        for name, part in vars(cls).items()
        if inspect.isfunction(part) and names.fullmatch(name.strip("_"))
    }
    return [ask for name, part in found.items() for ask in _without_arguments(made, name, part)]


def _without_arguments(made: Any, name: str, function: Any) -> list[Callable[[], Any]]:
    parameters = list(inspect.signature(function).parameters.values())[1:]
    if all(p.default is not p.empty or p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in parameters):
        return [getattr(made, name)]
    return []


def _is_annotated(function: Any) -> bool:
    answer = getattr(function, "__annotations__", {}).get("return", "")
    return (answer if isinstance(answer, str) else getattr(answer, "__name__", "")).split(".")[-1] in _ANNOTATIONS
