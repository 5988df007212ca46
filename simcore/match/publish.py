"""Telemetry of a match: reads the values of all channels and returns the values of one tick as a `Snapshot`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np

from simcore.channel import FIELD_OF, Channel
from simcore.errors import ConfigError
from simcore.loop.compiled import compiled
from simcore.match.camera_rig import CameraRig
from simcore.match.channels import MATCH, MECHANISM, PART, PIECES, ROBOT
from simcore.match.game import PlayedMatch
from simcore.match.scoring import Score
from simcore.robot.chassis import ground_clearance
from simcore.robot.components import Components, carried
from simcore.robot.fleet_view import FleetView
from simcore.robot.mechanisms import PistonSim, RackSim, ShaftSim
from simcore.robot.robot import Robot
from simcore.robot.robot_config import telemetry_name
from simcore.telemetry.columns import FIELDS, GAP, Columns, Table
from simcore.telemetry.snapshot import Snapshot, robot_prefix
from simcore.typing import FloatArray, IntArray

__all__ = ["Publisher"]

_DECIMALS = 6  # of poses; unrounded, a robot at rest moves by about 1e-9 m, and a log would record every tick


class PublishedMatch(PlayedMatch, Protocol):
    """Match interface that `Publisher` uses."""

    cameras: CameraRig
    ticks: int
    """Number of ticks since the start of the run."""
    last_tick_ms: float | None
    """Wall time of the last tick [ms]; None if not measured."""

    @property
    def substeps(self) -> int:
        """Number of engine steps in the last tick."""

    @property
    def score(self) -> Score:
        """Points of both alliances so far."""

    @property
    def score_counts(self) -> Mapping[str, int]:
        """Breakdown of the score by name: number of scored pieces in each zone, and other counts and points."""


class _Source(NamedTuple):
    """Telemetry keys of one type, and the function that returns the values of all these keys."""

    field: str
    """Name of the snapshot field that holds the values."""
    keys: list[str]
    """Telemetry keys. An open key contains `<...>`; the publisher replaces `<...>` with the name of each value."""
    decimals: int | None
    values: Callable[[], Iterable[Any]]
    """Function that returns an item per key: a value, a dict of values by name (open key), or None for no value."""


class Publisher:
    """Publisher of a match's telemetry, which assigns a column to each numeric key and makes snapshots.

    Args:
        match: Match with all its robots.
    """

    def __init__(self, match: PublishedMatch) -> None:
        self._match, self._robots, self._pieces = match, _Robots(match), _Pieces(match)
        self._tables = {name: Table(name) for name in FIELDS}
        self._fixed: dict[str, list[_Source]] = {name: [] for name in FIELDS}
        self._declared: set[str] = set()
        self._others: list[_Source] = []
        """Sources of arrays and strings."""
        self._named: list[_Source] = []
        """Sources of numbers with an open key."""
        self._known: dict[tuple[str, str], tuple[tuple[str, ...], IntArray]] = {}
        """Names of the latest values, and the columns of these names, by snapshot field and open key."""
        for kind in self._pieces.kinds:
            for channel in PIECES:
                self._add(channel, [channel.key.replace("<Type>", kind.name)], partial(_values_of, [channel], kind))
        by_type: dict[tuple[str, bool], list[Channel]] = {}
        for channel in MATCH:
            by_type.setdefault((channel.kind, "<" in channel.key), []).append(channel)
        for some in by_type.values():
            self._add(some[0], [channel.key for channel in some], partial(_values_of, some, match))
        things: dict[Channel, list[tuple[str, Any]]] = {}
        for robot in match.robots:
            for channel, key, thing in _lines(robot):
                things.setdefault(channel, []).append((key, thing))
                self._place(channel, key)  # robot by robot, for listings; values come channel by channel
        for channel, mine in things.items():
            self._add(channel, [key for key, _ in mine], self._robots.values_of(channel, [thing for _, thing in mine]))
        for channel in match.rules.channels:
            self._add(channel, [channel.key], partial(_of_rules, channel, match))
        self._programs = [0 for _ in match.robots]
        """Number of channels of each robot's program that the publisher has added so far."""
        self._add_programs()

    def _add_programs(self) -> None:
        """Add the channels that robot programs have declared since the last call."""
        for robot, known in zip(self._match.robots, self._programs, strict=True):
            for channel in robot.channels[known:]:
                self._add(
                    channel, [f"{robot_prefix(robot.number)}/{channel.key}"], partial(_values_of, [channel], robot)
                )
        self._programs = [len(robot.channels) for robot in self._match.robots]
        self._rounding = {name: self._decimals(name) for name in FIELDS}

    def _place(self, channel: Channel, key: str) -> None:
        """Assign a column to a key, unless the key is open or the channel's values are not stored in columns."""
        if "<" not in key and channel.field in FIELDS:
            self._tables[channel.field].place(key)

    def _add(self, channel: Channel, keys: list[str], values: Callable[[], Iterable[Any]]) -> None:
        source = _Source(channel.field, keys, channel.decimals, values)
        for key in keys:
            if key in self._declared:
                raise ConfigError(f"the telemetry key {key!r} is declared twice; choose another one")
            self._declared.add(key)
            self._place(channel, key)
        has_columns, is_open = source.field in FIELDS, "<" in keys[0]
        (self._others if not has_columns else self._named if is_open else self._fixed[source.field]).append(source)

    def _decimals(self, name: str) -> tuple[IntArray, FloatArray]:
        """Return the columns of all keys of a snapshot field that are not open, and the rounding scale of each column.

        A rounding scale is a power of ten, or 0 for no rounding.
        """
        sources = self._fixed[name]
        columns = [self._tables[name].place(key) for one in sources for key in one.keys]
        scales = [0.0 if one.decimals is None else 10.0**one.decimals for one in sources for _ in one.keys]
        return np.array(columns, np.int64), np.array(scales)

    def snapshot(self) -> Snapshot:
        """Return the telemetry of the last tick."""
        match = self._match
        if self._programs != [len(robot.channels) for robot in match.robots]:
            self._add_programs()
        self._robots.read()
        self._pieces.read(self._robots.view.places, self._robots.slots)
        found: dict[str, Any] = {name: {} for name in FIELD_OF.values() if name not in FIELDS}
        for name, keys, decimals, values in self._others:
            rows = found[name]
            for key, value in zip(keys, values(), strict=True):
                if value is None:
                    continue
                if "<" not in key:
                    rows[key] = value if decimals is None else _rounded(value, decimals)
                elif value:
                    rows.update({k: _rounded(v, decimals) for k, v in _filled(key, value).items()})
        late: dict[str, list[tuple[IntArray, Any]]] = {name: [] for name in FIELDS}
        for name, keys, decimals, values in self._named:
            for key, some in zip(keys, values(), strict=True):
                if some:
                    late[name].append((self._columns_of(name, key, some), _rounded([*some.values()], decimals)))
        blocks = {name: self._row(name, late[name]) for name in FIELDS}
        return Snapshot(time=match.time, tick=match.ticks - 1, **found | blocks)

    def _columns_of(self, name: str, key: str, values: Mapping[str, Any]) -> IntArray:
        """Return the columns of an open key's values; cache the columns until the names of the values change."""
        known, now = self._known.get((name, key)), tuple(values)
        if known is None or known[0] != now:
            places = [self._tables[name].place(one) for one in _filled(key, values)]
            known = self._known[name, key] = now, np.array(places, np.int64)
        return known[1]

    def _row(self, name: str, late: list[tuple[IntArray, Any]]) -> Columns:
        """Return all values of a snapshot field, each in the column of the value's key.

        Args:
            name: Name of the snapshot field.
            late: Columns and values of each open key.
        """
        table, (columns, scales) = self._tables[name], self._rounding[name]
        block = table.empty()
        if len(columns):
            values = np.concatenate([one.values() for one in self._fixed[name]])
            if table.dtype == np.float64:
                width = values.size // len(values)
                _put_rounded(values.reshape(-1, width), scales, columns, block.reshape(-1, width))
            else:
                block[columns] = values
        for columns, values in late:
            block[columns] = values
        return Columns(table, block)


def _filled(key: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by telemetry key: in the open key, the name of each value replaces `<...>`."""
    head, tail = key.split("<")[0], key.split(">")[1]
    return {f"{head}{name}{tail}": value for name, value in values.items()}


def _values_of(channels: Sequence[Channel], thing: Any) -> list[Any]:
    """Return the value of each channel for an object, with `GAP` for a missing number; all channels have one type."""
    found = [channel.of(thing) for channel in channels]
    return [GAP if value is None else value for value in found] if channels[0].kind == "double" else found


def _of_rules(channel: Channel, match: PublishedMatch) -> list[Any]:
    return _values_of([channel], match.rules)  # a reset of the field makes new rules


def _lines(robot: Robot) -> Iterator[tuple[Channel, str, Any]]:
    """Yield the channel, the telemetry key and the object to read, for each channel of a robot.

    The object is the robot, a mechanism, an intake, a shooter or a climber.
    """
    prefix = robot_prefix(robot.number)
    for channel in ROBOT:
        yield channel, f"{prefix}/{channel.key}", robot
    for name, mechanism in robot.mechanisms.items():
        for channel in MECHANISM:
            is_turning = not isinstance(mechanism, PistonSim)  # a piston has no turns, and uses air
            if isinstance(mechanism, channel.owner) and (is_turning or channel.owner is RackSim):
                yield channel, f"{prefix}/Debug/{telemetry_name(name)}{channel.key}", mechanism
    for channel in PART:
        parts = [part for part in (*robot.intakes, *robot.shooters, *robot.climbers) if isinstance(part, channel.owner)]
        for number, part in enumerate(parts, 1):
            yield channel, f"{prefix}/Debug/{channel.key}{number if number > 1 else ''}", part


class _Mechanisms:
    """Mechanisms that have a channel; `self[field]` reads a field of the mechanisms' records in the compiled loop."""

    def __init__(self, robots: _Robots, mechanisms: list[ShaftSim]) -> None:
        self._robots, self.mechanisms = robots, mechanisms
        self._rows = np.array([robots.shaft_of[id(mechanism)] for mechanism in mechanisms])

    def __getitem__(self, names: str | tuple[str, ...]) -> Any:
        field = self._robots.shafts
        for name in (names,) if isinstance(names, str) else names:
            field = field[name]
        return field.take(self._rows)


class _Robots:
    """State of all robots of a match, read into arrays with one row per robot."""

    def __init__(self, match: PublishedMatch) -> None:
        self.match, self.robots, self.records = match, match.robots, match.record.robots
        loop = match.world.robots.robots["model"]
        self.view = FleetView(self.robots)
        self.shaft_of: dict[int, int] = {}
        """Index of each mechanism in the compiled loop's array of shafts, by the mechanism's `id`."""
        drives: dict[int, list[tuple[int, int]]] = {}  # by number of shafts
        for robot, first in zip(self.robots, loop["first_shaft"].tolist(), strict=True):
            count = len(robot.drive.shafts)
            drives.setdefault(count, []).append((robot.number, first))
            self.shaft_of |= {id(one): first + count + k for k, one in enumerate(robot.mechanisms.values())}
        self.components = Components(self.robots, self.shaft_of)
        self._drives: list[tuple[IntArray, IntArray]] = []
        """Groups of n robots with the same number of drive shafts.

        Each group has the robot numbers, shape (n,), and the indices of the drive shafts in the compiled loop's array,
        shape (n, shafts).
        """
        for count, some in drives.items():
            numbers, firsts = np.array(some).T
            self._drives.append((numbers, firsts[:, None] + np.arange(count)))
        self._reach = np.array([robot.chassis.wheel_reach for robot in self.robots])

    def values_of(self, channel: Channel, things: list[Any]) -> Callable[[], Iterable[Any]]:
        """Return a function that reads a channel's value from each robot, mechanism or part in `things`."""
        if channel in MECHANISM:
            return partial(channel.of, _Mechanisms(self, things))
        return partial(channel.of, self) if channel in ROBOT else lambda: list(map(channel.of, things))

    def read(self) -> None:
        """Read the current state of all robots from the world; call this method before the channels' functions."""
        world = self.match.world
        self.shafts, self.batteries = world.robots.fleet.shafts, world.robots.fleet.batteries
        self.view.look(world.robots.fleet, world.bodies.records)
        self.slots = [robot.held for robot in self.robots]
        self.held = [len(slots) for slots in self.slots]
        """Number of pieces in each robot."""
        self.clearance = self.view.heights
        """Height of each robot's lowest wheel above the ground [m]."""
        for number in np.nonzero(~world.are_flat(self.view.places[:, :2], self._reach))[0].tolist():
            self.clearance[number] = ground_clearance(*self.robots[number].chassis.wheel_ground()).height

    @property
    def drive_currents(self) -> FloatArray:
        """Total battery current of each robot's drive and steer motors [A], shape (n,)."""
        found = np.empty(len(self.robots))
        for numbers, rows in self._drives:
            found[numbers] = self.shafts["supply"][rows].sum(axis=1)
        return found

    @property
    def sensors(self) -> list[dict[str, bool]]:
        """Sensor states that robot code reads, by telemetry name, for each robot."""
        return [{telemetry_name(k): value for k, value in robot.sensor_states.items()} for robot in self.robots]


class _Kind:
    """Slots and poses of all pieces of one kind, on the field, in flight and in robots."""

    def __init__(self, number: int, name: str) -> None:
        self.number, self.name = number, name
        self.slots, self.here = _NO_IDS, _NO_POSES
        """Slots and poses of the pieces on the field or in the air."""
        self.flying_slots, self.flying = _NO_IDS, _NO_POSES
        self.held_slots, self.held = _NO_IDS, _NO_POSES
        """Slots and poses of the pieces in robots, field frame."""


class _Inside:
    """Slots and robot-frame poses of the pieces in one robot, as of the last change."""

    slots: Sequence[int] = ()
    rows = np.empty((0, 7))


class _Pieces:
    """Slots and poses of all pieces of a match, grouped by kind for telemetry."""

    def __init__(self, match: PublishedMatch) -> None:
        self._match = match
        self._inside = [_Inside() for _ in match.robots]
        self._held: tuple[IntArray, IntArray, FloatArray] | None = None
        """Slots, robot numbers and robot-frame poses of all held pieces; None after a change of the held pieces."""
        self.kinds = [_Kind(number, supply.kind.name) for number, supply in enumerate(match.game.pieces)]

    def read(self, places: FloatArray, slots: Sequence[list[int]]) -> None:
        """Read the current state of all pieces.

        Args:
            places: Poses of the robots as rows of x, y, z [m], qw, qx, qy, qz, field frame, shape (n, 7).
            slots: Slots of the pieces held by each robot.
        """
        pieces, flying = self._match.pieces, self._match.record.flying
        held, rows = self._carried(places, slots)
        kinds = pieces.state.kind
        for kind in self.kinds:
            kind.slots, kind.here = pieces.shown.of(kind.number)
            mine = flying[kinds[flying] == kind.number] if len(flying) else flying
            kind.flying_slots, kind.flying = _NO_IDS, _NO_POSES
            if len(mine):  # pieces in flight are among `here`, which is sorted
                kind.flying_slots, kind.flying = _frozen(mine), _frozen(kind.here[np.searchsorted(kind.slots, mine)])
            kind.held_slots, kind.held = _NO_IDS, _NO_POSES
            if len(held) and (inside := kinds[held] == kind.number).any():
                kind.held_slots, kind.held = _frozen(held[inside]), _rounded(rows[inside], _DECIMALS)

    def _carried(self, places: FloatArray, slots: Sequence[list[int]]) -> tuple[IntArray, FloatArray]:
        """Return the slots and field-frame poses, shape (n, 7), of the pieces in robots."""
        robots, radii = self._match.robots, self._match.pieces.radius
        for robot, inside, held in zip(robots, self._inside, slots, strict=True):
            if held != inside.slots or (held and robot.is_shifting):
                inside.slots, inside.rows = held, robot.held_poses(radii)
                self._held = None
        if self._held is None:
            found = [slot for one in self._inside for slot in one.slots]
            owners = np.repeat(np.arange(len(robots)), [len(one.slots) for one in self._inside])
            self._held = _frozen(np.array(found, np.int64)), owners, np.concatenate([one.rows for one in self._inside])
        held_slots, owners, rows = self._held
        return held_slots, carried(rows, owners, places)


@compiled
def _put_rounded(values: FloatArray, scales: FloatArray, columns: IntArray, block: FloatArray) -> None:
    """Write rounded rows into columns of a block; a scale of 0 leaves values unrounded.

    Adding 0.0 turns -0.0 into 0.0, because a log would record the change of sign.
    """
    for k in range(len(values)):
        for j in range(values.shape[1]):
            value = values[k, j]
            block[columns[k], j] = np.rint(value * scales[k]) / scales[k] + 0.0 if scales[k] > 0.0 else value


def _rounded(values: Any, decimals: int | None) -> Any:
    """Return values as a read-only array rounded to `decimals` places, with 0.0 for -0.0; unchanged for None."""
    return values if decimals is None else _frozen(np.round(values, decimals) + 0.0)


def _frozen(values: Any) -> Any:
    values.setflags(write=False)
    return values


_NO_POSES = _frozen(np.empty((0, 7)))
_NO_IDS = _frozen(np.empty(0, np.int64))
