"""Rules of the 2025 game: points by level and period, times of judging, human players, ranking points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from match_laws import show_time

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.human_players import station_faces
from games.reefscape.places import branch_ends
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.scoring import ScoreEvent
from simcore.match.scripted import ScriptedRobot
from simcore.pieces.pool import PieceStatus
from simcore.pieces.resting_places import PlaceEvent
from simcore.units import GRAVITY, inches

FAR = (RobotEntry(start=(7.0, 6.9, 0.0), preload=0), RobotEntry(alliance="red", start=(7.0, 6.9, 0.0), preload=0))


def staged(match: Match, kind: str, count: int = 1) -> np.ndarray:
    """Return slots of pieces off the field, or slots in red's half for algae, which are all on the field."""
    number = [supply.kind.name for supply in REEFSCAPE.pieces].index(kind)
    state = match.pieces.state
    if kind == "Algae":
        return np.nonzero((state.kind == number) & (state.pos[:, 0] > 16.0))[0][:count]
    return np.nonzero((state.kind == number) & (state.status == PieceStatus.STAGED))[0][:count]


def put_on(match: Match, number: int, level: int) -> int:
    """Release a coral at one of blue's branches so that it slides on and comes to rest; return its slot."""
    start, tip = (np.array(end) for end in branch_ends(number, level))
    way = (tip - start) / np.linalg.norm(tip - start)
    tilt = math.acos(way[2])
    axis = np.cross((0.0, 0.0, 1.0), way)
    axis = axis / np.linalg.norm(axis) if tilt > 1e-6 else np.array([1.0, 0.0, 0.0])
    quat = np.array([*(math.sin(tilt / 2) * axis), math.cos(tilt / 2)])
    out = 0.17 if level == 4 else -0.03
    slot = staged(match, "Coral")
    match.pieces.release(slot, (tip + out * way)[None], quat[None])
    return int(slot[0])


def rows(match: Match, prefix: str = "Blue/") -> dict[str, int]:
    return {name.removeprefix(prefix): n for name, n in match.rules.breakdown().items() if n and prefix in name}


def test_coral_counts_by_level_and_period_and_loses_its_points_when_it_falls():
    """Each level, including the trough, gets a coral in auto and another in teleop; then a robot takes one off."""
    with Match(REEFSCAPE, robots=FAR) as match:
        slots = {level: put_on(match, 2 * level, level) for level in (2, 3, 4)}
        lying = np.array([[*(math.sin(math.pi / 4) * np.array([1.0, 0.0, 0.0])), math.cos(math.pi / 4)]])
        match.pieces.release(staged(match, "Coral"), np.array([[dim.REEF_CENTER[0] - 0.7, 4.0259, 0.55]]), lying)
        match.play(2.0)
        assert match.score.blue == 3 + 4 + 6 + 7
        assert match.pieces.places.count() == 4 and match.count.is_conserved
        show_time(match, 14.9)
        match.play(0.2)
        assert match.score.blue == 20 + 3 and match.score.red == 3, "both robots have left their lines"
        show_time(match, 20.0)
        late = [put_on(match, 2 * level + 1, level) for level in (2, 3, 4)]
        match.play(2.0)
        assert match.score.blue == 23 + 3 + 4 + 5
        assert rows(match)["autoReef/midRow"] == 1 and rows(match)["teleopReef/midRow"] == 2
        assert rows(match)["autoCoralCount"] == 4 and rows(match)["autoBonusAchieved"] == 1
        match.pieces.hold(np.array([slots[4]]), 0)
        match.tick()
        assert match.score.blue == 23 + 12 - 7
        match.pieces.launch(0, (2.5, 4.0, 0.2), (0.0, 0.0, 0.0), slot=slots[4], flying=False)
        put_on(match, 8, 4)
        match.play(2.0)
        assert match.score.blue == 23 + 12, "a branch that is filled again keeps its auto points"
        assert set(late) <= set(match.pieces.places.slots(level="BlueL4")) | set(
            match.pieces.places.slots(level="BlueL3")
        ) | set(match.pieces.places.slots(level="BlueL2"))


def test_human_players_feed_waiting_robots_and_throw_processed_algae():
    """A robot without coral at a station gets one; red's human player throws algae from blue's processor in teleop."""
    x, y, yaw = station_faces("blue")["right"]

    def wait(robot):
        robot.intake(True)
        yield from robot.drive_to(x + 0.46 * math.cos(yaw), y + 0.46 * math.sin(yaw), yaw)
        yield from robot.wait(30.0)

    start = (x + 1.2 * math.cos(yaw), y + 1.2 * math.sin(yaw), yaw)
    with Match(REEFSCAPE, robots=(RobotEntry(start=start, preload=0),)) as match:
        people, chassis = match.rules.human_players, match.robots[0].chassis
        match.carry_to(0, (x + 0.6 * math.cos(yaw), y + 0.6 * math.sin(yaw), yaw))
        assert people._waits_at("blue", "right") is not None
        chassis.vel = (1.0, 0.0, 0.0)
        assert people._waits_at("blue", "right") is None, "it drives past"
        match.carry_to(0, start)
        match.set_controller(0, ScriptedRobot(wait, match, "blue"))
        match.play(3.0)
        assert [match.pieces.types[match.pieces.state.kind[slot]].name for slot in match.robots[0].held] == ["Coral"]
        assert match.rules.human_players.stock == {"blue": 59, "red": 60}
        assert len(match.pieces.on_field("Coral")) == 6, "nobody drops a second one"
        algae = staged(match, "Algae", 2)
        for slot in algae:
            match.pieces.release(np.array([slot]), np.array([[dim.PROCESSOR_X, 0.3, 0.45]]))
            match.pieces.push(np.array([slot]), np.array([[0.0, -3.0, 0.0]]))
            match.play(0.4)
        assert match.score.blue == 12 and rows(match)["wallAlgaeCount"] == 2
        assert rows(match)["coopertitionCriteriaMet"] == 1
        assert match.rules.human_players.waiting_algae == {"blue": 0, "red": 2}
        show_time(match, 18.0)
        match.play(0.1)
        assert match.rules.human_players.waiting_algae["red"] == 1
        match.play(7.0)
        assert match.rules.human_players.waiting_algae["red"] == 0
        assert match.count.scored == 0 and match.count.is_conserved
        assert match.score.red == 4 * rows(match, "Red/").get("netAlgaeCount", 0) > 0


@pytest.mark.parametrize(("speed", "comes_off"), [(0.1, False), (2.0, True)])
def test_reef_algae_stay_in_place_until_a_force_exceeds_their_hold(speed, comes_off):
    """v sqrt(k m) of the pair is 4 N at 0.1 m/s and 85 N at 2 m/s; algae hold 15 to 30 N."""
    from games.reefscape.staging import reef_algae_places

    with Match(REEFSCAPE, robots=FAR) as match:
        state = match.pieces.state
        places = state.pos[match.pieces.on_field("Algae")].copy()
        match.play(3.0)
        assert np.array_equal(state.pos[match.pieces.on_field("Algae")], places)
        place = reef_algae_places()[0]
        slot = int(np.argmin(np.linalg.norm(state.pos - place, axis=1)))
        match.pieces.push(np.array([slot]), np.array([[0.0, 0.0, 0.3]]))  # 7 N during a tick
        assert state.status[slot] == PieceStatus.ASLEEP
        other = next(s for s in match.pieces.on_field("Algae").tolist() if state.pos[s, 2] < 0.6)
        out = place - np.array([*dim.REEF_CENTER, place[2]])
        out /= np.linalg.norm(out)
        match.pieces.release(np.array([other]), (place + (dim.ALGAE_DIAMETER + 0.002) * out)[None])
        match.pieces.push(np.array([other]), (-speed * out)[None])
        match.play(0.5)
        assert (
            state.status[slot] != PieceStatus.ASLEEP or np.linalg.norm(state.pos[slot] - place) > 0.001
        ) == comes_off
        match.pieces.push(np.array([slot]), np.array([[0.0, 0.0, 2.0]]))  # 45 N
        match.pieces.push(np.array([slot]), np.array([[0.0, 0.0, 0.3]]))
        assert state.vel[slot, 2] == 0.3, "once it is free, anything moves it"


def test_the_stocks_add_up_to_126_coral_and_18_algae():
    with Match(REEFSCAPE) as match:
        assert (match.count.staged, match.count.held) == (144, 1)
        assert len(match.pieces.on_field("Coral")) == 6 and len(match.pieces.on_field("Algae")) == 18
        assert match.rules.human_players.stock == {"blue": 59, "red": 60}
        assert not len(match.pieces.awake)


# --- scoring rules of the manual --------------------------------------------------------------------------------------


def process(match: Match, alliance: str, count: int) -> None:
    """Score algae through an alliance's processor in teleop."""
    zone = next(z for z in match.game.zones if z.alliance == alliance and "Algae" in z.kinds)
    algae = match.pieces.on_field("Algae")[:count]
    for slot in algae:
        match.pieces.score(np.array([slot]))
        match.rules.scored(ScoreEvent(match.time, zone.name, alliance, zone.points, int(slot)))


def test_coral_is_judged_three_seconds_after_auto_and_after_the_match():
    """Level 4 is worth 7 in auto, 5 in teleop and 0 after the assessment; an algae in the processor is worth 6."""
    processor = next(zone for zone in REEFSCAPE.zones if "Algae" in zone.kinds)
    place = next(place for place in REEFSCAPE.places if place.name == "Blue A L4")
    with Match(REEFSCAPE, robots=FAR) as match:
        for time, coral, algae in (
            (14.9, 7, 6), (17.9, 7, 6), (18.0, 5, 6), (152.9, 5, 6), (155.9, 5, 6), (156.1, 0, 0)
        ):  # fmt: skip
            match.start_mode("auto")
            show_time(match, time)
            before = match.tracker.totals["blue"]
            match.rules.placed(PlaceEvent(place, 3, -1))
            assert (match.tracker.totals["blue"] - before, match.rules.worth(processor)) == (coral, algae), time


def test_coral_and_barge_ranking_points_need_their_thresholds():
    """Thresholds are five coral on each of four levels, and 14 barge points by a deep cage and a parked robot."""
    with Match(REEFSCAPE, robots=(FAR[0], RobotEntry(start=(7.0, 5.0, 0.0), preload=0))) as match:
        for count, ends, met in ((5, ("DeepCage", "Parked"), 1), (4, ("DeepCage", "None"), 0)):
            for level in ("BlueL2", "BlueL3", "BlueL4", "BlueL1"):
                match.rules._count[level] = count
            match.rules._ends = dict(enumerate(ends))
            found = rows(match)
            assert (found.get("coralBonusAchieved", 0), found.get("bargeBonusAchieved", 0)) == (met, met)


def test_trough_coral_keeps_its_auto_value_up_to_the_count_at_the_end_of_auto():
    """With two in auto at 3 points each, any more are worth 2; a single remaining one counts as scored in auto."""
    with Match(REEFSCAPE, robots=FAR) as match:
        match.rules._auto_count["BlueL1"] = 2
        for now, points in ((4, (6, 4)), (2, (6, 0)), (1, (3, 0)), (0, (0, 0))):
            match.rules._count["BlueL1"] = now
            assert match.rules._coral("blue") == points


@pytest.mark.parametrize(("blue", "red", "is_met"), [(2, 2, True), (2, 1, False), (3, 0, False)])
def test_coopertition_needs_two_algae_from_both_alliances(blue, red, is_met):
    """Manual 6.5.4; with coopertition, three full levels suffice for the coral ranking point."""
    with Match(REEFSCAPE, robots=FAR) as match:
        show_time(match, 60.0)
        process(match, "blue", blue)
        process(match, "red", red)
        assert match.rules._is_coop == is_met
        for level in ("BlueL2", "BlueL3", "BlueL4"):
            match.rules._count[level] = 5
        assert rows(match).get("coralBonusAchieved", 0) == is_met


@pytest.mark.parametrize(("time", "points"), [(60.0, 0), (152.0, 0), (153.0, 2), (155.9, 2)])
def test_parking_counts_only_at_the_end_of_the_match(time, points):
    """Manual, barge points: the position at the end counts."""
    start = (dim.FIELD_CENTER[0] - 0.8, dim.FIELD_WIDTH - 2.4, 0.0)
    with Match(REEFSCAPE, robots=(RobotEntry(start=start, preload=0),)) as match:
        match.start_mode("teleop")
        show_time(match, time - 0.04)
        match.play(0.04)
        match.rules._judge()
        assert rows(match).get("endGameBargePoints", 0) == points


@pytest.mark.parametrize(("blue", "red", "points"), [(8, 7, (3, 0)), (7, 7, (1, 1)), (7, 8, (0, 3))])
def test_after_the_assessment_a_win_gives_three_ranking_points_and_a_tie_gives_one(blue, red, points):
    """The assessment takes three seconds, in which pieces and robots may still fall."""
    with Match(REEFSCAPE, robots=FAR) as match:
        match.tracker.add("blue", blue)
        match.tracker.add("red", red)
        for time, given in ((60.0, (0, 0)), (155.9, (0, 0)), (156.0, points)):
            show_time(match, time)
            assert (rows(match).get("rp", 0), rows(match, "Red/").get("rp", 0)) == given


def test_a_robot_leaves_only_if_all_bumpers_are_off_the_starting_line():
    """Manual, leave points: the line is 2 in wide, up to 299.438 in; a robot may leave to either side."""
    near, far, half = inches(297.438), inches(299.438), 0.4
    with Match(REEFSCAPE, robots=FAR) as match:
        for x, has_left in (
            (near - half - 0.01, True), (near - half + 0.01, False), (far, False), (far + half - 0.01, False),
            (far + half + 0.01, True),
        ):  # fmt: skip
            match.carry_to(0, (x, 2.0, 0.0))
            assert match.rules._has_left(match.robots[0]) == has_left, f"center at {x:.3f} m"


def test_the_auto_ranking_point_needs_all_robots_to_leave_and_one_coral():
    """Manual, ranking points of auto: a single robot that leaves still scores 3 points."""
    entries = (RobotEntry(start=(7.0, 6.9, 0.0), preload=0), RobotEntry(start=(7.0, 5.0, 0.0), preload=0))
    with Match(REEFSCAPE, robots=entries) as match:
        for left, coral, is_met in ((2, 1, True), (1, 1, False), (2, 0, False)):
            match.rules._left = {0: True, 1: left == 2}
            match.rules._auto_count["BlueL4"] = coral
            assert rows(match).get("autoBonusAchieved", 0) == is_met
            assert rows(match)["autoMobilityPoints"] == 3 * left


@pytest.mark.parametrize(("height", "end"), [(0.0, "Parked"), (0.05, "DeepCage")])
def test_a_robot_with_a_wheel_on_the_carpet_is_not_on_its_cage(height, end):
    start = (dim.CAGE_X - 1.0, dim.CAGE_YS[1], math.pi)
    with Match(REEFSCAPE, robots=(RobotEntry(start=start, preload=0),)) as match:
        robot = match.robots[0]
        robot.carry_to((dim.CAGE_X - 0.3, 5.6, math.pi))
        robot.climbers[0].rung = next(rung for rung in REEFSCAPE.field.rungs if rung.alliance == "blue")
        robot.chassis.pos = (*robot.chassis.pos[:2], robot.chassis.pos[2] + height)
        assert match.rules._end_of(robot) == end


def test_human_players_feed_only_their_own_alliance():
    """An empty red robot waits at blue's station and gets no coral."""
    x, y, yaw = REEFSCAPE.field.symmetry.flip_pose(*station_faces("blue")["right"])
    start = (x + 0.6 * math.cos(yaw), y + 0.6 * math.sin(yaw), yaw)  # blue, mirrored: at blue's station
    with Match(REEFSCAPE, robots=(RobotEntry(alliance="red", start=start, preload=0),)) as match:
        before = dict(match.rules.human_players.stock)
        match.play(2.5)
        assert match.robots[0].chassis.pose[0] < 2.0 and dict(match.rules.human_players.stock) == before


def test_a_thrown_algae_and_a_lodged_algae_never_gain_energy_together():
    """One algae is thrown from below at the other; their energy never exceeds that at the throw."""
    with Match(REEFSCAPE, robots=[RobotEntry(start=(7.2, 2.0, 0.0))]) as match:
        for seed, (speed, up) in enumerate(((3.3, 0.6), (9.0, 0.35), (9.0, 0.5), (10.0, 0.8))):
            match.reset(seed)
            state = match.pieces.state
            algae = np.nonzero(state.kind == 1)[0]
            inside = (state.pos[algae, 0] > 3.0) & (state.pos[algae, 0] < 6.0) & (state.pos[algae, 2] > 0.5)
            lodged, thrown = algae[inside][seed], algae[state.pos[algae, 0] > 8.0][:1]
            out = state.pos[lodged, :2] - dim.REEF_CENTER
            out /= np.linalg.norm(out)
            way = np.array([-out[0] * math.cos(up), -out[1] * math.cos(up), math.sin(up)])
            match.pieces.release(thrown, (state.pos[lodged] - 0.55 * way)[None])
            match.pieces.push(thrown, speed * way[None], flying=True)
            both, energies = np.array([lodged, thrown[0]]), []
            for _ in range(100):
                energies.append(0.5 * (state.vel[both] ** 2).sum() + GRAVITY * state.pos[both, 2].sum())
                match.tick()
            assert max(energies) < energies[0] + 0.01, f"seed {seed} [J/kg]"
