"""The perfect camera: the robot's exact pose, with the four nearest tags to go with it, whatever is in sight.

The Java reference has no other tag camera. Here it is a switch, for tests of what robot code does with a pose.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.quaternion import Quaternion, Vector, rpy
from simcore.units import plain_sum
from simcore.vision.camera import CameraConfig
from simcore.vision.frames import PoseEstimate, TagSighting
from simcore.vision.projection import angles_deg, camera_pose, optical_rotation, project, quad_area
from simcore.vision.tags import TagLayout

__all__ = ["perfect_frame"]

_TAGS = 4  # as many as the reference invents


def perfect_frame(
    layout: TagLayout, robot_pose: tuple[Vector, Quaternion], config: CameraConfig
) -> tuple[tuple[TagSighting, ...], PoseEstimate, PoseEstimate]:
    """Tags and both poses of a frame without any error.

    Args:
        layout: All tags; the four nearest ones count as seen, even behind the camera.
        robot_pose: True pose, field frame.
        config: The camera.
    """
    lens = config.type
    pos, quat = camera_pose(*robot_pose, config.mount.position, config.mount.rotation)
    rotation = optical_rotation(quat)
    reach = np.linalg.norm(layout.centers - pos, axis=1)
    tags = []
    for row in np.argsort(reach, kind="stable")[:_TAGS].tolist():
        corners, _ = project(layout.corners[row], pos, rotation, lens)
        u, v = corners.mean(axis=0).tolist()
        tx, ty = angles_deg(u, v, lens)
        area = 100.0 / (lens.width * lens.height) * abs(float(quad_area(corners[None])[0]))
        near, far = float(reach[row]), math.dist(layout.centers[row].tolist(), robot_pose[0])
        (u0, v0), (u1, v1), (u2, v2), (u3, v3) = corners.tolist()
        pixels = (u0, v0), (u1, v1), (u2, v2), (u3, v3)
        tags.append(TagSighting(int(layout.ids[row]), pixels, tx, ty, area, near, far, 0.0, None))
    roll, pitch, yaw = rpy(robot_pose[1])
    chosen = layout.centers[np.argsort(reach, kind="stable")[:_TAGS]]
    apart = np.linalg.norm(chosen[:, None, :] - chosen[None, :, :], axis=2)
    estimate = PoseEstimate(
        position=robot_pose[0],
        roll_deg=math.degrees(roll),
        pitch_deg=math.degrees(pitch),
        yaw_deg=math.degrees(yaw),
        tag_count=len(tags),
        tag_span=float(apart.max(initial=0.0)),
        average_distance=plain_sum([tag.camera_distance for tag in tags]) / max(1, len(tags)),
        average_area=plain_sum([tag.area_percent for tag in tags]) / max(1, len(tags)),
        std_devs=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    )
    return tuple(tags), estimate, estimate
