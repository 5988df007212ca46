"""Match of REBUILT: fuel, human players, and fuel leaving the hubs."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt import REBUILT, RebuiltSim
from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD, HUB_TARGET
from games.rebuilt.fuel import FUEL
from games.rebuilt.fuel_ways import hub_exit
from games.rebuilt.staging import Staging
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.scoring import ScoreEvent
from simcore.pieces.pool import PieceStatus
from simcore.units import inches

# --- robots and fuel ----------------------------------------------------------------------------------------------


def test_a_hub_releases_fuel_through_one_opening_at_no_more_than_ten_a_second():
    rng = np.random.default_rng(1)
    out = np.array([hub_exit("blue", rng)[0] for _ in range(500)])
    assert np.abs(out[:, 1] - dim.HUB_CENTER[1]).max() < 0.5 * inches(35.6) - FUEL.bounding_radius + 1e-3
    assert out[:, 2].min() > 0.765 + FUEL.bounding_radius and out[:, 2].max() < 0.988 - FUEL.bounding_radius
    with RebuiltSim(options=["hub_exits"]) as match:
        slots = match.pieces.on_field()[:12]
        match.pieces.score(slots)
        for slot in slots.tolist():
            match.rules.ways.enter_hub("blue", slot)
        left = []
        for _ in range(125):
            match.tick()
            left.append(match.rules.ways.in_hub("blue"))
        assert left[35] == 12, "nothing comes out within 0.75 s"
        assert left[-1] == 0 and max(a - b for a, b in zip(left, left[5:], strict=False)) <= 1


def test_each_hub_counts_and_returns_200_fuel_and_red_exits_are_blue_exits_rotated():
    """With equal random numbers in both hubs, red's exits are blue's rotated, within 1 mm after a tick."""
    empty = replace(REBUILT, staging=lambda rng, entries: [], preload=0)
    with Match(empty, options=["hub_exits"], robots=(RobotEntry(preload=0, start=(1.0, 1.0, 0.0)),)) as match:
        pieces, ways = match.pieces, match.rules.ways
        ways._rng["red"] = copy.deepcopy(ways._rng["blue"])
        goals = {"blue": HUB_TARGET, "red": (*FIELD.symmetry.flip_point(*HUB_TARGET[:2]), HUB_TARGET[2])}
        out = {"blue": [], "red": []}
        fuel = {"blue": [], "red": []}
        for tick in range(1150):
            if tick % 2 == 0 and tick < 400:
                for alliance, (x, y, z) in goals.items():
                    slots = pieces.spawn("Fuel", np.array([[x, y, z + 0.4]]))
                    pieces.push(slots, np.array([[0.0, 0.0, -5.0]]), flying=True)
                    fuel[alliance] += slots.tolist()
            aside = pieces.state.status == PieceStatus.STAGED
            match.tick()
            comes_out = aside & (pieces.state.status == PieceStatus.IN_FLIGHT)
            for alliance, slots in fuel.items():
                out[alliance] += [pieces.state.pos[slot].copy() for slot in slots if comes_out[slot]]
        assert match.count.is_conserved and match.count.on_field == 400
        assert (match.score.blue, match.score.red) == (200, 200)
        x, y, _ = pieces.state.pos[pieces.on_field()].T
        assert (0.0 < x).all() and (x < dim.FIELD_LENGTH).all() and (0.0 < y).all() and (y < dim.FIELD_WIDTH).all()
        turned = FIELD.symmetry.flip_points(np.array(out["red"]))
        assert len(turned) == 200 and np.abs(turned - out["blue"]).max() < 1e-3


def test_fuel_that_leaves_the_field_is_returned_after_a_few_seconds():
    with RebuiltSim(options=["human_players"]) as match:
        slot = match.pieces.on_field()[:1]
        match.pieces.release(slot, np.array([[8.0, 7.9, 2.0]]))
        match.pieces.push(slot, np.array([[0.0, 6.0, 3.0]]), flying=True)
        away = []
        for _ in range(500):
            match.tick()
            away.append(match.pieces.state.status[slot[0]] == PieceStatus.STAGED)
            assert match.count.is_conserved
        assert 150 <= sum(away) <= 401 and not away[-1]
        assert match.pieces.state.pos[slot[0], 1] < dim.FIELD_WIDTH


def test_a_human_player_takes_corral_fuel_and_opens_the_door_for_a_waiting_robot():
    with RebuiltSim(options=["human_players"], robots=(RobotEntry(preload=0),)) as match:
        assert match.rules.human_players.stock == {"blue": 24, "red": 24}
        slot = match.pieces.on_field()[:1]
        match.pieces.release(slot, np.array([[0.3, dim.OUTPOST_Y - 0.3, FUEL.bounding_radius]]))
        match.pieces.push(slot, np.array([[-1.5, 0.0, 0.0]]))
        match.play(0.4)
        assert match.pieces.state.status[slot[0]] == PieceStatus.STAGED and match.count.is_conserved
        before = match.rules.human_players.stock["blue"]
        assert before >= 24, "one came, and one may have been thrown"
        match.robots[0].carry_to((0.7, dim.OUTPOST_Y, math.pi))
        state, out = match.pieces.state, 0
        for _ in range(60):
            staged = state.status == PieceStatus.STAGED
            match.tick()
            out += np.count_nonzero(staged & (state.status != PieceStatus.STAGED) & (state.pos[:, 0] < 2.0))
        assert out >= 8, "one each 0.12 s; some roll back into the corral"
        assert match.rules.human_players.stock["red"] >= 22, "nobody waits there; it throws one each 1.3 s"


@pytest.mark.parametrize(
    ("staging", "preload", "total", "on_field"),
    [
        (Staging(), 8, 504, 400 + 48),
        (Staging(), 0, 504, 408 + 48),
        (Staging(neutral=0, depot=0, chute=0, robots=1), 3, 8, 5),
        (Staging(neutral=10, depot=2, chute=1, robots=1), 8, 24, 14),
    ],
)
def test_staging_counts_are_configurable_and_add_up(staging, preload, total, on_field):
    with RebuiltSim(staging=staging, robots=(RobotEntry(preload=preload),)) as match:
        fuel = match.count
        assert (fuel.staged, fuel.on_field, fuel.held, fuel.off_field) == (total, on_field, preload, 2 * staging.chute)
        match.tick()
        assert match.count.is_conserved
        assert match.pieces.count(PieceStatus.FREE) == 0


def test_game_data_depends_only_on_the_auto_started_by_the_driver_station():
    """Practice first, then a match: game data appears in teleop and depends on auto fuel of this match alone."""
    with RebuiltSim() as match:
        match.play(0.5)
        match.start_mode("auto")
        assert match.timer.time == 0.0 and match.rules.game_data() == ""
        zone = next(z for z in match.tracker.zones if z.alliance == "red")
        match.rules.scored(ScoreEvent(0.0, zone.name, "red", match.rules.worth(zone), 0))
        match.play(0.1)
        match.start_mode("teleop")
        assert match.timer.time == pytest.approx(23.0)
        assert match.rules.game_data() == "R"  # red scored more, so red's hub is inactive first
        match.start_mode("auto")
        assert match.rules.game_data() == ""
