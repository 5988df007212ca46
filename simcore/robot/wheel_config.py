"""What every driven wheel has, under a swerve module as under a tank."""

from __future__ import annotations

from dataclasses import dataclass

from simcore.quantities import EFFICIENCY, FRICTION, INERTIA, ROBOT_LENGTH, SLIP_SPEED, Quantity, require_fields

__all__ = ["WheelConfig"]


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelConfig:
    """A wheel on carpet. `SwerveModuleConfig` and `TankConfig` have these fields among their own."""

    wheel_radius: float = 0.0508
    """[m]"""
    wheel_cof: float = 1.2
    """Coefficient of friction of the wheel on carpet, along the wheel [-]. A cautious default: on a tilting table new
    treads held to 1.83 (blue nitrile) and 1.76 (HiGrip) along and 1.34 and 1.71 across; in matches they wear. Source:
    team 1640, DEWBOT VIII wheel friction coefficient testing; further treads in `cots.TREADS`."""
    wheel_grain: float = 1.0
    """Friction across the wheel over that along [-]: .73 (blue nitrile) and .97 (HiGrip) in the same test. 1, as the
    default of 1.2 along is less than what either has across; with a measured `wheel_cof` give this as well."""
    wheel_inertia: float = 8.0e-4
    """Wheel and last gears about the axle [kg m^2]; a 4 in wheel of 0.6 kg. Estimate, +-50 %."""
    rolling_resistance: float = 0.01
    """Drag per load while the wheel rolls [-]; estimate for carpet, +-50 %."""
    slip_ratio: float = 0.01
    """Slip per rolling speed at which the tire begins to slide [-]; estimate for a thin, stiff tread."""
    slip_speed: float = 0.002
    """Slip at which a standing tire begins to slide [m/s]; a robot parked on a 15 degree ramp creeps at 1/5 of it."""

    def __post_init__(self) -> None:
        self.require_wheel("wheel")

    def require_wheel(self, owner: str) -> None:
        """Check these fields; `owner` names them in a message."""
        require_fields(
            self,
            owner,
            wheel_radius=ROBOT_LENGTH,
            wheel_cof=FRICTION,
            wheel_grain=Quantity("", 0.0, 2.0, is_open=True),
            wheel_inertia=INERTIA,
            rolling_resistance=FRICTION,
            slip_ratio=EFFICIENCY,
            slip_speed=SLIP_SPEED,
        )
