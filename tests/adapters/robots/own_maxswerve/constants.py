"""Constants of REV's MAXSwerve template in Python: ids, places and configurations."""

import math

from rev import ClosedLoopConfig, FeedbackSensor, SparkMaxConfig
from wpimath.geometry import Translation2d
from wpimath.kinematics import SwerveDrive4Kinematics

TRACK_WIDTH = 0.6731
WHEEL_BASE = 0.6731
KINEMATICS = SwerveDrive4Kinematics(
    Translation2d(WHEEL_BASE / 2, TRACK_WIDTH / 2),
    Translation2d(WHEEL_BASE / 2, -TRACK_WIDTH / 2),
    Translation2d(-WHEEL_BASE / 2, TRACK_WIDTH / 2),
    Translation2d(-WHEEL_BASE / 2, -TRACK_WIDTH / 2),
)
WHEEL_DIAMETER = 0.0762
REDUCTION = (45.0 * 22) / (14 * 15)
FREE_SPEED = 5676 / 60 * WHEEL_DIAMETER * math.pi / REDUCTION  # [m/s]


def driving() -> SparkMaxConfig:
    config = SparkMaxConfig()
    config.setIdleMode(SparkMaxConfig.IdleMode.kBrake).smartCurrentLimit(50)
    factor = WHEEL_DIAMETER * math.pi / REDUCTION
    config.encoder.positionConversionFactor(factor).velocityConversionFactor(factor / 60.0)
    config.closedLoop.setFeedbackSensor(FeedbackSensor.kPrimaryEncoder).pid(0.04, 0, 0)
    config.closedLoop.feedForward.kV(12.0 / FREE_SPEED)
    config.closedLoop.outputRange(-1, 1)
    return config


def turning() -> SparkMaxConfig:
    config = SparkMaxConfig()
    config.setIdleMode(SparkMaxConfig.IdleMode.kBrake).smartCurrentLimit(20)
    config.absoluteEncoder.inverted(True).positionConversionFactor(math.tau).velocityConversionFactor(math.tau / 60.0)
    loop: ClosedLoopConfig = config.closedLoop
    loop.setFeedbackSensor(FeedbackSensor.kAbsoluteEncoder).pid(1, 0, 0).outputRange(-1, 1)
    loop.positionWrappingEnabled(True).positionWrappingInputRange(0, math.tau)
    return config
