"""Positions and dimensions of the 2025 field, in meters in the field frame.

All positions are for the **blue** alliance. The red positions are the blue positions rotated by 180 degrees about the
field center. "Left" and "right" are from the view of the alliance's drivers, so left is +y for blue.

In the sources, "tags" is WPILib's AprilTag layout `k2025ReefscapeWelded`. "6328" is FieldConstants.java of team 6328
(Mechanical Advantage, RobotCode2025Public), with values from the official CAD. "Manual" is a figure of the 2025 game
manual, section ARENA, as quoted by two public projects that agree. "MapleSim" is the 2025 arena of the simulation
MapleSim. Estimates are marked.
"""

from __future__ import annotations

from math import cos, radians, sqrt, tan
from typing import Final

from simcore.units import inches

__all__ = [
    "ALGAE_DIAMETER", "ALLIANCE_WALL_HEIGHT", "BARGE_LENGTH", "BARGE_POST_SIZE", "BARGE_ZONE_DEPTH",
    "BARGE_ZONE_WIDTH", "BRANCH_DIAMETER", "BRANCH_OFFSET", "BRANCH_SLOPE", "BRANCH_TIP_HEIGHTS", "BRANCH_TIP_RADIUS",
    "CAGE_DEEP_BOTTOM", "CAGE_HEIGHT", "CAGE_SHALLOW_BOTTOM", "CAGE_SIZE", "CAGE_X", "CAGE_YS", "CHUTE_LENGTH",
    "CHUTE_LIP_LENGTH", "CHUTE_LIP_SLOPE", "CHUTE_SLOPE", "CORAL_INNER_DIAMETER", "CORAL_LENGTH",
    "CORAL_OUTER_DIAMETER", "FIELD_CENTER", "FIELD_LENGTH", "FIELD_WIDTH", "GUARDRAIL_HEIGHT", "HIGH_ALGAE_FACES",
    "L4_BEND_HEIGHT", "L4_STRAIGHT", "MARK_X", "MARK_YS", "NET_FLOOR_HEIGHT", "NET_FRAME_THICKNESS", "NET_LENGTH",
    "NET_RIM_HEIGHT", "NET_WIDTH", "NET_Y", "PERIMETER_THICKNESS", "PROCESSOR_FRAME_TOP", "PROCESSOR_FRAME_WIDTH",
    "PROCESSOR_OPENING_BOTTOM", "PROCESSOR_OPENING_HEIGHT", "PROCESSOR_OPENING_WIDTH", "PROCESSOR_RECESS",
    "PROCESSOR_X", "REEF_ALGAE_HEIGHTS", "REEF_ALGAE_RADIUS", "REEF_APOTHEM", "REEF_CENTER",
    "REEF_FACE_YAWS_DEG", "REEF_ZONE_APOTHEM", "RISER_RADIUS", "STARTING_LINE_WIDTH", "STARTING_LINE_X",
    "STATION_DEPTH", "STATION_FACE_CENTER", "STATION_OPENING_BOTTOM", "STATION_OPENING_HEIGHT",
    "STATION_OPENING_WIDTH", "STATION_YAW_DEG", "TROUGH_DEPTH", "TROUGH_EDGE_HEIGHT", "TROUGH_FLOOR_DROP",
    "TROUGH_WALL_HEIGHT", "TRUSS_BOTTOM", "TRUSS_TOP",
]  # fmt: skip

# --- Field -----------------------------------------------------------------------------------------------------------

FIELD_LENGTH: Final = 17.548
"""Field length along x, between the alliance walls. Source: tags. The manual prints 690.875 in."""
FIELD_WIDTH: Final = 8.052
"""Field width along y, between the guardrails. Source: tags. The manual prints 317 in = 8.0518."""
FIELD_CENTER: Final = (FIELD_LENGTH / 2.0, FIELD_WIDTH / 2.0)
GUARDRAIL_HEIGHT: Final = inches(20.0)  # as in 2026
ALLIANCE_WALL_HEIGHT: Final = inches(78.8)  # as in 2026
PERIMETER_THICKNESS: Final = 0.3  # our choice, outward, so that no ball passes through
STARTING_LINE_X: Final = inches(299.438)
"""x of the starting line's edge toward the barge. Source: 6328. The value equals x of the far reef face plus 88 in plus
the width of the tape."""
STARTING_LINE_WIDTH: Final = inches(2.0)

# --- Reef ------------------------------------------------------------------------------------------------------------

REEF_CENTER: Final = (inches(176.746), FIELD_WIDTH / 2.0)
"""Center of the reef, midway between tags 18 and 21. Source: 6328."""
REEF_APOTHEM: Final = inches(65.5) / 2.0
"""Distance from the reef's center to a face. Source: manual. Tags 18 and 21 are twice this distance apart."""
REEF_ZONE_APOTHEM: Final = inches(93.5) / 2.0  # manual: line 12 in in front of the faces, plus the tape
REEF_FACE_YAWS_DEG: Final = (180.0, 120.0, 60.0, 0.0, -60.0, -120.0)
"""Yaw of the outward normals of faces 0 to 5 [degrees], at tags 18, 19, 20, 21, 22 and 17."""
BRANCH_OFFSET: Final = inches(12.938) / 2.0
"""Lateral distance from the center of a face to each of the two branches. Source: 6328. The manual prints 13 in between
the branches."""
BRANCH_DIAMETER: Final = inches(1.66)  # 1.25 in Sch 40 steel pipe, manual
BRANCH_TIP_RADIUS: Final = inches(30.738)
"""Distance from the reef's center to the end of a branch's axis, along the normal of the face, on all levels. Source:
6328."""
BRANCH_SLOPE: Final = radians(35.0)
"""Upward slope of the branches on levels 2 and 3 [rad]. Source: manual."""
_HALF_END: Final = inches(0.625) * cos(BRANCH_SLOPE)  # 6328: height from the center to the upper edge of a sloping end
BRANCH_TIP_HEIGHTS: Final = (inches(31.875) - _HALF_END, inches(47.625) - _HALF_END, inches(72.0))
"""Heights of the ends of the branches' axes on levels 2, 3 and 4. Source: manual and 6328."""
RISER_RADIUS: Final = BRANCH_TIP_RADIUS - 0.27
"""Distance from the reef's center to the upright pipe of the branches (riser), along the normal of the face. The value
is an estimate, with which algae on two branches rest 0.91 and 1.31 m high, as teams measured."""
L4_STRAIGHT: Final = 0.27
"""Length of the upright end of a level 4 branch. The value is an estimate. Below the upright end, a horizontal pipe
connects the branch with the riser and stops a coral."""
L4_BEND_HEIGHT: Final = BRANCH_TIP_HEIGHTS[2] - L4_STRAIGHT
TROUGH_EDGE_HEIGHT: Final = inches(18.0)  # manual
TROUGH_FLOOR_DROP: Final = 0.14  # from the edge to the lowest point of the sloping floor, estimate
TROUGH_DEPTH: Final = 0.25  # from the face to the upright inner wall, estimate
TROUGH_WALL_HEIGHT: Final = TROUGH_EDGE_HEIGHT  # height of the inner wall's top, estimate

# --- Coral stations --------------------------------------------------------------------------------------------------

STATION_FACE_CENTER: Final = (inches(33.51), inches(25.80))
"""x and y of the center of the right station's face, at tag 12. The face is 0.7 mm farther out in 6328. The left
station is the mirror image in y."""
STATION_YAW_DEG: Final = 54.0
"""Yaw of the outward normal of the right station's face [degrees]. Source: tags. 6328 has 54.011."""
STATION_OPENING_WIDTH: Final = inches(76.0)  # manual
STATION_OPENING_HEIGHT: Final = inches(7.0)  # manual
STATION_OPENING_BOTTOM: Final = inches(37.5)  # manual
CHUTE_SLOPE: Final = radians(55.0)  # manual
CHUTE_LIP_SLOPE: Final = radians(35.0)
"""Slope of the chute near the mouth [rad]. The value is an estimate. A floor of 55 degrees would leave no room for a
coral under the roof."""
CHUTE_LIP_LENGTH: Final = 0.10  # horizontal, estimate
CHUTE_LENGTH: Final = 0.50  # horizontal, from the mouth; estimate
STATION_DEPTH: Final = 1.05  # our choice: solid behind the face up to the corner of the walls

# --- Processor -------------------------------------------------------------------------------------------------------

PROCESSOR_X: Final = 5.987542
"""x of the center of the opening in the wall at y = 0. Source: tag 16. Red's human player is behind the opening."""
PROCESSOR_OPENING_WIDTH: Final = inches(28.0)  # manual
PROCESSOR_OPENING_HEIGHT: Final = inches(20.0)  # manual
PROCESSOR_OPENING_BOTTOM: Final = inches(7.0)  # manual
PROCESSOR_FRAME_WIDTH: Final = inches(4.0)  # width of the jambs, estimate
PROCESSOR_FRAME_TOP: Final = 1.45  # estimate: above the tag
PROCESSOR_RECESS: Final = 0.005  # offset of the frame behind the guardrail; tag 16 is 3.8 mm behind the guardrail

# --- Barge -----------------------------------------------------------------------------------------------------------

BARGE_LENGTH: Final = inches(350.0)  # along y, 29 ft 2 in, including the legs outside the guardrails; manual
BARGE_POST_SIZE: Final = 0.305  # size of the center post, MapleSim
BARGE_ZONE_DEPTH: Final = inches(46.0)  # along x, manual
BARGE_ZONE_WIDTH: Final = inches(146.5)  # along y from the guardrail, blue's on the left; manual
TRUSS_BOTTOM: Final = inches(62.0)  # where the cages' chains hang, manual
TRUSS_TOP: Final = inches(74.0)  # estimate: below the lowest point of the net
NET_Y: Final = 6.137656  # center of blue's net, tag 14
NET_LENGTH: Final = inches(144.0)  # along y, manual
NET_WIDTH: Final = 1.0  # along x, including the frame; tags 14 and 4 are 1.0038 m apart, 6328 has 40 in
NET_RIM_HEIGHT: Final = inches(88.0)  # 6328
NET_FLOOR_HEIGHT: Final = inches(76.0)  # manual: lowest point of the net
NET_FRAME_THICKNESS: Final = 0.05  # our choice

# --- Cages -----------------------------------------------------------------------------------------------------------

CAGE_X: Final = inches(345.428)  # 6328
CAGE_YS: Final = (inches(286.779), inches(242.855), inches(199.947))
"""y of blue's cages, from the guardrail inward. Source: 6328. The manual's value for the outer cage is 23 mm less."""
CAGE_SIZE: Final = inches(7.375)  # square, manual
CAGE_HEIGHT: Final = inches(24.0)  # manual
CAGE_SHALLOW_BOTTOM: Final = inches(30.125)  # manual, 6328
CAGE_DEEP_BOTTOM: Final = inches(3.125)  # manual, 6328

# --- Staging ---------------------------------------------------------------------------------------------------------

CORAL_LENGTH: Final = inches(11.875)  # manual
CORAL_OUTER_DIAMETER: Final = inches(4.5)  # manual
CORAL_INNER_DIAMETER: Final = inches(4.0)  # manual
ALGAE_DIAMETER: Final = inches(16.25)  # manual: +-0.25 in
MARK_X: Final = inches(48.0)  # 6328
MARK_YS: Final = (FIELD_WIDTH / 2.0 - inches(72.0), FIELD_WIDTH / 2.0, FIELD_WIDTH / 2.0 + inches(72.0))  # 6328
HIGH_ALGAE_FACES: Final = (0, 2, 4)  # faces with algae on level 3, 6328; the other faces have algae on level 2

_NOOK: Final = sqrt(
    (ALGAE_DIAMETER / 2.0 + BRANCH_DIAMETER / 2.0) ** 2 - BRANCH_OFFSET**2
)  # distance from a ball's center to the plane of two pipes
REEF_ALGAE_RADIUS: Final = RISER_RADIUS + _NOOK
"""Horizontal distance from the reef's center to the center of an algae on two branches, in contact with two risers."""
REEF_ALGAE_HEIGHTS: Final = tuple(
    tip - (BRANCH_TIP_RADIUS - REEF_ALGAE_RADIUS) * tan(BRANCH_SLOPE) + _NOOK / cos(BRANCH_SLOPE)
    for tip in BRANCH_TIP_HEIGHTS[:2]
)
"""Heights of the centers of low and high algae: 0.910 and 1.310 m, as teams measured."""
