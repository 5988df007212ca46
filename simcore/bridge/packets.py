"""Frames between simcore and the extension in a robot program, version 1: docs/bridge.md describes them.

The extension knows no port: `definitions` tells it in the first frame which functions of the HAL write and which ask.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import NamedTuple

from simcore.errors import SimcoreError

__all__ = [
    "CHOOSER", "CLOCK", "END", "ERROR_TEXT", "HEADER_SIZE", "INPUTS", "LOOK", "NEW_DATA", "OUTPUTS",
    "PROCESS", "SELECT", "SIM_VALUE", "VALUE_NAME", "VERSION", "Record", "VersionError", "definitions", "frame",
    "frame_size", "records",
]  # fmt: skip

VERSION = 1
_HEADER = struct.Struct("<4sIQ")
HEADER_SIZE = _HEADER.size
"""[bytes]"""
_RECORD = struct.Struct("<BBHid")

_CALLS = ("I", "D", "NI", "ND", "NSI", "NSD", "T")
"""Arguments of a function: index (N), second index (S), and integer (I), number (D) or text (T)."""
INPUTS = {
    "SetRoboRioVInVoltage": "D",
    **{f"SetDriverStation{name}": "I" for name in ("Autonomous", "Test", "Enabled", "EStop", "FmsAttached")},
    **{"SetDriverStationDsAttached": "I", "SetDriverStationAllianceStationId": "I", "SetDriverStationMatchTime": "D"},
    **{"SetMatchType": "I", "SetMatchNumber": "I", "SetReplayNumber": "I"},
    **{"SetGameSpecificMessage": "T", "SetEventName": "T"},
    **{f"SetJoystick{name}Count": "NI" for name in ("Axis", "POV", "Button")},
    **{"SetJoystickAxis": "NSD", "SetJoystickPOV": "NSI", "SetJoystickButtonsValue": "NI"},
    **{"SetEncoderCount": "NI", "SetEncoderPeriod": "ND", "SetEncoderDirection": "NI"},
    **{"SetDIOValue": "NI", "SetAnalogInVoltage": "ND", "SetDutyCycleOutput": "ND"},
    **{"SetAnalogGyroAngle": "ND", "SetAnalogGyroRate": "ND"},
}
"""Arguments of functions that simcore calls, by name without `HALSIM_`; the number of a row is its kind."""
OUTPUTS: dict[str, tuple[str, int, int]] = {
    "GetProgramStarted": ("I", 1, 1),
    **{f"GetDriverStation{name}": ("I", 1, 1) for name in ("Enabled", "Autonomous", "Test", "AllianceStationId")},
    **{"GetPWMInitialized": ("NI", 20, 1), "GetPWMPulseMicrosecond": ("NI", 20, 1)},
    **{"GetPWMSpeed": ("ND", 20, 1), "GetPWMPosition": ("ND", 20, 1)},
    **{f"GetDIO{name}": ("NI", 31, 1) for name in ("Initialized", "IsInput", "Value")},
    **{"GetAnalogInInitialized": ("NI", 8, 1), "GetAnalogGyroInitialized": ("NI", 2, 1)},
    "GetAnalogGyroAngle": ("ND", 2, 1),
    **{f"GetRelay{name}": ("NI", 4, 1) for name in ("InitializedForward", "InitializedReverse", "Forward", "Reverse")},
    **{f"GetEncoder{name}": ("NI", 8, 1) for name in ("DigitalChannelA", "DigitalChannelB", "Initialized", "Reset")},
    "GetEncoderDistancePerPulse": ("ND", 8, 1),
    **{"GetDutyCycleDigitalChannel": ("NI", 8, 1), "GetDutyCycleInitialized": ("NI", 8, 1)},
    **{"GetCTREPCMInitialized": ("NI", 63, 1), "GetCTREPCMSolenoidOutput": ("NSI", 63, 8)},
    **{"GetREVPHInitialized": ("NI", 63, 1), "GetREVPHSolenoidOutput": ("NSI", 63, 16)},
}
"""Values read after each step: arguments, number of indices, and of second indices where the row before is not zero.

The program answers with the values that have changed, from 0 at first.
"""
_DEFINE_INPUT, _DEFINE_OUTPUT = 96, 97
SIM_VALUE, NEW_DATA, CLOCK, END, LOOK, PROCESS = range(100, 106)
"""Value of a SimDevice; the driver station has sent; the clock goes by itself (1) or is stepped (0); the program ends;
asks for the choosers; id of the program's process."""
VALUE_NAME, CHOOSER, ERROR_TEXT = 128, 129, 130
"""Texts of the program: device and value, a zero between; one of a chooser's key, type, default, active and options (1
as second index where it continues); an error."""
SELECT = 138
"""Text for the program: key and option of a chooser, a zero between."""


class VersionError(SimcoreError):
    """The other side is no extension of this version."""


class Record(NamedTuple):
    """One value or text of a frame."""

    kind: int
    sub: int
    number: int
    value: float
    text: bytes = b""

    @property
    def parts(self) -> list[str]:
        """Parts of a text."""
        return self.text.decode("utf-8", "replace").split("\0")


def definitions() -> list[Record]:
    """Return the records of the first frame, which define the rows of `INPUTS` and `OUTPUTS`."""
    inputs = enumerate(INPUTS.items())
    found = [Record(_DEFINE_INPUT, _CALLS.index(call), row, 1.0, name.encode()) for row, (name, call) in inputs]
    rows = OUTPUTS.items()
    return found + [
        Record(_DEFINE_OUTPUT, _CALLS.index(call), count, subs, name.encode()) for name, (call, count, subs) in rows
    ]


def frame(time: int, values: list[Record]) -> bytes:
    """Return a frame for the program.

    Args:
        time: Time step of the program's clock [us].
        values: Records in the order in which they are written.
    """
    body = b"".join(_RECORD.pack(r.kind, r.sub, len(r.text), r.number, r.value) + r.text for r in values)
    return _HEADER.pack(b"SCB%d" % VERSION, len(body), time) + body


def frame_size(header: bytes) -> tuple[int, int]:
    """Return the size of what follows a header [bytes], and its time [us].

    Raises:
        VersionError: The header is of another version, or of something else.
    """
    magic, size, time = _HEADER.unpack(header)
    if magic[:3] != b"SCB":
        raise VersionError(f"what has connected is no extension of simcore: it begins with {magic!r}")
    if magic != b"SCB%d" % VERSION:
        raise VersionError(
            f"the program has an extension of version {magic[3:].decode('latin-1')}, this simcore is of version "
            f"{VERSION}: `simcore serve --extension` says where the right one is"
        )
    return size, time


def records(body: bytes) -> Iterator[Record]:
    """Yield the records of a frame."""
    at = 0
    while at + _RECORD.size <= len(body):
        code, sub, size, number, value = _RECORD.unpack_from(body, at)
        at += _RECORD.size
        yield Record(code, sub, number, value, body[at : at + size])
        at += size
