"""Methods of a maker's classes that simcore answers: its own simulation does not, or lives on the wall clock.

A method is wrapped once; for an object of robot code that is attached the reply comes from here, for any other from the
maker's library as before.
"""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable, Mapping
from typing import Any, Generic, TypeVar

__all__ = ["Answers"]

T = TypeVar("T")


class Answers(Generic[T]):
    """Which objects of robot code are answered for, and by what.

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
        """What replies for an object; None: nothing does."""
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
                setattr(cls, name, self._wrapped(original, reply, also_original))

    def _wrapped(self, original: Any, reply: Callable[..., Any], also_original: bool) -> Any:
        @functools.wraps(original)
        def answered(made: Any, *args: Any, **settings: Any) -> Any:
            answering = self._by_object.get(made)
            if answering is None:
                return original(made, *args, **settings)
            if also_original:
                original(made, *args, **settings)
            return reply(answering, *args, **settings)

        answered._answers = self  # type: ignore[attr-defined]
        return answered
