"""Simulation of the cameras that a robot program uses, based on the robot's true pose."""

from __future__ import annotations

import logging
import operator
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore import season
from simcore.errors import ConfigError
from simcore.install_text import install_command
from simcore.match.match import Match
from simcore.robotcode.makers.photonvision.photon_program import (
    FoundMount,
    lens_of,
    mounts,
    photon_program,
    pipeline_of,
)
from simcore.robotcode.networktables.network_clock import NetworkClock
from simcore.robotcode.networktables.questnav_table import TABLE, QuestNavTable
from simcore.robotcode.sim.table_watch import table_watch
from simcore.vision.camera import CameraConfig, CameraMount
from simcore.vision.quest_headset import QuestConfig

if TYPE_CHECKING:
    from simcore.vision.limelight import LimelightSim

Pose3d = season.wpimath.Pose3d
Quaternion = season.wpimath.Quaternion
Rotation3d = season.wpimath.Rotation3d
Translation3d = season.wpimath.Translation3d
ntcore = season.ntcore

__all__ = ["RobotCameras", "surveyed_cameras"]

_log = logging.getLogger(__name__)

_LIMELIGHT = re.compile(r"limelight(-[\w-]+)?")
"""Pattern of Limelight table names. Other tables may also have names that start with `limelight`."""


class RobotCameras:
    """Simulated cameras for one robot program.

    The match already contains the Limelights and PhotonVision cameras from `simcore.toml`. This class adds the other
    cameras that the program builds: each `PhotonCamera` with a known mount, and a QuestNav headset.

    Args:
        match: Match that contains the robot.
        number: Index of the robot in the match.
        cameras: Cameras described in `simcore.toml`.
        headset: Headset described in `simcore.toml`; None if the file describes no headset.
        clock: Clock that converts simulated time to NetworkTables time.
        folder: Folder of robot.py.
        file: Name of the robot description file, for messages.
    """

    def __init__(
        self,
        match: Match,
        number: int,
        cameras: tuple[CameraConfig, ...],
        headset: QuestConfig | None,
        *,
        clock: NetworkClock,
        folder: Path,
        file: str,
    ) -> None:
        self._match = match
        self._number = number
        self._file = file
        self._clock = clock
        self._described = {camera.name: camera for camera in cameras}
        self._program = photon_program()
        self._watch = table_watch()
        self._watch.search(folder)
        self._photon: dict[str, LimelightSim] = {}
        self._reported_mounts: dict[str, CameraMount | None] = {}
        self._reported: set[str] = set()
        self._unplaced: set[str] = set()  # Limelights without a known mount
        self._headset_reported = False
        chassis = match.robots[number].chassis

        def true_pose() -> Any:
            x, y, z, w = chassis.quat
            return Pose3d(Translation3d(*chassis.pos), Rotation3d(Quaternion(w, x, y, z)))

        self._program.true_pose = true_pose
        for camera in cameras:
            if camera.maker == "photonvision":
                self._feed(match.cameras.camera(camera.name))
            _log.info(
                "camera %r (%s %s): %s, as %s says",
                *(camera.name, camera.maker, camera.type.name, _place(camera.mount), file),
            )
        if headset is not None:
            self._add_headset(headset)
        self._seen = -1
        self._transforms: list[Any] = []
        self._asked = -1
        self.after_tick()
        unused = [name for name, c in self._described.items() if c.maker == "photonvision" and name not in self._built]
        if unused:
            _log.warning(
                "%s: robot code has built no PhotonCamera(%s); it has built %s",
                *(file, ", ".join(map(repr, unused)), ", ".join(map(repr, self._built)) or "none"),
            )

    @property
    def _built(self) -> Mapping[str, object]:
        return self._program.cameras

    @property
    def running(self) -> list[str]:
        """Names of the cameras in `simcore.toml` and of the program's cameras with a known mount.

        The list includes `QuestNav` if the match contains a headset.
        """
        placed = [name for name, camera in self._photon.items() if not camera.is_off]
        return [*self._described, *placed, *(["QuestNav"] if self._match.cameras.headsets else [])]

    @property
    def blind(self) -> list[str]:
        """Names of the cameras that the program uses and whose mount is unknown."""
        return [*(name for name, camera in self._photon.items() if camera.is_off), *sorted(self._unplaced)]

    def after_tick(self) -> None:
        """Add cameras and a headset that the program has started to use, and apply changes of camera mounts."""
        transforms = [seen.robot_to_camera for seen in self._program.estimators]
        if self._program.version != self._seen or any(map(operator.is_not, transforms, self._transforms)):
            self._seen, self._transforms = self._program.version, transforms
            self._follow_photon()
        if len(self._watch.names) != self._asked:
            self._asked = len(self._watch.names)
            self._follow_tables()
        self._follow_headset()

    # --- PhotonVision ---------------------------------------------------------------------------------------------

    def _follow_photon(self) -> None:
        found = mounts(self._program)
        new = [name for name in self._built if name not in {**self._described, **self._photon, **found}]
        if new:
            are_several = len(new) > 1
            _log.warning(
                "PhotonCamera(%s) %s nothing, because robot code does not say where %s; add this to %s%s:\n%s",
                *(", ".join(map(repr, new)), *(("see", "they sit") if are_several else ("sees", "it sits"))),
                *(self._file, ", once for each" if are_several else "", _what_to_write("photonvision", new[0])),
            )
        for name in self._built:
            if name in self._described:
                self._require_photon(name)
                continue
            camera = self._photon.get(name)
            if camera is None:
                camera = self._photon[name] = self._add_photon(name, found.get(name))
            mount = found.get(name)
            if mount is not None and self._reported_mounts.get(name) != mount.mount:
                self._mount(name, camera, mount)

    def _require_photon(self, name: str) -> None:
        if self._described[name].maker != "photonvision" and name not in self._reported:
            self._reported.add(name)
            _log.warning(
                "robot code builds PhotonCamera(%r), but %s describes a Limelight of that name; if it runs "
                'PhotonVision, write maker = "photonvision" there',
                *(name, self._file),
            )

    def _add_photon(self, name: str, found: FoundMount | None) -> LimelightSim:
        config = CameraConfig(
            name=name,
            maker="photonvision",
            type=lens_of(self._program, name),
            mount=CameraMount() if found is None else found.mount,
            pipelines=(pipeline_of(self._program, name),),
        )
        camera = self._match.cameras.mount_camera(config, robot=self._number)
        camera.is_off = True  # until the mount is known
        if found is None and name not in self._program.simulated:  # else the program's own simulation feeds the camera
            self._feed(camera)
        return camera

    def _mount(self, name: str, camera: LimelightSim, found: FoundMount) -> None:
        is_first = name not in self._reported_mounts
        self._reported_mounts[name] = found.mount
        camera.move_to(found.mount)
        camera.is_off = False
        if not camera.ports:
            self._feed(camera)
        if is_first:
            lens = camera.config.type
            _log.info(
                "PhotonCamera(%r): %s, as %s says%s; %d x %d px, %.0f degrees across, %.0f frames a second (%s)",
                *(name, _place(found.mount), found.source),
                f" (a guess; if it is wrong, add a [[camera]] to {self._file})" if found.is_guess else "",
                *(lens.width, lens.height, lens.horizontal_fov_deg, camera.config.rate, lens.name),
            )

    def _feed(self, camera: LimelightSim) -> None:
        try:
            from simcore.robotcode.makers.photonvision.photon_port import PhotonCameraPort
        except ImportError as error:
            raise ConfigError(
                f"camera {camera.config.name!r} of {self._file} is a PhotonVision camera, which needs photonlibpy "
                f"(from Python 3.11 on): {install_command('photonvision')}"
            ) from error
        camera.ports.append(PhotonCameraPort(camera.config, self._clock))
        self._program.fed.add(camera.config.name)

    # --- Limelight and QuestNav -----------------------------------------------------------------------------------

    def _follow_tables(self) -> None:
        names = [name for name in self._watch.names if _LIMELIGHT.fullmatch(name)]
        new = [name for name in names if name not in self._described and name not in self._reported]
        if new:
            self._reported.update(new)
            self._unplaced.update(new)
            near = [n for n, c in self._described.items() if c.maker == "limelight"]
            _log.warning(
                "robot code asks for %s %s, which nothing publishes%s; add this to %s%s:\n%s",
                *("Limelights" if len(new) > 1 else "a Limelight", ", ".join(map(repr, new))),
                *(f" (there is {', '.join(map(repr, near))})" if near else "", self._file),
                *(", once for each" if len(new) > 1 else "", _what_to_write("limelight", new[0])),
            )
        if TABLE in self._watch.names and not self._match.cameras.headsets:
            self._add_headset(QuestConfig())

    def _add_headset(self, config: QuestConfig) -> None:
        cameras = self._match.cameras
        port = QuestNavTable(ntcore.NetworkTableInstance.get_default(), self._clock)
        cameras.add_headset(config, robot=self._number, ports=[port])
        if config.mount is not None:
            _log.info("QuestNav: %s, as %s says", _place(config.mount), self._file)

    def _follow_headset(self) -> None:
        if self._headset_reported or not self._match.cameras.headsets:
            return
        headset = self._match.cameras.headsets[0]
        if headset.config.mount is not None:
            self._headset_reported = True
        elif headset.mount is not None:
            self._headset_reported = True
            _log.info("QuestNav: %s, as robot code's first pose reset implies", _place(headset.mount))
        elif headset.resets:
            self._headset_reported = True
            _log.warning(
                "QuestNav: robot code's pose reset is more than a meter off, so it does not tell where the headset "
                "sits; until one does, it is assumed to be at the robot's center; or add this to %s:\n%s",
                *(self._file, _what_to_write("questnav", "")),
            )


def surveyed_cameras(folder: Path) -> list[dict[str, Any]]:
    """Return the maker and, if known, the name, mount and mount source of each camera that the loaded program uses.

    Call `watch_program` before loading the program. The function finds Limelights by table name, and does not find a
    table that the program uses only in loops.

    Args:
        folder: Folder of the project. The function searches the project's modules for table names.
    """
    program, watch = photon_program(), table_watch()
    watch.search(folder)
    placed = mounts(program)
    found: list[dict[str, Any]] = []
    for name in watch.names:
        if _LIMELIGHT.fullmatch(name):
            found.append({"maker": "limelight", "name": name})
    for name in program.cameras:
        mount = placed.get(name)
        camera: dict[str, Any] = {"maker": "photonvision", "name": name}
        if mount is not None:
            m = mount.mount
            camera["place"] = [m.x, m.y, m.z, m.roll_deg, m.pitch_deg, m.yaw_deg]
            camera["source"] = mount.source
        found.append(camera)
    if TABLE in watch.names:
        found.append({"maker": "questnav"})
    return found


def _place(mount: CameraMount) -> str:
    angles = f"pitch {round(mount.pitch_deg)}, yaw {round(mount.yaw_deg)} degrees"  # integers, to avoid "-0"
    roll = f"roll {mount.roll_deg:.0f}, " if abs(mount.roll_deg) >= 0.5 else ""
    return f"x {mount.x:.2f}, y {mount.y:.2f}, z {mount.z:.2f} m, {roll}{angles}"


def _what_to_write(maker: str, name: str) -> str:
    """Return a `[[camera]]` table with example values, to copy into the robot description file."""
    lines = ["[[camera]]"]
    if maker != "limelight":
        lines.append(f'maker = "{maker}"')
    if name:
        lines.append(f'name = "{name}"')
    if maker == "limelight":
        lines.append('type = "LL4"         # LL3, LL3A, LL3G or LL4')
    lines += ["x = 0.30             # ahead of the robot's center", "y = 0.0              # to the left", "z = 0.40"]
    lines += ["pitch_deg = -20.0    # below zero looks up", "yaw_deg = 0.0        # 180 looks back"]
    return "\n".join(lines)
