from pathlib import Path

import numpy as np
import pytest
from each_case import each
from made_up_run import SCENE, recorded, snapshot
from page_reader import PageReader
from wpiutil.log import DataLogReader

from simcore.show import failed_run
from simcore.show.failed_run import safe_name, save_failed_run, write_log
from simcore.telemetry.recording import Recording
from simcore.telemetry.wpilog import WpilogSink


def test_a_failed_run_keeps_a_log_and_a_page_and_prints_their_paths(tmp_path: Path) -> None:
    left = save_failed_run(recorded(), tmp_path / "new", name="test_auto[red/3]", scene=SCENE, note="assert 3 >= 20")
    assert left.problems == ()
    assert {left.log, left.page} == set((tmp_path / "new").iterdir())
    for path in (left.log, left.page):
        assert path is not None and path.stem == "test_auto_red_3" and str(path) in str(left)
    assert left.page is not None and PageReader(left.page).meta["notes"] == ["assert 3 >= 20"]
    assert DataLogReader(str(left.log)).isValid()


def test_the_log_equals_a_log_written_during_the_run(tmp_path: Path) -> None:
    with WpilogSink(tmp_path / "live.wpilog", bulk_period=0.04) as sink:
        for tick in range(100):
            sink.write(snapshot(tick))
    write_log(recorded(100), tmp_path / "after.wpilog")
    assert _records(tmp_path / "after.wpilog") == _records(tmp_path / "live.wpilog")


def _records(path: Path) -> list[tuple[object, ...]]:
    names: dict[int, str] = {}
    found: list[tuple[object, ...]] = []
    for record in DataLogReader(str(path)):
        if record.isStart():
            start = record.getStartData()
            names[start.entry] = start.name
            found.append((start.name, start.type))
        elif not record.isControl():
            raw = record.getRaw()
            name = names[record.getEntry()]
            if name.endswith("Fuel"):  # kept in single precision
                raw = np.frombuffer(raw).round(5).tobytes()
            found.append((name, record.getTimestamp(), bytes(raw)))
    assert len(found) > 300
    return sorted(found, key=repr)


def test_a_run_without_a_scene_is_drawn_on_a_bare_field(tmp_path: Path) -> None:
    left = save_failed_run(recorded(), tmp_path, name="bare")
    assert left.problems == () and left.page is not None


def test_a_run_that_ends_before_the_first_tick_is_reported(tmp_path: Path) -> None:
    left = save_failed_run(Recording(), tmp_path / "new", scene=SCENE)
    assert "no tick was recorded" in str(left)
    assert not (tmp_path / "new").exists()


def test_a_folder_that_cannot_be_written_is_reported_without_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    left = save_failed_run(recorded(3), tmp_path / "file", scene=SCENE)
    assert (left.log, left.page) == (None, None)
    assert len(left.problems) == 2 and str(left).startswith("nothing of the run could be kept; no log: ")


def test_a_failed_write_affects_only_its_own_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(path: Path, *_: object, **__: object) -> None:
        path.touch()  # the file that a full disk leaves behind
        raise RuntimeError("it broke")

    monkeypatch.setattr(failed_run, "write_page", fail)
    left = save_failed_run(recorded(3), tmp_path, name="x", scene=SCENE)
    assert left.page is None and left.log is not None
    assert left.problems == ("no page: it broke",)
    assert not (tmp_path / "x.html").exists()


@each(
    ("name", "safe"),
    [("a/b\\c:d*", "a_b_c_d"), ("", "run"), ("CON", "_CON"), ("lpt1.txt", "_lpt1.txt"), ("x" * 300, "x" * 100)],
)
def test_a_safe_name_is_valid_on_every_file_system(name: str, safe: str) -> None:
    assert safe_name(name) == safe
