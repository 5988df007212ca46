"""What a program builds and calls: devices of any maker, and WPILib's kinematics, odometry and drive classes.

Classes are watched from before the program is imported, because libraries keep bound methods from the time when an
object is built.
"""

from __future__ import annotations

import functools
import inspect
import weakref
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

from simcore import season
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robotcode.program.motor_controllers import BuiltDevice

__all__ = [
    "Answers", "Arguments", "Built", "BuiltDevices", "Settings", "after_call", "built", "guard", "odometry_classes",
    "record_class", "watch_program",
]  # fmt: skip

Arguments: TypeAlias = tuple[Any, ...]
Settings: TypeAlias = dict[str, Any]
"""Arguments by keyword."""
T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Built:
    """One object that the program has built."""

    kind: str
    """`kinematics`, `odometry`, `drive` or `group`."""
    name: str
    """Of its class in WPILib: `SwerveDrive4Kinematics`."""
    made: Any
    args: tuple[Any, ...]
    settings: dict[str, Any]
    """Arguments by keyword."""

    def argument(self, place: int, name: str) -> Any:
        """Return one argument, whichever way it was given; None: it was not."""
        return self.settings.get(name, self.args[place] if len(self.args) > place else None)


_built: list[Built] = []


def built(kind: str, name: str = "") -> list[Built]:
    """List what the program has built of a kind, first to last.

    Args:
        kind: See `Built.kind`.
        name: With which the name of its class begins.
    """
    return [b for b in _built if b.kind == kind and b.name.startswith(name)]


_noted: set[tuple[Any, str, str, str]] = set()


def after_call(owner: Any, method: str, note: Callable[[Any, Any, Arguments, Settings], object]) -> None:
    """Call `note` after each call of a method from now on; again is harmless.

    Args:
        owner: Class that has the method.
        method: Its name.
        note: Gets the object, the answer, the arguments and those by keyword.
    """
    mark = owner, method, note.__module__, note.__qualname__
    if mark in _noted:
        return
    _noted.add(mark)
    call = getattr(owner, method)

    def noted(made: Any, *args: Any, **settings: Any) -> Any:
        answer = call(made, *args, **settings)
        note(made, answer, args, settings)
        return answer

    # pybind11 asks the frame by its name whether an overriding method calls its base, which else calls it again
    noted.__code__ = noted.__code__.replace(co_name=method)
    setattr(owner, method, functools.wraps(call)(noted))


def guard(
    owner: Any,
    method: str,
    key_of: Callable[[Any], DeviceKey | None],
    may_write: Callable[[DeviceKey], bool],
    *,
    drops: bool = True,
    dropped: object = None,
) -> None:
    """Ask before each call of a method by which a team's own simulation writes; see `Maker.watch_simulations`.

    Args:
        owner: Class that has the method; a guard of before is replaced.
        method: Its name.
        key_of: Model and address of the device, from the object; None: not known, so nobody asks.
        may_write: Gets these.
        drops: Whether a call that may not be is left out; else it is only noted, as one that gives something to write.
        dropped: Answer to a call that is left out.
    """
    call = inspect.unwrap(getattr(owner, method))

    @functools.wraps(call)
    def guarded(made: Any, *args: Any, **settings: Any) -> Any:
        key = key_of(made)
        if key is not None and not may_write(key) and drops:
            return dropped
        return call(made, *args, **settings)

    setattr(owner, method, guarded)


def record_class(cls: Any, note: Callable[[Any, Arguments, Settings], object]) -> None:
    """Call `note` with each object of a class, its arguments and keywords once it is built; again is harmless."""

    def note_built(made: Any, _: Any, args: Arguments, settings: Settings) -> None:
        note(made, args, settings)

    note_built.__module__, note_built.__qualname__ = note.__module__, note.__qualname__
    after_call(cls, "__init__", note_built)


class Answers(Generic[T]):
    """Methods of a maker's classes that simcore answers: its own simulation does not, or lives on the wall clock.

    A method is wrapped once; for an object of robot code that is attached the reply comes from here, for any other from
    the maker's library as before.

    >>> class Gyro:
    ...     def yaw(self):
    ...         return 0.0
    >>> answers = Answers[float]()
    >>> answers.wrap(Gyro, {"yaw": lambda turned: turned})
    >>> here, there = Gyro(), Gyro()
    >>> answers.attach(here, 90.0)
    >>> here.yaw(), there.yaw()
    (90.0, 0.0)
    """

    def __init__(self) -> None:
        self._by_object: weakref.WeakKeyDictionary[Any, T] = weakref.WeakKeyDictionary()

    def attach(self, made: Any, answering: T) -> None:
        """Reply for this object of robot code from now on."""
        self._by_object[made] = answering

    def of(self, made: Any) -> T | None:
        """Return what replies for an object; None: nothing does."""
        return self._by_object.get(made)

    def wrap(self, cls: Any, replies: Mapping[str, Callable[..., Any]], *, also_original: bool = False) -> None:
        """Wrap methods of a class; again is harmless.

        Args:
            cls: Of the maker's library.
            replies: By the name of the method; each gets what was attached, and the arguments.
            also_original: Whether the maker's own method is called as well, before the reply; its answer is dropped.
        """
        for name, reply in replies.items():
            original = getattr(cls, name, None)
            if original is not None and getattr(original, "_answers", None) is not self:
                setattr(cls, name, self._answered(original, reply, also_original))

    def _answered(self, original: Any, reply: Callable[..., Any], also_original: bool) -> Any:
        @functools.wraps(original)
        def answered(made: Any, *args: Any, **settings: Any) -> Any:
            answering = self.of(made)
            if answering is None:
                return original(made, *args, **settings)
            if also_original:
                original(made, *args, **settings)
            return reply(answering, *args, **settings)

        answered._answers = self  # type: ignore[attr-defined]
        return answered


class BuiltDevices:
    """Devices that the program has built, of one maker; what the program drops is no longer there.

    >>> class Motor:
    ...     def __init__(self, number):
    ...         self.number = number
    >>> motors = BuiltDevices()
    >>> motors.record(Motor, "motor", lambda made, args, settings: DeviceAddress(made.number))
    >>> made = Motor(3)
    >>> [str(device) for device in motors.devices()], str(motors.find(made))
    (['motor 3'], 'motor 3')
    """

    def __init__(self) -> None:
        self._built: list[tuple[str, DeviceAddress, weakref.ref[Any]]] = []
        self._keys: dict[int, tuple[weakref.ref[Any], DeviceKey]] = {}

    def record(self, cls: Any, model: str, address_of: Callable[[Any, Arguments, Settings], DeviceAddress]) -> None:
        """Note each object of a class from now on.

        Args:
            cls: Of the maker's library.
            model: As its maker writes it.
            address_of: Of an object, from itself or from what it was built with; with a number below zero it is none.
        """
        record_class(cls, lambda made, args, settings: self.add(model, address_of(made, args, settings), made))

    def add(self, model: str, address: DeviceAddress, made: Any) -> None:
        """Note one object; once is enough."""
        known = self._keys.get(id(made))
        if address.number >= 0 and (known is None or known[0]() is not made):
            reference = weakref.ref(made)
            self._built.append((model, address, reference))
            self._keys[id(made)] = reference, (model, address)

    @property
    def objects(self) -> list[BuiltDevice]:
        """One per object, in the order they were built."""
        found = [BuiltDevice(model, address, reference()) for model, address, reference in self._built]
        return [device for device in found if device.hardware is not None]

    def devices(self) -> list[BuiltDevice]:
        """List one per model and address; the first object where a program has built two."""
        found: dict[DeviceKey, BuiltDevice] = {}
        for device in self.objects:
            found.setdefault(device.key, device)
        return list(found.values())

    def find(self, made: Any) -> BuiltDevice | None:
        """Return the device that an object is, of whatever class a program derived; None: it has not been seen."""
        reference, key = self._keys.get(id(made), (None, None))
        if reference is None or reference() is not made:
            return None
        return next(device for device in self.devices() if device.key == key)


def odometry_classes() -> list[Any]:
    """WPILib's odometry and pose estimators, of the plane and of space."""
    return [
        getattr(season.wpimath, f"{drive}{kind}{space}")
        for kind in ("Odometry", "PoseEstimator")
        for drive in season.DRIVES
        for space in ("", "3d")
    ]


def watch_program() -> None:
    """Note kinematics, odometry and drive classes that are built from now on."""
    for drive in season.DRIVES:
        _watch("kinematics", getattr(season.wpimath, f"{drive}Kinematics"))
    for cls in odometry_classes():
        _watch("odometry", cls)
    for name in ("DifferentialDrive", "MecanumDrive"):
        _watch("drive", getattr(season.wpilib, name))
    _watch("group", season.wpilib.MotorControllerGroup)


def _watch(kind: str, cls: Any) -> None:
    record_class(cls, lambda made, args, settings: _built.append(Built(kind, cls.__name__, made, args, settings)))
