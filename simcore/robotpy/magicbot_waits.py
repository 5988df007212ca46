"""Physics between the loops of a MagicBot: its wait for the next loop is cut, and each part of physics done in time.

A MagicRobot has no `addPeriodic`; it waits in robotpy's `NotifierDelay`. Volts that stand for a whole loop of 20 ms
make a steer motor overshoot by 18 % (5 ms: nothing). A Notifier of our own would be another thread, whose turn against
the robot's loop is a matter of luck. So the robot's own thread does the parts while it would sleep.
"""

from __future__ import annotations

import sys
import threading
from typing import Any, Protocol

import hal
from wpilib import Timer

__all__ = ["TimedParts", "run_in_waits"]


class TimedParts(Protocol):
    """Work that is due at times of its own: `RobotPhysics`."""

    @property
    def next_due(self) -> float:
        """When the next part is due, FPGA time [s]."""
        ...

    def do_due(self) -> None:
        """Do all parts that are due by now."""
        ...


def run_in_waits(robot: Any, parts: TimedParts) -> bool:
    """Do parts in the waits of a MagicBot from now on; called on the robot's thread.

    Returns:
        Whether the robot is a MagicBot whose waits can be cut.
    """
    magicbot = sys.modules.get("magicbot")
    if magicbot is None or not isinstance(robot, magicbot.MagicRobot):
        return False
    from robotpy_ext.misc.precise_delay import NotifierDelay

    whole_wait = NotifierDelay.wait
    if not hasattr(NotifierDelay, "_update_alarm"):  # another version, with other insides
        return False
    thread = threading.get_ident()

    def wait(self: NotifierDelay) -> None:
        handle = getattr(self, "_notifier", None)
        if handle is not None and threading.get_ident() == thread:
            if parts.next_due <= Timer.getFPGATimestamp():
                parts.do_due()  # after a loop that took too long nothing is left to wait for
            while True:
                due = int(1e6 * parts.next_due)  # [us]
                if due >= self._expiry_time:
                    break
                hal.updateNotifierAlarm(handle, due)
                if hal.waitForNotifierAlarm(handle)[0] == 0:  # the program ends
                    return
                parts.do_due()
            hal.updateNotifierAlarm(handle, self._expiry_time)
        whole_wait(self)

    NotifierDelay.wait = wait
    return True
