"""Side or corner that the name of a motor gives, for names that teams write."""

from each_case import each

from simcore.quantities import DeviceAddress
from simcore.robotcode.program import sides_discovery
from simcore.robotcode.program.makers import Maker
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.sides_discovery import says_place

SIDES = ("left", "right")
CORNERS = ("front left", "front right", "rear left", "rear right")


@each(
    ("name", "side"),
    [
        ("leftMotor1", "left"), ("talonL", "left"), ("L_motor", "left"), ("base.motorL1", "left"), ("l1", "left"),
        ("drive_l1", "left"), ("LDrive", "left"), ("fl_motor", "left"), ("rl_motor", "left"), ("lf", "left"),
        ("right_leader", "right"), ("motorR2", "right"), ("r1", "right"), ("RDrive", "right"), ("frMotor", "right"),
        ("rr_motor", "right"), ("brMotor", "right"), ("drive.rightSpark", "right"),
        ("port_leader", "left"), ("starboardMotor", "right"), ("portal", None),
        ("left.lift", None), ("roller", None), ("flywheel", None), ("climber1", None), ("arm", None), ("", None),
    ],
)  # fmt: skip
def test_the_side_of_a_motor_is_found_in_its_name(name, side):
    assert [place for place in SIDES if says_place(name, place)] == ([side] if side else [])


@each(
    ("name", "corner"),
    [
        ("frontLeft", "front left"), ("fl", "front left"), ("lf_motor", "front left"), ("front_l", "front left"),
        ("FRDrive", "front right"), ("rightFront1", "front right"), ("motorRL", "rear left"), ("bl1", "rear left"),
        ("rear_left", "rear left"), ("back_r", "rear right"), ("rr", "rear right"), ("br_spark", "rear right"),
        ("left", None), ("front", None),
    ],
)  # fmt: skip
def test_the_corner_of_a_motor_is_found_in_its_name(name, corner):
    assert [place for place in CORNERS if says_place(name, place)] == ([corner] if corner else [])


def test_the_attribute_path_gives_the_side_unless_the_motor_name_does(monkeypatch):
    monkeypatch.setattr(sides_discovery, "maker_of", lambda device: Maker())
    motors = [BuiltDevice("SPARK MAX", DeviceAddress(k), object()) for k in range(2)]
    held = {"drive.left.leader": motors[0], "drive.right.leader": motors[1]}
    assert sides_discovery._by_name(held, SIDES) == [[motors[0]], [motors[1]]]
    named = {"right.left_spark": motors[0], "left.right_spark": motors[1]}
    assert sides_discovery._by_name(named, SIDES) == [[motors[0]], [motors[1]]]
