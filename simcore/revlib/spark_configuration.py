"""What a SPARK is configured with, read from the controller into plain numbers."""

from __future__ import annotations

from typing import Any

import rev

from simcore.revlib.built_sparks import is_zero_centered
from simcore.revlib.spark_loop import Feedback, MotionLimits, SlotGains, SparkConfiguration

__all__ = ["read_spark_configuration"]

_SLOTS = tuple(getattr(rev.ClosedLoopSlot, f"kSlot{k}") for k in range(4))
_FEEDBACK = {
    "kPrimaryEncoder": Feedback.PRIMARY,
    "kAbsoluteEncoder": Feedback.ABSOLUTE,
    "kAlternateOrExternalEncoder": Feedback.EXTERNAL,
    "kAnalogSensor": Feedback.ANALOG,
}


def read_spark_configuration(spark: Any) -> SparkConfiguration:
    """All of it; some 0.3 ms.

    Args:
        spark: The robot code's `SparkMax` or `SparkFlex`.
    """
    accessor = spark.configAccessor
    key = ("SPARK MAX" if isinstance(spark, rev.SparkMax) else "SPARK Flex"), int(spark.getDeviceId())
    loop, switches, soft = accessor.closedLoop, accessor.limitSwitch, accessor.softLimit
    external = accessor.alternateEncoder if isinstance(spark, rev.SparkMax) else accessor.externalEncoder
    feedback = _FEEDBACK.get(loop.getFeedbackSensor().name, Feedback.NONE)
    compensation = float(accessor.getVoltageCompensation()) if accessor.getVoltageCompensationEnabled() else None
    stops = tuple(
        "kKeepMoving" not in behavior.name
        for behavior in (
            switches.getForwardLimitSwitchTriggerBehavior(),
            switches.getReverseLimitSwitchTriggerBehavior(),
        )
    )
    return SparkConfiguration(
        brakes=accessor.getIdleMode() == rev.SparkBaseConfig.IdleMode.kBrake,
        current_limit=float(accessor.getSmartCurrentLimit()),
        compensation=compensation,
        open_ramp=float(accessor.getOpenLoopRampRate()),
        closed_ramp=float(accessor.getClosedLoopRampRate()),
        feedback=feedback,
        primary=_factors(accessor.encoder),
        absolute=_factors(accessor.absoluteEncoder),
        external=_factors(external),
        analog=_factors(accessor.analogSensor),
        is_centered=is_zero_centered(key),
        is_brushed=spark.getMotorType() == rev.SparkLowLevel.MotorType.kBrushed,
        wrap=_wrap(loop),
        soft_forward=float(soft.getForwardSoftLimit()) if soft.getForwardSoftLimitEnabled() else None,
        soft_reverse=float(soft.getReverseSoftLimit()) if soft.getReverseSoftLimitEnabled() else None,
        stops_forward=stops[0],
        stops_reverse=stops[1],
        slots=tuple(_gains(loop, slot) for slot in _SLOTS),
    )


def _factors(encoder: Any) -> tuple[float, float]:
    return float(encoder.getPositionConversionFactor()), float(encoder.getVelocityConversionFactor())


def _wrap(loop: Any) -> tuple[float, float] | None:
    if not loop.getPositionWrappingEnabled():
        return None
    return float(loop.getPositionWrappingMinInput()), float(loop.getPositionWrappingMaxInput())


def _gains(loop: Any, slot: Any) -> SlotGains:
    ahead, profile = loop.feedForward, loop.maxMotion
    return SlotGains(
        p=float(loop.getP(slot)),
        i=float(loop.getI(slot)),
        d=float(loop.getD(slot)),
        d_filter=float(loop.getDFilter(slot)),
        i_zone=float(loop.getIZone(slot)),
        i_most=float(loop.getMaxIAccumulation(slot)),
        allowed_error=float(loop.getAllowedClosedLoopError(slot)),
        least=float(loop.getMinOutput(slot)),
        most=float(loop.getMaxOutput(slot)),
        ks=float(ahead.getkS(slot)),
        kv=float(ahead.getkV(slot)),
        ka=float(ahead.getkA(slot)),
        kg=float(ahead.getkG(slot)),
        kcos=float(ahead.getkCos(slot)),
        kcos_ratio=float(ahead.getkCosRatio(slot)),
        motion=MotionLimits(
            cruise=float(profile.getCruiseVelocity(slot)),
            acceleration=float(profile.getMaxAcceleration(slot)),
            allowed_error=float(profile.getAllowedProfileError(slot)),
        ),
    )
