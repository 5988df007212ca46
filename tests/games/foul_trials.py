"""Short trials in which robots drive from given poses at a given match time and may commit a foul."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from match_laws import show_time

from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.world.symmetry import Pose


def flipped(game: Game, alliance: str, pose: Pose) -> Pose:
    """Return the pose for an alliance that corresponds to a pose written for blue."""
    return pose if alliance == "blue" else game.field.symmetry.flip_pose(*pose)


def begin(match: Match, time: float) -> None:
    """Start auto and set the match clock to a time [s]."""
    match.start_mode("auto")
    show_time(match, time)


def told(match: Match) -> list[tuple[str, str, int]]:
    """Return rule, committing alliance and points of each foul."""
    return [(foul.rule, foul.alliance, foul.points) for foul in match.tracker.fouls]


def foul_trials(game: Game, *, far: Sequence[Pose]) -> Iterator[Callable[..., Match]]:
    """Yield `play(poses, time, ...)`, which plays a match with robots driving from `poses` at a clock time [s].

    Robots 0, 1 and 2 are blue, red and blue, and stand far away without a pose; `side="red"` swaps alliances and
    places. For use by a fixture.
    """
    matches: dict[tuple[str, int], Match] = {}

    def run(
        poses: Mapping[int, Pose],
        time: float,
        *,
        drive: Mapping[int, tuple[float, float, float]] | None = None,
        act: Callable[[Match], None] | None = None,
        side: str = "blue",
        seconds: float = 0.4,
    ) -> Match:
        crew = max([1, *poses]) + 1
        if (side, crew) not in matches:
            other = "red" if side == "blue" else "blue"
            entries = tuple(RobotEntry(alliance=a, preload=0) for a in (side, other, side)[:crew])
            matches[side, crew] = Match(game, robots=entries)
        match = matches[side, crew]
        begin(match, time)
        for robot in match.robots:
            robot.drive.set_chassis_speeds(0.0, 0.0, 0.0)
            robot.put(flipped(game, side, poses.get(robot.number, far[robot.number])), believed=None)
        match.tick()
        begin(match, time)
        for number, speeds in (drive or {}).items():
            match.robots[number].drive.set_chassis_speeds(*speeds)
        if act is not None:
            act(match)
        match.play(seconds)
        return match

    yield run
    for match in matches.values():
        match.close()
