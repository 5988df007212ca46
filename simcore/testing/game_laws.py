"""Assertions for any game: functions that play an auto and raise AssertionError if the game violates a law."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter

import numpy as np

from simcore.match.game import Game, PlayedMatch, Rules
from simcore.match.match import Match
from simcore.match.runner import AutoRun, play_auto
from simcore.match.scoring import Alliance
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.resting_places import PlaceEvent
from simcore.typing import FloatArray, IntArray
from simcore.units import TICK
from simcore.world.shapes import Sphere

__all__ = [
    "check_conserved",
    "check_mirrored",
    "check_on_the_floor",
    "check_placed",
    "check_questions",
    "check_repeatable",
]

_NEAR = 0.02  # largest distance between mirrored paths, because contacts amplify rounding differences [m]
_SUNK = 0.03  # largest depth of a landing piece in the carpet [m]


def _play(game: Game, auto: str, *, seconds: float | None, alliance: Alliance = "blue", seed: int = 0) -> AutoRun:
    return play_auto(game, auto, alliance=alliance, seed=seed, seconds=seconds)


def check_conserved(game: Game, auto: str, *, seconds: float | None = None) -> None:
    """Check after each tick of an auto that no piece is lost or created.

    The check also compares the number of pieces in robots with the number that the match counts as held.
    """

    def check(match: Match) -> None:
        count = match.count
        assert count.is_conserved, f"{game.name}, tick {match.ticks}: {count}"
        held = len([slot for robot in match.robots for slot in robot.held])
        assert held == count.held, f"{game.name}, tick {match.ticks}: robots hold {held} pieces, {count.held} are held"

    play_auto(game, auto, seconds=seconds, on_tick=check).match.close()


def check_repeatable(game: Game, auto: str, *, seconds: float | None = None) -> None:
    """Check that two runs of an auto with the same seed have bit-identical states."""
    digests = []
    for _ in range(2):
        run = _play(game, auto, seconds=seconds)
        run.match.close()
        digests.append(run.report.digest)
    assert digests[0] == digests[1], f"{game.name}, auto {auto}: two runs of one seed differ"


def check_questions(game: Game, auto: str, *, seconds: float | None = None, times: int = 100) -> None:
    """Check that queries of the rules do not change the match: play the auto without and with queries, and compare.

    Args:
        game: Game whose rules are queried.
        auto: Auto to play.
        seconds: Simulated time to play [s]; None for the game's autonomous period.
        times: Number of repetitions of each query per tick.
    """

    def ask(match: Match) -> None:
        rules = match.rules
        for _ in range(times):
            for zone in game.zones:
                rules.worth(zone)
            rules.game_data(), rules.breakdown(), [channel.of(rules) for channel in rules.channels]

    runs = [play_auto(game, auto, seconds=seconds, on_tick=look) for look in (None, ask)]
    for run in runs:
        run.match.close()
    quiet, asked = runs
    assert quiet.match.rules.breakdown() == asked.match.rules.breakdown(), (
        f"{game.name}: querying the rules changes the score"
    )
    assert quiet.report.digest == asked.report.digest, f"{game.name}, auto {auto}: querying the rules changes the match"


def check_mirrored(game: Game, auto: str, *, seconds: float | None = None) -> None:
    """Check that an auto for a red robot is the symmetric counterpart of the same auto for a blue robot.

    The scores must be equal, and the paths of the robots must agree within 2 cm.
    """
    blue = _play(game, auto, seconds=seconds, alliance="blue")
    red = _play(game, auto, seconds=seconds, alliance="red")
    blue.match.close()
    red.match.close()
    flipped = game.field.symmetry.flip_points(red.path[:, :2])
    apart = np.abs(flipped - blue.path[:, :2]).max(axis=1)
    first = int(np.argmax(apart >= _NEAR))
    x, y = blue.path[first, :2].tolist()
    assert apart[first] < _NEAR, (
        f"{game.name}, auto {auto}: red's path, flipped, leaves blue's by {_NEAR:g} m at {(first + 1) * TICK:.2f} s, "
        f"where blue is at ({x:.2f}, {y:.2f}) m, and by {apart.max():.3f} m at most: the element there is not "
        "mirrored, or the auto ignores its alliance; pushed pieces also drift apart a little: try an auto that pushes "
        "none"
    )
    assert blue.report.score.blue == red.report.score.red, (
        f"{game.name}, auto {auto}: blue scores {blue.report.score.blue}, red {red.report.score.red}"
    )


def check_on_the_floor(game: Game, auto: str, *, seconds: float | None = None) -> None:
    """Check after each tick that no piece is 3 cm deep in the carpet, or outside of the field below a height of 1 m."""
    length, width = game.field.size

    def check(match: Match) -> None:
        for number, supply in enumerate(game.pieces):
            slots = match.pieces.on_field(supply.kind.name)
            pos = match.pieces.state.pos[slots]
            if not len(pos):
                continue
            low = float((pos[:, 2] - _rest_heights(match, supply.kind, slots)).min())
            assert low > -_SUNK, f"{game.name}, tick {match.ticks}: a {supply.kind.name} is {-low:.3f} m too low"
            inside = (pos[:, 0] > 0.0) & (pos[:, 0] < length) & (pos[:, 1] > 0.0) & (pos[:, 1] < width)
            high = pos[:, 2] > 1.0  # human players return pieces that fly over the wall
            assert (inside | high).all(), f"{game.name}, tick {match.ticks}: {supply.kind.name} outside, kind {number}"

    play_auto(game, auto, seconds=seconds, on_tick=check).match.close()


def _rest_heights(match: Match, kind: GamePieceConfig, slots: IntArray) -> FloatArray:
    """Return the height of each piece's center at rest on the carpet with the current attitude [m], shape (n,)."""
    if isinstance(kind.shape, Sphere):
        return np.full(len(slots), kind.rest_height)
    return np.array([kind.rest_height_at((x, y, z, w)) for w, x, y, z in match.pieces.attitudes(slots).tolist()])


def check_placed(game: Game, auto: str, *, seconds: float | None = None) -> None:
    """Check the placed pieces after each tick.

    All placed pieces must be inside the zones of the resting places. The number of pieces in a resting place must not
    exceed the capacity, and must be equal to the number of `placed` events minus the number of `removed` events.
    """
    events: Counter[str] = Counter()

    def counted(match: PlayedMatch) -> Rules:
        rules = game.rules(match)
        placed, removed = rules.placed, rules.removed

        def note_placed(event: PlaceEvent) -> None:
            events[event.place.name] += 1
            placed(event)

        def note_removed(event: PlaceEvent) -> None:
            events[event.place.name] -= 1
            removed(event)

        rules.placed, rules.removed = note_placed, note_removed  # type: ignore[method-assign]
        return rules

    def check(match: Match) -> None:
        for place in game.places:
            where = f"{game.name}, tick {match.ticks}, {place.name}"
            slots = match.pieces.places.slots(place.name)
            assert place.zone.contains(match.pieces.state.pos[slots]).all(), f"{where}: a placed piece is outside"
            assert len(slots) <= (place.capacity or math.inf), (
                f"{where}: {len(slots)} pieces, capacity {place.capacity}"
            )
            assert len(slots) == events[place.name], f"{where}: {len(slots)} pieces, by events {events[place.name]}"

    play_auto(dataclasses.replace(game, rules=counted), auto, seconds=seconds, on_tick=check).match.close()
