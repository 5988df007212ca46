"""Positions and dimensions of the 2026 field, in meters in the field frame.

All positions are for the **blue** alliance. The red positions are the blue positions rotated by 180 degrees about the
field center. "Left" and "right" are from the view of the alliance's drivers, so left is +y for blue.

In the sources, "manual" is the 2026 game manual, kickoff version V0, section 5 ARENA. "Tags" is WPILib's AprilTag
layout `k2026RebuiltWelded`. "6328" is FieldConstants.java of team 6328 (Mechanical Advantage), with values from the
official CAD. "Java" is a Java simulation of the 2026 robot. Estimates are marked.
"""

from __future__ import annotations

from math import sqrt
from typing import Final

from simcore.units import inches

# --- Field -----------------------------------------------------------------------------------------------------------

FIELD_LENGTH: Final = 16.541
"""Field length along x, between the alliance walls. Source: tags. Manual 5.2 prints ~651.2 in = 16.540."""
FIELD_WIDTH: Final = 8.069
"""Field width along y, between the guardrails. Source: tags. Manual 5.2 prints ~317.7 in = 8.070."""
FIELD_CENTER: Final = (FIELD_LENGTH / 2.0, FIELD_WIDTH / 2.0)
GUARDRAIL_HEIGHT: Final = inches(20.0)  # manual 5.2
ALLIANCE_WALL_HEIGHT: Final = inches(36.8) + inches(42.0)
"""Height of diamond plate and plastic sheet, without the top rail, which has no printed size. Source: manual 5.9.1.

The tower wall has the same height in the simulation. The real tower wall, 49.25 in wide and 78.25 in (1.988 m) high
(manual 5.8), is 14 mm lower.
"""
PERIMETER_THICKNESS: Final = 0.3  # our choice, outward, so that no ball passes through at 40 m/s
ALLIANCE_ZONE_DEPTH: Final = inches(158.6)  # manual 5.3

# --- Hub -------------------------------------------------------------------------------------------------------------

HUB_SIZE: Final = inches(47.0)
"""Edge length of the square base. Source: manual 5.4."""
HUB_CENTER: Final = (inches(158.6) + HUB_SIZE / 2.0, FIELD_WIDTH / 2.0)
"""Center of the hub. The front of the hub is 158.6 in from the alliance wall. The hub is centered between the bumps.
Source: manual 5.4. Tags 26 and 20 agree to 0.3 mm."""
HUB_BOX_TOP: Final = 1.2
"""Height of the solid base, which is the floor of the scoring zone. Source: Java. The value is an estimate, because the
manual has no figure."""
HUB_OPENING_HEIGHT: Final = inches(72.0)
"""Height of the opening's rim. Source: manual 5.4 (front edge)."""
HUB_OPENING_APOTHEM: Final = inches(41.7) / 2.0
"""Apothem of the hexagonal opening. Source: manual 5.4, with 41.7 in as the width across flats, as in Java."""
HUB_OPENING_CIRCUMRADIUS: Final = HUB_OPENING_APOTHEM * 2.0 / sqrt(3.0)
"""Circumradius of the hexagonal opening. One side of the hexagon faces the alliance wall, so two corners extend 15 mm
beyond the base in y."""
HUB_THROAT_CIRCUMRADIUS: Final = 0.300
"""Circumradius of the hexagonal hole at the bottom of the funnel. Source: Java; the value is an estimate."""
HUB_THROAT_APOTHEM: Final = HUB_THROAT_CIRCUMRADIUS * sqrt(3.0) / 2.0
HUB_THROAT_HEIGHT: Final = inches(56.5)
"""Height of the funnel's bottom. Source: 6328 (`innerHeight`). The slope of the funnel is then 55 degrees."""
HUB_RIM_THICKNESS: Final = inches(1.0)
"""Thickness of the rim from the opening to the outer skirt. The value is an estimate. The outer edge of the rim is also
lower by this amount, because balls came to rest on a flat rim."""
HUB_SHOULDER_RISE: Final = 0.26
"""Rise of the slopes on the four corners of the base. The value is an estimate. The slope angle is about 45 degrees, so
balls roll off."""
HUB_BACKBOARD_TOP: Final = 3.0
"""Height of the net behind the opening, on the neutral side. Source: Java, because the manual has no figure."""
HUB_EXIT_X: Final = HUB_CENTER[0] + HUB_SIZE / 2.0
"""x of the face of the base with the exit, toward the neutral zone. Source: manual 5.4."""
HUB_EXIT_WIDTH: Final = inches(47.0) - 2.0 * inches(5.72)
"""Width of the single exit, 35.6 in. Source: drawing GE-26306, as cited by rebuilt-sim-2026. Figure 5-8 of the manual
shows four exits."""
HUB_EXIT_BOTTOM: Final = inches(30.13)  # drawing GE-26306
HUB_EXIT_TOP: Final = inches(38.88)  # drawing GE-26306

# --- Bumps -----------------------------------------------------------------------------------------------------------

BUMP_WIDTH: Final = inches(73.0)  # along y, manual 5.5
BUMP_DEPTH: Final = inches(44.4)  # along x, manual 5.5
BUMP_HEIGHT: Final = inches(6.513)
"""Height of the bumps. Source: manual 5.5.

With this height and the printed depth, the two ramps have a slope of 16.4 degrees, and not the printed 15 degrees. (A
slope of 15 degrees would fit if each ramp started with a lip of 0.565 in, about the thickness of the 0.5 in plate.)
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
width. The other 3.3 in must be a part of the frame outside the guardrail, beyond the reach of robots and balls.
"""
TRENCH_ARM_DEPTH: Final = inches(4.0)
"""Depth of the arm across the opening, along x. Source: 6328 (`barWidth`). Tags 17 and 28, on the two sides of the arm,
are 2.95 in apart."""
TRENCH_X: Final = HUB_CENTER[0]  # tags 17 and 28 are on the two sides of this line
TRENCH_LEFT_Y: Final = FIELD_WIDTH - TRENCH_CLEAR_WIDTH / 2.0
"""y of the middle of the left trench's clear opening. Tag 22 agrees to 6 mm."""
TRENCH_RIGHT_Y: Final = TRENCH_CLEAR_WIDTH / 2.0

# --- Tower -----------------------------------------------------------------------------------------------------------

TOWER_Y: Final = 3.7457
"""y of the tower's center. Source: tag 31, which is the center in 6328. MapleSim's uprights are 2 mm to the right."""
TOWER_BASE_WIDTH: Final = inches(39.0)  # along y, manual 5.8
TOWER_BASE_DEPTH: Final = inches(45.18)  # from the tower wall, manual 5.8
TOWER_BASE_HEIGHT: Final = inches(0.25)  # manual 5.8: edges 0.2 to 0.3 in high
TOWER_UPRIGHT_HEIGHT: Final = inches(72.1)  # top above the carpet, manual 5.8
TOWER_UPRIGHT_THICKNESS: Final = inches(1.5)  # along y, manual 5.8
TOWER_UPRIGHT_DEPTH: Final = inches(3.5)  # along x, manual 5.8
TOWER_UPRIGHT_GAP: Final = inches(32.25)  # clear gap between the uprights, manual 5.8
TOWER_UPRIGHT_X: Final = inches(43.51) - TOWER_UPRIGHT_DEPTH / 2.0
"""x of the uprights' centers. Source: 6328 (`frontFaceX`). MapleSim has 1.062."""
TOWER_UPRIGHT_YS: Final = (
    TOWER_Y - (TOWER_UPRIGHT_GAP + TOWER_UPRIGHT_THICKNESS) / 2.0,
    TOWER_Y + (TOWER_UPRIGHT_GAP + TOWER_UPRIGHT_THICKNESS) / 2.0,
)
"""y of the center of the right upright, and y of the center of the left upright."""
TOWER_RUNG_HEIGHTS: Final = (inches(27.0), inches(45.0), inches(63.0))  # low, mid, high; centers, manual 5.8
TOWER_RUNG_DIAMETER: Final = inches(1.66)  # manual 5.8
TOWER_RUNG_LENGTH: Final = TOWER_UPRIGHT_GAP + 2.0 * (TOWER_UPRIGHT_THICKNESS + inches(5.875))  # manual 5.8
TOWER_BRACE_BOTTOM: Final = inches(28.40)  # structure from uprights to wall, manual 5.8 (approximately)
TOWER_BRACE_TOP: Final = inches(43.38)  # manual 5.8 (approximately)

# --- Driver stations --------------------------------------------------------------------------------------------------

_STATION_WIDTH: Final = inches(72.0)
"""Width of one driver station. The value is an estimate from the space next to the walls of tower and outpost."""
_TOWER_WALL_WIDTH: Final = inches(49.25)  # manual 5.8
_STATION_X: Final = -0.01  # behind the face of the alliance wall, at the station's panel
DRIVER_STATIONS: Final = (
    (_STATION_X, TOWER_Y + _TOWER_WALL_WIDTH / 2.0 + 1.5 * _STATION_WIDTH),
    (_STATION_X, TOWER_Y + _TOWER_WALL_WIDTH / 2.0 + 0.5 * _STATION_WIDTH),
    (_STATION_X, TOWER_Y - _TOWER_WALL_WIDTH / 2.0 - 0.5 * _STATION_WIDTH),
)
"""x and y of the centers of driver stations 1 to 3, from the drivers' left to right. The tower wall is between stations
2 and 3."""

# --- Depot -----------------------------------------------------------------------------------------------------------

DEPOT_WIDTH: Final = inches(42.0)  # along y, outer size, manual 5.7
DEPOT_DEPTH: Final = inches(27.0)  # along x from the alliance wall, outer size, manual 5.7
DEPOT_BARRIER_WIDTH: Final = inches(3.0)  # manual 5.7
DEPOT_BARRIER_HEIGHT: Final = inches(1.125)  # 1.0 in on hook fastener, manual 5.7
DEPOT_BARRIER_BEVEL: Final = inches(1.0)
"""Bevel of both long edges. The value is an estimate, because the manual prints no cross section.

A real driven tire climbs a square edge by grip on the edge. In the simulation, only the tire model computes grip, and
the contact of a tire with an edge has no grip. The edge must therefore be a ramp.
"""
DEPOT_Y: Final = FIELD_WIDTH / 2.0 + inches(75.93)
"""y of the depot's center. Source: 6328 (`distanceFromCenterY`). The right edge is then at 5.430, in Java at 5.429."""

# --- Outpost ---------------------------------------------------------------------------------------------------------
# Chute and corral are behind the alliance wall, in the alliance area of the human player (manual 5.9.2).

OUTPOST_Y: Final = 0.666  # tag 29
OUTPOST_OPENING_WIDTH: Final = inches(31.8)  # chute, manual 5.9.2
OUTPOST_OPENING_BOTTOM: Final = inches(28.1)  # chute, manual 5.9.2
CORRAL_OPENING_WIDTH: Final = inches(32.0)  # manual 5.9.2
CORRAL_OPENING_HEIGHT: Final = inches(7.0)  # manual 5.9.2
CORRAL_OPENING_BOTTOM: Final = inches(1.88)  # manual 5.9.2
