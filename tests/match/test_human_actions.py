"""Actions of human players are data of a game, used alike by the game's policy and by a person."""

from dataclasses import replace

import numpy as np
import pytest

from simcore.match.game import Game, PieceSupply, Rules, StagedPieces
from simcore.match.human_actions import Feeder, HumanAction
from simcore.match.match import Match
from simcore.pieces.kinds import GamePieceConfig
from simcore.world.shapes import Sphere

BALL = GamePieceConfig(name="Ball", shape=Sphere(0.08), mass=0.2)


class Tables(Rules):
    """Rules with three balls on the table of each human player; the policy rolls one every 0.5 s and tips none."""

    def start(self) -> None:
        self.feeders = {"blue": Feeder(self.match, range(3)), "red": Feeder(self.match, range(3, 6))}
        common = {"feeders": self.feeders, "act": self.roll}
        self.actions = (
            HumanAction(name="Roll", summary="roll a ball", period=0.5, **common),
            HumanAction(name="Tip", summary="tip the table", period=0.1, lasts=0.15, modes=("teleop",), **common),
        )

    def human_actions(self) -> tuple[HumanAction, ...]:
        return self.actions

    def before_tick(self) -> None:
        for alliance in self.feeders:
            if alliance not in self.match.persons:
                self.actions[0].take(self.match.timer, alliance)

    def roll(self, alliance: str) -> None:
        x = 0.5 if alliance == "blue" else 15.5
        self.feeders[alliance].put(np.array([x, 4.0 + 0.5 * self.feeders[alliance].stock, 0.08]))


@pytest.fixture
def match():
    staging = (StagedPieces(kind="Ball", off_field=6),)
    game = replace(Game.bare(pieces=[PieceSupply(BALL, 6)]), staging=lambda rng, entries: staging, rules=Tables)
    with Match(game) as match:
        yield match


def stocks(match: Match) -> list[int]:
    assert match.count.is_conserved
    return [feeder.stock for feeder in match.rules.feeders.values()]


def test_a_policy_and_a_person_act_at_most_once_per_action_period(match):
    match.control.human_action("red", "Roll")
    match.play(0.7)
    assert stocks(match) == [1, 2], "blue's policy at 0 and 0.5 s; red's person once"
    match.control.human_action("red", "Roll")
    match.play(0.02)
    match.control.human_action("red", "Roll")
    match.play(0.2)
    assert stocks(match) == [1, 1], "the hand is not ready"
    match.play(0.3)
    assert stocks(match) == [0, 0] and match.persons == {"red": {}}


def test_a_clumsy_human_player_takes_longer_and_throws_worse(match):
    """A clumsiness of 2 halves the rate to one ball a second and doubles the errors."""
    feeders = match.rules.feeders
    feeders["red"] = Feeder(match, range(3, 6), clumsiness=2.0)
    match.play(0.9)
    assert stocks(match) == [1, 2]
    match.play(0.2)
    assert stocks(match) == [0, 1]
    exact, clumsy = (Feeder(match, (), clumsiness=c, rng=np.random.default_rng(4)).errors(3) for c in (1.0, 2.0))
    assert clumsy == pytest.approx(2.0 * exact)


def test_a_lasting_action_continues_and_ends_by_itself(match):
    match.timer.start("teleop")
    match.control.take_over("blue")
    match.control.human_action("blue", "Tip")
    match.play(1.0)
    assert stocks(match) == [1, 1] and match.persons == {"blue": {}}, "two in 0.15 s; red's policy two"
    assert match.rules.feeders["blue"].is_due(0.5, "Roll"), "another hand"


def refusal(match: Match, give, *arguments: object) -> str:
    """Give a command and return the reason of its refusal; check that no person has taken over."""
    give(*arguments)
    match.control.before_tick()
    result = match.control.results[-1]
    assert not result.is_done and match.persons == {}
    return result.text


def test_a_refused_action_states_the_reason_and_the_policy_continues(match):
    ask = match.control.human_action
    for alliance, name, words in (
        ("blue", "Tip", "blue's human player cannot tip the table: the rules allow it in teleop"),
        ("bleu", "Roll", "Did you mean 'blue'?"),
        ("blue", "rol", "no action of a human player named 'rol'"),
    ):
        assert words in refusal(match, ask, alliance, name)
    match.timer.set_enabled(False)
    assert "wait until robots are enabled" in refusal(match, ask, "blue", "Roll")
    match.timer.set_enabled(True)
    match.play(1.1)
    assert "no piece is left for it" in refusal(match, ask, "red", "Roll")
    assert stocks(match) == [0, 0]
    with Match.bare() as other:
        assert "this run of bare has no human players" in refusal(other, other.control.take_over, "blue")


def test_an_early_request_waits_once_and_is_dropped_when_it_becomes_impossible(match):
    match.control.human_action("blue", "Roll")
    match.play(0.02)
    match.control.human_action("blue", "Roll")
    match.play(0.02)
    assert match.persons == {"blue": {"Roll": pytest.approx(0.02)}}
    match.control.human_action("blue", "Roll")
    match.play(0.02)
    said = "blue's human player cannot roll a ball: the previous one is still to come, and each takes 0.5 s"
    assert match.control.results[-1].text == said
    match.timer.set_enabled(False)
    match.play(1.0)
    assert match.persons == {"blue": {}} and stocks(match)[0] == 2
