"""Reader that converts the configuration of a REVLib controller to `SparkConfiguration`."""

from __future__ import annotations

from typing import Any

from simcore import season
from simcore.robotcode.makers.revlib.built_sparks import is_zero_centered, key_of
from simcore.robotcode.makers.revlib.spark_loop import Feedback, MotionLimits, SlotGains, SparkConfiguration

__all__ = ["read_spark_configuration"]

rev = season.rev
_SLOTS = tuple(getattr(rev.ClosedLoopSlot, f"SLOT{k}") for k in range(4))
_FEEDBACK = {
    rev.FeedbackSensor.PRIMARY_ENCODER: Feedback.PRIMARY,
    rev.FeedbackSensor.ABSOLUTE_ENCODER: Feedback.ABSOLUTE,
    rev.FeedbackSensor.ALTERNATE_OR_EXTERNAL_ENCODER: Feedback.EXTERNAL,
    rev.FeedbackSensor.ANALOG_SENSOR: Feedback.ANALOG,
}


def read_spark_configuration(spark: Any) -> SparkConfiguration:
    """Return the complete configuration of a controller; the read takes 0.3 ms.

    Args:
        spark: `SparkMax` or `SparkFlex` of the robot program.
    """
    accessor = spark.config_accessor
    loop, switches, soft = accessor.closed_loop, accessor.limit_switch, accessor.soft_limit
    external = accessor.alternate_encoder if isinstance(spark, rev.SparkMax) else accessor.external_encoder
    feedback = _FEEDBACK.get(loop.get_feedback_sensor(), Feedback.NONE)
    compensation = float(accessor.get_voltage_compensation()) if accessor.get_voltage_compensation_enabled() else None
    stops = tuple(
        "KEEP" not in behavior.name.upper()
        for behavior in (
            switches.get_forward_limit_switch_trigger_behavior(),
            switches.get_reverse_limit_switch_trigger_behavior(),
        )
    )
    return SparkConfiguration(
        brakes=accessor.get_idle_mode() == rev.IdleMode.BRAKE,
        current_limit=float(accessor.get_smart_current_limit()),
        compensation=compensation,
        open_ramp=float(accessor.get_open_loop_ramp_rate()),
        closed_ramp=float(accessor.get_closed_loop_ramp_rate()),
        feedback=feedback,
        primary=season.spark_factors(accessor.encoder),
        absolute=season.spark_factors(accessor.absolute_encoder),
        external=season.spark_factors(external),
        analog=season.spark_factors(accessor.analog_sensor),
        is_centered=season.centered_spark_encoder(accessor.absolute_encoder, is_zero_centered(key_of(spark))),
        is_brushed=spark.get_motor_type() == rev.MotorType.BRUSHED,
        wrap=season.spark_wrap(loop),
        soft_forward=float(soft.get_forward_soft_limit()) if soft.get_forward_soft_limit_enabled() else None,
        soft_reverse=float(soft.get_reverse_soft_limit()) if soft.get_reverse_soft_limit_enabled() else None,
        stops_forward=stops[0],
        stops_reverse=stops[1],
        slots=tuple(_gains(loop, slot) for slot in _SLOTS),
    )


def _gains(loop: Any, slot: Any) -> SlotGains:
    ahead, profile = loop.feed_forward, loop.max_motion
    return SlotGains(
        p=float(loop.get_p(slot)),
        i=float(loop.get_i(slot)),
        d=float(loop.get_d(slot)),
        d_filter=float(loop.get_d_filter(slot)),
        i_zone=float(loop.get_i_zone(slot)),
        i_most=float(loop.get_max_i_accumulation(slot)),
        allowed_error=float(loop.get_allowed_closed_loop_error(slot)),
        least=float(loop.get_min_output(slot)),
        most=float(loop.get_max_output(slot)),
        ks=float(ahead.getk_s(slot)),
        kv=float(ahead.getk_v(slot)),
        ka=float(ahead.getk_a(slot)),
        kg=float(ahead.getk_g(slot)),
        kcos=float(ahead.getk_cos(slot)),
        kcos_ratio=float(ahead.getk_cos_ratio(slot)),
        motion=MotionLimits(
            cruise=float(profile.get_cruise_velocity(slot)),
            acceleration=float(profile.get_max_acceleration(slot)),
            allowed_error=float(profile.get_allowed_profile_error(slot)),
        ),
    )
