"""Logs of simulated robots in the formats of teams, with known values that `simcore calibrate` must find."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from simcore.calibrate.drive_model import DriveConfig, drive
from simcore.calibrate.runs import TICK, Run

TESTS = ("slow-forward", "slow-backward", "fast-forward", "fast-backward")
STATES = {
    "slow-forward": "quasistatic-forward",
    "slow-backward": "quasistatic-reverse",
    "fast-forward": "dynamic-forward",
    "fast-backward": "dynamic-reverse",
}


def asked(test: str, sides: int = 2, *, seconds: float | None = None) -> Run:
    """Return a SysId run with only its voltage: a ramp of 0.5 V/s or a step of 5 V."""
    is_slow = "slow" in test
    times = np.arange(0.0, seconds or (6.0 if is_slow else 2.4), TICK)
    volts = np.where(times > 0.2, 0.5 * (times - 0.2) if is_slow else 5.0, 0.0)
    volts = (volts if "forward" in test else -volts)[:, None].repeat(sides, axis=1)
    return Run(test, times, volts, np.zeros_like(volts))


def driven(config: DriveConfig, *, noise: float = 0.0, seed: int = 0, tests: Sequence[str] = TESTS) -> list[Run]:
    """Return runs of a drivetrain with encoder noise [m], and voltage noise of 20 times that number [V]."""
    rng, runs = np.random.default_rng(seed), []
    for run in map(asked, tests):
        done = drive(config, run)
        way = done.way + rng.normal(0.0, noise, done.way.shape) if noise else done.way
        way = np.broadcast_to(way, run.way.shape)
        volts = run.volts + 20.0 * rng.normal(0.0, noise, run.volts.shape) * (run.volts != 0.0) if noise else run.volts
        runs.append(replace(run, volts=volts, way=way - way[0], yaw=done.yaw, ground=None, amps=done.amps))
    return runs


def csv_text(runs: Sequence[Run], *, head: str = "test,t_s,left_V,right_V,left_m,right_m,yaw_rad") -> str:
    """Return the CSV table of runs of a tank drive."""
    lines = [head]
    for run in runs:
        yaw = run.yaw if run.yaw is not None else np.zeros(len(run.times))
        rows = np.column_stack([run.times, run.volts, run.way, yaw])
        lines += [f"{run.name}," + ",".join(f"{v:.6f}" for v in row) for row in rows.tolist()]
    return "\n".join(lines) + "\n"


def sysid_json(runs: Sequence[Run], *, per_turn: float, units: str = "Meters", kind: str = "Drivetrain") -> str:
    """Return a file of SysId 2021 to 2023: positions in turns, speeds in turns per second."""
    data: dict[str, object] = {"sysid": True, "test": kind, "units": units, "unitsPerRotation": per_turn}
    for run in runs:
        way = run.way / per_turn
        speed = np.gradient(way, run.times, axis=0)
        columns = [run.times + 100.0, run.volts, way, speed]
        if kind == "Drivetrain":
            yaw = np.zeros(len(way)) if run.yaw is None else run.yaw
            columns += [yaw, np.gradient(yaw, run.times)]
        data[run.name] = np.column_stack(columns).round(6).tolist()
    return json.dumps(data)


class LogFile:
    """Data log written by WPILib's own writer."""

    def __init__(self, path: Path) -> None:
        from wpiutil import DataLogWriter

        self._log, self._entries = DataLogWriter(str(path)), {}

    def put(self, name: str, time: float, value: float | str | bytes, *, type: str = "", metadata: str = "") -> None:
        """Append a value at a time [s]."""
        kind = type or ("string" if isinstance(value, str) else "raw" if isinstance(value, bytes) else "double")
        if name not in self._entries:
            self._entries[name] = self._log.start(name, kind, metadata, 1)
        entry, micros = self._entries[name], round(time * 1e6)
        if isinstance(value, str):
            self._log.appendString(entry, value, micros)
        elif isinstance(value, bytes):
            self._log.appendRaw(entry, value, micros)
        else:
            self._log.appendDouble(entry, value, micros)

    def close(self) -> None:
        """Write the remaining records."""
        self._log.flush()
        self._log.stop()


def sysid_log(path: Path, runs: Sequence[Run]) -> None:
    """Write a log of WPILib's SysIdRoutine, 2024 and later: `<value>-<motor>-<mechanism>`, units as metadata."""
    log, start = LogFile(path), 10.0
    for run in runs:
        for k, time in enumerate((start + run.times).tolist()):
            log.put("sysid-test-state-drive", time, STATES[run.name])
            for side, name in enumerate(("left", "right")):
                log.put(f"voltage-{name}-drive", time, float(run.volts[k, side]), metadata="Volt")
                log.put(f"position-{name}-drive", time, float(run.way[k, side]), metadata="Meter")
        start += float(run.times[-1]) + TICK
        log.put("sysid-test-state-drive", start, "none")
        start += 2.0
    log.close()


def advantagekit_log(path: Path, runs: Sequence[Run], *, radius: float) -> None:
    """Write a log of AdvantageKit's differential drive template: inputs by field, logged when they change."""
    log, start, last = LogFile(path), 20.0, {}

    def put(name: str, time: float, value: float) -> None:
        if last.get(name) != value:
            last[name] = value
            log.put(f"/{name}", time, value, metadata='{"source":"AdvantageKit"}')

    for run in runs:
        for k, time in enumerate((start + run.times).tolist()):
            log.put("/Timestamp", time, 1e6 * time)
            for side, name in enumerate(("Left", "Right")):
                put(f"Drive/{name}PositionRad", time, float(run.way[k, side]) / radius)
                put(f"Drive/{name}VelocityRadPerSec", time, 0.0)
                put(f"Drive/{name}AppliedVolts", time, float(run.volts[k, side]))
            amps = 0.0 if run.amps is None else float(run.amps[k])
            put("SystemStats/BatteryVoltage", time, 12.5 - 0.02 * amps)
            put("PowerDistribution/TotalCurrent", time, amps)
        start += float(run.times[-1]) + 1.0
        for name in ("Left", "Right"):
            put(f"Drive/{name}AppliedVolts", start - 1.0 + TICK, 0.0)
    log.close()


def status_frame(volts: float, bus: float, amps: float) -> bytes:
    """Return status frame 0 of a SPARK with firmware 25 or later by REV's table: 16 bits output, 12 volts, 12 amps."""
    word = round(volts / bus / 0.00003082369457075716) & 0xFFFF
    word |= (round(bus / 0.0073260073260073) & 0xFFF) << 16
    word |= (round(amps / 0.0366300366300366) & 0xFFF) << 28
    return struct.pack("<Q", word)


def urcl_log(path: Path, runs: Sequence[Run], ids: Sequence[int], *, turn: float, aliases: str = "{}") -> None:
    """Write a log of URCL, revision 3: batches of raw CAN frames of SPARKs.

    Args:
        path: File to write.
        runs: Runs of the drivetrain.
        ids: CAN ids of the left and right SPARK.
        turn: Distance per turn of the rotor [m].
        aliases: Names of the SPARKs, as JSON.
    """
    log, start, bus = LogFile(path), 5.0, 12.4
    firmware = b"".join(struct.pack("<H", 9 << 10 | 8 << 6 | device) + bytes([26, 0, 0, 0, 0, 0]) for device in ids)
    log.put("NT:/URCL/Raw/Persistent", start, firmware, type="URCLr3_persistent")
    log.put("NT:/URCL/Raw/Aliases", start, aliases.encode(), type="URCLr3_aliases")
    offset = np.zeros(2)  # encoders continue from the previous run
    for run in runs:
        batch = b""
        for k, time in enumerate((start + run.times).tolist()):
            for side, device in enumerate(ids):
                for index, frame in (
                    (0, status_frame(float(run.volts[k, side]), bus, 3.0)),
                    (2, struct.pack("<ff", 0.0, float(offset[side] + run.way[k, side]) / turn)),
                ):
                    batch += struct.pack("<IH", round(1e3 * time), 46 << 10 | index << 6 | device) + frame
            if k % 5 == 4 or k + 1 == len(run.times):
                log.put("NT:/URCL/Raw/Periodic", time, batch, type="URCLr3_periodic")
                batch = b""
        start += float(run.times[-1]) + 1.0
        offset = offset + run.way[-1]
        rest = b"".join(
            struct.pack("<IH", round(1e3 * (start - 0.98)), 46 << 10 | device) + status_frame(0.0, bus, 0.0)
            for device in ids
        )
        log.put("NT:/URCL/Raw/Periodic", start - 0.98, rest, type="URCLr3_periodic")
    log.close()
