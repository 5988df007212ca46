"""Built files of the extension: made from this source, small, and independent of WPILib's libraries."""

from __future__ import annotations

import json

import pytest
from build_bridge import digest

from simcore.bridge.built_extension import BUILT, SOURCE, TARGETS

HASHES = json.loads((BUILT / "hashes.json").read_text())
NAMES = [name for _, name in TARGETS.values()]


def test_the_built_files_come_from_the_current_source():
    """`python scripts/build_bridge.py` rebuilds them."""
    assert HASHES[SOURCE.name] == digest(SOURCE)
    assert {name: HASHES[name] for name in NAMES} == {name: digest(BUILT / name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_a_built_file_is_small_and_links_no_wpilib_library(name):
    content = (BUILT / name).read_bytes()
    assert len(content) < 100_000
    assert content.startswith((b"\x7fELF", b"MZ", b"\xcf\xfa\xed\xfe"))
    for library in (b"libwpiHal", b"libntcore", b"libwpiutil", b"libwpilibc"):
        assert library not in content
    assert b"HALSIM_InitExtension" in content
