"""TimedRobot that localizes with PhotonVision and starts with an estimate 3 m off.

In simulation it feeds its odometry to a VisionSystemSim, as photonlib's example does, which would confirm any estimate.
Of its cameras, one is in that simulation, one is placed by its estimator only, one by simcore.toml only, and one
nowhere.
"""

import math

import measures
import wpilib
from phoenix6 import utils
from photonlibpy import PhotonCamera, PhotonPoseEstimator
from robotpy_apriltag import AprilTagField, AprilTagFieldLayout
from wpimath.geometry import Pose2d, Rotation3d, Transform3d

LAYOUT = AprilTagFieldLayout.loadField(AprilTagField.k2026RebuiltWelded)
FRONT = Transform3d(0.25, 0.1, 0.4, Rotation3d(0.0, math.radians(-15.0), 0.0))
REAR = Transform3d(-0.25, -0.1, 0.5, Rotation3d(0.0, math.radians(-10.0), math.pi))


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.drivetrain.reset_pose(Pose2d(5.3, 4.2, 0.0))
        self.cameras = {"front": PhotonCamera("front")}
        self.estimators = {"front": PhotonPoseEstimator(LAYOUT, FRONT)}
        self.cameras["rear"] = PhotonCamera("rear")
        self.estimators["rear"] = PhotonPoseEstimator(LAYOUT, REAR)
        self.pieces = PhotonCamera("pieces")
        self.unknown = PhotonCamera("unknown")
        self.used = {"front": 0, "rear": 0}
        self.latencies: list[float] = []
        self.connected: list[bool] = []
        if self.isSimulation():
            from photonlibpy.simulation import PhotonCameraSim, SimCameraProperties, VisionSystemSim

            self.vision_sim = VisionSystemSim("main")
            self.vision_sim.addAprilTags(LAYOUT)
            properties = SimCameraProperties.OV9281_1280_720()
            properties.setFPS(40)
            self.vision_sim.addCamera(PhotonCameraSim(self.cameras["front"], properties), FRONT)

    def robotPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
        if self.isSimulation():
            self.vision_sim.update(self.drivetrain.get_state().pose)
        for name, camera in self.cameras.items():
            for result in camera.getAllUnreadResults():
                estimator = self.estimators[name]
                found = estimator.estimateCoprocMultiTagPose(result) or estimator.estimateLowestAmbiguityPose(result)
                if found is None:
                    continue
                self.used[name] += 1
                self.latencies.append(wpilib.Timer.getFPGATimestamp() - found.timestampSeconds)
                at = utils.fpga_to_current_time(found.timestampSeconds)
                self.drivetrain.add_vision_measurement(found.estimatedPose.toPose2d(), at, (0.3, 0.3, 0.5))
        self.connected.append(all(c.isConnected() for c in (*self.cameras.values(), self.pieces, self.unknown)))
