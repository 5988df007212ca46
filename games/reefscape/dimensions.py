"""Positions and dimensions of the 2025 field: numbers in meters, field frame.

Positions are those of the **blue** alliance; red is blue rotated by 180 degrees about the field center.
"Left" and "right" are seen from the alliance's own drivers, so for blue, left is +y.

Sources: "tags" is WPILib's AprilTag layout `k2025ReefscapeWelded`. "6328" is FieldConstants.java of team 6328
(Mechanical Advantage, RobotCode2025Public), which reads the official CAD. "manual" is a figure of the 2025 game manual,
section ARENA, as two public projects that agree print it. "MapleSim" is that simulation's 2025 arena. An estimate says
so.
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
"""Length along x, between the alliance walls. Tags; manual prints 690.875 in."""
FIELD_WIDTH: Final = 8.052
"""Width along y, between the guardrails. Tags; manual prints 317 in = 8.0518."""
FIELD_CENTER: Final = (FIELD_LENGTH / 2.0, FIELD_WIDTH / 2.0)
GUARDRAIL_HEIGHT: Final = inches(20.0)  # as in 2026
ALLIANCE_WALL_HEIGHT: Final = inches(78.8)  # as in 2026
PERIMETER_THICKNESS: Final = 0.3  # ours, not the field's: outward, so that no ball can pass
STARTING_LINE_X: Final = inches(299.438)
"""Inner edge of the line, toward the barge. 6328; equals the far reef face plus 88 in plus the tape."""
STARTING_LINE_WIDTH: Final = inches(2.0)

# --- Reef ------------------------------------------------------------------------------------------------------------

REEF_CENTER: Final = (inches(176.746), FIELD_WIDTH / 2.0)
"""Center of the reef. 6328; the middle of tags 18 and 21."""
REEF_APOTHEM: Final = inches(65.5) / 2.0
"""Distance from the center to a face. Manual; tags 18 and 21 are as far apart."""
REEF_ZONE_APOTHEM: Final = inches(93.5) / 2.0  # manual: the line 12 in before the faces, and its tape
REEF_FACE_YAWS_DEG: Final = (180.0, 120.0, 60.0, 0.0, -60.0, -120.0)
"""Outward directions of the faces 0 to 5: tags 18, 19, 20, 21, 22, 17."""
BRANCH_OFFSET: Final = inches(12.938) / 2.0
"""Distance from the middle of a face to each of its two branches. 6328; manual prints 13 in between them."""
BRANCH_DIAMETER: Final = inches(1.66)  # 1.25 in Sch 40 steel pipe, manual
BRANCH_TIP_RADIUS: Final = inches(30.738)
"""Distance from the reef's center, along the face's normal, to the end of a branch's axis, on all levels. 6328."""
BRANCH_SLOPE: Final = radians(35.0)
"""Slope of branches of levels 2 and 3, up and outward. Manual."""
_HALF_END: Final = inches(0.625) * cos(BRANCH_SLOPE)  # 6328: from the upper edge of a sloping end to its middle
BRANCH_TIP_HEIGHTS: Final = (inches(31.875) - _HALF_END, inches(47.625) - _HALF_END, inches(72.0))
"""Heights of the ends of the axes on levels 2, 3 and 4. Manual, 6328."""
RISER_RADIUS: Final = BRANCH_TIP_RADIUS - 0.27
"""Radius to the upright pipe that carries the branches. Estimate; algae between it and two branches then rest 0.91 and
1.31 m high, as teams measured them."""
L4_STRAIGHT: Final = 0.27
"""Length of the upright end on level 4, estimate. Below it the pipe is horizontal to the riser: a coral stops there."""
L4_BEND_HEIGHT: Final = BRANCH_TIP_HEIGHTS[2] - L4_STRAIGHT
TROUGH_EDGE_HEIGHT: Final = inches(18.0)  # manual
TROUGH_FLOOR_DROP: Final = 0.14  # lowest place of the sloping floor under the edge, estimate
TROUGH_DEPTH: Final = 0.25  # from the face to the upright inner wall, estimate
TROUGH_WALL_HEIGHT: Final = TROUGH_EDGE_HEIGHT  # upper end of the inner wall, estimate

# --- Coral stations --------------------------------------------------------------------------------------------------

STATION_FACE_CENTER: Final = (inches(33.51), inches(25.80))
"""Middle of the right station's face, at tag 12; 0.7 mm farther out in 6328. The left one is mirrored in y."""
STATION_YAW_DEG: Final = 54.0
"""Outward direction of the right station's face. Tags; 6328 has 54.011."""
STATION_OPENING_WIDTH: Final = inches(76.0)  # manual
STATION_OPENING_HEIGHT: Final = inches(7.0)  # manual
STATION_OPENING_BOTTOM: Final = inches(37.5)  # manual
CHUTE_SLOPE: Final = radians(55.0)  # manual
CHUTE_LIP_SLOPE: Final = radians(35.0)
"""Slope near the mouth, estimate: under a roof of 55 degrees there is no room for a coral otherwise."""
CHUTE_LIP_LENGTH: Final = 0.10  # horizontal, estimate
CHUTE_LENGTH: Final = 0.50  # horizontal, from the mouth; estimate
STATION_DEPTH: Final = 1.05  # ours: solid behind the face up to the walls' corner

# --- Processor -------------------------------------------------------------------------------------------------------

PROCESSOR_X: Final = 5.987542
"""Middle of the opening, in the wall y = 0. Tag 16. The red alliance's human player is behind it."""
PROCESSOR_OPENING_WIDTH: Final = inches(28.0)  # manual
PROCESSOR_OPENING_HEIGHT: Final = inches(20.0)  # manual
PROCESSOR_OPENING_BOTTOM: Final = inches(7.0)  # manual
PROCESSOR_FRAME_WIDTH: Final = inches(4.0)  # of the jambs, estimate
PROCESSOR_FRAME_TOP: Final = 1.45  # estimate: above the tag
PROCESSOR_RECESS: Final = 0.005  # of the frame behind the guardrail: the tag hangs 3.8 mm behind it

# --- Barge -----------------------------------------------------------------------------------------------------------

BARGE_LENGTH: Final = inches(350.0)  # along y, 29 ft 2 in, with its legs outside of the guardrails; manual
BARGE_POST_SIZE: Final = 0.305  # of the post in the middle, MapleSim
BARGE_ZONE_DEPTH: Final = inches(46.0)  # along x, manual
BARGE_ZONE_WIDTH: Final = inches(146.5)  # from the guardrail, blue's is the left one; manual
TRUSS_BOTTOM: Final = inches(62.0)  # where the cages' chains hang, manual
TRUSS_TOP: Final = inches(74.0)  # estimate: under the sag of the net
NET_Y: Final = 6.137656  # middle of blue's, tag 14
NET_LENGTH: Final = inches(144.0)  # along y, manual
NET_WIDTH: Final = 1.0  # along x over its frame; tags 14 and 4 are 1.0038 m apart, 6328 has 40 in
NET_RIM_HEIGHT: Final = inches(88.0)  # 6328
NET_FLOOR_HEIGHT: Final = inches(76.0)  # manual: lowest point of the net
NET_FRAME_THICKNESS: Final = 0.05  # ours

# --- Cages -----------------------------------------------------------------------------------------------------------

CAGE_X: Final = inches(345.428)  # 6328
CAGE_YS: Final = (inches(286.779), inches(242.855), inches(199.947))
"""Y of blue's cages, from the guardrail inward. 6328; for the outer one the manual has 23 mm less."""
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
HIGH_ALGAE_FACES: Final = (0, 2, 4)  # faces with algae on level 3; the others have it on level 2. 6328

_NOOK: Final = sqrt(
    (ALGAE_DIAMETER / 2.0 + BRANCH_DIAMETER / 2.0) ** 2 - BRANCH_OFFSET**2
)  # ball to plane of two pipes
REEF_ALGAE_RADIUS: Final = RISER_RADIUS + _NOOK
"""Distance from the reef's center to algae that rest on two branches against two risers."""
REEF_ALGAE_HEIGHTS: Final = tuple(
    tip - (BRANCH_TIP_RADIUS - REEF_ALGAE_RADIUS) * tan(BRANCH_SLOPE) + _NOOK / cos(BRANCH_SLOPE)
    for tip in BRANCH_TIP_HEIGHTS[:2]
)
"""Low and high: 0.910 and 1.310 m, as teams have measured."""
