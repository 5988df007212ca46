"""Encoding of the frames between simcore and the extension in a robot program, version 1 of `docs/bridge.md`.

The extension has no built-in list of ports. The records of `definitions` in the first frame list the HAL functions that
write inputs and the HAL functions that read outputs.
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
"""Size of a frame's header [bytes]."""
_RECORD = struct.Struct("<BBHid")

_CALLS = ("I", "D", "NI", "ND", "NSI", "NSD", "T")
"""Argument patterns of HAL functions: N is an index, S a second index, I an integer, D a double and T a text."""
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
"""Argument patterns of the HAL functions that write inputs, by name without `HALSIM_`.

The position of a function in the dictionary is the kind of the records for the function.
"""
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
"""HAL functions to read after each step: argument pattern, number of indices and number of second indices.

The extension reads the second indices of an index only if the previous function in the dictionary is not zero at this
index. The extension sends only values that have changed; the initial value is 0.
"""
_DEFINE_INPUT, _DEFINE_OUTPUT = 96, 97
SIM_VALUE, NEW_DATA, CLOCK, END, LOOK, PROCESS = range(100, 106)
"""Kinds of records, in this order: value of a SimDevice; new driver station data; mode of the program's clock (1 runs
freely, 0 is stepped); command to end the program; request for the choosers; process ID of the program."""
VALUE_NAME, CHOOSER, ERROR_TEXT = 128, 129, 130
"""Kinds of texts from the program, in this order: names of a SimDevice and of a value, separated by a zero byte; key,
type, default option, active option or another option of a chooser (second index 0 for the key, otherwise 1); error."""
SELECT = 138
"""Kind of a text to the program: key and selected option of a chooser, separated by a zero byte."""


class VersionError(SimcoreError):
    """Error for a frame from another version of the extension, or from another program."""


class Record(NamedTuple):
    """One value or text of a frame: kind, second index (`sub`), index (`number`), value and text."""

    kind: int
    sub: int
    number: int
    value: float
    text: bytes = b""

    @property
    def parts(self) -> list[str]:
        """Strings in the record's text, split at zero bytes."""
        return self.text.decode("utf-8", "replace").split("\0")


def definitions() -> list[Record]:
    """Return the records that define the functions in `INPUTS` and `OUTPUTS`, for the first frame."""
    inputs = enumerate(INPUTS.items())
    found = [Record(_DEFINE_INPUT, _CALLS.index(call), row, 1.0, name.encode()) for row, (name, call) in inputs]
    rows = OUTPUTS.items()
    return found + [
        Record(_DEFINE_OUTPUT, _CALLS.index(call), count, subs, name.encode()) for name, (call, count, subs) in rows
    ]


def frame(time: int, values: list[Record]) -> bytes:
    """Encode a frame for the program.

    Args:
        time: Time by which the extension steps the program's clock [us].
        values: Records in the order in which the extension applies them.
    """
    body = b"".join(_RECORD.pack(r.kind, r.sub, len(r.text), r.number, r.value) + r.text for r in values)
    return _HEADER.pack(b"SCB%d" % VERSION, len(body), time) + body


def frame_size(header: bytes) -> tuple[int, int]:
    """Return the size of the records after a header [bytes], and the time in the header [us].

    Raises:
        VersionError: If the header is from another version of the extension, or from another program.
    """
    magic, size, time = _HEADER.unpack(header)
    if magic[:3] != b"SCB":
        raise VersionError(
            f"the program that connected does not have simcore's extension: its first bytes are {magic!r}"
        )
    if magic != b"SCB%d" % VERSION:
        raise VersionError(
            f"the program's extension is version {magic[3:].decode('latin-1')}, but this simcore needs version "
            f"{VERSION}: `simcore serve --extension` prints the path of the right one"
        )
    return size, time


def records(body: bytes) -> Iterator[Record]:
    """Yield the records in the body of a frame."""
    at = 0
    while at + _RECORD.size <= len(body):
        code, sub, size, number, value = _RECORD.unpack_from(body, at)
        at += _RECORD.size
        yield Record(code, sub, number, value, body[at : at + size])
        at += size
