"""Data of a run for the player: one JSON object, and one binary block of 16-bit integers for long arrays."""

from __future__ import annotations

import functools
import logging
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from simcore.errors import ModelError
from simcore.match.camera_rig import tag_layout
from simcore.show.charts import Chart, Curve, charts_of, thinned
from simcore.show.frames import FrameLayout, PieceKind, Rows, kind_look, pack, piece_kinds
from simcore.show.match_tables import tables_of, verdict
from simcore.show.palette import COLORS, color, tint
from simcore.show.run_events import (
    ChangeRecord,
    board_now,
    changing_rows,
    counts_now,
    ending_of,
    events_of,
    failure_of,
    lamps_now,
    phases_of,
    score_keys,
)
from simcore.show.run_track import RunTrack
from simcore.show.scene import LevelLook, PieceLook, RobotLook, Scene
from simcore.show.shots import ShotTrace, shots_of
from simcore.show.solids import RobotSolids, Solid, element_solids, model_solids, robot_solids, shape_solids
from simcore.show.view_models import FieldModels, Model, ViewModels, load_models
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray, alliance_in
from simcore.world.shapes import Box

__all__ = ["Block", "layout_of", "report_data", "run_data", "scene_data"]

_log = logging.getLogger(__name__)
_FIELD_STEP, _ROBOT_STEP = 1e-3, 2.5e-4  # [m]; smallest resolution of vertices
_FINE, _COARSE = 400, 150  # numbers of parts for `thinned`, in runs with one robot and with several robots
_CHASSIS = (0.05, 0.17)  # [m]; lower and upper edge of the bumpers of an unknown robot
_PAINT = {"blue": "#1e54b7", "red": "#c42828"}
_FRAMES = ("", "#2f3640", "#d9a441", "#5aa69a")  # frame colors of an alliance's robots; empty for the model's own color


class Block:
    """Binary block of concatenated arrays of 16-bit integers."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, rows: Rows) -> list[int]:
        """Append an array of shape (n, m), and return the offset of the array in the block [bytes], n, and m."""
        packed, place = pack(rows), [self._size, *rows.shape]
        self._parts.append(packed)
        self._size += len(packed)
        return place

    @property
    def data(self) -> bytes:
        """Contents of the block."""
        return b"".join(self._parts)


def run_data(
    recording: Recording, scene: Scene, *, title: str = "run", subtitle: str = ""
) -> tuple[dict[str, Any], bytes]:
    """Return the data for the page of a run: a JSON object and a binary block.

    Args:
        recording: Recording of the run.
        scene: Scene of the run.
        title: Heading of the page.
        subtitle: First note on the page; empty for no note.
    """
    block, kinds = Block(), piece_kinds(recording, scene)
    layout, solids = layout_of(scene, kinds, recording)
    board, lamps, cells = ChangeRecord(), ChangeRecord(), ChangeRecord()
    for snapshot in recording.snapshots(changing_rows(recording, scene)):
        board.take(snapshot.time, board_now(snapshot, scene))
        lamps.take(snapshot.time, lamps_now(snapshot).items())
        cells.take(snapshot.time, counts_now(snapshot, scene).items())
    meta = scene_data(scene, kinds, solids, block)
    meta |= {"live": False, "groups": {}, "lamps": lamps.found}
    lines = [{"label": label, **changes} for label, changes in board.found.items()]
    frames = layout.frames(recording)
    for name, width in layout.widths.items():
        meta["groups"][name] = {"width": width}
        if name in frames:
            times, rows = frames[name]
            meta["groups"][name] |= {"times": block.add(_steps(times)), "rows": block.add(rows)}
    report = report_data(recording, scene, block, kinds, title, subtitle)
    return meta | report | {"board": lines, "cells": cells.found}, block.data


def layout_of(
    scene: Scene, kinds: Sequence[PieceKind], source: Recording | Snapshot
) -> tuple[FrameLayout, list[RobotSolids]]:
    """Return the layout of the frames of a run, and the solids of each robot.

    Args:
        scene: Scene of the run.
        kinds: Kinds of pieces in the run.
        source: Recording or snapshot of the run; the telemetry keys determine the moving parts and the camera lines.
    """
    solids = []
    for robot in scene.robots:
        key = f"{robot.prefix}/Robot/ComponentPoses"
        if isinstance(source, Recording):
            count = source.most_poses(key)
        else:
            count = len(source.pose_arrays.get(key, ()))
        solids.append(robot_solids(robot, next(iter(_models(robot.models).robots), None), count))
    keys = source.keys if isinstance(source, Recording) else source.pose_arrays
    return FrameLayout(scene, solids, kinds, keys), solids


def scene_data(scene: Scene, kinds: Sequence[PieceKind], solids: Sequence[RobotSolids], block: Block) -> dict[str, Any]:
    """Return the JSON data of everything that does not change during a run: field, robot models and kinds of pieces.

    The function appends the meshes to `block`.
    """
    length, width = scene.field_size
    field = _models(scene.models).field
    tags = tag_layout(scene.tags, scene.field_size)
    rows = [[i, *np.round(pose, 4).tolist()] for i, pose in zip(tags.id_list, _tag_poses(tags), strict=True)]
    names = sorted({name.lower() for name, _ in scene.field_outlines if name.lower().startswith(("blue_", "red_"))})
    prefixes = sorted({"_".join(name.split("_")[:2]) for name in names})
    mesh = _solids(None if field is None else field.body, prefixes) or element_solids(scene, prefixes)
    models: list[dict[str, Any]] = []
    seen: dict[int, int] = {}
    robots: list[dict[str, Any]] = []
    for one in solids:
        identity = hash(_identity(one))
        if identity not in seen:
            seen[identity] = len(models)
            models.append(_model_data(one, block))
        robots.append(_robot_data(scene, len(robots), one, seen[identity]))
    return {
        "field": {
            "size": [length, width],
            "solids": [_solid_data(solid, block, _FIELD_STEP) for solid in mesh],
            "outlines": [_outline_data(name, corners) for name, corners in scene.field_outlines],
            "stations": [list(place) for place in _stations(field, scene.field_size)],
            "tags": rows,
            "tag_size": tags.size if rows else 0.0,
        },
        "models": models,
        "robots": robots,
        "kinds": [_kind_data(kind, kind_look(scene, kind), field, block) for kind in kinds],
        "looks": [
            {"name": name.lower(), "box": look.size is not None, "color": look.color, "edge": look.edge_color}
            for name, look in scene.pieces.items()
        ],
    }


def report_data(
    recording: Recording, scene: Scene, block: Block, kinds: Sequence[PieceKind], title: str, subtitle: str = ""
) -> dict[str, Any]:
    """Return the JSON data of the report of a run: title, notes, facts, events, tables, charts, shots and levels.

    The function appends the values of the charts to `block`.
    """
    track = RunTrack(recording, scene)
    shots = shots_of(recording, scene)
    start, end = track.span
    buckets = _FINE if len(scene.robots) == 1 else _COARSE
    return {
        "title": title,
        "notes": [text for text in (subtitle, *ending_of(recording)) if text],
        "failure": failure_of(recording),
        "start": round(start, 3),
        "end": round(end, 3),
        "facts": _facts(track, shots),
        "verdict": verdict(track),
        "board": [],
        "phases": [[round(time, 2), words, left] for time, words, left in phases_of(recording)],
        "events": [[round(event.time, 2), event.kind, event.text] for event in events_of(recording, scene, shots)],
        "tables": [table.data() for table in tables_of(track, shots)],
        "charts": [_chart_data(chart, start, buckets, block) for chart in charts_of(track)],
        "shots": [
            {"time": round(shot.time, 3), "end": round(float(shot.times[-1]), 3), "robot": shot.robot,
             "result": shot.result, "piece": _row_of(kinds, shot.piece)}
            for shot in shots
        ],
        "taken": _taken(recording),
        "levels": [_level_data(level, recording) for level in scene.levels if recording.has(level.key)],
        "cells": {},
    }  # fmt: skip


@functools.lru_cache(maxsize=8)
def _models(folder: Path | None) -> ViewModels:
    """Load the models of a folder, or return empty `ViewModels` without a folder.

    If a model is invalid, log a warning and return empty `ViewModels`.
    """
    try:
        return ViewModels() if folder is None else load_models(folder)
    except ModelError as error:
        _log.warning("a page without models: %s", error)
        return ViewModels()


def _solids(model: Model | None, names: Iterable[str] = ()) -> Sequence[Solid]:
    """Return the solids of a model, or no solids without a model.

    If the model cannot be read, log a warning and return no solids.
    """
    try:
        return () if model is None else model_solids(model, tuple(names))
    except ModelError as error:
        _log.warning("a page without a model: %s", error)
        return ()


# --- the scene --------------------------------------------------------------------------------------------------------


def _identity(one: RobotSolids) -> tuple[object, ...]:
    return tuple(
        (solid.name, solid.color, solid.opacity, solid.vertices.tobytes())
        for solids in (one.body, *(part for part, _ in one.parts))
        for solid in solids
    )


def _model_data(one: RobotSolids, block: Block) -> dict[str, Any]:
    return {
        "body": [_solid_data(solid, block, _ROBOT_STEP) for solid in one.body],
        "parts": [[_solid_data(solid, block, _ROBOT_STEP) for solid in part] for part, _ in one.parts],
    }


def _solid_data(solid: Solid, block: Block, step: float) -> dict[str, Any]:
    reach = float(np.abs(solid.vertices).max(initial=0.0))
    step = max(step, reach / 32000.0)
    vertices = np.rint(solid.vertices / step).astype(np.int16)
    faces = solid.faces.astype(np.uint16).reshape(-1, 1).view(np.int16)
    return {
        "name": solid.name, "color": solid.color, "opacity": solid.opacity, "scale": step,
        "vertices": block.add(vertices), "faces": block.add(faces),
    }  # fmt: skip


def _robot_data(scene: Scene, number: int, one: RobotSolids, model: int) -> dict[str, Any]:
    look = scene.robots[number]
    low, high = _CHASSIS
    if look.config is not None:
        low, high = look.config.body.clearance, look.config.body.bumper_top
    elif bumpers := [solid for solid in one.body if solid.name == "bumper"]:
        low, high = (float(f(bumpers[0].vertices[:, 2])) for f in (np.min, np.max))
    same = [number for number, other in enumerate(scene.robots) if other.alliance == look.alliance]
    return {
        "label": look.name or look.team or str(number), "name": look.name, "alliance": look.alliance,
        "size": list(look.bumpers), "heights": [low, high],
        "open": look.config is not None and look.config.body.bay is not None,
        "model": model, "parts": len(one.parts), "ink": _path_ink(scene, look),
        "own_ink": look.ink and color(look.ink), "is_run": bool(look.score_key),
        "intakes": [np.round(zone, 3).tolist() for zone in look.intakes],
        "bumper": COLORS[look.ink][0] if look.ink else _PAINT.get(look.alliance, "#666e78"),
        "frame": _FRAMES[same.index(number) % len(_FRAMES)] if len(scene.robots) > 1 else "",
    }  # fmt: skip


def _path_ink(scene: Scene, robot: RobotLook) -> str:
    """Return the CSS color of a robot's path.

    The color is that of the robot's look, otherwise the path color for a single robot or the color of the alliance.
    """
    if robot.ink:
        return color(robot.ink)
    return color("path") if len(scene.robots) == 1 else tint(robot.alliance)[1]


def _outline_data(name: str, corners: FloatArray) -> tuple[str, str, list[list[float]]]:
    """Return the name, alliance (or `neutral`) and corners [m] of a field element seen from above."""
    return name, alliance_in(name) or "neutral", np.round(corners, 3).tolist()


def _kind_data(kind: PieceKind, look: PieceLook, field: FieldModels | None, block: Block) -> dict[str, Any]:
    model = field.pieces.get(kind.name.split()[0]) if field is not None else None
    size = look.size or (2.0 * look.reach,) * 3
    solids = [] if kind.is_round else _solids(model) or shape_solids(look.shape or Box(size), look.color)
    return {
        "name": kind.name, "count": len(kind.ids), "round": kind.is_round, "radius": look.reach, "size": list(size),
        "color": look.color, "air": look.air_color, "edge": look.edge_color, "hole": look.hole,
        "solids": [_solid_data(solid, block, _ROBOT_STEP) for solid in solids],
    }  # fmt: skip


def _stations(field: FieldModels | None, size: tuple[float, float]) -> Sequence[tuple[float, float]]:
    """Return the positions of the driver stations, blue 1 to 3, then red 1 to 3, field frame [m].

    If the field model has no stations, the positions are 1.75 m apart at the alliance walls.
    """
    if field is not None and field.stations:
        return field.stations
    offsets = (1.75, 0.0, -1.75)
    return [(x, 0.5 * size[1] + sign * off) for x, sign in ((0.0, 1.0), (size[0], -1.0)) for off in offsets]


def _tag_poses(tags: Any) -> Iterable[FloatArray]:
    for center, rotation in zip(tags.centers, tags.rotations, strict=True):
        x, y, z, w = Rotation.from_matrix(rotation).as_quat()
        yield np.array((*center, w, x, y, z))


# --- the report -------------------------------------------------------------------------------------------------------


def _facts(track: RunTrack, shots: Sequence[ShotTrace]) -> list[list[str]]:
    """Return the main results of a run as pairs of label and text, e.g. score, hits and lowest battery voltage."""
    recording, scene = track.recording, track.scene

    def last(key: str) -> float | None:
        return float(recording.series(key)[1][-1]) if recording.has(key) and len(recording.series(key)[1]) else None

    facts = []
    for label, key in score_keys(scene):
        points = last(key)
        if points is not None:
            facts.append([f"score {label}", f"{points:.0f}"])
    if len(scene.robots) > 1 and not any(robot.score_key for robot in scene.robots):
        facts.insert(0, ["result", verdict(track)])
        for alliance in ("Blue", "Red"):
            points = last(f"Sim/Score/{alliance}/rp")
            facts += [] if points is None else [[f"ranking points {alliance.lower()}", f"{points:.0f}"]]
    apart = any(robot.score_key for robot in scene.robots)
    tried, hits, taken = (last(f"Sim/{name}") for name in ("Shots", "Hits", "TakenIn"))
    if tried and hits is not None and not apart:
        facts.append(["shots hit", f"{hits:.0f} of {tried:.0f}"])
        passes = len([shot for shot in shots if shot.result == "pass"])
        facts += [["of the shots passed on", f"{passes}"]] if passes else []
    if taken and not apart:
        facts.append([f"{scene.piece_names} taken in", f"{taken:.0f}"])
    for number, robot in enumerate(scene.robots if apart else scene.robots[:1]):
        whose = "" if len(scene.robots) == 1 else f", {scene.label(number)}"
        prefix = robot.prefix
        driven, volts, offs = (
            last(f"{prefix}/{key}") for key in ("Robot/DistanceDriven", "Debug/BatteryVoltageLowest", "Debug/Brownouts")
        )
        if apart:
            mine = [shot for shot in shots if shot.robot == number]
            facts.append([f"shots hit{whose}", f"{len([shot for shot in mine if shot.scored])} of {len(mine)}"])
        facts += [] if driven is None else [[f"driven{whose}", f"{driven:.1f} m"]]
        facts += [] if volts is None else [[f"lowest battery voltage{whose}", f"{volts:.2f} V"]]
        facts += [[f"brownouts{whose}", f"{offs:.0f}"]] if offs else []
    if len(recording):
        facts.append(["simulated", f"{track.span[1]:.2f} s"])
    return facts


def _level_data(level: LevelLook, recording: Recording) -> dict[str, Any]:
    """Return the JSON data of a level: names of the level and the places, number of places, and center."""
    return {
        "name": level.name, "alliance": level.alliance, "label": level.label, "places": level.places,
        "count": len(recording.integers_at(level.key, recording.times[0])), "single": level.is_single,
        "middle": level.middle,
    }  # fmt: skip


def _taken(recording: Recording) -> list[list[float]]:
    """Return the time [s] and the position (x, y) [m] of each pickup of a piece by an intake."""
    events = recording.events("Sim/NewestTakenIn")
    return [[round(time, 2), round(1e-3 * x, 3), round(1e-3 * y, 3)] for time, (_, x, y) in events]


def _row_of(kinds: Sequence[PieceKind], piece: int) -> int:
    """Return the index of the piece with the id `piece` among the pieces of all kinds; 0 for an unknown piece."""
    first = 0
    for kind in kinds:
        row = int(np.searchsorted(kind.ids, piece))
        if not kind.key and row < len(kind.ids) and kind.ids[row] == piece:
            return first + row
        first += len(kind.ids)
    return 0


def _chart_data(chart: Chart, start: float, buckets: int, block: Block) -> dict[str, Any]:
    return {
        "title": chart.title, "unit": chart.unit, "limit": chart.limit, "limit_label": chart.limit_label,
        "from_zero": chart.from_zero, "group": chart.group,
        "curves": [_curve_data(curve, start, buckets, block) for curve in chart.curves],
    }  # fmt: skip


def _curve_data(curve: Curve, start: float, buckets: int, block: Block) -> dict[str, Any]:
    """Return the JSON data of a thinned curve, and append the times and values to `block` as 16-bit integers.

    A stored number n represents the value `low + scale * (n + 32000)`. A curve without finite values has no data.
    """
    look: Mapping[str, Any] = {
        "label": curve.label, "color": curve.color, "stepped": curve.is_stepped, "key": curve.key,
    }  # fmt: skip
    finite = np.isfinite(curve.values)
    if not finite.any():
        return dict(look)
    thin = thinned(replace(curve, times=curve.times[finite], values=curve.values[finite]), buckets)
    low, high = float(thin.values.min()), float(thin.values.max())
    is_whole = high - low < 64000.0 and bool((thin.values == np.rint(thin.values)).all())
    scale = 1.0 if is_whole else max((high - low) / 64000.0, 1e-9)
    numbers = np.rint((thin.values - low) / scale) - 32000.0
    rows = np.column_stack((_steps(thin.times, start)[:, 0], numbers)).astype(np.int16)
    return {**look, "low": low, "scale": scale, "data": block.add(rows)}


def _steps(times: FloatArray, start: float | None = None) -> Rows:
    """Convert times [s] to increments [ms], shape (n, 1).

    The first increment is the time since `start` [s], or 0 if `start` is None.
    """
    milliseconds = np.rint(1e3 * times)
    first = milliseconds[:1] if start is None else [round(1e3 * start)]
    steps = np.diff(milliseconds, prepend=first)
    found: Rows = np.clip(steps, 0, 32767).astype(np.int16).reshape(-1, 1)
    return found
