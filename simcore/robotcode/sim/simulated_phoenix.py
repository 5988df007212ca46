"""Phoenix 6 in FPGA time: the emulator of CTRE's libraries, enabled and stepped by the robot program's own clock."""

from __future__ import annotations

from typing import Any

from phoenix6.phoenix_native import Native
from phoenix6.wpiutils.auto_feed_enable import AutoFeedEnable

from simcore import season
from simcore.robotcode import emulator
from simcore.robotcode.emulator import Emulator

RobotState = season.wpilib.RobotState
Timer = season.wpilib.Timer

__all__ = ["PhoenixTime", "install_simulated_phoenix", "phoenix_time"]

_FEED_MS = 100  # as phoenix6's own Notifier feeds, every 10 ms


class PhoenixTime:
    """Keeps the simulated devices on the FPGA's clock.

    Phoenix 6 feeds its enable signal from a Notifier, a thread of its own: at the instants at which the robot's loop
    runs too, chance would decide which is first. Here the feed comes before each step, on the thread that steps.

    Args:
        world: The devices.
    """

    def __init__(self, world: Emulator) -> None:
        self.world = world

    def step(self, dt: float) -> None:
        """Feed the enable signal and let the devices run for dt [s]."""
        self.world.enable.feed(_FEED_MS if RobotState.is_enabled() else 0)
        self.world.step(dt)

    def catch_up(self, time: float) -> None:
        """Let the devices run until `time` on the FPGA's clock [s]; never back."""
        behind = time - self.world.clock.now
        if behind > 0.0:
            self.step(behind)


def install_simulated_phoenix() -> PhoenixTime:
    """Run Phoenix 6 in simulated time from here on, with no device yet; call before the robot object is built.

    Raises:
        SeamError: The installed phoenix6 does not fit; the text names a version that does.
    """
    world = emulator.install()
    world.clock.reset(season.start_of_clock())
    native: Any = Native.instance()
    native.c_ctre_phoenix6_get_current_time_seconds = Timer.get_monotonic_timestamp
    native.c_ctre_phoenix6_get_system_time_seconds = Timer.get_monotonic_timestamp
    native.c_ctre_phoenix6_get_monotonic_time_seconds = Timer.get_monotonic_timestamp
    feed: Any = AutoFeedEnable
    feed.start = feed.stop = _nothing
    return PhoenixTime(world)


def phoenix_time() -> PhoenixTime | None:
    """The clock of the simulated devices; None while Phoenix 6 is CTRE's own, on the wall clock."""
    world = emulator.installed()
    return None if world is None else PhoenixTime(world)


def _nothing(self: Any) -> None:
    """In place of the Notifier that feeds the enable signal."""
