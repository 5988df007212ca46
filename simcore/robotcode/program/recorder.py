"""Record of objects that a program builds: devices of any maker, and WPILib's kinematics, odometry and drive classes.

Recording starts before the program is imported, because libraries store bound methods when an object is built.
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
"""Keyword arguments of a call, by name."""
T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Built:
    """WPILib object that the program has built, with the constructor's arguments."""

    kind: str
    """Kind of object: `kinematics`, `odometry`, `drive` or `group`."""
    name: str
    """Class name in WPILib: `SwerveDrive4Kinematics`."""
    made: Any
    args: tuple[Any, ...]
    settings: dict[str, Any]
    """Keyword arguments of the constructor."""

    def argument(self, place: int, name: str) -> Any:
        """Return a constructor argument by position or keyword; None for an omitted argument."""
        return self.settings.get(name, self.args[place] if len(self.args) > place else None)


_built: list[Built] = []


def built(kind: str, name: str = "") -> list[Built]:
    """List the objects of one kind that the program has built, in build order.

    Args:
        kind: Kind of object, as in `Built.kind`.
        name: Beginning of the class name.
    """
    return [b for b in _built if b.kind == kind and b.name.startswith(name)]


_noted: set[tuple[Any, str, str, str]] = set()


def after_call(owner: Any, method: str, note: Callable[[Any, Any, Arguments, Settings], object]) -> None:
    """Call `note` after each call of a method from now on; safe to call more than once.

    Args:
        owner: Class that has the method.
        method: Name of the method.
        note: Function that takes the object, the result, the arguments and the keyword arguments.
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

    # pybind11 detects an override that calls its base method by the frame's name; another name would recurse
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
    """Check each call of a method that writes to a simulated device with `may_write`; see `Maker.watch_simulations`.

    Args:
        owner: Class that has the method; a new guard replaces an earlier guard.
        method: Name of the method.
        key_of: Function that returns model and address of the device behind the object, or None to let the call pass.
        may_write: Function that takes model and address, and returns whether the call may pass.
        drops: Whether to drop a refused call; if not, `may_write` only records the call.
        dropped: Return value of a dropped call.
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
    """Call `note` with each new object of a class and the constructor's arguments; safe to call more than once."""

    def note_built(made: Any, _: Any, args: Arguments, settings: Settings) -> None:
        note(made, args, settings)

    note_built.__module__, note_built.__qualname__ = note.__module__, note.__qualname__
    after_call(cls, "__init__", note_built)


class Answers(Generic[T]):
    """Replacements for vendor library methods whose simulation is missing or runs on the wall clock.

    Each method is wrapped once. Calls on an attached object of robot code get simcore's reply; calls on any other
    object go to the vendor library.

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
        """Use `answering` as the source of replies for an object of robot code from now on."""
        self._by_object[made] = answering

    def of(self, made: Any) -> T | None:
        """Return the source of replies attached to an object, or None without a source."""
        return self._by_object.get(made)

    def wrap(self, cls: Any, replies: Mapping[str, Callable[..., Any]], *, also_original: bool = False) -> None:
        """Wrap methods of a class; safe to call more than once.

        Args:
            cls: Class of the vendor library.
            replies: Function by method name; takes the attached source of replies and the call's arguments.
            also_original: Whether to call the library's own method first and ignore its result.
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
    """Devices of one maker that the program has built and still refers to.

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
        """Record each new object of a class from now on.

        Args:
            cls: Class of the vendor library.
            model: Model in the maker's spelling.
            address_of: Function that returns an object's address from the object or its constructor arguments; an
                object with a negative number is not recorded.
        """
        record_class(cls, lambda made, args, settings: self.add(model, address_of(made, args, settings), made))

    def add(self, model: str, address: DeviceAddress, made: Any) -> None:
        """Record an object, unless the object is already recorded or the address number is negative."""
        known = self._keys.get(id(made))
        if address.number >= 0 and (known is None or known[0]() is not made):
            reference = weakref.ref(made)
            self._built.append((model, address, reference))
            self._keys[id(made)] = reference, (model, address)

    @property
    def objects(self) -> list[BuiltDevice]:
        """Devices in build order, one per object that still exists."""
        found = [BuiltDevice(model, address, reference()) for model, address, reference in self._built]
        return [device for device in found if device.hardware is not None]

    def devices(self) -> list[BuiltDevice]:
        """List one device per model and address, each with the first object that still exists."""
        found: dict[DeviceKey, BuiltDevice] = {}
        for device in self.objects:
            found.setdefault(device.key, device)
        return list(found.values())

    def find(self, made: Any) -> BuiltDevice | None:
        """Return the device behind an object of robot code, or None if the object is unknown."""
        reference, key = self._keys.get(id(made), (None, None))
        if reference is None or reference() is not made:
            return None
        return next(device for device in self.devices() if device.key == key)


def odometry_classes() -> list[Any]:
    """Return WPILib's odometry and pose estimator classes, 2D and 3D."""
    return [
        getattr(season.wpimath, f"{drive}{kind}{space}")
        for kind in ("Odometry", "PoseEstimator")
        for drive in season.DRIVES
        for space in ("", "3d")
    ]


def watch_program() -> None:
    """Record the WPILib kinematics, odometry, drive and group objects that are built from now on."""
    for drive in season.DRIVES:
        _watch("kinematics", getattr(season.wpimath, f"{drive}Kinematics"))
    for cls in odometry_classes():
        _watch("odometry", cls)
    for name in ("DifferentialDrive", "MecanumDrive"):
        _watch("drive", getattr(season.wpilib, name))
    _watch("group", season.wpilib.MotorControllerGroup)


def _watch(kind: str, cls: Any) -> None:
    record_class(cls, lambda made, args, settings: _built.append(Built(kind, cls.__name__, made, args, settings)))
