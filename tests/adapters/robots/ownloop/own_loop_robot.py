"""A base class with a loop of its own, as PyKit's LoggedRobot is: no addPeriodic, and no wait when it is late."""

import hal
import wpilib


class OwnLoopRobot(wpilib.IterativeRobotBase):
    def __init__(self) -> None:
        super().__init__(0.02)
        self._next_cycle = 20_000
        self._notifier = hal.initializeNotifier()[0]

    def endCompetition(self) -> None:
        hal.stopNotifier(self._notifier)
        hal.cleanNotifier(self._notifier)

    def startCompetition(self) -> None:
        self.robotInit()
        if self.isSimulation():
            self._simulationInit()
        hal.observeUserProgramStarting()
        while True:
            now = wpilib.RobotController.getFPGATime()
            if self._next_cycle < now:
                self._next_cycle = now
            else:
                hal.updateNotifierAlarm(self._notifier, self._next_cycle)
                if hal.waitForNotifierAlarm(self._notifier)[0] == 0:
                    return
            self._next_cycle += 20_000
            self._loopFunc()
