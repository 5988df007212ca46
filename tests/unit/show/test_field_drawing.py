"""What is seen of a field: all that stands at its edge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from made_up_run import SCENE, recorded

from simcore.show.field_drawing import FieldDrawing
from simcore.show.run_track import RunTrack


def test_what_stands_across_the_edge_is_seen_to_its_end_and_far_away_things_do_not_shrink_the_field() -> None:
    length, width = SCENE.field_size
    station = np.array([(-0.7, width - 1.0), (1.0, width + 0.6), (0.0, width + 1.0)])
    far = np.array([(length, 0.0), (length + 30.0, 0.0), (length, -30.0)])
    outlines = (*SCENE.field_outlines, ("blue_station", station), ("red_far", far))
    drawing = FieldDrawing(RunTrack(recorded(), replace(SCENE, field_outlines=outlines)), [])
    left, top, across, down = drawing.box
    x, y = drawing.points(station).T
    assert left <= x.min() and top <= y.min()
    assert left + across == 100.0 * length + 150.0 and top + down == 100.0 * width + 150.0
