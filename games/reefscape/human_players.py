"""Human players, who drop coral into the stations' chutes and throw algae from the processor at the alliance's net."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

import numpy as np

from games.reefscape import dimensions as dim
from games.reefscape.field import ALLIANCES, FIELD
from games.reefscape.pieces import ALGAE, CORAL
from games.reefscape.staging import STATION_STOCK
from simcore.match.game import PlayedMatch
from simcore.match.human_actions import Feeder, HumanAction
from simcore.match.scoring import Alliance, other_alliance
from simcore.pieces.pool import PieceStatus
from simcore.robot.robot import Robot
from simcore.typing import FloatArray
from simcore.units import degrees
from simcore.world.rotation import from_rpy, rotate

__all__ = ["HumanPlayers", "station_faces"]

# Estimates.
_DROP_PERIOD = 1.1  # [s] between two coral from one station
_THROW_PERIOD = 4.0  # [s] between two algae
_DROP_DEPTH = 0.30  # [m] behind the chute's mouth
_DROP_SPREAD = 0.03  # [m]; standard deviation of the lateral position
_HALF_CHUTE = 0.5 * (dim.STATION_OPENING_WIDTH - dim.CORAL_LENGTH)  # [m]; largest lateral offset of a coral's center
_STATION_YAW = math.radians(dim.STATION_YAW_DEG)
_HALF_DROP = (
    dim.STATION_FACE_CENTER[0] - (_DROP_DEPTH + 0.5 * dim.CORAL_OUTER_DIAMETER) * math.cos(_STATION_YAW)
) / math.sin(_STATION_YAW) - 0.5 * dim.CORAL_LENGTH  # [m]; lateral limit by the alliance wall at this depth
_DROP_GAP = 0.003  # [m]; height above the chute
_REACH = 0.7  # [m]; largest distance from a station's face to the center of a robot that waits for coral
_WAITING = 0.7  # [m/s]; top speed of a robot that waits for coral
_THROW_HEIGHT = 2.0  # [m]
_THROW_ELEVATION = degrees(60.0)
_THROW_ERROR = 0.03  # standard deviation of the direction [rad], and relative to the speed


def station_faces(alliance: Alliance) -> dict[str, tuple[float, float, float]]:
    """Return the center and outward yaw of the face of each station of an alliance, by side [m, m, rad]."""
    (x, y), yaw = dim.STATION_FACE_CENTER, _STATION_YAW
    faces = {"right": (x, y, yaw), "left": (x, dim.FIELD_WIDTH - y, -yaw)}
    if alliance == "blue":
        return faces
    return {side: FIELD.symmetry.flip_pose(*face) for side, face in faces.items()}


class HumanPlayers:
    """All human players of one match.

    Args:
        match: Match with staged pieces and placed robots.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        state, kinds = match.pieces.state, [kind.name for kind in match.pieces.types]
        waiting = np.nonzero((state.status == PieceStatus.STAGED) & (state.kind == kinds.index(CORAL.name)))[0].tolist()
        preloads = sum(len(robot.held) for robot, of in zip(match.robots, match.alliances, strict=True) if of == "blue")
        blue = min(STATION_STOCK - preloads, len(waiting))
        self._faces = {alliance: station_faces(alliance) for alliance in ALLIANCES}
        own = match.entries[0].alliance  # scatter goes by this alliance, for symmetry
        self._coral: dict[Alliance, Feeder] = {}
        self._algae: dict[Alliance, Feeder] = {}
        for alliance in ALLIANCES:
            slots = waiting[:blue] if alliance == "blue" else waiting[blue:]
            clumsiness = match.draws.factor("human_players", int(alliance != own))
            self._coral[alliance] = Feeder(match, slots, clumsiness=clumsiness)
            self._algae[alliance] = Feeder(match, clumsiness=clumsiness)
        self._stations = {
            side: HumanAction(
                name=f"Feed{side.capitalize()}",
                summary=f"drop a coral into the {side} station",
                feeders=self._coral,
                act=partial(self._drop, side),
                period=_DROP_PERIOD,
            )
            for side in self._faces["blue"]
        }
        self._net = HumanAction(
            name="ThrowAlgae",
            summary="throw an algae at the net",
            feeders=self._algae,
            act=self._throw,
            period=_THROW_PERIOD,
            modes=("teleop",),
        )
        self.actions = (*self._stations.values(), self._net)
        """Actions of human players: feed at each station, and throw an algae."""

    @property
    def stock(self) -> Mapping[Alliance, int]:
        """Number of coral at each alliance's stations."""
        return {alliance: feeder.stock for alliance, feeder in self._coral.items()}

    @property
    def waiting_algae(self) -> Mapping[Alliance, int]:
        """Number of algae that each alliance's human player at a processor has."""
        return {alliance: feeder.stock for alliance, feeder in self._algae.items()}

    def take_algae(self, scored_by: Alliance, slot: int) -> None:
        """Give an algae scored in a processor to the other alliance's human player."""
        self._algae[other_alliance(scored_by)].keep(slot)

    def act(self) -> None:
        """Drop coral for waiting robots and throw algae, when due; call this method once a tick.

        The method does not act for human players that a user controls.
        """
        timer = self._match.timer
        for alliance in ALLIANCES:
            if alliance in self._match.persons:
                continue
            for side, station in self._stations.items():
                if station.is_ready(timer, alliance) and self._waits_at(alliance, side) is not None:
                    station.take(timer, alliance)
            self._net.take(timer, alliance)

    def _waits_at(self, alliance: Alliance, side: str) -> float | None:
        """Return the lateral offset of a robot that waits for coral at a station, or None if no robot waits.

        The offset is to the left as seen from the station [m].
        """
        x, y, yaw = self._faces[alliance][side]
        c, s = math.cos(yaw), math.sin(yaw)
        for robot, owner in zip(self._match.robots, self._match.alliances, strict=True):
            rx, ry, _ = robot.chassis.pose
            out, aside = c * (rx - x) + s * (ry - y), c * (ry - y) - s * (rx - x)
            is_there = out < _REACH and abs(aside) < _HALF_CHUTE and robot.chassis.speed < _WAITING
            if owner == alliance and is_there and not self._has_coral(robot):
                return aside
        return None

    def _drop(self, side: str, alliance: Alliance) -> None:
        """Drop a coral in front of a robot that waits at a station, or at the station's center if no robot waits."""
        feeder = self._coral[alliance]
        aside = (self._waits_at(alliance, side) or 0.0) + _DROP_SPREAD * float(feeder.errors(1)[0])
        feeder.put(*_in_chute(*self._faces[alliance][side], min(max(aside, -_HALF_DROP), _HALF_DROP)))

    def _has_coral(self, robot: Robot) -> bool:
        return any(self._match.pieces.kind_name(slot) == CORAL.name for slot in robot.held)

    def _throw(self, alliance: Alliance) -> None:
        """Throw an algae at the net, with random errors of direction and speed."""
        target = (dim.FIELD_CENTER[0], dim.FIELD_WIDTH - dim.NET_Y, dim.NET_RIM_HEIGHT + ALGAE.rest_height)
        hands = (dim.PROCESSOR_X, -0.3, _THROW_HEIGHT)  # red's human player, behind blue's processor
        flip = FIELD.symmetry if alliance == "blue" else None
        self._algae[alliance].throw(hands, target, elevation=_THROW_ELEVATION, error=_THROW_ERROR, flip=flip)


def _in_chute(x: float, y: float, yaw: float, aside: float) -> tuple[FloatArray, FloatArray]:
    """Return the position and attitude of a coral that lies across a chute and will roll down.

    Args:
        x: x of the center of the station's face [m].
        y: y of the center of the station's face [m].
        yaw: Yaw of the outward normal of the face [rad].
        aside: Lateral offset from the center, to the left as seen from the station [m].
    """
    lip = dim.STATION_OPENING_BOTTOM + dim.CHUTE_LIP_LENGTH * math.tan(dim.CHUTE_LIP_SLOPE)
    floor = lip + (_DROP_DEPTH - dim.CHUTE_LIP_LENGTH) * math.tan(dim.CHUTE_SLOPE)
    up = (0.5 * dim.CORAL_OUTER_DIAMETER + _DROP_GAP) / math.cos(dim.CHUTE_SLOPE)
    across = rotate(from_rpy(0.0, 0.0, yaw), (-_DROP_DEPTH, aside, 0.0))
    place = np.array([x + across[0], y + across[1], floor + up])
    return place, np.array(from_rpy(-math.pi / 2, 0.0, yaw))
