"""The robot from its side on the page of a run: every part is where the telemetry has it, in the data and as drawn."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from simcore.show.glb import convex_bodies

from games.rebuilt import REBUILT
from games.rebuilt.robot import rebuilt_robot
from games.reefscape import REEFSCAPE
from games.reefscape.robot import reefscape_robot
from simcore.geometry.linkage import part_pose
from simcore.match.game import Game
from simcore.match.runner import play_auto
from simcore.show.log_page import draw_log
from simcore.show.page import write_page
from simcore.show.scene import scene_of
from simcore.show.view_models import RobotModels, load_models
from simcore.telemetry.recording import Recording
from simcore.telemetry.wpilog import WpilogSink

RUNS = {"rebuilt": (REBUILT, "neutral", 3.4), "reefscape": (REEFSCAPE, "three_l4", 3.4)}
"""Over the bump with its front up at 3.2 s; with the elevator up at 2 s, and down again."""


class Run:
    """An auto, its page, and what the page says of the robot's side."""

    def __init__(self, folder: Path, game: Game, auto: str, seconds: float, **settings: Any) -> None:
        self.recording, self.page, self.log = Recording(), folder / "run.html", folder / "run.wpilog"
        with WpilogSink(self.log) as log:
            self.played = play_auto(game, auto, seconds=seconds, sinks=[self.recording, log], **settings)
            self.played.match.close()
        write_page(self.page, self.recording, scene_of(self.played.match), title=game.name)
        self.models = load_models(game.models).robot()


@pytest.fixture(scope="module", params=list(RUNS))
def run(request, tmp_path_factory) -> Run:
    return Run(tmp_path_factory.mktemp(request.param), *RUNS[request.param])


def data(page: Path) -> dict[str, Any]:
    found = re.search(r'id="run">(.*?)</script>', page.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    return json.loads(found[1])


def told(page: Path) -> list[tuple[float, dict[int, tuple[np.ndarray, Rotation]]]]:
    """Each frame: its time, and place [m] and attitude of every part that is there."""
    run, rows, frames = data(page), {}, []
    for frame, changes in zip(run["frames"], run["side"]["changes"], strict=True):
        for part, *numbers in changes:
            if len(numbers) in (1, 3):
                numbers = [*rows[part][:3], *numbers]
            if numbers:
                rows[part] = (*numbers, *(0,) * (6 - len(numbers)))
            else:
                del rows[part]
        poses = np.array(list(rows.values())) / 1000.0
        turns = Rotation.from_rotvec(poses[:, [4, 3, 5]])
        frames.append((frame["time"], {part: (poses[k, :3], turns[k]) for k, part in enumerate(rows)}))
    return frames


def attitude(row: np.ndarray) -> Rotation:
    return Rotation.from_quat(row[[4, 5, 6, 3]])


def is_same(seen: tuple[np.ndarray, Rotation], place: np.ndarray, turn: Rotation) -> bool:
    """To the millimeter and the milliradian."""
    return np.abs(seen[0] - place).max() < 6e-4 and (seen[1].inv() * turn).magnitude() < 2e-3


def check_components(run: Run, page: Path) -> int:
    frames, count = told(page), len(run.models.parts)
    for time, parts in frames:
        rows = run.recording.array_at("Sim/Robot/ComponentPoses", time)
        assert len(rows) == count > 7
        for number, row in enumerate(rows):
            assert is_same(parts[1 + number], row[:3], attitude(row)), (time, number)
    return len(frames)


def test_components_are_where_the_telemetry_has_them(run):
    assert check_components(run, run.page) > 80
    changes = data(run.page)["side"]["changes"]
    moves = {entry[0] for entries in changes[1:] for entry in entries}
    rows = np.array([run.recording.array_at("Sim/Robot/ComponentPoses", t) for t, _ in told(run.page)])
    still = {1 + number for number in range(rows.shape[1]) if np.ptp(rows[:, number], axis=0).max() == 0.0}
    assert not still & moves, "what never moves is told once"
    assert still or run.played.match.game is REBUILT


def test_body_and_held_pieces_are_where_the_telemetry_has_them(run):
    times, poses = run.recording.poses("Sim/Robot/Pose3d")
    first, most_tilted, most_held = 1 + len(run.models.parts), 0.0, 0
    for time, parts in told(run.page):
        robot = poses[np.searchsorted(times, time - 1e-9)]
        turn, heading = attitude(robot), run.recording.path("Sim/Robot/Pose3d")[np.searchsorted(times, time - 1e-9), 2]
        assert is_same(parts[0], np.array([0.0, 0.0, robot[2]]), Rotation.from_rotvec([0.0, 0.0, -heading]) * turn)
        most_tilted = max(most_tilted, parts[0][1].magnitude())
        keys = [key for key in run.recording.keys if key.startswith("Sim/Held/")]
        held = [row for key in keys for row in run.recording.array_at(key, time)]
        seen = [parts[number] for number in parts if number >= first]
        assert len(seen) == len(held)
        most_held = max(most_held, len(held))
        for row in held:
            inside = turn.inv().apply(row[:3] - robot[:3])
            assert min(np.abs(place - inside).max() for place, _ in seen) < 6e-4
    assert most_held == {"rebuilt": 8, "reefscape": 1}[run.played.match.game.name]
    assert run.played.match.game is REEFSCAPE or most_tilted > 0.3, "it climbs the bump"


def test_a_page_of_the_log_tells_the_same(run, tmp_path):
    assert draw_log(run.log, page=tmp_path / "log.html", picture=tmp_path / "log.png") == 0
    check_components(run, tmp_path / "log.html")


def test_a_robot_without_models_is_drawn_by_its_config(tmp_path):
    """Claw and hook are where the mechanisms take them, and the claw is drawn on the arm that the elevator lifts."""
    config = replace(reefscape_robot(), components=())
    run = Run(tmp_path, REEFSCAPE, "three_l4", 2.0, robot=config)
    mechanisms = run.played.match.robots[0].mechanisms
    frames = told(run.page)
    (_, first), (_, last) = frames[0], frames[-1]
    for part in (*config.placers, *config.climbers):
        (x, y, z), quat = part_pose(part.joints, mechanisms)
        found = [k for k, pose in last.items() if is_same(pose, np.array([x, y, z]), Rotation.from_quat(quat))]
        assert len(found) == 1
        assert part in config.climbers or last[found[0]][0][2] > first[found[0]][0][2] + 0.5
    assert {solid[2] for solid in data(run.page)["side"]["solids"]} >= {"var(--path)", "var(--hit)", "var(--ghost)"}


def test_what_is_never_there_is_left_out(tmp_path):
    """An intake that never comes out, and poses that a log never set."""
    run = Run(tmp_path, REBUILT, "depot", 0.3, robot=replace(rebuilt_robot(), components=()))
    assert {solid[2] for solid in data(run.page)["side"]["solids"]} & {"var(--hit)", "var(--miss)"} == {"var(--miss)"}
    unset = Recording()
    for snapshot in run.recording.snapshots():
        unset.write(replace(snapshot, poses={key: np.zeros(7) for key in snapshot.poses}))
    write_page(run.page, unset, scene_of(run.played.match))
    assert data(run.page)["side"] is None


GO = """(() => {{ const slider = document.querySelector(".bar input"); slider.value = {time};
  slider.dispatchEvent(new Event("input"));
  const corners = (node) => (node.getAttribute("points") || "").split(" ").map((xy) => xy.split(",").map(Number));
  const all = [...document.querySelectorAll(".of-robot polygon")];
  return all.map((node) => [Number(node.dataset.part), ...corners(node)]);
}})()"""


def drawn(visitor, time: float) -> dict[int, list[np.ndarray]]:
    """Corners of each outline by part [mm], x to the front and z up, with the slider at a time."""
    found: dict[int, list[np.ndarray]] = {}
    for part, *corners in visitor.evaluate(GO.format(time=time)):
        found.setdefault(part, []).append(np.array(corners) * (1, -1) if len(corners) > 1 else np.empty((0, 2)))
    return found


def area(polygon: np.ndarray) -> float:
    x, y = polygon.T
    return 0.5 * abs(float(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))))


def check_drawing(visitor, recording: Recording, models: RobotModels, time: float) -> dict[int, list[np.ndarray]]:
    """The outline of each body is that of its model's corners, turned as the telemetry says."""
    times, poses = recording.poses("Sim/Robot/Pose3d")
    k = int(np.searchsorted(times, time - 1e-9))
    heading = recording.path("Sim/Robot/Pose3d")[k, 2]
    tilt = Rotation.from_rotvec([0.0, 0.0, -heading]) * attitude(poses[k])
    seen = drawn(visitor, time)
    rows = recording.array_at("Sim/Robot/ComponentPoses", time)
    for number, (model, row) in enumerate(zip(models.parts, rows, strict=True), 1):
        hulls = []
        for *_, corners in convex_bodies(model):
            flat = tilt.apply(attitude(row).apply(corners) + row[:3])[:, [0, 2]] + (0.0, poses[k, 2])
            hulls.append(flat[ConvexHull(flat).vertices])
        for polygons in (seen[number], hulls):
            polygons.sort(key=area)
        for outline, hull in zip(seen[number], hulls, strict=True):
            assert area(outline) * 1e-6 == pytest.approx(area(hull), rel=0.05, abs=5e-4), (
                "to half a millimeter around it"
            )
        for edge in (np.min, np.max):
            reach = edge(np.concatenate(seen[number]), axis=0) / 1000.0
            assert reach == pytest.approx(edge(np.concatenate(hulls), axis=0), abs=4e-3), (time, number)
    return seen


def test_the_drawing_follows_the_slider(run, browser):
    visitor = browser(run.page.as_uri())
    visitor.wait_for_text("Robot from its right")
    assert {0.48, 2.0, 3.16} <= {time for time, _ in told(run.page)}, "between two frames the page interpolates"
    early, later, _ = (check_drawing(visitor, run.recording, run.models, time) for time in (0.48, 2.0, 3.16))
    name = run.played.match.game.name
    number = {"rebuilt": 1, "reefscape": 3}[name]  # the intake; the carriage
    low, high = (np.concatenate(seen[number]).max(axis=0) for seen in (early, later))
    assert np.abs(high - low).max() > 100, "the slider moves it"
    said = visitor.evaluate("document.querySelector('.of-robot span').innerText")
    times, poses = run.recording.poses("Sim/Robot/Pose3d")
    pose = poses[int(np.searchsorted(times, 3.16 - 1e-9))]
    front = np.degrees(np.arcsin(attitude(pose).apply([1.0, 0.0, 0.0])[2]))
    numbers = re.fullmatch(r"(\d+) cm up, front (\d+)\u00b0 up", said)
    assert (numbers is not None) == (name == "rebuilt"), said
    if numbers:
        assert front > 10.0, "it climbs the bump"
        assert [int(text) for text in numbers.groups()] == pytest.approx([100.0 * pose[2], front], abs=0.6)


def test_a_robot_that_tumbles_is_drawn_in_three_dimensions(run, browser, tmp_path):
    """Any attitude of the robot and of each part in it."""
    random, tumbling = np.random.default_rng(3), Recording()
    for snapshot in list(run.recording.snapshots())[:9]:
        rows = snapshot.pose_arrays["Sim/Robot/ComponentPoses"].copy()
        rows[:, 3:] = Rotation.random(len(rows), random).as_quat()[:, [3, 0, 1, 2]]
        pose = np.array(
            [5.0, 3.0, 0.4, *Rotation.from_euler("xyz", random.uniform(-1.0, 1.0, 3)).as_quat()[[3, 0, 1, 2]]]
        )
        arrays = {**snapshot.pose_arrays, "Sim/Robot/ComponentPoses": rows}
        tumbling.write(replace(snapshot, poses={"Sim/Robot/Pose3d": pose}, pose_arrays=arrays))
    write_page(tmp_path / "tumbling.html", tumbling, scene_of(run.played.match))
    visitor = browser((tmp_path / "tumbling.html").as_uri())
    visitor.wait_for_text("Robot from its right")
    for time in (0.04, 0.12):
        check_drawing(visitor, tumbling, run.models, time)


@pytest.mark.parametrize("width", [1400, 900, 360])
def test_the_panel_is_whole_below_the_field(run, browser, width):
    visitor = browser(run.page.as_uri())
    visitor.call("Emulation.setDeviceMetricsOverride", width=width, height=800, deviceScaleFactor=1, mobile=width < 500)
    visitor.wait_for_text("Robot from its right")
    edges = "(({left, top, right, bottom}) => [left, top, right, bottom])(document.querySelector('%s').%s)"
    (_, _, _, field), (left, top, right, _), drawing = (
        visitor.evaluate(edges % (name, "getBoundingClientRect()")) for name in (".field", ".of-robot", ".of-robot svg")
    )
    assert top >= field and left >= 0 and right <= width
    assert drawing[2] - drawing[0] > 200 and 150 < drawing[3] - drawing[1] <= 341
    assert visitor.evaluate("document.documentElement.scrollWidth") <= width
