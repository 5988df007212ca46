"""Summary of a robot's devices at the start of a run, with advice on tables to add to `simcore.toml`."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.robot_file.template import FILE_NAME

__all__ = ["StartupSummary"]

_WIDTH = 118
_MOST = 6  # largest number of rows under one label
_LABEL = 13
_ON_NETWORK = "WPILib (5810, 1735){} on every interface of this computer"
_NOT_ON_NETWORK = (
    "another program (a simulation that is still open?) holds port 5810 of NetworkTables: dashboards show that one, "
    "not this; close it and start again"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class StartupSummary:
    """Startup summary of a robot: one text or list of texts for each topic."""

    robot: str
    """Game, mass and dimensions of the robot, physics engine, and source of these values."""
    drivetrain: str
    """Models and addresses of the drivetrain's devices."""
    assumed: str = ""
    """Guessed dimensions and other values of the drivetrain; empty without guesses."""
    described: Sequence[str] = ()
    """Mechanisms in simcore.toml, with their devices."""
    sensors: Sequence[str] = ()
    """Sensors in simcore.toml, with their ports."""
    lights: str = ""
    """Devices with lights that telemetry records."""
    guessed: Sequence[tuple[str, str]] = ()
    """Devices and guessed mechanism of each group of motors."""
    own: str = ""
    """Devices that the project's own physics writes."""
    nobody: str = ""
    """Devices that no model writes and that keep the initial readings."""
    cameras: str = ""
    """Cameras that simcore simulates."""
    unseen: str = ""
    """Cameras that the program uses and that simcore does not simulate."""
    pushed: str = ""
    """Kinds of game pieces on the field if the robot description has no intake; empty with an intake."""
    has_file: bool = True
    """Whether the project has a simcore.toml."""
    is_on_network: bool | None = None
    """Whether the program can use NetworkTables' port; False if the port is taken, None without a network."""

    def lines(self) -> list[str]:
        """Return the line about the robot and the labelled lines of each topic.

        The lines are at most 118 characters long. Long topics end after two to five lines.

        >>> for line in StartupSummary(robot="Robot: 55 kg", drivetrain="TalonFX 1-8").lines():
        ...     print(line)
        Robot: 55 kg
          drivetrain   TalonFX 1-8
          cameras      none that simcore runs; [[camera]] in simcore.toml adds one
          to change    mass, bumpers and start are in [robot] and [start] of simcore.toml
        """
        rows = [("drivetrain", self.drivetrain)]
        if self.assumed:
            rows.append(("", f"guessed; set them in [drivetrain]: {self.assumed}"))
        rows += _some("described", list(self.described))
        rows += _some("sensors", list(self.sensors))
        rows += _some("guessed", [f"{devices}: {what}" for devices, what in self.guessed])
        if self.own:
            rows.append(("own physics", self.own))
        if self.nobody:
            rows.append(("not moved", f"{self.nobody}: keeps its reading from the start"))
        if self.lights:
            rows.append(("lights", f"{self.lights}: shown as Sim/Lights in telemetry"))
        if self.pushed:
            rows.append(("intake", f"not described: {self.pushed} is pushed, not taken in; [[intake]] describes one"))
        cameras = self.cameras or f"none that simcore runs; [[camera]] in {FILE_NAME} adds one"
        rows.append(("cameras", cameras + (f"; your program asks for {self.unseen}" if self.unseen else "")))
        if self.is_on_network is not None:
            phoenix = " and Phoenix (1250) listen" if "phoenix6" in sys.modules else " listens"
            rows.append(("network", _ON_NETWORK.format(phoenix) if self.is_on_network else _NOT_ON_NETWORK))
        rows.append(("to change", self._advice()))
        lines = [self.robot]
        for label, text in rows:
            lines += textwrap.wrap(
                text,
                _WIDTH,
                initial_indent=f"  {label:<{_LABEL}}",
                subsequent_indent=" " * (2 + _LABEL),
                max_lines={"": 5, "not moved": 4}.get(label, 2),
            )
        return lines

    def _advice(self) -> str:
        if not self.has_file:
            return f"`simcore init` writes a {FILE_NAME} with these motors; there is none yet"
        if self.guessed:
            number = self.guessed[0][0].split(" + ")[0].split()[-1]
            return (
                f"a guess becomes a mechanism with [[mechanism]] name, kind, leader = {number} and gearing in "
                f"{FILE_NAME}; mass, bumpers and start are in [robot] and [start]"
            )
        return f"mass, bumpers and start are in [robot] and [start] of {FILE_NAME}"


def _some(label: str, texts: Sequence[str]) -> list[tuple[str, str]]:
    """Return the rows (label, text) of one topic, at most six. The last row counts omitted texts."""
    shown = list(texts) if len(texts) <= _MOST else [*texts[: _MOST - 1], f"and {len(texts) - _MOST + 1} more"]
    return [(label if k == 0 else "", text) for k, text in enumerate(shown)]
