"""LED state of a CANdle from robot code's requests: color of each LED, and a description.

Neither CTRE's simulation nor the emulator models the LEDs, so this module records calls of `set_control`. CTRE does not
document whether a solid color or an animation takes precedence on the same LEDs. In this module, the animation does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from phoenix6.hardware import CANdle

from simcore.quantities import DeviceAddress
from simcore.robotcode.makers.phoenix6.built_devices import address_of
from simcore.robotcode.program.recorder import after_call
from simcore.typing import IntArray

__all__ = ["candle_lights"]

CHANGING_COLORS = -1
"""Color value of LEDs in an animation without a fixed color: rainbow, RGB fade, fire."""

_MOST_LEDS = 400
_ONBOARD = 8


class CANdleLights:
    """LED state of one CANdle after the latest request."""

    def __init__(self) -> None:
        self._solid = np.zeros(_MOST_LEDS, dtype=np.int64)
        self._spans: dict[tuple[int, int], int] = {}
        self._animations: dict[int, tuple[str, int, int, int]] = {}
        self._used = _ONBOARD
        self.changes = 0
        """Number of requests so far that have changed the lights."""

    def note(self, request: Any) -> None:
        """Record a control request of robot code; requests without LEDs are ignored."""
        name = str(request.name)
        if name == "EmptyAnimation":
            self.changes += self._animations.pop(int(request.slot), None) is not None
            return
        if not hasattr(request, "led_start_index"):
            return
        ends = int(request.led_start_index), int(request.led_end_index)
        first, last = max(0, min(ends)), min(_MOST_LEDS - 1, max(ends))
        if first > last:
            return
        color = _rgb(request.color) if hasattr(request, "color") else CHANGING_COLORS
        self._used = max(self._used, last + 1)
        if name == "SolidColor":
            if self._spans.get((first, last)) == color and (self._solid[first : last + 1] == color).all():
                return
            # drop earlier requests whose LEDs are all covered by the new request
            self._spans = {k: v for k, v in self._spans.items() if not (first <= k[0] and k[1] <= last)}
            self._spans[first, last] = color
            self._solid[first : last + 1] = color
            self.changes += 1
            return
        animation = (name, first, last, color)
        if self._animations.get(int(request.slot)) != animation:
            self._animations[int(request.slot)] = animation
            self.changes += 1

    @property
    def colors(self) -> IntArray:
        """Color of each LED as 0xRRGGBB or `CHANGING_COLORS`, up to the last LED used so far, shape (n,)."""
        shown = self._solid[: self._used].copy()
        for _, (_, first, last, color) in sorted(self._animations.items()):
            shown[first : last + 1] = color
        return shown

    @property
    def shows(self) -> str:
        """Description of the active requests, for example `SolidColor 0-7 #00FF00, RainbowAnimation 8-67`."""
        words = [_words("SolidColor", *span, color) for span, color in self._spans.items()]
        words += [_words(*animation) for _, animation in sorted(self._animations.items())]
        return ", ".join(words)


def _words(name: str, first: int, last: int, color: int) -> str:
    text = f"{name} {first}-{last}" if last > first else f"{name} {first}"
    return text if color == CHANGING_COLORS else f"{text} #{color:06X}"


def _rgb(color: Any) -> int:
    """Return an `RGBWColor` as 0xRRGGBB, with white added to each channel, up to 255."""
    r, g, b = (min(255, int(part) + int(color.white)) for part in (color.red, color.green, color.blue))
    return r << 16 | g << 8 | b


_lights: dict[DeviceAddress, CANdleLights] = {}


def candle_lights() -> dict[DeviceAddress, CANdleLights]:
    """Return the LED state of every CANdle that has received a request, by address."""
    return _lights


def _note_request(candle: Any, status: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    if status.is_ok() and candle.device_id >= 0:  # CANdle.none() has a negative ID and is not a device
        request = next(iter((*args, *settings.values())))
        _lights.setdefault(address_of(candle), CANdleLights()).note(request)


after_call(CANdle, "set_control", _note_request)  # record requests from the import of this module on
