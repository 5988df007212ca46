"""NetworkTables that a program accesses, by any kind of access; in a separate process, as ntcore is wrapped."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("ntcore", reason="pyntcore is not installed")
pytest.importorskip("pyfrc", reason="needs the extra 'robotpy'")

PROGRAM = """
import json, sys
from pathlib import Path
import ntcore
import early
from simcore.robotcode.sim.table_watch import table_watch

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


def test_every_kind_of_table_access_is_recorded(tmp_path, python):
    (tmp_path / "early.py").write_text(EARLY)
    (tmp_path / "program.py").write_text(PROGRAM)
    code, said = python(tmp_path, "program.py", str(tmp_path))
    assert code == 0, said
    names = json.loads(said.splitlines()[-1])
    assert names == [f"limelight-{k}" for k in ("top", "class", "a", "b", "c", "d", "e")]
