"""Which tables of NetworkTables a program asks for, however it does; in a process of its own, as ntcore is wrapped."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import simcore

pytest.importorskip("ntcore", reason="pyntcore is not installed")
pytest.importorskip("pyfrc", reason="needs the extra 'robotpy'")

PACKAGES = Path(simcore.__file__).resolve().parents[1]

PROGRAM = """
import json, sys
from pathlib import Path
import ntcore
import early
from simcore.robotpy.table_watch import table_watch

watch = table_watch()
watch.search(Path(sys.argv[1]))
inst = ntcore.NetworkTableInstance.getDefault()
inst.getTable("limelight-a").getEntry("tx").getDouble(0.0)
inst.getTable(key="/limelight-b")
inst.getDoubleTopic("/limelight-c/tx").subscribe(0.0)
inst.getEntry("limelight-d/tx")
inst.getStructTopic("/limelight-e/pose", early.Pose2d)
inst.getTopics()
assert table_watch() is watch
print(json.dumps(list(watch.names)))
"""

EARLY = """
import ntcore
from wpimath.geometry import Pose2d
TABLE = ntcore.NetworkTableInstance.getDefault().getTable("limelight-top")
class Vision:
    tx = ntcore.NetworkTableInstance.getDefault().getDoubleTopic("/limelight-class/tx").subscribe(0.0)
"""


def test_every_way_of_asking_is_noted(tmp_path):
    (tmp_path / "early.py").write_text(EARLY)
    (tmp_path / "program.py").write_text(PROGRAM)
    done = subprocess.run(
        [sys.executable, "program.py", str(tmp_path)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(PACKAGES)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    names = json.loads(done.stdout.splitlines()[-1])
    assert names == [f"limelight-{k}" for k in ("top", "class", "a", "b", "c", "d", "e")]
