"""A mechanism guessed from a motor controller's configuration, for motors whose mechanism is described nowhere.

It keeps at-setpoint logic alive: velocity loops spin up, position loops arrive, gravity gains find the weight that they
hold. It is no model of anything in particular; `simcore.toml` describes the real mechanism.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simcore.phoenix6.configuration import talon_configuration
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.guessed_mechanism import GuessedMechanism, guessed_inertia, guessed_weight, with_guessed_friction
from simcore.robot.mechanisms import ArmConfig, ArmSim
from simcore.robot.motor_controllers import BuiltDevice, FollowerGroup
from simcore.robot.shaft import ShaftSim
from simcore.robot_file.reader import gearbox_motor

__all__ = ["Guess", "gain_volts", "guess_mechanism"]

_MOST_VOLTS = 1.0  # gains kS and kG above this are amperes of a torque-current loop
_ARRANGEMENTS = {  # of a TalonFXS
    "MINION_JST": "Minion",
    "NEO_JST": "NEO",
    "NEO550_JST": "NEO 550",
    "VORTEX_JST": "NEO Vortex",
    "BRUSHED_DC": "CIM",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Guess(GuessedMechanism):
    """What a group of devices probably turns."""

    inverted: bool
    """Whether the leader is configured `CLOCKWISE_POSITIVE`."""
    sensor: tuple[str, int] | None
    """The remote absolute encoder of its configuration, as (source, id)."""
    sensor_gearing: float
    """Turns of that encoder, or of one wired to a TalonFXS, per turn of the mechanism [-]."""
    wired_gearing: float | None
    """Rotor turns per turn of an encoder wired to a TalonFXS [-]; None: there is none."""


def guess_mechanism(group: FollowerGroup) -> Guess:
    """A plausible mechanism from the configuration of the leader, which is read from the device (50 ms).

    Raises:
        ConfigError: The device does not answer.
    """
    device = group.leader
    config = talon_configuration(device.hardware, device.model)
    feedback = config.feedback if device.model == "TalonFX" else config.external_feedback
    source = str(
        (
            feedback.feedback_sensor_source if device.model == "TalonFX" else feedback.external_feedback_sensor_source
        ).name
    )
    on_rotor = source in ("ROTOR_SENSOR", "COMMUTATION")
    per_mechanism = _ratio(feedback.sensor_to_mechanism_ratio)
    per_sensor = 1.0 if on_rotor else _ratio(feedback.rotor_to_sensor_ratio)
    name = "Kraken X60 FOC"
    if device.model == "TalonFXS":
        name = _ARRANGEMENTS.get(config.commutation.motor_arrangement.name, "NEO")
    gearbox = GearboxConfig(motor=gearbox_motor(name), motors=len(group.devices), gearing=per_mechanism * per_sensor)
    gains = config.slot0
    static, weight = gain_volts(gearbox, gains.k_s), gain_volts(gearbox, gains.k_g)
    gearbox = with_guessed_friction(gearbox, static)
    inertia = guessed_inertia(gearbox, gains.k_v, gains.k_a)
    torque_per_volt = gearbox.torque_per_amp / gearbox.resistance
    is_remote = "CANCODER" in source or "CANDI" in source
    return Guess(
        mechanism=_mechanism(device, gearbox, inertia, weight * torque_per_volt, config),
        motor=name,
        inverted=config.motor_output.inverted.name == "CLOCKWISE_POSITIVE",
        sensor=(source, int(feedback.feedback_remote_sensor_id)) if is_remote else None,
        sensor_gearing=per_mechanism,
        wired_gearing=per_sensor if source in ("QUADRATURE", "PULSE_WIDTH") else None,
    )


def _mechanism(device: BuiltDevice, gearbox: GearboxConfig, inertia: float, weight: float, config: Any) -> ShaftSim:
    """A free shaft; with a kG, one with a weight that rests on a stop where it is at first."""
    if config.slot0.gravity_type.name == "ARM_COSINE" and weight > 0.0:
        device.hardware.get_position().wait_for_update(0.1)
        start = device.hardware.get_position().value * math.tau
        limits = config.software_limit_switch
        low = limits.reverse_soft_limit_threshold * math.tau if limits.reverse_soft_limit_enable else start
        low = min(low, start)
        return ArmSim(
            ArmConfig(
                gearbox=gearbox,
                inertia=inertia,
                mass=weight,
                center_of_mass=1.0,
                gravity=1.0,  # mass and lever are not known apart, and need not be
                min_angle=low,
                max_angle=max(low, start) + math.pi,
                start_angle=start,
            )
        )
    return guessed_weight(gearbox, inertia, weight)


def _ratio(value: float) -> float:
    return abs(float(value)) or 1.0


def gain_volts(gearbox: GearboxConfig, gain: float) -> float:
    """A gain kS or kG in volts, whether it was tuned in volts or in amperes.

    Args:
        gearbox: What the gain was tuned on.
        gain: As it is configured.
    """
    return float(gain) if abs(gain) <= _MOST_VOLTS else float(gain) * gearbox.resistance
