"""Positions and dimensions of the 2026 field, in meters in the field frame.

Positions are those of the **blue** alliance; red is blue rotated by 180 degrees about the field center. "Left" and
"right" are as seen by the alliance's own drivers, so for blue, left is +y.

Sources: "manual" is the 2026 game manual, kickoff version V0, section 5 ARENA. "Tags" is WPILib's AprilTag layout
`k2026RebuiltWelded`. "6328" is FieldConstants.java of team 6328 (Mechanical Advantage), which reads the official CAD.
"Java" is a Java simulation of the 2026 robot. Estimates are marked.
"""

from __future__ import annotations

from math import sqrt
from typing import Final

from simcore.units import inches

# --- Field -----------------------------------------------------------------------------------------------------------

FIELD_LENGTH: Final = 16.541
"""Field length along x, between the alliance walls. Tags; manual 5.2 prints ~651.2 in = 16.540."""
FIELD_WIDTH: Final = 8.069
"""Field width along y, between the guardrails. Tags; manual 5.2 prints ~317.7 in = 8.070."""
FIELD_CENTER: Final = (FIELD_LENGTH / 2.0, FIELD_WIDTH / 2.0)
GUARDRAIL_HEIGHT: Final = inches(20.0)  # manual 5.2
ALLIANCE_WALL_HEIGHT: Final = inches(36.8) + inches(42.0)
"""Height of diamond plate and plastic sheet, manual 5.9.1, without the top rail, whose size is not printed.

Also used for the tower wall, 49.25 in wide and 78.25 in (1.988 m) high (manual 5.8), which is 14 mm lower.
"""
PERIMETER_THICKNESS: Final = 0.3  # our choice, outward, so that no ball passes through at 40 m/s
ALLIANCE_ZONE_DEPTH: Final = inches(158.6)  # manual 5.3

# --- Hub -------------------------------------------------------------------------------------------------------------

HUB_SIZE: Final = inches(47.0)
"""Edge length of the square base. Manual 5.4."""
HUB_CENTER: Final = (inches(158.6) + HUB_SIZE / 2.0, FIELD_WIDTH / 2.0)
"""Center of the hub: 158.6 in from the alliance wall to its front, centered between the bumps. Manual 5.4; tags 26 and
20 agree to 0.3 mm."""
HUB_BOX_TOP: Final = 1.2
"""Height of the solid base, which is the floor of the scoring zone. Java; estimate, the manual has no figure."""
HUB_OPENING_HEIGHT: Final = inches(72.0)
"""Height of the opening's rim. Manual 5.4 (front edge)."""
HUB_OPENING_APOTHEM: Final = inches(41.7) / 2.0
"""Apothem of the hexagonal opening, with the 41.7 in of manual 5.4 taken as the width across flats, as in Java."""
HUB_OPENING_CIRCUMRADIUS: Final = HUB_OPENING_APOTHEM * 2.0 / sqrt(3.0)
"""Circumradius of the hexagonal opening. One flat edge faces the alliance wall, so the corners extend 15 mm past the
base in y."""
HUB_THROAT_CIRCUMRADIUS: Final = 0.300
"""Circumradius of the hexagonal hole at the bottom of the funnel. Java; estimate."""
HUB_THROAT_APOTHEM: Final = HUB_THROAT_CIRCUMRADIUS * sqrt(3.0) / 2.0
HUB_THROAT_HEIGHT: Final = inches(56.5)
"""Height of the funnel's bottom. 6328 (`innerHeight`); the funnel's slope is then 55 degrees."""
HUB_RIM_THICKNESS: Final = inches(1.0)
"""Thickness of the rim from the opening to the outer skirt; estimate. The rim also drops outward by this amount,
because balls came to rest on a flat rim."""
HUB_SHOULDER_RISE: Final = 0.26
"""Rise of the slopes on the four corners of the base; estimate. The slope is about 45 degrees, so that no ball stays
there."""
HUB_BACKBOARD_TOP: Final = 3.0
"""Height of the net behind the opening, on the neutral side. Java; the manual has no figure."""
HUB_EXIT_X: Final = HUB_CENTER[0] + HUB_SIZE / 2.0
"""x of the base's face with the exit, toward the neutral zone. Manual 5.4."""
HUB_EXIT_WIDTH: Final = inches(47.0) - 2.0 * inches(5.72)
"""Width of the single exit, 35.6 in. Drawing GE-26306, as cited by rebuilt-sim-2026; figure 5-8 of the manual shows
four exits."""
HUB_EXIT_BOTTOM: Final = inches(30.13)  # drawing GE-26306
HUB_EXIT_TOP: Final = inches(38.88)  # drawing GE-26306

# --- Bumps -----------------------------------------------------------------------------------------------------------

BUMP_WIDTH: Final = inches(73.0)  # along y, manual 5.5
BUMP_DEPTH: Final = inches(44.4)  # along x, manual 5.5
BUMP_HEIGHT: Final = inches(6.513)
"""Height of the bumps. Manual 5.5. Two ramps from the carpet to this height have a slope of 16.4 degrees, not the
printed 15 degrees; we keep height and depth. (15 degrees fit if each ramp starts with a lip of 0.565 in, about the
thickness of its 0.5 in plate.)
"""
BUMP_X: Final = HUB_CENTER[0]
BUMP_LEFT_Y: Final = HUB_CENTER[1] + (HUB_SIZE + BUMP_WIDTH) / 2.0  # next to the hub, manual 5.5
BUMP_RIGHT_Y: Final = HUB_CENTER[1] - (HUB_SIZE + BUMP_WIDTH) / 2.0

# --- Trenches --------------------------------------------------------------------------------------------------------

TRENCH_DEPTH: Final = inches(47.0)  # along x, manual 5.6
TRENCH_HEIGHT: Final = inches(40.25)  # manual 5.6
TRENCH_CLEAR_WIDTH: Final = inches(50.34)  # from the guardrail, manual 5.6
TRENCH_CLEAR_HEIGHT: Final = inches(22.25)  # under the arm, manual 5.6
TRENCH_LEG_WIDTH: Final = FIELD_WIDTH / 2.0 - HUB_SIZE / 2.0 - BUMP_WIDTH - TRENCH_CLEAR_WIDTH
"""Width of the leg between the clear opening and the bump: 12.0 in, as in 6328 (`blockWidth`) and MapleSim.

The printed outer width of 65.65 in does not fit between guardrail and bump, which are 62.35 in apart. We keep the clear
width; the other 3.3 in must be frame outside the guardrail, beyond the reach of robots and balls.
"""
TRENCH_ARM_DEPTH: Final = inches(4.0)
"""Depth of the arm across the opening, along x. 6328 (`barWidth`); tags 17 and 28, on its two sides, are 2.95 in
apart."""
TRENCH_X: Final = HUB_CENTER[0]  # tags 17 and 28 stand on both sides of this line
TRENCH_LEFT_Y: Final = FIELD_WIDTH - TRENCH_CLEAR_WIDTH / 2.0
"""y of the left trench's center, in the middle of the clear opening. Tag 22 agrees to 6 mm."""
TRENCH_RIGHT_Y: Final = TRENCH_CLEAR_WIDTH / 2.0

# --- Tower -----------------------------------------------------------------------------------------------------------

TOWER_Y: Final = 3.7457
"""y of the tower's center. Tag 31, which 6328 gives as the center; MapleSim's uprights are 2 mm to the right."""
TOWER_BASE_WIDTH: Final = inches(39.0)  # along y, manual 5.8
TOWER_BASE_DEPTH: Final = inches(45.18)  # from the tower wall, manual 5.8
TOWER_BASE_HEIGHT: Final = inches(0.25)  # manual 5.8: edges 0.2 to 0.3 in high
TOWER_UPRIGHT_HEIGHT: Final = inches(72.1)  # top above the carpet, manual 5.8
TOWER_UPRIGHT_THICKNESS: Final = inches(1.5)  # along y, manual 5.8
TOWER_UPRIGHT_DEPTH: Final = inches(3.5)  # along x, manual 5.8
TOWER_UPRIGHT_GAP: Final = inches(32.25)  # clear gap between the uprights, manual 5.8
TOWER_UPRIGHT_X: Final = inches(43.51) - TOWER_UPRIGHT_DEPTH / 2.0
"""x of the uprights' centers. 6328 (`frontFaceX`); MapleSim has 1.062."""
TOWER_UPRIGHT_YS: Final = (
    TOWER_Y - (TOWER_UPRIGHT_GAP + TOWER_UPRIGHT_THICKNESS) / 2.0,
    TOWER_Y + (TOWER_UPRIGHT_GAP + TOWER_UPRIGHT_THICKNESS) / 2.0,
)
"""y of the centers of the right and the left upright."""
TOWER_RUNG_HEIGHTS: Final = (inches(27.0), inches(45.0), inches(63.0))  # low, mid, high; centers, manual 5.8
TOWER_RUNG_DIAMETER: Final = inches(1.66)  # manual 5.8
TOWER_RUNG_LENGTH: Final = TOWER_UPRIGHT_GAP + 2.0 * (TOWER_UPRIGHT_THICKNESS + inches(5.875))  # manual 5.8
TOWER_BRACE_BOTTOM: Final = inches(28.40)  # structure from uprights to wall, manual 5.8 (approximately)
TOWER_BRACE_TOP: Final = inches(43.38)  # manual 5.8 (approximately)

# --- Driver stations --------------------------------------------------------------------------------------------------

_STATION_WIDTH: Final = inches(72.0)
"""Width of one driver station. Estimate, from the space next to the walls of tower and outpost."""
_TOWER_WALL_WIDTH: Final = inches(49.25)  # manual 5.8
_STATION_X: Final = -0.01  # behind the face of the alliance wall, at the station's panel
DRIVER_STATIONS: Final = (
    (_STATION_X, TOWER_Y + _TOWER_WALL_WIDTH / 2.0 + 1.5 * _STATION_WIDTH),
    (_STATION_X, TOWER_Y + _TOWER_WALL_WIDTH / 2.0 + 0.5 * _STATION_WIDTH),
    (_STATION_X, TOWER_Y - _TOWER_WALL_WIDTH / 2.0 - 0.5 * _STATION_WIDTH),
)
"""Centers of stations 1 to 3, from the drivers' left to right; station 3 is beyond the tower wall."""

# --- Depot -----------------------------------------------------------------------------------------------------------

DEPOT_WIDTH: Final = inches(42.0)  # along y, outer size, manual 5.7
DEPOT_DEPTH: Final = inches(27.0)  # along x from the alliance wall, outer size, manual 5.7
DEPOT_BARRIER_WIDTH: Final = inches(3.0)  # manual 5.7
DEPOT_BARRIER_HEIGHT: Final = inches(1.125)  # 1.0 in on hook fastener, manual 5.7
DEPOT_BARRIER_BEVEL: Final = inches(1.0)
"""Bevel of both long edges; estimate, because the manual prints no cross section. A driven tire climbs a square edge by
its grip on the edge; our contacts leave grip to the tire model, so the edge itself must be a ramp.
"""
DEPOT_Y: Final = FIELD_WIDTH / 2.0 + inches(75.93)
"""y of the depot's center. 6328 (`distanceFromCenterY`); the right edge is then at 5.430, and at 5.429 in Java."""

# --- Outpost ---------------------------------------------------------------------------------------------------------
# Chute and corral are behind the alliance wall, in the alliance area of the human player (manual 5.9.2).

OUTPOST_Y: Final = 0.666  # tag 29
OUTPOST_OPENING_WIDTH: Final = inches(31.8)  # chute, manual 5.9.2
OUTPOST_OPENING_BOTTOM: Final = inches(28.1)  # chute, manual 5.9.2
CORRAL_OPENING_WIDTH: Final = inches(32.0)  # manual 5.9.2
CORRAL_OPENING_HEIGHT: Final = inches(7.0)  # manual 5.9.2
CORRAL_OPENING_BOTTOM: Final = inches(1.88)  # manual 5.9.2
