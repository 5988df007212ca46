"""Controllers for a robot that a person drives field-relative with two sticks, an intake button and action buttons."""

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
_MOST_TURN = math.tau  # [rad/s] at full stick


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverInput:
    """State of a driver's sticks and buttons in one tick."""

    ahead: float = 0.0
    """Commanded speed away from the driver station, relative to the full speed [-]."""
    left: float = 0.0
    """Commanded speed to the left as seen from the driver station, relative to the full speed [-]."""
    turn: float = 0.0
    """Commanded yaw rate, counter-clockwise positive, relative to the full yaw rate [-]."""
    intake: bool = False
    """Whether the driver commands the intake to run."""
    action: int | None = None
    """Index of the action whose button is held; None if no action button is held."""
    device: str = "keyboard"
    """Name of the input device."""

    def __post_init__(self) -> None:
        require_fields(self, ahead=_STICK, left=_STICK, turn=_STICK, action=COUNT)


Driver: TypeAlias = Callable[[], "DriverInput | None"]
"""Function that returns the current input, or None while no person drives."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverControls:
    """Driver controls of a game: action buttons, and settings of the robot.

    The sticks and the intake button have the same effect in all games.
    """

    settings: ScriptSettings = field(default_factory=ScriptSettings)
    """Settings of the robot's acceleration, shooter and intake."""
    actions: Mapping[str, Script] = field(default_factory=dict)
    """Script of each action button, at most four, by label and in the order of the buttons.

    A script runs while the driver holds the button.
    """
    rest: Callable[[ScriptedRobot], None] = lambda robot: None
    """Function that sets the commands of the mechanisms while no action runs.

    The controller calls the function at the start and after each action.
    """

    def __post_init__(self) -> None:
        require_fields(self)
        if len(self.actions) > 4:
            raise ConfigError(f"DriverControls: actions must be at most 4 scripts by name, got {shown(self.actions)}")

    def controller(self, match: PlayedMatch, alliance: Alliance, driver: Driver) -> DrivenRobot:
        """Return a controller that drives the robot according to a driver's inputs."""
        return DrivenRobot(self, match, alliance, driver)


class DrivenRobot(ScriptedRobot):
    """Controller that drives a robot with a swerve drive according to a driver's inputs.

    The sticks have no effect while an action steers, e.g. to aim. The robot stands still while no person drives.

    Args:
        controls: Action buttons and robot settings.
        match: Match in which the robot plays.
        alliance: Alliance of the robot.
        driver: Function that returns the driver's current input, or None while no person drives.
    """

    def __init__(self, controls: DriverControls, match: PlayedMatch, alliance: Alliance, driver: Driver) -> None:
        super().__init__(lambda _: self._follow(), match, alliance, controls.settings)
        self._controls = controls
        self._driver = driver
        self._is_steered = False
        self._last = -math.inf

    def __call__(self, robot: Robot, time: float) -> None:
        """Run one tick of driving; first reset the commanded velocity to zero if the robots were disabled before."""
        if time > self._last + 1.5 * TICK:  # the robots were disabled in between
            super().stop()
        self._last = time
        super().__call__(robot, time)

    def accelerate_to(self, vx: float, vy: float, turn: float = 0.0) -> None:
        """Change the commanded velocity as a command of an action's script; the sticks have no effect in this tick."""
        self._is_steered = True
        super().accelerate_to(vx, vy, turn)

    def stop(self) -> None:
        """Command zero velocity for an action's script; the sticks have no effect in this tick."""
        self._is_steered = True
        super().stop()

    # --- inside -------------------------------------------------------------------------------------------------

    def _follow(self) -> Steps:
        actions = tuple(self._controls.actions.values())
        number: int | None = None  # of the held action
        steps: Steps | None = None  # of that action, until it ends
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
        # left is reversed at a mirrored driver station
        hand = 1.0 if self.alliance == "blue" or self._symmetry.keeps_hands else -1.0
        super().accelerate_to(drive.max_speed * wants.ahead, hand * drive.max_speed * wants.left)
        self._velocity = (*self._velocity[:2], hand * min(_MOST_TURN, drive.max_omega) * wants.turn)


class HandedOver:
    """Controller that runs another controller, such as an auto, until a person takes over and drives.

    Args:
        match: Match in which the robot plays.
        alliance: Alliance of the robot.
        auto: Controller of the robot before a person takes over.
        driver: Function that returns the driver's current input, or None while no person drives.
        from_teleop: Whether a person can take over only in teleop.
    """

    def __init__(
        self, match: PlayedMatch, alliance: Alliance, auto: Controller, driver: Driver, *, from_teleop: bool = False
    ) -> None:
        controls = match.game.driving or DriverControls()
        self._driven = WhileEnabled(match, lambda: controls.controller(match, alliance, driver))
        self._match, self._auto, self._driver = match, auto, driver
        self._from_teleop = from_teleop
        self.is_taken = False
        """Whether a person has taken over."""

    def __call__(self, robot: Robot, time: float) -> None:
        """Run one tick of `auto` or, after a person has taken over, of the controller that follows the driver."""
        may = not self._from_teleop or self._match.timer.phase.mode == "teleop"
        self.is_taken = self.is_taken or (may and self._driver() is not None)
        (self._driven if self.is_taken else self._auto)(robot, time)
