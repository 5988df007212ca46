"""A real browser for the tests in this folder."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[object]:
    """Return a function that opens an address in a new Chromium; close all of them after the test."""
    spec = importlib.util.spec_from_file_location("chromium", Path(__file__).with_name("chromium.py"))
    assert spec is not None and spec.loader is not None
    chromium = importlib.util.module_from_spec(spec)
    sys.modules["chromium"] = chromium
    spec.loader.exec_module(chromium)
    if chromium.find_chromium() is None:
        pytest.skip("no Chromium or Chrome on this computer")
    pytest.importorskip("websockets", reason='needs websockets: pip install -e ".[view]"')
    pages = []

    def visit(url: str):
        pages.append(chromium.Chromium(url, tmp_path / f"profile{len(pages)}"))
        return pages[-1]

    yield visit
    for page in pages:
        page.close()
