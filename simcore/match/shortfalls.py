"""Reasons why a robot took in no pieces or shot no pieces, one sentence for each part that did not work."""

from __future__ import annotations

import math
from collections.abc import Iterator

from simcore.robot.intake import Intake, is_deployed
from simcore.robot.mechanisms import ShaftSim, place_text
from simcore.robot.robot import Robot
from simcore.robot.shooter import Shooter

__all__ = ["Shortfalls"]

_REQUEST = 0.02  # volts or duty cycle; smaller requests count as zero
_PERIOD = 5  # ticks between checks
_ENOUGH = 8  # checks with requests in one direction; a part with fewer may not have had enough time
_UNMOVED = 0.05  # of the travel between the stops; a smaller movement counts as none
_ELSEWHERE = 0.5  # [m]; tolerated distance between pose estimate and true pose


class Shortfalls:
    """Monitor that checks the intakes and shooters of one robot ten times a second.

    The monitor checks an intake or shooter only until the part has worked once, to save computing time.

    Args:
        robot: Robot to monitor.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._ranges: dict[str, tuple[float, float]] = {}  # of positions, or of speeds for rollers and wheels
        self._requested: dict[str, int] = {}  # number of checks with positive requests minus negative requests
        self._idle = list(enumerate(robot.intakes, 1))  # intakes that have not worked yet
        self._silent = list(enumerate(robot.shooters, 1))  # shooters whose gate has not been open yet
        self._empty_at: dict[int, float] = {}  # time of the first opening without pieces [s], by shooter number
        self._coasting: dict[str, int] = {}  # number of shots while a feeder was coasting, by name of the feeder
        self._shots = self._ticks = 0

    def after_tick(self, time: float) -> None:
        """Check the intakes and shooters in every fifth call; call once per tick, before the shots of the tick.

        Args:
            time: Simulated time at the end of the tick [s].
        """
        self._ticks += 1
        if self._ticks % _PERIOD:
            return
        for number, intake in list(self._idle):
            config = intake.config
            if intake.is_active:
                self._idle.remove((number, intake))
            for name in (config.deploy, config.roller):
                if name is not None:
                    self._record_range(name, is_position=name == config.deploy)
        for number, shooter in list(self._silent):
            for name in (*shooter.config.wheels, *shooter.config.gate):
                self._record_range(name, is_position=False)
            if shooter.gate_open:
                self._silent.remove((number, shooter))
                if not self._shots and not self._robot.storage_of(shooter.config).pieces:
                    self._empty_at[number] = time

    def note_shot(self) -> None:
        """Count a shot of the robot, and add 1 to the count of each feeder that coasts without output."""
        self._shots += 1
        for name in dict.fromkeys(name for shooter in self._robot.shooters for name in shooter.config.gate):
            if self._mechanism(name).record["request"]["value"][0] == 0.0:
                self._coasting[name] = self._coasting.get(name, 0) + 1

    def lines(self, *, taken_in: int) -> Iterator[str]:
        """Yield a sentence for each commanded part that did not work, each coasting feeder, and a wrong pose estimate.

        Args:
            taken_in: Number of pieces that the robot has taken in.
        """
        if not taken_in:
            for number, intake in self._idle:
                yield from self._of_intake(f"intake {number}", intake)
        if not self._shots:
            for number, shooter in self._silent:
                yield from self._of_shooter(f"shooter {number}", shooter)
            for number, time in self._empty_at.items():
                yield f"shooter {number} had nothing to throw: its storage was empty as it opened, at {time:.2f} s"
        for name, count in self._coasting.items():
            yield (
                f"{count} of {self._shots} shots left while {name!r} had no output and coasted: brake it, or bring the "
                "wheels up to speed before it feeds"
            )
        estimated, (x, y, _) = self._robot.estimated_pose, self._robot.chassis.pose
        if estimated is not None and math.dist(estimated[:2], (x, y)) > _ELSEWHERE:
            yield (
                f"the program believes that it is at ({estimated[0]:.2f}, {estimated[1]:.2f}) m, but the robot is at "
                f"({x:.2f}, {y:.2f}) m"
            )

    # --- inside ---------------------------------------------------------------------------------------------------

    def _mechanism(self, name: str) -> ShaftSim:
        return self._robot.mechanisms[name]

    def _record_range(self, name: str, *, is_position: bool) -> None:
        record = self._mechanism(name).record
        value, request = float(record["position" if is_position else "speed"][0]), float(record["request"]["value"][0])
        low, high = self._ranges.get(name, (value, value))
        self._ranges[name] = min(low, value), max(high, value)
        if abs(request) > _REQUEST:
            self._requested[name] = self._requested.get(name, 0) + (1 if request > 0.0 else -1)

    def _of_intake(self, whose: str, intake: Intake) -> Iterator[str]:
        config = intake.config
        if abs(self._requested.get(config.roller or config.deploy or "", 0)) < _ENOUGH:  # never commanded
            return
        if config.deploy is not None:
            low, high = self._ranges[config.deploy]
            mechanism = self._mechanism(config.deploy)
            nearest = high if config.deployed_at == "upper" else low
            lower, upper = mechanism.stops
            if not is_deployed(nearest, mechanism.stops, config.deployed_at):
                start, stop = (lower, "lower") if config.deployed_at == "upper" else (upper, "upper")
                text = f"{whose} was never out: {config.deploy!r} came to {place_text(mechanism, nearest)}"
                if abs(nearest - start) < _UNMOVED * (upper - lower):
                    place = place_text(mechanism, start)
                    text = f"{whose} was never out: {config.deploy!r} stayed at its {stop} stop, {place}"
                    asked = self._requested.get(config.deploy, 0)
                    if not asked:
                        text += ", and was not asked to move"
                    elif (asked > 0) == (stop == "upper"):
                        text += ", and was driven against it: does your code count the other way? reversed = true"
                yield f"{text} (it is out near its {config.deployed_at} stop)"
        if config.roller is not None:
            low, high = self._ranges[config.roller]
            best, other = (-low, high) if config.roller_reversed else (high, -low)
            if best <= config.roller_speed:
                yield _too_slow(whose, config.roller, best, other, config.roller_speed)

    def _of_shooter(self, whose: str, shooter: Shooter) -> Iterator[str]:
        config = shooter.config
        if all(abs(self._requested.get(name, 0)) < _ENOUGH for name in (*config.wheels, *config.gate)):
            return
        best = sum(self._ranges[name][1] for name in config.wheels) / len(config.wheels)
        other = -sum(self._ranges[name][0] for name in config.wheels) / len(config.wheels)
        if best <= config.min_wheel_speed:
            yield _too_slow(whose, "' and '".join(config.wheels), best, other, config.min_wheel_speed)
        for name in config.gate:
            low, high = self._ranges[name]
            best, other = (-low, high) if name in config.gate_reversed else (high, -low)
            if best <= config.gate_speed:
                yield _too_slow(whose, name, best, other, config.gate_speed)


def _too_slow(whose: str, name: str, best: float, other: float, least: float) -> str:
    """Return the sentence for a roller or wheel that never reached the required speed.

    Args:
        whose: Name of the part in the sentence.
        name: Name of the mechanism.
        best: Largest speed in the required direction [rad/s]; negative if there was no such speed.
        other: Largest speed in the opposite direction [rad/s].
        least: Required speed [rad/s].
    """
    reached = max(0.0, best) / math.tau
    text = f"{whose}: {name!r} reached {reached:.1f} of the {least / math.tau:.1f} turns/s that it needs"
    if other > least:
        text += f", but {other / math.tau:.1f} backward: does your code count the other way? reversed = true"
    return text
