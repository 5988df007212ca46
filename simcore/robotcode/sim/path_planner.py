"""PathPlanner's pathfinder in simulated time: the program waits until each plan is complete.

The pathfinder plans on a separate thread, and the planning time depends on the computer. Without waiting, the robot
would start to move in a different loop in each run.
"""

from __future__ import annotations

import functools
import threading
import time
import types
from collections.abc import Callable
from typing import Any

from simcore import season

__all__ = ["wait_for_plans"]

_PATIENCE = 5.0  # longest wall time to wait for one plan [s]
_REST = 2e-4  # time between two polls of the planner for requests [s]


class _PlannerTime(types.ModuleType):
    """Replacement for the module `time` in PathPlanner's pathfinder that detects when the pathfinder is idle.

    The pathfinder's thread calls `sleep` only while the thread has no request.
    """

    def __init__(self) -> None:
        super().__init__("time")
        self._rests = 0
        self._changed = threading.Condition()

    def __getattr__(self, name: str) -> Any:
        return getattr(time, name)

    def sleep(self, seconds: float) -> None:
        """Record that the pathfinder has no request, and sleep: 0.2 ms if a test steps the clock, else `seconds`."""
        with self._changed:
            self._rests += 1
            self._changed.notify_all()
        time.sleep(_REST if season.hal_simulation.is_timing_paused() else seconds)

    def wait(self) -> None:
        """Wait until the pathfinder has polled twice without a request, at most 5 s of wall time.

        One poll is not enough, because the first poll may have begun before the call.
        """
        with self._changed:
            first = self._rests
            self._changed.wait_for(lambda: self._rests >= first + 2, _PATIENCE)


def wait_for_plans(pathfinders: Any) -> None:
    """Make each request to the module `pathplannerlib.pathfinders` wait for the complete plan while time is stepped."""
    pathfinders.time = clock = _PlannerTime()
    planner = pathfinders.LocalADStar
    for name in ("setStartPosition", "setGoalPosition", "setDynamicObstacles"):
        setattr(planner, name, _waiting(getattr(planner, name), clock))


def _waiting(request: Callable[..., Any], clock: _PlannerTime) -> Callable[..., Any]:
    @functools.wraps(request)
    def request_and_wait(*args: Any, **settings: Any) -> Any:
        is_stepped = season.hal_simulation.is_timing_paused()
        if is_stepped:
            clock.wait()  # complete an earlier request, e.g. the initial one
        answer = request(*args, **settings)
        if is_stepped:
            clock.wait()
        return answer

    return request_and_wait
