"""Telemetry sink that publishes snapshots on NetworkTables, for AdvantageScope and dashboards."""

from __future__ import annotations

import math
import re
import socket
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from simcore import season
from simcore.errors import ConfigError, OutputError
from simcore.telemetry.columns import Changes
from simcore.telemetry.sinks import Cadence
from simcore.telemetry.snapshot import (
    POSE_TYPE,
    SCHEMA_TYPE,
    STRUCT_SCHEMAS,
    Snapshot,
    checked_integers,
    struct_array_bytes,
)
from simcore.typing import FloatArray, IntArray
from simcore.world.rotation import yaw_of

__all__ = ["NetworkTablesSink", "start_local_server"]


_UNSEEN_PERIOD = 0.1  # [s], shortest time between snapshots on a local instance
_FIELD_PERIOD = 0.1  # [s], time between updates of a `Field2d`, which has an array for each kind of piece
_FIELD_KEY = re.compile(r"Sim(?:/Robots/(\d+))?/Robot/(Pose3d|EstimatedPose)$")
_PIECES = "Sim/GamePieces/"
_KINDS = {
    "double": "double", "int": "integer", "boolean": "boolean", "string": "string", "double[]": "double_array",
    "int[]": "integer_array",
}  # fmt: skip
"""NetworkTables type for each snapshot type; all other types are structs."""
_COLUMNS = {"poses": POSE_TYPE, "doubles": "double", "integers": "int", "booleans": "boolean"}
"""Value type of each snapshot field that is stored in columns."""


class NetworkTablesSink:
    """Publisher of every key of a snapshot under `/`, and of the struct schemas.

    The sink starts no server. A robot program runs a server itself, and other callers use `start_local_server`. On a
    local instance, as under `robotpy test`, only the program itself can read the values, and the sink takes 10
    snapshots per second instead of 50. Values have NetworkTables timestamps, like the values of the robot program; a
    log has simulated time.
    """

    def __init__(
        self, instance: season.NetworkTables, *, period: float = 0.02, stays: bool = False, field: str | None = None
    ) -> None:
        """Publish the struct schemas; each topic is published when its key first appears.

        Args:
            instance: NetworkTables instance, owned by the caller.
            period: Simulated time between two snapshots [s]; in a run faster than real time, ntcore drops values but
                never blocks.
            stays: Whether `close` keeps the last values readable until `withdraw`.
            field: Name of a `Field2d` to publish for dashboards, with the robots' true poses, the first robot's
                estimated pose, and the game pieces; None for a robot program, which publishes a `Field2d` itself.

        Raises:
            ConfigError: The period is not finite or not > 0.
        """
        self._cadence = Cadence(max(period, _UNSEEN_PERIOD) if season.is_local(instance) else period)
        self._instance = instance
        self._options = season.pub_sub_options(periodic=max(period, 0.005))  # ntcore sends every 100 ms by default
        self._publishers: dict[str, Any] = {}
        self._types: dict[str, str] = {}
        self._values: dict[str, object] = {}
        self._arrays: dict[str, FloatArray | IntArray] = {}  # last published arrays
        self._changes = {field: Changes(field) for field in _COLUMNS}
        self._stays = stays
        self._field, self._field_cadence = field, Cadence(_FIELD_PERIOD)
        self.closed = False
        for name, schema in STRUCT_SCHEMAS.items():
            if not instance.has_schema(name):
                instance.add_schema(name, SCHEMA_TYPE, schema)

    def due(self, time: float) -> bool:
        """Return whether a snapshot is due at a simulated time [s]; False after `close`."""
        return not self.closed and self._cadence.due(time)

    def write(self, snapshot: Snapshot) -> None:
        """Publish the changed values of one snapshot without blocking; ntcore sends from its own thread.

        Raises:
            OutputError: The sink is closed.
            ConfigError: An array has the wrong shape, a key is invalid, or the type of a key has changed.
        """
        if self.closed:
            raise OutputError("this NetworkTablesSink is closed; create a new one to publish on")
        self._cadence.take(snapshot.time)
        self._set_columns("poses", snapshot.poses)
        for type_name, arrays in snapshot.struct_arrays:
            for key, rows in arrays.items():
                if self._is_new(key, rows):
                    self._publisher(key, type_name).set(struct_array_bytes(type_name, key, rows))
        self._set_columns("doubles", snapshot.doubles)
        self._set_columns("integers", snapshot.integers)
        self._set_columns("booleans", snapshot.booleans)
        self._set_all("string", snapshot.strings)
        new = {key: ids for key, ids in snapshot.integer_arrays.items() if self._is_new(key, ids)}
        self._set_all("int[]", {key: checked_integers(key, ids).tolist() for key, ids in new.items()})
        if self._field is not None and self._field_cadence.take(snapshot.time):
            self._write_field(self._field, snapshot)

    def _write_field(self, name: str, snapshot: Snapshot) -> None:
        """Publish the topics of a `Field2d`: x, y [m] and heading [deg] for each robot, pose estimate and piece."""
        self._set_all("string", {f"{name}/.type": "Field2d", f"{name}/.name": name})
        objects: dict[str, list[float]] = {}
        for key, pose in snapshot.poses.items():
            found = _FIELD_KEY.match(key)
            if found is not None:
                what = "Robot" if found[2] == "Pose3d" else "Estimate"
                x, y, _, *turn = (float(value) for value in pose)
                yaw = math.degrees(yaw_of((turn[1], turn[2], turn[3], turn[0])))
                objects[f"{name}/{what}{'' if found[1] is None else f' {found[1]}'}"] = [x, y, yaw]
        for key, poses in snapshot.pose_arrays.items():
            if key.startswith(_PIECES):
                flat = np.column_stack((np.asarray(poses)[:, :2], np.zeros(len(poses))))
                objects[f"{name}/{key.removeprefix(_PIECES)}"] = flat.ravel().tolist()
        self._set_all("double[]", objects)

    def close(self) -> None:
        """Stop publishing, and unpublish the topics unless `stays` was set; safe to call more than once."""
        self.closed = True
        if not self._stays:
            self.withdraw()

    def withdraw(self) -> None:
        """Unpublish the topics, but keep the instance; safe to call more than once."""
        for publisher in self._publishers.values():
            publisher.close()
        self._publishers.clear()

    def _set_columns(self, field: str, values: Mapping[str, Any]) -> None:
        """Publish the changed values of one snapshot field that is stored in columns."""
        changes, type_name = self._changes[field], _COLUMNS[field]
        columns, block = changes.of(values)
        for column, value in zip(columns.tolist(), changes.table.values(block), strict=True):
            publisher = self._publisher(changes.table.keys[column], type_name)
            publisher.set(value.tobytes() if type_name == POSE_TYPE else value)

    def _is_new(self, key: str, rows: FloatArray | IntArray) -> bool:
        """Return whether an array may have changed since the last publication: a new object, or a writeable array."""
        is_new = self._arrays.get(key) is not rows or rows.flags.writeable
        self._arrays[key] = rows
        return is_new

    def _set_all(self, type_name: str, values: Mapping[str, object]) -> None:
        last = self._values
        for key, value in values.items():
            publisher = self._publisher(key, type_name)
            if last.get(key) != value:  # ntcore drops equal values, too, but takes 3 us to do so
                last[key] = value
                publisher.set(value)

    def _publisher(self, key: str, type_name: str) -> Any:
        known = self._types.get(key)
        if known == type_name:
            return self._publishers[key]
        if known is not None:
            raise ConfigError(f"{key}: published as {known} before, now as {type_name}; one key has one type")
        if not key or key.startswith("/"):
            raise ConfigError(f"a telemetry key is a name without a leading '/', got {key!r}")
        publisher = self._publish(f"/{key}", type_name)
        self._publishers[key], self._types[key] = publisher, type_name
        return publisher

    def _publish(self, topic: str, type_name: str) -> Any:
        kind = _KINDS.get(type_name)
        if kind is None:
            return self._instance.get_raw_topic(topic).publish(type_name, self._options)
        return getattr(self._instance, f"get_{kind}_topic")(topic).publish(self._options)


def start_local_server(instance: season.NetworkTables, *, port: int = 5810, address: str = "127.0.0.1") -> None:
    """Serve NetworkTables 4 from this process, by default to programs on this computer only.

    The server saves no persistent topics and keeps the NT3 port closed; `instance.stopServer()` stops the server.
    Call this function before publishing: the first call in a process sets the NetworkTables clock to zero, as a robot
    program does, so time axes start at 0 s and not at 1970.

    Args:
        instance: NetworkTables instance that becomes the server.
        port: TCP port; AdvantageScope and dashboards expect 5810.
        address: Address to listen on; an empty string for all network interfaces.

    Raises:
        OutputError: The port is in use; ntcore would only log the failure and continue without a server.
        ConfigError: The port is out of range.
    """
    if not 1 <= port <= 65535:
        raise ConfigError(f"a NetworkTables port is 1 to 65535, got {port}")
    with socket.socket() as probe:
        if sys.platform != "win32":  # on Windows, SO_REUSEADDR would allow binding a port that is in use
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((address, port))
        except OSError as error:
            raise OutputError(
                f"cannot serve NetworkTables on {address or 'any address'}:{port}: {error.strerror or error}. "
                "Another robot program or simulation may be running: end it, or choose another port"
            ) from error
    season.start_server(instance, address, port)
