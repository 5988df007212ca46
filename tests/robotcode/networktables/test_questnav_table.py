"""Messages equal, byte for byte, those that Google's protobuf writes from QuestNav's descriptions."""

import math

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.robotcode.networktables.questnav_table import device_message, frame_message, read_command, response_message
from simcore.vision.quest_headset import QuestFrame

# Made by the classes in robotpy-questnav 2026.0.1a0 with protobuf 6.33; tests/adapters/test_questnav.py makes them
# again.
FRAME = (
    "08ac0211000000000000f83f1a450a1b0900000000000004401100000000000011c019000000000000e03f12260a2409000000000000e03f"
    "11000000000000e03f19000000000000e0bf21000000000000e03f2001"
)
RESET = "08011007522c0a2a0a1209000000000000084011000000000000f83f12140a1209333333333333e33f219a9999999999e93f"


def test_a_frame_is_encoded_in_the_bytes_that_questnav_sends():
    frame = QuestFrame(300, 1.5, (2.5, -4.25, 0.5), (0.5, -0.5, 0.5, 0.5))  # x, y, z, w
    assert frame_message(frame).hex() == FRAME


def test_the_device_state_is_encoded_in_the_bytes_that_questnav_sends():
    """Newer headsets omit field 2, `currently_tracking`; older and newer libraries accept it."""
    assert device_message(87, lost=2).hex() == "0802" + "1001" + "1857"


def test_a_response_is_encoded_in_the_bytes_that_questnav_sends():
    assert response_message(7).hex() == "08071001"
    assert response_message(7, "no").hex() == "0807" + "1000" + "1a026e6f"


def test_a_pose_reset_is_read():
    command = read_command(bytes.fromhex(RESET))
    assert command.number == 7 and command.problem == ""
    assert command.reset is not None
    assert command.reset.position == (3.0, 1.5, 0.0)
    assert command.reset.attitude == pytest.approx((0.0, 0.0, 0.8, 0.6))


@each(
    ("data", "problem"),
    [
        ("08051007", "unknown command type 5"),
        ("08011007", "no pose in the command"),
        ("080110075204" + "0a020a00", "has no attitude"),
    ],
)
def test_an_invalid_command_is_answered_with_the_reason(data, problem):
    command = read_command(bytes.fromhex(data))
    assert command.reset is None and command.number == 7
    assert problem in command.problem


@each("data", [b"\xff\xff", b"\x52\x7f", b"\x0b", b"\x08" + b"\x80" * 12])
def test_an_invalid_headset_message_is_refused(data):
    with pytest.raises(ConfigError, match="QuestNav message"):
        read_command(data)


def test_a_large_frame_number_is_encoded_as_a_varint():
    frame = QuestFrame(2**31 - 1, math.pi, (0.0, -1e9, 1e-9), (0.0, 0.0, 0.0, 1.0))
    assert frame_message(frame).startswith(b"\x08\xff\xff\xff\xff\x07")
