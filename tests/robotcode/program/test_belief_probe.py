"""Values that swerve modules report after their sensors move: at once, after an update, or never."""

import math
from types import SimpleNamespace

import pytest

from simcore.robotcode.program.belief_probe import ModulePorts, probe_modules

Rotation2d = pytest.importorskip("wpimath.geometry").Rotation2d
SwerveModulePosition = pytest.importorskip("wpimath.kinematics").SwerveModulePosition

WAY, OFFSET = 0.05, -2.5  # [m] a turn of the rotor, and [rad]; a quarter turn on, the angle has passed half a turn


class Port:
    """Motor or encoder, as the program reads it."""

    def __init__(self) -> None:
        self.position = 0.0

    def write(self, position: float, velocity: float) -> None:
        self.position = position


class Live:
    def __init__(self) -> None:
        self.ports = ModulePorts(drive=Port(), steer=Port(), encoder=Port(), wheel=None)
        self.updates = 0

    def sensed(self) -> SwerveModulePosition:
        angle = Rotation2d(math.remainder(OFFSET - self.ports.encoder.position, math.tau))
        return SwerveModulePosition(-WAY * self.ports.drive.position, angle)

    def get_position(self) -> SwerveModulePosition:
        return self.sensed()

    def update(self) -> None:
        self.updates += 1


class Kept(Live):
    """Module that returns what its last update read, as with loggers and input layers."""

    def __init__(self) -> None:
        super().__init__()
        self.last = SwerveModulePosition()

    def get_position(self) -> SwerveModulePosition:
        return self.last

    def update(self) -> None:
        super().update()
        self.last = self.sensed()


class Deaf(Kept):
    def update(self, period: float = 0.02) -> None:
        raise RuntimeError("no robot")


def probed(*modules):
    return probe_modules([[SimpleNamespace(), m] for m in modules], [m.ports for m in modules], lambda: None)


@pytest.mark.parametrize("kind", [Live, Kept])
def test_the_probe_measures_modules_that_read_sensors_directly_or_in_an_update(kind):
    modules = [kind(), kind()]
    for belief in probed(*modules):
        assert belief.zero == pytest.approx(OFFSET)
        assert belief.meters_per_rotor_turn == pytest.approx(-WAY)
        assert belief.angle_per_encoder_turn == pytest.approx(-math.tau)
        assert not belief.is_deaf
    assert all(m.get_position().distance == 0.0 for m in modules)  # the module starts where its sensors are
    assert modules[0].updates == 0 or kind is Kept  # nothing is called without need


def test_a_module_whose_update_fails_is_found_deaf_and_one_without_a_position_is_not():
    assert all(belief.is_deaf for belief in probed(Deaf()))
    silent = SimpleNamespace(ports=Live().ports)
    assert not any(belief.is_deaf for belief in probed(silent))
