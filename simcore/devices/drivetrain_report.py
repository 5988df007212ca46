"""What was found of a drivetrain, as text: the table that `simcore init` writes, and lines for `check` and the log."""

from __future__ import annotations

import math
from typing import Any

from simcore.devices.found_drivetrain import FoundDrivetrain, FoundWheel, Measure

__all__ = ["drivetrain_lines", "drivetrain_rows"]

Row = tuple[str, Any, str]

_MEASURES = ("drive_motor", "drive_gearing", "wheel_radius", "steer_motor", "steer_gearing", "trackwidth")
_LOOPS = ("drive_loop", "steer_loop")


def drivetrain_rows(found: FoundDrivetrain) -> list[Row]:
    """Keys of `[drivetrain]`, their values, and what is to be said of each.

    Args:
        found: With complete measures.
    """
    wheels, first = found.wheels, found.wheels[0]
    rows: list[Row] = [("kind", found.kind, found.about)]
    if len({w.motors[0].model for w in wheels}) > 1:  # the table has one; what is found has no need of it
        return rows + [_measure(name, found.measures[name]) for name in _MEASURES if name in found.measures]
    rows.append(("controller", first.motors[0].model, ""))
    if found.kind == "tank":
        model = first.motors[0].model
        for wheel in wheels:  # the program says itself who follows, of whatever model
            rows.append((wheel.name, [d.address.in_file for d in wheel.motors if d.model == model], "the leader first"))
    else:
        rows.append(("drive", [wheel.motors[0].address.in_file for wheel in wheels], _names(wheels)))
    if first.steer is not None:
        if first.steer.model != first.motors[0].model:
            rows.append(("steer_controller", first.steer.model, ""))
        rows.append(("steer", [w.steer.address.in_file for w in wheels if w.steer is not None], ""))
        rows += _encoders(wheels)
    if found.kind != "tank":
        rows += [("x", [_rounded(w.place[0]) for w in wheels], "forward of the center")]
        rows += [("y", [_rounded(w.place[1]) for w in wheels], "")]
    rows += _signs(wheels)
    if first.wheel_encoder is not None and first.wheel_encoder.model == "Encoder":
        rows.append(("wheel_encoders", [w.wheel_encoder.address.in_file for w in wheels if w.wheel_encoder], "DIO"))
        if all(w.meters_per_encoder_turn for w in wheels):
            rows.append(
                (
                    "wheel_distances",
                    [_rounded(w.meters_per_encoder_turn) for w in wheels],
                    "m that 2048 pulses are to the code",
                )
            )
    if found.gyro is not None:
        rows.append(("gyro", str(found.gyro), ""))
    return rows + [_measure(name, found.measures[name]) for name in _MEASURES if name in found.measures]


def _names(wheels: tuple[FoundWheel, ...]) -> str:
    """Last attributes that tell the wheels apart."""
    names = [w.name.split(".")[-1] for w in wheels]
    return ", ".join(names) if len("".join(names)) < 60 and not names[0].isdigit() else ""


def _encoders(wheels: tuple[FoundWheel, ...]) -> list[Row]:
    first = wheels[0]
    if first.encoder is None:
        return [("encoder", "none", "")]
    if first.is_wired:
        return [("encoder", "wired", "absolute encoders at the steer motors' controllers")]
    return [
        ("encoder", first.encoder.model, ""),
        ("encoders", [w.encoder.address.in_file for w in wheels if w.encoder is not None], ""),
    ]


def _signs(wheels: tuple[FoundWheel, ...]) -> list[Row]:
    rows: list[Row] = []
    if any(w.zero for w in wheels):
        zeros = [round(math.degrees(w.zero), 4) for w in wheels]
        rows.append(("zeros_deg", zeros, "what your code reads as angle while the encoder reads 0"))
    for key, name in (
        ("reversed_drive", "drive_sign"),
        ("reversed_steer", "steer_sign"),
        ("reversed_encoders", "encoder_sign"),
    ):
        turned = [k for k, wheel in enumerate(wheels) if getattr(wheel, name) < 0.0]
        if turned:
            rows.append((key, turned, "by their place in the lists above, from 0"))
    return rows


def _measure(name: str, measure: Measure) -> Row:
    remark = f"{'guess: ' if measure.is_guess else ''}{measure.source}"
    if name == "wheel_radius":
        return "wheel_diameter", _rounded(2.0 * float(measure.value)), remark
    return name, _rounded(measure.value), remark


def _rounded(value: Any) -> Any:
    return float(f"{value:.7g}") if isinstance(value, float) else value


def drivetrain_lines(found: FoundDrivetrain) -> list[str]:
    """Lines for a person: what it is, what is guessed, and what contradicts what."""
    loops = {str(found.measures[name].value) for name in _LOOPS if name in found.measures}
    closed = f", loops on the {' and on the '.join(sorted(loops))}" if loops else ""
    gyro = "no gyro" if found.gyro is None else str(found.gyro)
    lines = [f"{found.kind} drive: {found.about}, {gyro}{closed}"]
    lines += [f"guess: {name} {measure}" for name, measure in found.measures.items() if measure.is_guess]
    return lines + [f"differs: {sentence}" for sentence in found.differences]
