"""The Python functions behind ctypes callbacks.

A ctypes callback prints an exception and goes on. In a test the exception of a request or of a telemetry function shall
reach whoever runs the test, so the function itself is called, not the C function that ctypes made of it.
"""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Callable
from typing import Any

__all__ = ["Held", "python_function"]

_C_FUNCTION = type(ctypes.CFUNCTYPE(None))


class Held:
    """What a pointer argument of a callback gives: `contents`."""

    __slots__ = ("contents",)

    def __init__(self, contents: Any) -> None:
        self.contents = contents


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
