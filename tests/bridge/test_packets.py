"""Frames of the bridge: packed records are read back, and frames of another version are refused."""

from __future__ import annotations

import pytest

from simcore.bridge.packets import HEADER_SIZE, Record, VersionError, frame, frame_size
from simcore.bridge.packets import records as read_records


def test_unpacking_a_packed_record_returns_its_values():
    sent = [Record(3, 1, -7, 0.1), Record(128, 0, 0, 0.0, "fünf\0sechs".encode()), Record(100, 0, 2**31 - 1, -1e300)]
    packed = frame(20_000, sent)
    size, time = frame_size(packed[:HEADER_SIZE])
    assert (size, time) == (len(packed) - HEADER_SIZE, 20_000)
    assert list(read_records(packed[HEADER_SIZE:])) == sent
    assert sent[1].parts == ["fünf", "sechs"]


def test_the_error_names_the_version_of_an_incompatible_frame():
    with pytest.raises(VersionError, match="version 2, but this simcore needs version 1"):
        frame_size(b"SCB2" + frame(0, [])[4:HEADER_SIZE])
    with pytest.raises(VersionError, match="does not have simcore's extension"):
        frame_size(b"GET / HTTP/1.1\r\n")
