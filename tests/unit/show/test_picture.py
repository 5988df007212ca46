from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_run import SCENE, recorded
from PIL import Image

from simcore.errors import OutputError
from simcore.show.palette import COLORS, rgb
from simcore.show.picture import draw_summary
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import require_writable


def count(image: Any, color: str) -> int:
    pixels = np.asarray(image.convert("RGB"), dtype=int)
    return int((np.abs(pixels - rgb(color)).max(axis=2) < 6).sum())


def test_picture_shows_pieces_hits_misses_and_what_was_believed(tmp_path: Path) -> None:
    draw_summary(tmp_path / "new" / "all.png", recorded(), SCENE, title="a <$1> title", subtitle="and more")
    draw_summary(tmp_path / "none.png", Recording(), SCENE)
    with Image.open(tmp_path / "new" / "all.png") as full, Image.open(tmp_path / "none.png") as bare:
        assert full.width == bare.width == 1600
        for color in ("#ffd923", *(COLORS[name][0] for name in ("hit", "miss", "ghost", "path"))):
            assert count(full, color) > count(bare, color) + 20, color


def test_the_same_drawing_as_svg_and_pdf(tmp_path: Path) -> None:
    for suffix in ("svg", "pdf"):
        draw_summary(tmp_path / f"run.{suffix}", recorded(3), SCENE, title="A & B")
    text = (tmp_path / "run.svg").read_text(encoding="utf-8")
    assert text.startswith("<svg ") and "A &amp; B" in text and "var(" not in text
    assert (tmp_path / "run.pdf").read_bytes().startswith(b"%PDF")


def test_letters_are_the_same_whatever_fonts_a_system_has(monkeypatch: pytest.MonkeyPatch) -> None:
    from simcore.show.raster import rasterized
    from simcore.show.svg import document, words

    drawing = document((0, 0, 200, 40), words(5, 30, "Ag 12.5 m/s", 24, ink="#000000", bold=True))
    with Image.open(io.BytesIO(rasterized(drawing, 200))) as image:
        assert 300 < np.count_nonzero(np.asarray(image)[..., 3] > 200) < 2500, "bold letters, not boxes and not nothing"


def test_unwritable(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write the picture"):
        draw_summary(tmp_path / "file" / "x.png", Recording(), SCENE)
    with pytest.raises(OutputError, match=r"pictures end in \.pdf, \.png, \.svg"):
        draw_summary(tmp_path / "x.gif", Recording(), SCENE)


def test_check_before_the_run_leaves_nothing_and_keeps_what_is_there(tmp_path: Path) -> None:
    require_writable("picture", tmp_path / "out" / "new.png")
    assert list((tmp_path / "out").iterdir()) == []
    (tmp_path / "old.png").write_text("old")
    require_writable("picture", tmp_path / "old.png")
    assert (tmp_path / "old.png").read_text() == "old"


def test_import_loads_no_drawing_library_and_logs_need_no_ntcore() -> None:
    code = (
        "import sys, simcore.show.picture, simcore.telemetry.wpilog, simcore.telemetry.sinks\n"
        "import simcore.show.failed_run, simcore.show.animation\n"
        "assert not {'PIL', 'resvg_py', 'ntcore', 'wpiutil'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
