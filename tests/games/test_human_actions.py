"""A person plays human players, by Python and NetworkTables, in both games, within the rules of the policy."""

from __future__ import annotations

import math
import time

import numpy as np
from dashboard import Dashboard

from games.rebuilt import RebuiltSim
from games.rebuilt import dimensions as rebuilt
from games.rebuilt.field import FIELD
from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as reefscape
from games.reefscape.human_players import station_faces
from simcore import Match, RobotEntry
from simcore.pieces.pool import PieceStatus
from simcore.robotcode.networktables.control_topics import ControlTopics


def outposts(**settings) -> Match:
    return RebuiltSim(options=["human_players"], robots=(RobotEntry(preload=0),), **settings)


def said(match: Match, *commands: tuple[str, str]) -> list[str]:
    """Return the results of commands given in one tick."""
    for alliance, name in commands:
        match.control.human_action(alliance, name)
    match.tick()
    assert match.count.is_conserved
    return [result.text for result in list(match.control.results)[-len(commands) :]]


def to_teleop(match: Match) -> None:
    match.timer.start("teleop")


def test_only_an_accepted_request_takes_over_a_human_player():
    def played(*commands) -> tuple[str, dict]:
        with outposts(seed=3) as match:
            for alliance, name in commands:
                match.control.human_action(alliance, name)
            match.play(4.0)
            return match.digest.hexdigest(), dict(match.rules.human_players.stock)

    alone, both_throw = played()
    assert max(both_throw.values()) <= 21, "one each 1.3 s"
    refused = played(("green", "ThrowFuel"), ("blue", "ThrowFuell"), ("blue", ""))
    assert refused == (alone, both_throw)
    changed, stock = played(("blue", "ThrowFuel"))
    assert changed != alone and stock == {"blue": 23, "red": both_throw["red"]}


def test_the_policy_keeps_eight_fuel_for_robots_and_feeds_waiting_robots():
    """A robot that drives past or is full gets no fuel; an alliance without robots throws all of its fuel."""
    start = (0.5, rebuilt.OUTPOST_Y, 0.0)
    with RebuiltSim(options=["human_players"], robots=(RobotEntry(start=start, preload=0),), seed=3) as match:
        people, robot = match.rules.human_players, match.robots[0]
        assert people._is_awaited("blue") and not people._is_awaited("red")
        robot.chassis.vel = (1.0, 0.0, 0.0)
        assert not people._is_awaited("blue")
        robot.chassis.vel = (0.0, 0.0, 0.0)
        slots = match.pieces.on_field()[: robot.storage.room]
        match.pieces.hold(slots, 0)
        robot.storage.add(slots.tolist())
        assert not people._is_awaited("blue")
        robot.storage.pieces.clear()
        match.carry_to(0, FIELD.symmetry.flip_pose(*start))
        assert not people._is_awaited("red"), "an opponent"
        match.carry_to(0, (2.5, 5.9, 0.0))
        for feeder in people._feeders.values():
            del feeder._slots[8:]
        match.play(3.0)
        assert people.stock["blue"] == 8 and people.stock["red"] < 7


def test_a_person_at_an_outpost_can_open_the_door_throw_and_push_fuel_out():
    with outposts(seed=6) as match:
        (text,) = said(match, ("blue", "OpenDoor"))
        assert text == "blue's human player: open the chute's door, 24 were ready"
        match.play(2.0)
        assert match.rules.human_players.stock["blue"] == 15, "nine fuel in a second, and then it is closed"
        rolled = match.pieces.state.pos[match.pieces.on_field()]
        assert ((rolled[:, 0] < 3.0) & (abs(rolled[:, 1] - rebuilt.OUTPOST_Y) < 1.5)).sum() >= 9
        before = match.score.blue
        for _ in range(4):
            said(match, ("blue", "ThrowFuel"))
            match.play(1.4)
        match.play(1.0)
        assert match.rules.human_players.stock["blue"] == 11 and 0 < match.score.blue - before < 4, "as people throw"
        said(match, ("blue", "PushFuel"))
        match.play(0.5)
        assert match.rules.human_players.stock["blue"] == 10, "it does not come back at once"
        assert match.count.is_conserved and match.pieces.recovered == 0
        assert match.breakdown()["Blue/humanPlayerPoints"] == match.score.blue, "no robot has shot"


def test_a_policy_resumes_when_control_is_handed_back_and_at_every_new_run():
    with outposts(seed=3) as match:
        match.play(1.0)
        first = match.digest.hexdigest()
        match.control.take_over("blue")
        stock = match.rules.human_players.stock["blue"]
        match.play(2.0)
        assert match.rules.human_players.stock["blue"] == stock and set(match.persons) == {"blue"}
        match.control.reset_field()
        match.play(0.02)
        assert set(match.persons) == {"blue"}, "the person is still there"
        match.control.take_over("blue", False)
        match.play(2.0)
        assert match.rules.human_players.stock["blue"] < 24
        match.control.take_over("blue")
        match.play(0.1)
        match.reset()
        match.play(1.0)
        assert match.digest.hexdigest() == first


def test_a_person_can_feed_coral_at_any_time_and_throw_algae_only_in_teleop():
    x, y, yaw = station_faces("blue")["right"]
    start = (x + 3.0 * math.cos(yaw), y + 3.0 * math.sin(yaw), yaw)
    with Match(REEFSCAPE, robots=(RobotEntry(start=start, preload=0),)) as match:
        assert [action.name for action in match.rules.human_actions()] == ["FeedRight", "FeedLeft", "ThrowAlgae"]
        before = len(match.pieces.on_field("Coral"))
        said(match, ("blue", "FeedRight"), ("blue", "FeedLeft"), ("red", "FeedLeft"))
        match.play(2.0)
        fed = match.pieces.state.pos[match.pieces.on_field("Coral")]
        assert len(fed) == before + 3 and match.rules.human_players.stock["blue"] == 58
        near = [np.hypot(*(fed[:, :2] - face[:2]).T).min() for face in station_faces("blue").values()]
        assert max(near) < 2.0, "one at each station, though no robot waits"
        slot = int(match.pieces.on_field("Algae")[0])
        match.pieces.release(np.array([slot]), np.array([[reefscape.PROCESSOR_X, 0.3, 0.45]]))
        match.pieces.push(np.array([slot]), np.array([[0.0, -3.0, 0.0]]))
        match.play(0.4)
        assert match.rules.human_players.waiting_algae["red"] == 1
        assert "the rules allow it in teleop, now it is auto" in said(match, ("red", "ThrowAlgae"))[0]
        to_teleop(match)
        assert "no piece is left" in said(match, ("blue", "ThrowAlgae"))[0]
        said(match, ("red", "ThrowAlgae"))
        match.play(1.0)
        assert match.rules.human_players.waiting_algae["red"] == 0
        assert match.pieces.state.status[slot] != PieceStatus.STAGED and match.pieces.recovered == 0


def test_a_dashboard_plays_human_players_over_networktables():
    """The dashboard sends pulses, manual mode and back, misspelled alliances, and numbers instead of buttons."""
    folder = "/Sim/HumanPlayer/"
    with Dashboard() as board, outposts(seed=2) as match:
        client = board.client
        kept = client.get_boolean_topic(folder + "Red/OpenDoor").publish()
        kept.set(True)
        wrong = client.get_double_topic(folder + "Red/PushFuel").publish()  # the first publisher sets the type
        wrong.set(1.0)
        board.connect(folder)
        topics = ControlTopics(match, board.server)

        def done(number: int) -> str:
            board.until(match, lambda: match.control.count >= number)
            assert match.control.count == number and match.count.is_conserved
            return str(match.control.results[-1])

        names = client.get_string_array_topic(folder + "Actions").subscribe([])
        ready = client.get_integer_topic(folder + "Blue/Ready/ThrowFuel").subscribe(-1)
        status = client.get_string_topic("/Sim/Control/Status").subscribe("")
        manual = client.get_boolean_topic(folder + "Blue/Manual").get_entry(False)
        button = client.get_boolean_topic(folder + "Blue/ThrowFuel").get_entry(False)
        board.until(match, lambda: ready.get() > 0)
        assert list(names.get()) == ["OpenDoor", "ThrowFuel", "PushFuel"]
        assert match.control.count == 0 and not match.persons, "what was kept is no command"
        button.set(True)
        assert done(1).startswith("1 done: blue's human player: throw a fuel at the hub, ")
        board.until(match, lambda: not button.get())  # the button is released
        board.until(match, lambda: manual.get() and not match.persons["blue"])
        left = ready.get()
        button.set(True)
        assert done(2).startswith("2 done")
        board.until(match, lambda: ready.get() == left - 1)
        manual.set(False)
        assert done(3) == "3 done: the game itself plays blue's human player" and not match.persons
        manual.set(True)
        assert done(4) == "4 done: a person plays blue's human player"
        green = client.get_boolean_topic(folder + "Green/ThrowFuel").publish()
        green.set(True)
        assert done(5).startswith("5 refused: no alliance named 'green'")
        thorw = client.get_boolean_topic(folder + "Blue/ThorwFuel").publish()
        thorw.set(True)
        assert "Did you mean 'ThrowFuel'" in done(6)
        wrong.set(math.nan)
        assert done(7).endswith("a button is a boolean that is set to true, got nan")
        text = client.get_string_topic(folder + "Blue/Dump").publish()
        text.set("now")
        assert done(8).endswith("a button is a boolean that is set to true, got 'now'")
        board.until(match, lambda: status.get() == str(match.control.results[-1]))
        topics.close()
        button.set(True)
        time.sleep(0.3)
        match.play(0.1)
        assert match.control.count == 8
