"""Native functions that belong to no device: the hoot log, hoot replay and the orchestra.

Each answers as CTRE's simulation library does (status codes read from Phoenix 6 26.3.0). Nothing is written to disk:
a hoot log is stamped with the time of the wall clock, and simulated time would make no sense in it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from phoenix6.status_code import StatusCode

from simcore.phoenix6_emulator.native_library import NativeLibrary, always, target_of
from simcore.phoenix6_emulator.versions import PREFIX

__all__ = ["LibraryServices"]

_OK = StatusCode.OK.value
_NOT_SUPPORTED = StatusCode.NOT_SUPPORTED.value
_NOT_RUNNING = StatusCode.LOGGER_NOT_RUNNING.value
_NO_ACTION = StatusCode.INVALID_ORCHESTRA_ACTION.value

_WRITTEN = (
    *(f"write_{kind}{many}" for kind in ("boolean", "integer", "float", "double", "string") for many in ("", "_array")),
    "write_raw",
)
_REPLAYED = (
    *(f"get_{kind}{many}" for kind in ("boolean", "integer", "float", "double", "string") for many in ("", "_array")),
    *("get_raw", "get_schema_value", "load_file", "play", "pause", "stop", "step_timing"),
)
"""Functions of `HootReplay` that CTRE's simulation library, which replays nothing, answers with NOT_SUPPORTED."""


@dataclass(slots=True)
class _Orchestra:
    """Music that is played; no sound is made and no motor turns, but time runs in it."""

    instruments: list[int] = field(default_factory=list)
    file: str | None = None
    played: float = 0.0
    """Until the last pause [s]."""
    since: float | None = None
    """When it went on to play [s]; None: it does not."""


class LibraryServices(NativeLibrary):
    """Signal logger, hoot replay and orchestra, as phoenix6 finds them in a native library.

    Args:
        now: Simulated time [s].
    """

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._is_logging = False
        self._schemas: set[tuple[bytes, int]] = set()
        self._orchestras: dict[int, _Orchestra] = {}
        self._numbers = itertools.count(1)
        for name in _WRITTEN:
            setattr(self, f"{PREFIX}platform_{name}", self._written)
        for name in _REPLAYED:
            setattr(self, f"{PREFIX}platform_replay_{name}", lambda *values: _NOT_SUPPORTED)
        for kind in ("alert", "multi_alert"):
            setattr(self, f"{PREFIX}{kind}_create", lambda *values: next(self._numbers))
            for what in ("set_debounce", "set_active", "set_inactive"):
                setattr(self, f"{PREFIX}{kind}_{what}", lambda *values: None)

    # ---- signal logger

    def _written(self, *values: Any) -> int:
        return _OK if self._is_logging else _NOT_RUNNING

    def c_ctre_phoenix6_platform_set_logger_path(self, path: Any) -> int:
        folder = path.value.decode()
        return _OK if not folder or Path(folder).is_dir() else StatusCode.DIRECTORY_MISSING.value

    def c_ctre_phoenix6_platform_start_logger(self) -> int:
        self._is_logging = True
        return _OK

    def c_ctre_phoenix6_platform_stop_logger(self) -> int:
        self._is_logging = False
        self._schemas.clear()  # the next log is another file
        return _OK

    def c_ctre_phoenix6_platform_add_schema(self, name: Any, kind: int, schema: Any, size: int) -> int:
        if not self._is_logging:
            return _NOT_RUNNING
        self._schemas.add((name.value, int(kind)))
        return _OK

    c_ctre_phoenix6_platform_add_schema_string = c_ctre_phoenix6_platform_add_schema

    def c_ctre_phoenix6_platform_has_schema(self, name: Any, kind: int) -> bool:
        return (name.value, int(kind)) in self._schemas

    def c_ctre_phoenix6_platform_write_schema_value(
        self, name: Any, schema: Any, kind: int, data: Any, size: int, latency: float
    ) -> int:
        if not self._is_logging:
            return _NOT_RUNNING
        known = (schema.value.removesuffix(b"[]"), int(kind)) in self._schemas
        return _OK if known else StatusCode.MISSING_SCHEMA.value

    c_ctre_phoenix6_platform_enable_auto_logging = always(_OK)

    # ---- hoot replay: `CANBus(name, "logs/example.hoot")` of generated constants asks for it, and gets none

    c_ctre_phoenix6_platform_replay_is_file_loaded = always(False)
    c_ctre_phoenix6_platform_replay_is_running = always(True)  # nothing can be replayed, but programs may ask that
    c_ctre_phoenix6_platform_replay_is_finished = always(True)
    c_ctre_phoenix6_platform_replay_close_file = always(None)
    c_ctre_phoenix6_platform_replay_set_speed = always(None)

    # ---- orchestra

    def c_ctre_phoenix6_orchestra_Create(self, out: Any) -> int:
        number = next(self._numbers)
        self._orchestras[number] = _Orchestra()
        target_of(out).value = number
        return _OK

    def c_ctre_phoenix6_orchestra_Close(self, number: Any) -> int:
        self._orchestras.pop(_plain(number), None)
        return _OK

    def c_ctre_phoenix6_orchestra_AddDevice(self, number: Any, network: Any, device_hash: int) -> int:
        self._orchestras[_plain(number)].instruments.append(device_hash)
        return _OK

    def c_ctre_phoenix6_orchestra_AddDeviceWithTrack(
        self, number: Any, network: Any, device_hash: int, track: int
    ) -> int:
        return self.c_ctre_phoenix6_orchestra_AddDevice(number, network, device_hash)

    def c_ctre_phoenix6_orchestra_ClearDevices(self, number: Any) -> int:
        self._orchestras[_plain(number)].instruments.clear()
        return _OK

    def c_ctre_phoenix6_orchestra_LoadMusic(self, number: Any, path: Any) -> int:
        orchestra = self._orchestras[_plain(number)]
        name = path.value.decode()
        orchestra.file, orchestra.played, orchestra.since = None, 0.0, None
        if not Path(name).is_file():
            return StatusCode.MUSIC_FILE_NOT_FOUND.value
        orchestra.file = name
        return _OK

    def c_ctre_phoenix6_orchestra_Play(self, number: Any) -> int:
        orchestra = self._orchestras[_plain(number)]
        if orchestra.file is None:
            return _NO_ACTION
        if orchestra.since is None:
            orchestra.since = self._now()
        return _OK

    def c_ctre_phoenix6_orchestra_Pause(self, number: Any) -> int:
        orchestra = self._orchestras[_plain(number)]
        if orchestra.since is None:
            return _NO_ACTION
        orchestra.played += self._now() - orchestra.since
        orchestra.since = None
        return _OK

    def c_ctre_phoenix6_orchestra_Stop(self, number: Any) -> int:
        orchestra = self._orchestras[_plain(number)]
        if orchestra.file is None:
            return _NO_ACTION
        orchestra.played, orchestra.since = 0.0, None
        return _OK

    def c_ctre_phoenix6_orchestra_IsPlaying(self, number: Any, out: Any) -> int:
        target_of(out).value = int(self._orchestras[_plain(number)].since is not None)
        return _OK

    def c_ctre_phoenix6_orchestra_GetCurrentTime(self, number: Any, out: Any) -> int:
        orchestra = self._orchestras[_plain(number)]
        running = 0.0 if orchestra.since is None else self._now() - orchestra.since
        target_of(out).value = orchestra.played + running
        return _OK


def _plain(number: Any) -> int:
    """Of a ctypes number or a plain one."""
    return int(getattr(number, "value", number))
