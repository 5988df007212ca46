"""Robot under test with the interface of `RobotTest`, for a robot program that runs in another process."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import SimpleNamespace

from simcore import season
from simcore.bridge.mirrored_ports import MirroredPorts
from simcore.bridge.packets import CLOCK, LOOK, Record
from simcore.bridge.robot_process import ProgramError, RobotProcess
from simcore.errors import ConfigError
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import PORT_CONTROLLERS, RobotSettings
from simcore.robotcode.sim.attach import PhysicsHook, watch_program
from simcore.robotcode.sim.attached_physics import AttachedPhysics
from simcore.robotcode.sim.robot_test import RobotTest
from simcore.units import TICK

Timer = season.wpilib.Timer
simulation = season.wpilib_simulation

__all__ = ["ServedRobot", "require_ports"]

_log = logging.getLogger(__name__)

_LOOK = 5  # [ticks], time between requests for the choosers while the robot is disabled
_POLL = 0.005  # [s], wall time between checks for the start of the program


class Program:
    """Placeholder for the program's robot object; the robot object itself is in the other process."""


class ServedRobot(RobotTest):
    """Robot under test, like the fixture `sim`, for a robot program in another process.

    Args:
        process: Process of the program, started but not yet connected.
        file: Path of the file that describes the robot, usually simcore.toml.
        game: Name of the game; None for the game in the file.
        engine: Name of the physics engine; None for the engine in the file.
        match: Name of a full match with scripted players; None for the match in the file.
        real_time: Whether the program's clock runs freely on the wall clock.
        follows: Whether the program's own driver station enables the robot, for example WPILib's Sim GUI.

    Raises:
        ConfigError: If the file is invalid or names a device that cannot be stepped, or if the bridge does not support
            the WPILib version.
    """

    def __init__(
        self,
        process: RobotProcess,
        file: Path,
        *,
        game: str | None = None,
        engine: str | None = None,
        match: str | None = None,
        real_time: bool = False,
        follows: bool = False,
    ) -> None:
        if season.clock_rate() != 1e6:
            raise ConfigError(
                "the bridge cannot step programs of this WPILib version: docs/java.md names the season that it steps"
            )
        settings = read_settings(file)
        require_ports(settings)
        AttachedPhysics.ownership = watch_program()
        AttachedPhysics.folder, AttachedPhysics.file_name = file.parent, file.name
        AttachedPhysics.game_name, AttachedPhysics.engine_name, AttachedPhysics.match_name = game, engine, match
        season.initialize_hal()
        if not real_time:
            simulation.pause_timing()
        self._process = process
        self._ports = MirroredPorts(settings, follows=follows)
        self._is_real_time = real_time
        self._served: AttachedPhysics | None = None
        self._ticked = 0
        self._due = 0.0
        control = SimpleNamespace(_thread=None, _reraise=SimpleNamespace(exception=None), robot_is_alive=True)
        super().__init__(control, Program(), PhysicsHook([AttachedPhysics], nullcontext))

    def connect(self) -> None:
        """Connect to the program, set the mode of the program's clock, and wait until the main loop has started.

        Raises:
            ProgramError: If the program does not connect, or does not reach its main loop in time.
        """
        end = time.monotonic() + self._process.patience
        self._ports.take(self._process.connect())
        self._exchange(0.0, [Record(CLOCK, 0, 0, float(self._is_real_time))])
        while not self._ports.has_started:
            if time.monotonic() > end:
                raise ProgramError(
                    "the robot program has connected, but has not reached its first loop within "
                    f"{self._process.patience:g} s: a constructor or robotInit waits; --wait gives it longer"
                )
            time.sleep(_POLL)
            self._exchange(0.0, [])

    def ask_choosers(self) -> None:
        """Request the choosers of the program, and publish the choosers on simcore's NetworkTables."""
        self._exchange(0.0, [Record(LOOK, 0, 0, 0.0)])

    def _run_robot(self) -> None:
        self.connect()

    def _build(self) -> None:
        """Build the robot and the field for the open ports, and step the program's clock by half a part.

        A part is the fraction of a tick between two exchanges with the program.
        """
        self._hook.begin(self.robot)
        assert self._hook.engine is not None
        self._served = self._hook.engine[0]
        self._exchange(0.5 * self._served.part, self._ports.driver_station())

    def _advance(self, seconds: float) -> None:
        """Step the physics and the program alternately, one part of a tick at a time.

        The first call only builds the physics.

        The program's clock is half a part ahead of the physics. The driver station data are sent with the last part of
        the tick, because the program's loop runs in this part, as for a program in this process.
        """
        if self._served is None:
            self._build()  # also takes the first step, as for a program in this process
            return
        physics = self._served
        parts = round(seconds / physics.part)
        for number in range(parts):
            if self._is_real_time:
                self._wait_for(physics.part)
            else:
                simulation.step_timing(physics.part + 0.5e-6)  # truncates to whole microseconds
            physics.do_due()
            values = self._ports.inputs()
            if number == parts - 1:
                values = [*self._ports.driver_station(), *self._look()]
            self._exchange(0.0 if self._is_real_time else physics.part, values)
        physics.update_sim(float(Timer.get_monotonic_timestamp()), TICK)
        self._ticked += 1

    def _look(self) -> list[Record]:
        is_due = self._mode == "disabled" and self._ticked % _LOOK == 0
        return [Record(LOOK, 0, 0, 0.0)] if is_due else []

    def _exchange(self, seconds: float, values: list[Record]) -> None:
        self._ports.take(self._process.exchange(round(1e6 * seconds), values))
        for text in self._ports.errors:
            if text not in self.warnings:
                _log.warning("the program reports: %s", text)
        self._ports.errors.clear()

    def _wait_for(self, seconds: float) -> None:
        """Wait on the wall clock until the next part of the tick is due."""
        self._due = max(self._due + seconds, time.monotonic() - TICK)
        time.sleep(max(0.0, self._due - time.monotonic()))

    @contextmanager
    def _watched(self, awaited: str) -> Iterator[None]:
        """Run the block without a time limit, because `RobotProcess` limits the time of each step."""
        yield


def require_ports(settings: RobotSettings) -> None:
    """Check that simcore.toml names only devices that the bridge can step.

    Raises:
        ConfigError: If the settings name a device that cannot be stepped.
    """
    table = settings.drivetrain
    named = [("[drivetrain]", model) for model in (table.controller, table.steer_controller, table.gyro) if model]
    named += [(f"[[mechanism]] {m.name!r}", m.controller) for m in settings.mechanisms]
    named += [(f"[[mechanism]] {m.name!r}", "CANcoder") for m in settings.mechanisms if m.cancoder is not None]
    named += [(f"[[sensor]] {s.name!r}", s.keys[0][0]) for s in settings.sensors]
    for where, model in named:
        for prefix, why in _REFUSED.items():
            if model.startswith(prefix):
                raise ConfigError(f"simcore.toml {where}: {model} {why}; {_WORKS}")


_WORKS = (
    "what works over the bridge: controllers "
    f"{', '.join(PORT_CONTROLLERS)}, encoders and switches on DIO, analog inputs, duty cycles, ADIS16448, ADIS16470, "
    "ADXRS450 and AnalogGyro (docs/java.md)"
)
_CTRE = "(CTRE) runs on the wall clock in simulation and cannot be stepped"
_REV = (
    "(REV) computes its output only if the program calls SparkSim.iterate(velocity, busVoltage, 0.02) in "
    "simulationPeriodic, with a velocity that the program must know"
)
_REFUSED = {
    **dict.fromkeys(("TalonFX", "CANcoder", "Pigeon2", "CANrange", "CANdi", "CANdle", "TalonSRX", "VictorSPX"), _CTRE),
    "SPARK": _REV,
    "navX": "reads its simulated yaw in a thread that runs on the wall clock",
}
