"""Base class of a team: its own loop on a HAL notifier, and values on NetworkTables under one root."""

from typing import Any, ClassVar

import hal
import wpilib
from ntcore import NetworkTableInstance
from wpimath.geometry import Pose2d


class Logger:
    publishers: ClassVar[dict[str, Any]] = {}

    @classmethod
    def process(cls, name: str, inputs: Any) -> None:
        for key, value in vars(inputs).items():
            topic = f"/AdvantageKit/{name}/{key}"
            network = NetworkTableInstance.getDefault()
            if topic not in cls.publishers:
                if isinstance(value, Pose2d):
                    cls.publishers[topic] = network.getStructTopic(topic, Pose2d).publish()
                elif isinstance(value, tuple):
                    cls.publishers[topic] = network.getDoubleArrayTopic(topic).publish()
                else:
                    cls.publishers[topic] = network.getDoubleTopic(topic).publish()
            cls.publishers[topic].set(value)


class LoggedRobot(wpilib.IterativeRobotBase):
    PERIOD_US = 20_000

    def __init__(self) -> None:
        super().__init__(self.PERIOD_US / 1e6)
        self.next_cycle = self.PERIOD_US
        self.notifier = hal.initializeNotifier()[0]

    def startCompetition(self) -> None:
        self.robotInit()
        if self.isSimulation():
            self._simulationInit()
        hal.observeUserProgramStarting()
        while True:
            now = wpilib.RobotController.getFPGATime()
            if self.next_cycle < now:
                self.next_cycle = now
            else:
                hal.updateNotifierAlarm(self.notifier, self.next_cycle)
                time, status = hal.waitForNotifierAlarm(self.notifier)
                if status != 0:
                    raise RuntimeError(f"waiting for the notifier failed: {status}")
                if time == 0:
                    return
            self.next_cycle += self.PERIOD_US
            self._loopFunc()

    def endCompetition(self) -> None:
        hal.stopNotifier(self.notifier)
        hal.cleanNotifier(self.notifier)
