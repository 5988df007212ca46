"""Frames between simcore and the extension in a robot program, version 1: docs/bridge.md describes them.

`INPUTS` and `OUTPUTS` are rows of tables in extension.c, in the same order; the place of a name is its kind.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import NamedTuple

from simcore.errors import SimcoreError

__all__ = [
    "CHOOSER", "CLOCK", "END", "ERROR_TEXT", "GOODBYE", "INPUTS", "LOOK", "NEW_DATA", "OUTPUTS", "PROCESS", "SELECT",
    "SIM_VALUE", "TEXTS", "VALUE_NAME", "VERSION", "Record", "VersionError", "frame", "frame_size", "kind", "records",
]  # fmt: skip

VERSION = 1
_HEADER = struct.Struct("<4sIQ")
_RECORD = struct.Struct("<BBHid")
_TEXT = 128  # kinds from here on carry text

INPUTS = (
    *("SetRoboRioVInVoltage", "SetDriverStationEnabled", "SetDriverStationAutonomous", "SetDriverStationTest"),
    *("SetDriverStationEStop", "SetDriverStationFmsAttached", "SetDriverStationDsAttached"),
    *("SetDriverStationAllianceStationId", "SetDriverStationMatchTime", "SetMatchType", "SetMatchNumber"),
    *("SetReplayNumber", "SetJoystickAxisCount", "SetJoystickPOVCount", "SetJoystickButtonCount", "SetJoystickAxis"),
    *("SetJoystickPOV", "SetJoystickButtonsValue", "SetEncoderCount", "SetEncoderPeriod", "SetEncoderDirection"),
    *("SetDIOValue", "SetAnalogInVoltage", "SetDutyCycleOutput", "SetAnalogGyroAngle", "SetAnalogGyroRate"),
)
"""What simcore writes, by the name of the HAL's function without `HALSIM_`."""
OUTPUTS = (
    *("GetProgramStarted", "GetDriverStationEnabled", "GetDriverStationAutonomous", "GetDriverStationTest"),
    *("GetDriverStationAllianceStationId", "GetPWMInitialized", "GetPWMSpeed", "GetPWMPosition"),
    *("GetPWMPulseMicrosecond", "GetDIOInitialized", "GetDIOIsInput", "GetDIOValue", "GetAnalogInInitialized"),
    *("GetAnalogGyroInitialized", "GetAnalogGyroAngle", "GetRelayInitializedForward", "GetRelayInitializedReverse"),
    *("GetRelayForward", "GetRelayReverse", "GetEncoderDigitalChannelA", "GetEncoderDigitalChannelB"),
    *("GetEncoderInitialized", "GetEncoderDistancePerPulse", "GetEncoderReset", "GetDutyCycleDigitalChannel"),
    *("GetDutyCycleInitialized", "GetCTREPCMInitialized", "GetCTREPCMSolenoidOutput", "GetREVPHInitialized"),
    "GetREVPHSolenoidOutput",
)
"""What the program is asked after each step; it answers with what has changed, from 0 at first."""
TEXTS = ("SetGameSpecificMessage", "SetEventName")
SIM_VALUE, NEW_DATA, CLOCK, END, LOOK, PROCESS = range(100, 106)
"""Value of a SimDevice; the driver station has sent; the clock goes by itself (1) or is stepped (0); the program ends;
asks for the choosers; id of the program's process."""
VALUE_NAME, CHOOSER, ERROR_TEXT = range(_TEXT, _TEXT + 3)
"""Texts of the program, parts with zeros between: device and value; key, type, default, active, options; an error."""
SELECT, GOODBYE = _TEXT + 10, _TEXT + 11
"""Texts for the program besides `TEXTS`: key and option of a chooser; why it ends."""


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


def kind(name: str) -> int:
    """Return the kind of a value or text that simcore writes."""
    return INPUTS.index(name) if name in INPUTS else _TEXT + TEXTS.index(name)


def frame(time: int, values: list[Record]) -> bytes:
    """Return a frame for the program.

    Args:
        time: By how much its clock is stepped [us].
        values: In the order in which they are written.
    """
    body = b"".join(_RECORD.pack(r.kind, r.sub, len(r.text), r.number, r.value) + r.text for r in values)
    return _HEADER.pack(b"SCB%d" % VERSION, len(body), time) + body


def frame_size(header: bytes) -> tuple[int, int]:
    """Return the size of what follows a header [bytes], and its time [us].

    Raises:
        VersionError: It is a header of another version, or of something else.
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


HEADER_SIZE = _HEADER.size


def records(body: bytes) -> Iterator[Record]:
    """Yield the records of a frame."""
    at = 0
    while at + _RECORD.size <= len(body):
        code, sub, size, number, value = _RECORD.unpack_from(body, at)
        at += _RECORD.size
        yield Record(code, sub, number, value, body[at : at + size])
        at += size
