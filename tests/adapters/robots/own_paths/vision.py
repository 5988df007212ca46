from collections.abc import Iterator

from photonlibpy import PhotonCamera, PhotonPoseEstimator
from photonlibpy.simulation import PhotonCameraSim, SimCameraProperties, VisionSystemSim
from robotpy_apriltag import AprilTagField, AprilTagFieldLayout
from wpilib import RobotBase
from wpimath.geometry import Pose2d, Rotation2d, Rotation3d, Transform3d, Translation3d

LAYOUT = AprilTagFieldLayout.loadField(AprilTagField.k2026RebuiltWelded)
CAMERAS = {
    "front": Transform3d(Translation3d(0.28, 0.0, 0.35), Rotation3d.fromDegrees(0, -20, 0)),
    "rear": Transform3d(Translation3d(-0.28, 0.0, 0.35), Rotation3d.fromDegrees(0, -20, 180)),
}


class Vision:
    def __init__(self) -> None:
        self.cameras = {name: PhotonCamera(name) for name in CAMERAS}
        self.estimators = {name: PhotonPoseEstimator(LAYOUT, place) for name, place in CAMERAS.items()}
        self.estimates = 0
        if RobotBase.isSimulation():
            self.world = VisionSystemSim("main")
            self.world.addAprilTags(LAYOUT)
            for name, camera in self.cameras.items():
                properties = SimCameraProperties()
                properties.setCalibrationFromFOV(960, 720, Rotation2d.fromDegrees(90))
                properties.setFPS(30)
                properties.setAvgLatency(0.03)
                self.world.addCamera(PhotonCameraSim(camera, properties), CAMERAS[name])

    def simulate(self, believed: Pose2d) -> None:
        self.world.update(believed)

    def measurements(self) -> Iterator[tuple[Pose2d, float, tuple[float, float, float]]]:
        for name, camera in self.cameras.items():
            estimator = self.estimators[name]
            for result in camera.getAllUnreadResults():
                estimate = estimator.estimateCoprocMultiTagPose(result) or estimator.estimateLowestAmbiguityPose(result)
                if estimate is None:
                    continue
                targets = result.getTargets()
                far = sum(t.getBestCameraToTarget().translation().norm() for t in targets) / len(targets)
                if len(targets) == 1 and (targets[0].getPoseAmbiguity() > 0.2 or far > 4.0):
                    continue
                spread = 0.1 * (1.0 + far**2 / 10.0) / len(targets)
                self.estimates += 1
                yield estimate.estimatedPose.toPose2d(), estimate.timestampSeconds, (spread, spread, 0.3)
