"""The hook between `robotpy sim` (or `robotpy test`) and a simulated game."""

from __future__ import annotations

import atexit
import gc
import logging
import sys
import time
import weakref
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from hal.simulation import isTimingPaused
from wpilib import DriverStation, Timer

from simcore.errors import ConfigError
from simcore.robotpy.between_loops import run_between_loops
from simcore.robotpy.field_view import FieldView
from simcore.robotpy.match_time import MatchTime
from simcore.robotpy.roborio import RoboRioPower
from simcore.robotpy.seams import DrivetrainDevices, Game, MotorDevices, Plant

if TYPE_CHECKING:
    from simcore.robotpy.fine_steps import FineSteps
    from simcore.robotpy.simulated_phoenix import PhoenixTime

__all__ = ["RobotPhysics", "TickTimes", "latest_physics"]

_log = logging.getLogger(__name__)

TICK = 0.02  # [s]; of a game
_MOST_OWED = 20  # parts; a stall longer than this is skipped, not caught up with
_HISTORY = 6000  # ticks; two minutes


@dataclass(frozen=True, slots=True, kw_only=True)
class TickTimes:
    """What the physics cost, and whether it kept up."""

    ticks: int
    median_ms: float
    """Work per 20 ms tick, wall time [ms]."""
    p99_ms: float
    max_ms: float
    late_parts: int
    """Parts of a tick that came late enough to be made up for in one go."""
    skipped: float
    """Time that was given up because the robot program stood still for too long [s]."""
    late_loops: int
    """Robot loops that came half a period late, whoever's fault it was."""
    lateness_ms: float
    """How late parts came where a test keeps to the wall clock, 99th percentile [ms]: how old rotors were."""


class RobotPhysics:
    """Runs a game under a robot program: base class for the `PhysicsEngine` in a team's physics.py.

    Everything happens on the robot's thread, in parts of 5 ms: volts are read from the devices, the game moves, sensors
    are written. A TimedRobot of any period gets the parts through `addPeriodic`, a MagicRobot while it waits for its
    next loop, others get those that are due at once from `update_sim`.

    pyfrc replaces the robot's own `_simulationInit` and `_simulationPeriodic`; a warning says so if there are any.
    `simulationPeriodic` of subsystems goes on to work.

    Args:
        physics_controller: From pyfrc.
        robot: The robot object.
        game: The game, e.g. `RebuiltSim`; it is closed when the program ends.
        plant: Which of its robots this program drives, e.g. `game.robots[0]`.
        drivetrain: Its devices, e.g. `SwerveDrivetrainSim`; None if it has none.
        motors: Devices of its mechanisms, e.g. `TalonFXMotorSim`.
        parts: In how many parts a tick is cut; None: 4 of 5 ms, or in simulated time 1 for a robot with a loop of
            20 ms, whose controllers are then asked in the middle of it.
        pace_tests: In tests that use CTRE's own simulation (`--phoenix=real`) time jumps, but Phoenix 6 lives on the
            wall clock: keep to it, so that its loops see what they see on the robot. False runs as fast as it can.
            In simulated time, which is the default in tests, nothing waits for a clock.

    Raises:
        ConfigError: A device is not one, or `parts` is not a whole number from 1 to 20.
    """

    def __init__(
        self,
        physics_controller: Any,
        robot: Any,
        *,
        game: Game,
        plant: Plant,
        drivetrain: DrivetrainDevices | None = None,
        motors: Sequence[MotorDevices] = (),
        parts: int | None = None,
        pace_tests: bool = True,
    ) -> None:
        self._phoenix = _phoenix_time()
        self._period = float(getattr(robot, "getPeriod", lambda: TICK)())
        self._drivetrain = drivetrain
        self._motors = list(motors)
        self._fine = self._fine_steps(plant) if parts is None and self._period >= TICK else None
        if parts is None:
            parts = 4 if self._fine is None else 1
        if not (isinstance(parts, int) and 1 <= parts <= 20):
            raise ConfigError(f"RobotPhysics: parts must be a whole number from 1 to 20, got {parts!r}")
        for device in (*motors, *(() if drivetrain is None else (drivetrain,))):
            if not (callable(getattr(device, "read", None)) and callable(getattr(device, "write", None))):
                raise ConfigError(f"RobotPhysics: {device!r} has no read and write; wrap it, e.g. in TalonFXMotorSim")
        if self.replaces_hooks:
            _warn_of_replaced_hooks(robot)
        self.robot = robot
        self.game = game
        self.plant = plant
        self._parts = parts
        self._h = TICK / parts
        self._part = 0
        self._pace_tests = pace_tests and self._phoenix is None
        self._late: deque[float] = deque(maxlen=4 * _HISTORY)
        # In simulated time nobody looks on, and drawing 504 fuel takes half a millisecond.
        self._view = FieldView(physics_controller.field, every=10 if self._phoenix is None else 50)
        self._match_time = MatchTime()
        self._start: float | None = None
        self._done = 0
        self._last_wall = 0.0
        self._work = 0.0
        self._work_ms: deque[float] = deque(maxlen=_HISTORY)
        self._ticks = self._late_parts = self._late_loops = 0
        self._skipped = 0.0
        self._color: DriverStation.Alliance | None = None
        self._was_enabled = False
        self._comes_in_time = hasattr(robot, "addPeriodic")
        self._power = RoboRioPower(plant.battery)
        global _latest
        _latest = weakref.ref(self)
        if self._comes_in_time:
            robot.addPeriodic(self.do_due, self._h, self._h / 2.0)  # never at the same instant as the robot's loop
        else:
            self._comes_in_time = run_between_loops(self)
            if not self._comes_in_time:
                _log.warning("%s has no addPeriodic: physics runs in bursts, once a loop", type(robot).__name__)
        atexit.register(game.close)

    replaces_hooks = True
    """Whether pyfrc runs this in place of the robot's own hooks, as it does with a physics.py."""

    def after_tick(self) -> None:
        """Called after each tick of 20 ms; for subclasses, e.g. to log or to feed cameras."""

    def update_sim(self, now: float, tm_diff: float) -> None:
        """Pyfrc's hook, once a robot loop (but never within 10 ms)."""
        if tm_diff > 1.5 * max(self._period, 0.010) + 0.010 * (self._period < 0.020):
            self._late_loops += 1
        if not self._comes_in_time:
            self.do_due()

    def add_motor(self, motor: MotorDevices) -> None:
        """Connect one more motor, from the next part on."""
        self._motors.append(motor)

    def remove_motor(self, motor: MotorDevices) -> None:
        """Disconnect a motor; its device keeps what was written last."""
        self._motors.remove(motor)

    @property
    def times(self) -> TickTimes:
        """What the last two minutes cost."""
        work = np.array(self._work_ms) if self._work_ms else np.zeros(1)
        return TickTimes(
            ticks=self._ticks,
            median_ms=float(np.median(work)),
            p99_ms=float(np.percentile(work, 99)),
            max_ms=float(work.max()),
            late_parts=self._late_parts,
            skipped=self._skipped,
            late_loops=self._late_loops,
            lateness_ms=1e3 * float(np.percentile(self._late, 99)) if self._late else 0.0,
        )

    @property
    def next_due(self) -> float:
        """When the next part is due, FPGA time [s]; the first comes half a part after it is asked for.

        So a loop and a part, whose periods are multiples, never meet at one instant.
        """
        if self._start is None:
            return float(Timer.getFPGATimestamp()) + 0.5 * self._h
        return self._start + (self._done + 1) * self._h

    def do_due(self) -> None:
        """Do all parts that are due by now."""
        now = Timer.getFPGATimestamp()
        if self._start is None:
            self._start = now - self._h
            gc.collect()
            gc.freeze()  # field, fuel and robot stay: the collector need not look at them in every run (5 % of a tick)
            if self._phoenix is not None:
                # A tick makes thousands of small objects, nearly all gone by its end: looking for cycles after every
                # 700 took 5 to 8 % of a test's time. On the wall clock shorter pauses matter more.
                gc.set_threshold(20_000, *gc.get_threshold()[1:])
                self._phoenix.catch_up(self._start)
        owed = int((now - self._start) / self._h + 0.5) - self._done
        if owed > _MOST_OWED:
            self._skipped += (owed - _MOST_OWED) * self._h
            self._done += owed - _MOST_OWED
            _log.warning("physics skips %.2f s: the robot program stood still", (owed - _MOST_OWED) * self._h)
            owed = _MOST_OWED
        self._late_parts += max(0, owed - 1)
        for _ in range(owed):
            if self._pace_tests and isTimingPaused():
                self._keep_to_the_wall_clock()
            begin = time.perf_counter()
            self._do_part()
            self._work += time.perf_counter() - begin
            self._done += 1
            if self._part == self._parts:
                self._end_tick()

    def _do_part(self) -> None:
        plant, drivetrain = self.plant, self._drivetrain
        volts = plant.battery.voltage
        powered = not plant.battery.browned_out
        if self._part == 0:
            self._power.show_voltage()
            self.game.begin_tick()
        self._part += 1
        if self._fine is not None:
            self._fine.begin()
            self.game.move(self._h)
            self._power.show_rails()
            return
        if drivetrain is not None:
            drivetrain.read(volts)
        for motor in self._motors:
            motor.read(volts, powered=powered)
        self.game.move(self._h)
        self._power.show_rails()
        if drivetrain is not None:
            gyro = plant.gyro
            drivetrain.write(gyro.yaw, gyro.pitch, gyro.roll, gyro.rates.tolist())
        for motor in self._motors:
            motor.write()
        if self._phoenix is not None:
            self._phoenix.step(self._h)

    def _fine_steps(self, plant: Plant) -> FineSteps | None:
        """In simulated time: devices that go with the drivetrain's inner steps, where plant and devices can."""
        if self._phoenix is None or self._drivetrain is None:
            return None
        from simcore.robotpy.fine_steps import FineSteps

        return FineSteps(plant, self._drivetrain, self._motors, self._phoenix) if FineSteps.supports(plant) else None

    def _end_tick(self) -> None:
        begin = time.perf_counter()
        self._part = 0
        assert self._start is not None
        self.game.set_clock(self._start + self._done * self._h)  # when it was due, not when the thread came to it
        self.game.end_tick()
        self._follow_alliance()
        period = self._match_time.update(TICK)
        if period:
            self.game.start_period(period)
        self._match_time.send(self.game.game_message)
        self._view.update(self.plant.chassis.pose, self.game.piece_places())
        self.after_tick()
        self._ticks += 1
        self._work_ms.append(1e3 * (self._work + time.perf_counter() - begin))
        self.game.last_tick_ms = self._work_ms[-1]
        self._work = 0.0

    def _follow_alliance(self) -> None:
        """Until the first enable the drive team carries the robot to where the chosen alliance starts."""
        if self._was_enabled:
            return
        self._was_enabled = DriverStation.isEnabled()  # the alliance may become known in the very packet that enables
        color = DriverStation.getAlliance()
        if color is not None and color != self._color:
            self._color = color
            self.game.set_alliance(self.plant.number, "red" if color == DriverStation.Alliance.kRed else "blue")

    def _keep_to_the_wall_clock(self) -> None:
        rest = self._last_wall + self._h - time.perf_counter()
        if rest > 0.0:
            time.sleep(rest)
        if self._last_wall:
            self._late.append(max(0.0, time.perf_counter() - self._last_wall - self._h))
        self._last_wall = max(self._last_wall + self._h, time.perf_counter() - self._h)


_latest: weakref.ref[RobotPhysics] | None = None


def latest_physics() -> RobotPhysics | None:
    """The physics that was built last in this process, if it still lives; for test fixtures."""
    return None if _latest is None else _latest()


def _phoenix_time() -> PhoenixTime | None:
    """The clock of simulated Phoenix 6 devices, if somebody has installed them; never loads phoenix6 itself."""
    module = sys.modules.get("simcore.robotpy.simulated_phoenix")
    return None if module is None else module.phoenix_time()  # type: ignore[no-any-return]


def _warn_of_replaced_hooks(robot: Any) -> None:
    for owner in type(robot).__mro__:
        for name in ("_simulationInit", "_simulationPeriodic"):
            # pyfrc's own are in a class that it gives the robot's name, which in tests is derived from once more
            maker = getattr(vars(owner).get(name), "__module__", None) or ""
            if maker.split(".")[0] not in ("", "wpilib", "pyfrc", "magicbot", "commands2", "builtins"):
                _log.warning(
                    "%s.%s is not called while there is a physics.py; do it in the PhysicsEngine's after_tick",
                    owner.__name__,
                    name,
                )
