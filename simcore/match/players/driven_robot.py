"""A robot that a person drives: field-relative by two sticks, with a button for the intake and four for actions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from simcore.errors import ConfigError
from simcore.match.game import PlayedMatch
from simcore.match.players.lineup import WhileEnabled
from simcore.match.scoring import Alliance
from simcore.match.scripted import Script, ScriptedRobot, ScriptSettings, Steps
from simcore.quantities import COUNT, Quantity, require_fields, shown
from simcore.robot.robot import Controller, Robot
from simcore.robot.swerve_drive import SwerveDrive
from simcore.units import TICK

__all__ = ["DrivenRobot", "Driver", "DriverControls", "DriverInput", "HandedOver"]

_STICK = Quantity("", -1.0, 1.0)
_MOST_TURN = math.tau  # of a stick that is pushed to its end [rad/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverInput:
    """What a person wants of a robot now."""

    ahead: float = 0.0
    """Away from the own driver station, as a share of full speed [-]."""
    left: float = 0.0
    """To the left as seen from the own driver station [-]."""
    turn: float = 0.0
    """Counter-clockwise seen from above [-]."""
    intake: bool = False
    """Whether to take pieces in."""
    action: int | None = None
    """Which action of the game is held, by its place among them; None, or one that the game does not have: none."""
    device: str = "keyboard"
    """What the person holds, in words."""

    def __post_init__(self) -> None:
        require_fields(self, ahead=_STICK, left=_STICK, turn=_STICK, action=COUNT)


Driver: TypeAlias = Callable[[], "DriverInput | None"]
"""What a person wants now; None while nobody drives."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverControls:
    """What the buttons of a person do who drives a robot of a game; sticks and intake are the same in all games."""

    settings: ScriptSettings = field(default_factory=ScriptSettings)
    """How the robot is handled."""
    actions: Mapping[str, Script] = field(default_factory=dict)
    """Up to four scripts by what people call them, in the order of the buttons; each runs while its button is held."""
    rest: Callable[[ScriptedRobot], None] = lambda robot: None
    """Commands the mechanisms as they are while no action runs; called at the start and after each action."""

    def __post_init__(self) -> None:
        require_fields(self)
        if len(self.actions) > 4:
            raise ConfigError(f"DriverControls: actions must be at most 4 scripts by name, got {shown(self.actions)}")

    def controller(self, match: PlayedMatch, alliance: Alliance, driver: Driver) -> DrivenRobot:
        """Make what commands a robot as a driver wants."""
        return DrivenRobot(self, match, alliance, driver)


class DrivenRobot(ScriptedRobot):
    """A controller that does what a person wants; for robots with swerve.

    While an action steers, as one that aims, the sticks do not. While nobody drives, the robot stands.

    Args:
        controls: What the buttons do.
        match: In which it plays.
        alliance: Whose robot it is.
        driver: The person.
    """

    def __init__(self, controls: DriverControls, match: PlayedMatch, alliance: Alliance, driver: Driver) -> None:
        super().__init__(lambda _: self._follow(), match, alliance, controls.settings)
        self._controls = controls
        self._driver = driver
        self._is_steered = False
        self._last = -math.inf

    def __call__(self, robot: Robot, time: float) -> None:
        """One tick."""
        if time > self._last + 1.5 * TICK:  # robots were disabled meanwhile
            super().stop()
        self._last = time
        super().__call__(robot, time)

    def accelerate_to(self, vx: float, vy: float, turn: float = 0.0) -> None:
        """As the script of an action wants it; the sticks do not count in this tick."""
        self._is_steered = True
        super().accelerate_to(vx, vy, turn)

    def stop(self) -> None:
        """Stand still; the sticks do not count in this tick."""
        self._is_steered = True
        super().stop()

    # --- inside -------------------------------------------------------------------------------------------------

    def _follow(self) -> Steps:
        actions = tuple(self._controls.actions.values())
        number: int | None = None  # of the action that is held
        steps: Steps | None = None  # of it, until it ends
        self._controls.rest(self)
        while True:
            wants = self._driver()
            held = None if wants is None or wants.action not in range(len(actions)) else wants.action
            if held != number:
                if steps is not None:
                    self._end(steps)
                number, steps = held, None if held is None else actions[held](self)
            self.intake(wants is not None and wants.intake)
            self._is_steered = False
            if steps is not None and next(steps, self) is self:
                self._end(steps)
                steps = None
            if wants is None:
                super().stop()
            elif not self._is_steered:
                self._steer(wants)
            yield

    def _end(self, steps: Steps) -> None:
        steps.close()
        self.hold_fire()
        self._controls.rest(self)

    def _steer(self, wants: DriverInput) -> None:
        drive = self.robot.drive
        assert isinstance(drive, SwerveDrive)
        hand = 1.0 if self.alliance == "blue" or self._symmetry.keeps_hands else -1.0  # left of a mirrored station
        super().accelerate_to(drive.max_speed * wants.ahead, hand * drive.max_speed * wants.left)
        self._velocity = (*self._velocity[:2], hand * min(_MOST_TURN, drive.max_omega) * wants.turn)


class HandedOver:
    """A robot that plays an auto until a person takes it over, who then has it while robots may move.

    Args:
        match: In which it plays.
        alliance: Whose robot it is.
        auto: What it does before.
        driver: The person.
        from_teleop: Whether nobody can take it over in auto.
    """

    def __init__(
        self, match: PlayedMatch, alliance: Alliance, auto: Controller, driver: Driver, *, from_teleop: bool = False
    ) -> None:
        controls = match.game.driving or DriverControls()
        self._driven = WhileEnabled(match, lambda: controls.controller(match, alliance, driver))
        self._match, self._auto, self._driver = match, auto, driver
        self._from_teleop = from_teleop
        self.is_taken = False
        """Whether a person has taken it over."""

    def __call__(self, robot: Robot, time: float) -> None:
        """One tick."""
        may = not self._from_teleop or self._match.timer.phase.mode == "teleop"
        self.is_taken = self.is_taken or (may and self._driver() is not None)
        (self._driven if self.is_taken else self._auto)(robot, time)
