"""Script that takes pictures of pages for the docs."""

from __future__ import annotations

import struct

import pytest
import take_picture
from made_up_run import SCENE, recorded

from simcore.show.page import write_page


def test_a_computer_without_a_browser_is_reported_in_a_single_sentence(monkeypatch, tmp_path) -> None:
    monkeypatch.setattr(take_picture.shutil, "which", lambda name: None)
    with pytest.raises(SystemExit, match="no Chromium or Chrome on this computer's path: looked for chromium, "):
        take_picture.main([str(tmp_path / "page.png")])
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_picture_has_the_requested_size(browser, tmp_path) -> None:
    write_page(tmp_path / "run.html", recorded(), SCENE)
    picture = tmp_path / "page.png"
    assert (
        take_picture.main([str(picture), "--page", str(tmp_path / "run.html"), "--at", "0.5", "--size", "900x600"]) == 0
    )
    content = picture.read_bytes()
    assert content.startswith(b"\x89PNG") and struct.unpack(">II", content[16:24]) == (900, 600)
    assert len(content) > 20_000, "the field is drawn"
