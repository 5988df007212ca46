"""A camera's table as PhotonVision's coprocessor keeps it, on the default NetworkTables instance."""

from __future__ import annotations

import logging
from typing import Any

import ntcore
from photonlibpy.networktables.NTTopicSet import NTTopicSet
from photonlibpy.targeting import PhotonPipelineResult
from wpimath.geometry import Transform3d

from simcore.photonvision.photon_results import pipeline_result
from simcore.vision.camera import CameraConfig
from simcore.vision.camera_frame import Frame
from simcore.vision.camera_manager import NetworkClock
from simcore.vision.limelight import CameraRequest

__all__ = ["PhotonCameraPort"]

_log = logging.getLogger(__name__)

_ROOT = "photonvision"


class PhotonCameraPort:
    """Publishes a camera to every `PhotonCamera` of its name, and listens to what they ask for.

    Append one to the `ports` of a `LimelightSim`. A frame costs about a millisecond, most of it photonlib's packing.
    Pipelines, driver mode and the limit of frames take effect; lights are only told; no pictures are saved.

    Args:
        config: The camera.
        clock: From simulated time to NetworkTables' time.
    """

    def __init__(self, config: CameraConfig, clock: NetworkClock) -> None:
        self._config = config
        self._clock = clock
        root = ntcore.NetworkTableInstance.getDefault().getTable(_ROOT)
        table = root.getSubTable(config.name)
        self._topics: Any = NTTopicSet(table)
        self._topics.updateEntries()  # publishes with the id of the messages, which a PhotonCamera checks
        self._version = root.getStringTopic("version").publish()
        self._version.set(_photonvision_version())
        # One poller for what is rarely written, as asking each subscriber would take longer.
        self._poller = ntcore.NetworkTableListenerPoller(root.getInstance())
        self._lights_request = root.getIntegerTopic("ledModeRequest").subscribe(-1)
        self._lights = root.getIntegerTopic("ledModeState").publish()
        self._pictures = [table.getIntegerTopic(f"{kind}SaveImgCmd").subscribe(0) for kind in ("input", "output")]
        now = ntcore.EventFlags.kValueAll | ntcore.EventFlags.kImmediate
        self._listeners = {
            self._poller.addListener(subscriber, now): name
            for name, subscriber in (
                ("pipeline", self._topics.pipelineIndexRequestSub),
                ("driver", self._topics.driverModeSubscriber),
                ("limit", self._topics.fpsLimitSubscriber),
                ("lights", self._lights_request),
                *(("picture", subscriber) for subscriber in self._pictures),
            )
        }
        self._drives = False
        self._shortest = 0.0  # [s]; between two frames
        self._last = float("-inf")
        self._has_warned = False
        (fx, fy), (cx, cy) = config.type.focal_length, config.type.principal_point
        first = clock.to_network(0.0)  # older than any frame: ntcore drops what is older than the value that is there
        self._topics.cameraIntrinsicsPublisher.set([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0], first)
        self._topics.cameraDistortionPublisher.set([0.0] * 8, first)
        self._topics.pipelineIndexPublisher.set(0, first)
        self._topics.driverModePublisher.set(False, first)
        self._topics.fpsLimitPublisher.set(-1, first)
        self._topics.heartbeatPublisher.set(0, first)

    def read(self) -> list[CameraRequest]:
        """Pipelines that robot code asks for."""
        requests: list[CameraRequest] = []
        for event in self._poller.readQueue():
            name, value = self._listeners[event.listener], event.data.value.value()
            if name == "pipeline":
                requests.append(CameraRequest("pipeline", (float(value),)))
            elif name == "driver":
                self._drives = bool(value)
                self._topics.driverModePublisher.set(self._drives)
            elif name == "limit":
                self._shortest = 1.0 / value if value > 0 else 0.0
                self._topics.fpsLimitPublisher.set(value)
            elif name == "lights":
                self._lights.set(value)
            elif value and not self._has_warned:
                self._has_warned = True
                _log.warning("%s: there is no picture to save", self._config.name)
        return requests

    def publish(self, frame: Frame) -> None:
        """Send a frame; in driver mode one without targets."""
        if frame.time - self._last < self._shortest - 1e-9:
            return
        self._last = frame.time
        stamp = self._clock.to_network(frame.published)
        result = pipeline_result(frame, stamp)
        if self._drives:
            result.targets, result.multitagResult = [], None
        topics = self._topics
        topics.rawBytesEntry.set(PhotonPipelineResult.photonStruct.pack(result).getData(), stamp)
        topics.latencyMillisEntry.set(result.getLatencyMillis(), stamp)
        best = result.getBestTarget()
        topics.hasTargetEntry.set(best is not None, stamp)
        topics.targetPitchEntry.set(0.0 if best is None else best.getPitch(), stamp)
        topics.targetYawEntry.set(0.0 if best is None else best.getYaw(), stamp)
        topics.targetAreaEntry.set(0.0 if best is None else best.getArea(), stamp)
        topics.targetSkewEntry.set(0.0 if best is None else best.getSkew(), stamp)
        topics.targetPoseEntry.set(Transform3d() if best is None else best.getBestCameraToTarget(), stamp)
        topics.pipelineIndexPublisher.set(frame.pipeline, stamp)
        topics.heartbeatPublisher.set(frame.number, stamp)

    def close(self) -> None:
        """Withdraw what is published; may be called twice."""
        self._poller.close()
        for name, publisher in vars(self._topics).items():
            if name.endswith(("Publisher", "Entry")) or name.startswith("bestTarget"):
                publisher.close()
        self._lights.close()
        self._version.close()


def _photonvision_version() -> str:
    from photonlibpy import version

    return str(getattr(version, "PHOTONVISION_VERSION", version.PHOTONLIB_VERSION))
