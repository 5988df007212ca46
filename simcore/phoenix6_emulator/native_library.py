"""What emulated native libraries share: the names of functions, ctypes arguments, and callbacks.

A ctypes callback prints an exception and goes on. In a test the exception of a request or of a telemetry function shall
reach whoever runs the test, so the function itself is called, not the C function that ctypes made of it.
"""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Callable
from typing import Any

from simcore.phoenix6_emulator.versions import PREFIX, RENAMED

__all__ = ["Held", "NativeLibrary", "always", "python_function", "target_of"]

_C_FUNCTION = type(ctypes.CFUNCTYPE(None))


class NativeLibrary:
    """An object with functions, as phoenix6 expects a native library; functions that are not modelled raise."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if name in RENAMED:
            return getattr(self, RENAMED[name])
        plain = name.removeprefix(PREFIX).removeprefix("RequestControl")
        raise NotImplementedError(
            f"Phoenix 6 function {plain} is not modelled in simulated time; --phoenix=real runs the test on CTRE's own "
            "simulation, on the wall clock"
        )


def always(answer: Any) -> Callable[..., Any]:
    """A function of such an object whose answer is the same for whatever arguments."""

    def function(self: NativeLibrary, *values: Any) -> Any:
        return answer

    return function


class Held:
    """A pointer argument of a callback, with its `contents`."""

    __slots__ = ("contents",)

    def __init__(self, contents: Any) -> None:
        self.contents = contents


def target_of(reference: Any) -> Any:
    """The target of a ctypes argument: of `byref(x)` x, and an array itself."""
    return getattr(reference, "_obj", reference)


def python_function(callback: Any) -> Callable[..., Any]:
    """The function that a ctypes callback was made of.

    Args:
        callback: Made by `ctypes.CFUNCTYPE(...)(function)`; anything else is returned as it is.

    Raises:
        TypeError: A C function that no Python function stands behind.
    """
    if not isinstance(type(callback), _C_FUNCTION):
        return callback  # type: ignore[no-any-return]
    # callback -> its keep-alive table -> ctypes' thunk -> the function
    for thunk in (callback._objects or {}).values():
        for found in gc.get_referents(thunk):
            if callable(found) and not isinstance(found, type):
                return found  # type: ignore[no-any-return]
    raise TypeError(f"{callback!r} is not made of a Python function; the simulated drivetrain cannot call it")
