"""Both 2025 AprilTag layouts on the field: tags face outward where the dimensions put them, and cameras see them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.human_players import station_faces
from games.reefscape.robot import reefscape_robot
from simcore import Match, RobotEntry
from simcore.match.camera_rig import tag_layout
from simcore.vision.camera import CameraConfig, CameraMount, limelight_type
from simcore.world.symmetry import FieldSymmetry

BLUE_REEF = dict(zip((18, 19, 20, 21, 22, 17), dim.REEF_FACE_YAWS_DEG, strict=True))
RED = {1: 13, 2: 12, 3: 16, 4: 15, 5: 14, 6: 19, 7: 18, 8: 17, 9: 22, 10: 21, 11: 20}
"""Blue tag that corresponds to each red tag."""


def direction(yaw: float) -> tuple[float, float, float]:
    return math.cos(yaw), math.sin(yaw), 0.0


@pytest.mark.parametrize(("name", "off"), [("2025-welded", 0.004), ("2025-andymark", 0.074)])
def test_tags_face_outward_on_the_reef_the_stations_and_the_processor(name, off):
    """The field follows the welded layout to 4 mm; on AndyMark fields processors are 7 cm and stations 3 cm off."""
    layout = tag_layout(name, REEFSCAPE.field.size)
    assert layout.id_list == list(range(1, 23)) and layout.field_size == pytest.approx(REEFSCAPE.field.size, abs=0.011)
    wanted = {}
    for number, yaw_deg in BLUE_REEF.items():
        out = direction(math.radians(yaw_deg))
        wanted[number] = (np.array((*dim.REEF_CENTER, 0.0)) + dim.REEF_APOTHEM * np.array(out), out)
    for number, (x, y, yaw) in zip((12, 13), station_faces("blue").values(), strict=True):
        wanted[number] = (np.array((x, y, 0.0)), direction(yaw))
    wanted[16] = (np.array((dim.PROCESSOR_X, 0.0, 0.0)), direction(math.pi / 2))
    worst = 0.0
    for number, (place, out) in wanted.items():
        row = layout.id_list.index(number)
        assert layout.normals[row] == pytest.approx(out, abs=1e-4), number
        worst = max(worst, float(np.abs(layout.centers[row, :2] - place[:2]).max()))
    assert 0.3 * off < worst < off
    symmetry = FieldSymmetry("rotate", layout.field_size)
    for red, blue in RED.items():
        rows = [layout.id_list.index(number) for number in (red, blue)]
        assert symmetry.flip_points(layout.centers[rows[1:]])[0] == pytest.approx(layout.centers[rows[0]], abs=0.013)
        assert symmetry.flip_vectors(layout.normals[rows[1:]])[0] == pytest.approx(layout.normals[rows[0]], abs=1e-3)


def test_a_match_uses_the_welded_tag_layout_unless_another_layout_is_named():
    """The camera is between the alliance wall and the blue reef, which hides the tags on the far side."""
    assert REEFSCAPE.field.tags == "2025-welded"
    eye = CameraConfig(name="eye", type=limelight_type("LL4"), mount=CameraMount(x=0.2, z=0.4))
    entry = RobotEntry(start=(2.2, 4.0, 0.0), config=replace(reefscape_robot(), cameras=(eye,)), preload=0)
    for tags, shift in ((None, 0.0), ("2025-andymark", -0.0051)):
        with Match(REEFSCAPE, robots=[entry], tags=tags) as match:
            match.play(0.12)
            assert match.cameras.layout.centers[17, 1] == pytest.approx(4.0259 + shift, abs=2e-4)
            frame = match.cameras.camera("eye").last
            seen = {tag.id for tag in frame.tags}
            assert 18 in seen and not seen & {20, 21, 22}
