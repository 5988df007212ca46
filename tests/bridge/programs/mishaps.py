"""Robot program that fails in the way that its argument names: `mishaps.py WHAT`."""

import os
import signal
import sys
import time

import wpilib

WHAT = sys.argv[1]


class Robot(wpilib.TimedRobot):
    def __init__(self):
        super().__init__()
        if WHAT == "waits in its constructor":
            time.sleep(1000.0)
        if WHAT != "opens nothing":
            self.motors = wpilib.PWMSparkMax(0), wpilib.PWMSparkMax(1)
            self.encoders = wpilib.Encoder(0, 1), wpilib.Encoder(2, 3)
        self.loops = 0

    def robotPeriodic(self):
        self.loops += 1
        if WHAT == "prints a gigabyte":
            sys.stdout.write(f"{self.loops} {'x' * 998}\n" * 1000)
        if self.loops < 150:
            return
        if WHAT == "divides by zero":
            print(1 / (self.loops - self.loops))
        elif WHAT == "divides by zero in C++":
            os.kill(os.getpid(), signal.SIGFPE)
        elif WHAT == "waits":
            time.sleep(1000.0)
        elif WHAT == "leaves":
            os._exit(0)


if WHAT == "ends at once":
    sys.exit("no such team")
else:
    Robot().startCompetition()
