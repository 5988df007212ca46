"""Decoder of the SPARK MAX and SPARK Flex status frames in a log of URCL (Unofficial REV-Compatible Logger).

URCL revision 3 (2025 and 2026) logs raw CAN frames in the entries `URCL/Raw/Persistent` (ID, 6 bytes),
`URCL/Raw/Periodic` (time in ms, ID, 8 bytes) and `URCL/Raw/Aliases` (JSON). The lowest 6 bits of an ID are the device,
the next 4 bits the frame index, and the higher bits the frame class (46 for periodic frames).

Sources: URCL's `URCLDriver.cpp` and `URCL.java`; AdvantageScope's docs, "Unofficial REV-Compatible Logger", and
AdvantageScope's `spark-frames-2026.ts` for positions and scales of fields. Signal names are AdvantageScope's.
"""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from simcore.calibrate.signals import Signal
from simcore.telemetry.wpilog import TelemetryLog
from simcore.typing import FloatArray

__all__ = ["urcl_signals"]

_PERIODIC = np.dtype([("millis", "<u4"), ("id", "<u2"), ("data", "u1", 8)])
_CLASS = 46
_DUTY, _VOLTS, _AMPS = 0.00003082369457075716, 0.0073260073260073, 0.0366300366300366
"""Resolution of applied output [-], voltage [V] and current [A]."""


def urcl_signals(log: TelemetryLog) -> Iterator[tuple[str, Signal]]:
    """Yield the name and the signal of each SPARK reading: voltages, current, encoder position and velocity.

    Positions are in turns and velocities in rpm unless robot code sets conversion factors.
    """
    for key, column in log.columns.items():
        if not key.endswith("Raw/Periodic"):
            continue
        root = key.removesuffix("Raw/Periodic")
        frames = [
            np.frombuffer(raw[: len(raw) // 14 * 14], _PERIODIC) for raw in map(column.payload, range(len(column)))
        ]
        rows = np.concatenate([np.zeros(0, _PERIODIC), *frames])
        rows = rows[rows["id"] >> 10 == _CLASS]
        names = _aliases(log, f"{root}Raw/Aliases")
        for device in np.unique(rows["id"] & 0x3F).tolist():
            head = f"{root}{names.get(str(device), f'Spark-{device}')}"
            own = rows[rows["id"] & 0x3F == device]
            status, encoder = (own[own["id"] >> 6 & 0xF == index] for index in (0, 2))
            duty, volts, amps = _status(status["data"])
            if len(status):
                times = _seconds(status["millis"])
                for name, values in (("AppliedOutputVoltage", duty * volts), ("InputVoltage", volts),
                                     ("CurrentOutput", amps)):  # fmt: skip
                    yield f"{head}/{name}", Signal(times, values)
            if len(encoder):
                found = np.ascontiguousarray(encoder["data"]).view("<f4").astype(np.float64)
                yield f"{head}/PrimaryEncoderVelocity", Signal(_seconds(encoder["millis"]), found[:, 0])
                yield f"{head}/PrimaryEncoderPosition", Signal(_seconds(encoder["millis"]), found[:, 1])


def _seconds(millis: FloatArray) -> FloatArray:
    times: FloatArray = millis.astype(np.float64) * 1e-3
    return times


def _status(data: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Decode applied output [-], voltage [V] and current [A] from the data of status 0 frames."""
    word = np.ascontiguousarray(data).view("<u8").reshape(-1)
    duty, volts, amps = (word & 0xFFFF).astype(np.uint16).view(np.int16), word >> 16 & 0xFFF, word >> 28 & 0xFFF
    return duty.astype(np.float64) * _DUTY, volts.astype(np.float64) * _VOLTS, amps.astype(np.float64) * _AMPS


def _aliases(log: TelemetryLog, key: str) -> dict[str, str]:
    """Return the device names in an aliases entry by CAN ID, with the CAN ID as a string; empty without aliases."""
    column = log.columns.get(key)
    if column is None or not len(column):
        return {}
    try:
        found = json.loads(column.payload(len(column) - 1) or b"{}")
    except ValueError:
        return {}
    return {str(device): str(name) for device, name in found.items()} if isinstance(found, dict) else {}
