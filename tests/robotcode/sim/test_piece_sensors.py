"""Times at which a sensor detects the pieces that a robot holds."""

from types import SimpleNamespace

import pytest

pytest.importorskip("wpilib", reason="needs the extra 'robotpy'")

from simcore.robot.storage import Storage, StorageConfig
from simcore.robot_file.sensor_tables import PieceView
from simcore.robotcode.sim.piece_sensors import PieceSensor
from simcore.units import TICK


class Robot:
    """Robot with the parts that a sensor reads: a storage and a claw."""

    def __init__(self, *pieces: int) -> None:
        self.storage = Storage(StorageConfig(capacity=9))
        self.storage.add(list(pieces))
        self.claw = SimpleNamespace(piece=None)
        self.placers = [self.claw]

    @property
    def held(self) -> list[int]:
        return self.storage.pieces + [p.piece for p in self.placers if p.piece is not None]


def kind_of(slot: int) -> str:
    return "Cube" if slot < 10 else "Cone"


def eye(robot: Robot, place: str = "storage", **view) -> PieceSensor:
    return PieceSensor(PieceView(place=place, **view), robot, kind_of)


def ticks_seen(sensor: PieceSensor, ticks: int) -> list[bool]:
    return [sensor.look() for _ in range(ticks)]


def test_the_pieces_in_a_storage_are_counted_by_kind():
    robot = Robot(1, 11)
    two, cubes = eye(robot, at_least=2), eye(robot, at_least=2, kinds=("Cube",))
    assert two.look() and not cubes.look()
    robot.storage.add([2])
    assert two.look() and cubes.look()
    robot.storage.take()
    assert two.look() and not cubes.look()


def test_a_piece_reaches_its_sensor_after_a_delay_unless_it_was_preloaded():
    assert eye(Robot(1), delay=0.1).look()
    robot = Robot()
    sensor = eye(robot, delay=0.1)
    assert not sensor.look()
    robot.storage.add([1])
    assert ticks_seen(sensor, 7) == [False] * 5 + [True] * 2  # the tick in which it enters, then five ticks of 20 ms
    robot.storage.take()
    assert not sensor.look()
    robot.storage.add([1])
    assert not sensor.look()  # the same piece enters again


@pytest.mark.parametrize("place", ["intake", "shooter"])
def test_a_sensor_detects_a_piece_only_while_the_piece_passes(place):
    robot = Robot(1)
    sensor = eye(robot, place, passing_time=3 * TICK)
    assert ticks_seen(sensor, 2) == [False, False]
    robot.storage.add([2])
    seen_in = ticks_seen(sensor, 5)
    robot.storage.take()
    seen_out = ticks_seen(sensor, 5)
    passing, not_passing = [True] * 3 + [False] * 2, [False] * 5
    assert (seen_in, seen_out) == ((passing, not_passing) if place == "intake" else (not_passing, passing))


def test_a_piece_that_moves_into_the_claw_triggers_only_the_claw_sensor():
    robot = Robot(1)
    claw, shooter = eye(robot, "claw"), eye(robot, "shooter")
    assert not claw.look() and not shooter.look()
    robot.claw.piece = robot.storage.take()
    assert claw.look() and not shooter.look()
    robot.claw.piece = None
    assert not claw.look() and shooter.look()
