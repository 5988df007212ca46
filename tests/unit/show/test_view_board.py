"""The board of the page."""

from __future__ import annotations

import numpy as np
from simcore.show.view_board import board_html, clock_text, lights_html

from simcore.telemetry.snapshot import Snapshot


def test_clock() -> None:
    assert [clock_text(t) for t in (0.0, 9.96, 59.94, 59.96, 160.0, -1.0)] == [
        "0:00.0", "0:10.0", "0:59.9", "1:00.0", "2:40.0", "0:00.0",
    ]  # fmt: skip


def test_board_says_score_clock_pieces_and_robots() -> None:
    snapshot = Snapshot(
        time=12.3,
        tick=614,
        pose_arrays={"Sim/GamePieces/Fuel": np.zeros((448, 7))},
        doubles={"Sim/Match/TimeLeft": 147.7, "Sim/Debug/BatteryVoltage": 11.27},
        strings={"Sim/Match/Period": "shift 1", "Sim/Match/Game": "rebuilt", "Sim/Match/Tower1": "None"},
        booleans={"Sim/Match/RedHubActive": False, "Sim/Match/BlueHubActive": True, "Sim/Match/Enabled": True},
        integers={"Sim/Score/Blue": 24, "Sim/Score/Red": 3, "Sim/Shots": 9, "Sim/Hits": 8, "Sim/Intake/HeldCount": 5},
    )
    board = board_html(snapshot, {0: "Sim", 1: "Sim/Robots/1"})
    for text in ("BLUE</small> 24<", "RED</small> 3<", "0:12.3", "2:27.7 left, period: shift 1",
                 "fuel on the field <b>448</b>", "hits <b>8</b>",
                 "robot 0: holds <b>5</b>, battery <b>11.3 V</b>",
                 'data-period="shift 1" data-enabled="True" data-time="12.3" data-left="147.7"'):  # fmt: skip
        assert text in board
    assert "robot 1" not in board, "nothing is known of it"
    assert "\u2714 blue hub active" in board and "\u2718 red hub active: no" in board, "told apart without color"
    assert "None" not in board and "rebuilt" not in board and "disabled" not in board


def test_an_empty_snapshot_has_a_board_too() -> None:
    assert "0:00.0" in board_html(Snapshot(time=0.0, tick=0), {})


def test_lights_are_squares_of_their_colors_and_a_long_strip_is_thinned_out() -> None:
    assert lights_html([0x00FF00, 0x00FF00, 0, -1]) == (
        '<span style="color:#00ff00">\u25a0\u25a0</span><span style="color:#000000">\u25a0</span>\u25a8'
    )
    assert lights_html([0xFF] * 30 + [0xFF0000] * 30).count("\u25a0") == 20
    lit = {"Sim/Lights/CANdle9/Colors": np.array([0xFF8000]), "Sim/Robots/1/Lights/CANdle9/Colors": np.array([0xFF])}
    board = board_html(Snapshot(time=0.0, tick=0, integer_arrays=lit), {0: "Sim"})
    assert 'CANdle9 <span style="color:#ff8000">' in board and "#0000ff" not in board
