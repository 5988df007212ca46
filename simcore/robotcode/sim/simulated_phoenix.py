"""Coupling of the Phoenix 6 emulator to the robot program's FPGA clock and enable state."""

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

_FEED_MS = 100  # duration of one enable feed, as in phoenix6's own Notifier [ms]


class PhoenixTime:
    """Clock of the emulated devices, coupled to the FPGA clock.

    Phoenix 6 feeds the enable signal from a Notifier on a separate thread. The order of a feed and a robot loop at the
    same time would therefore be random. This class feeds the enable signal before each step, on the stepping thread.

    Args:
        world: Emulator that contains the devices.
    """

    def __init__(self, world: Emulator) -> None:
        self.world = world

    def step(self, dt: float) -> None:
        """Feed the robot's enable state to the devices, and advance the devices by dt [s]."""
        self.world.enable.feed(_FEED_MS if RobotState.is_enabled() else 0)
        self.world.step(dt)

    def catch_up(self, time: float) -> None:
        """Advance the devices to the FPGA time `time` [s] if the devices' clock is behind."""
        behind = time - self.world.clock.now
        if behind > 0.0:
            self.step(behind)


def install_simulated_phoenix() -> PhoenixTime:
    """Switch Phoenix 6 to simulated time, remove all emulated devices, and return the devices' clock.

    Phoenix 6's timestamps become FPGA times, and the library no longer feeds the enable signal. Call this function
    before the program builds a robot.

    Raises:
        SeamError: The installed phoenix6 is incompatible. The message names compatible versions.
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
    """Return the clock of the emulated devices; None while Phoenix 6 uses CTRE's libraries on the wall clock."""
    world = emulator.installed()
    return None if world is None else PhoenixTime(world)


def _nothing(self: Any) -> None:
    """Do nothing, as a replacement for the start and stop of the library's enable feed."""
