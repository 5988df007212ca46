"""How much of the robot each wheel carries."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simcore.errors import NonFiniteError
from simcore.loop.robot_state import WHEEL, records
from simcore.loop.tires import share_loads
from simcore.robot.wheel_config import RobotMass

__all__ = ["normal_loads"]


def normal_loads(
    config: RobotMass,
    touching: Sequence[bool],
    gravity_robot: Sequence[float],
    accel_robot: Sequence[float] = (0.0, 0.0, 0.0),
) -> list[float]:
    """Normal load of each wheel from gravity, acceleration and which wheels touch.

    The ground acts on the chassis with f = m (a - g). Its vertical part is shared so that the forces at the contact
    points make no moment about the center of mass (a rigid chassis that is not just tipping):

        sum N_i = f_z,   sum N_i x_i = -height f_x,   sum N_i y_i = -height f_y

    Speeding up puts load on the rear axle, a left turn on the right wheels, and a slope on the lower ones. See
    `simcore.loop.tires.share_loads` for robots with more than three wheels and those with a dropped center.

    Args:
        config: Positions of the wheels, mass, center of mass.
        touching: Per wheel, whether it is on the ground.
        gravity_robot: Acceleration of gravity, robot axes [m/s^2], shape (3,); level ground: (0, 0, -9.80665).
        accel_robot: Of the center of mass, robot axes, as seen from the field [m/s^2], shape (3,).

    Returns:
        Loads [N], each >= 0, 0 where nothing touches; they add up to f_z, or are all 0 in free fall.

    Raises:
        NonFiniteError: When an acceleration is NaN or infinite.
    """
    if not all(map(math.isfinite, (*gravity_robot, *accel_robot))):
        raise NonFiniteError(f"normal loads need finite numbers, got gravity={gravity_robot}, accel={accel_robot}")
    wheels = records(WHEEL, len(config.positions))
    wheels["x"], wheels["y"] = zip(*config.positions, strict=True)
    wheels["is_down"] = touching
    wheels["is_lowered"][list(config.lowered)] = 1
    height = config.center_of_mass[2] * config.mass
    share_loads(
        *(wheels, 0, len(wheels), config.mass * (accel_robot[2] - gravity_robot[2])),
        height * (gravity_robot[0] - accel_robot[0]),
        height * (gravity_robot[1] - accel_robot[1]),
    )
    loads: list[float] = wheels["load"].tolist()
    return loads
