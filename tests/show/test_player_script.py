"""The player's script without a browser: its reader and its other pure functions, run by node."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from made_up_run import SCENE, recorded

from simcore.show.frames import FrameLayout, piece_kinds
from simcore.show.page import packed
from simcore.show.run_data import run_data

TESTS = Path(__file__).with_name("player") / "player.test.mjs"


def test_the_page_reader_and_pure_functions_pass_the_node_tests(tmp_path: Path) -> None:
    node = shutil.which("node")
    version = "" if node is None else subprocess.run([node, "--version"], capture_output=True, text=True).stdout
    if tuple(map(int, re.findall(r"\d+", version)[:2])) < (20, 19):
        pytest.skip(f"needs node 20.19 or newer, got {version.strip() or 'none'}")
    recording = recorded()
    meta, data = run_data(recording, SCENE)
    layout = FrameLayout(SCENE, (), piece_kinds(recording, SCENE))
    expected = []
    for snapshot in recording.snapshots():
        pieces = layout.frame(snapshot)["pieces"].reshape(-1, 4) / (1e3, 1e3, 1e3, 1.0)
        true, believed = snapshot.poses["Sim/Robot/Pose3d"], snapshot.poses["Sim/Robot/EstimatedPose"]
        yaw, turned = (2.0 * np.arctan2(row[6], row[3]) for row in (true, believed))
        expected.append(
            {
                "time": snapshot.time,
                "robot": [*true[:3].tolist(), float(yaw)],
                "belief": [*believed[:2].tolist(), float(turned)],
                "pieces": pieces.tolist(),
            }
        )
    text = json.dumps(meta, allow_nan=False).encode()
    content = {"run": packed(text), "data": packed(data), "expected": expected[::2]}  # pieces have every 2nd frame
    run = tmp_path / "run.json"
    run.write_text(json.dumps(content))
    done = subprocess.run(
        [str(node), "--test", str(TESTS)], env={**os.environ, "SIMCORE_RUN": str(run)}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
