"""Phoenix 6 in FPGA time: the emulator of CTRE's libraries, enabled and stepped by the robot program's clock."""

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

_FEED_MS = 100  # fed by phoenix6's own Notifier, every 10 ms


class PhoenixTime:
    """Clock of the simulated devices, tied to the FPGA's.

    Phoenix 6 feeds its enable signal from a Notifier, on its own thread: at instants at which the robot's loop
    also runs, the order would be random. Here the feed comes before each step, on the stepping thread.

    Args:
        world: Devices.
    """

    def __init__(self, world: Emulator) -> None:
        self.world = world

    def step(self, dt: float) -> None:
        """Feed the enable signal and advance the devices by dt [s]."""
        self.world.enable.feed(_FEED_MS if RobotState.is_enabled() else 0)
        self.world.step(dt)

    def catch_up(self, time: float) -> None:
        """Advance the devices to `time` on the FPGA's clock [s]; never back."""
        behind = time - self.world.clock.now
        if behind > 0.0:
            self.step(behind)


def install_simulated_phoenix() -> PhoenixTime:
    """Run Phoenix 6 in simulated time from now on, without devices yet; call before the robot object is built.

    Raises:
        SeamError: The installed phoenix6 is incompatible; the text names a compatible version.
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
    """Return the clock of the simulated devices; None while Phoenix 6 is CTRE's own, on the wall clock."""
    world = emulator.installed()
    return None if world is None else PhoenixTime(world)


def _nothing(self: Any) -> None:
    """Replace the Notifier that feeds the enable signal."""
