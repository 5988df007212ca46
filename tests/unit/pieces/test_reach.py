"""Chunks: what a mover marks covers its reach, and chunks linger."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from simcore.pieces.reach import ChunkGrid

from simcore.errors import ConfigError

LOW, HIGH = (-1.0, -1.0), (17.5, 9.1)
place = st.tuples(st.floats(-3.0, 20.0), st.floats(-3.0, 12.0))


def grid(linger: int = 25) -> ChunkGrid:
    return ChunkGrid(LOW, HIGH, size=2.0, linger=linger)


@given(at=place, reach=st.floats(0.0, 5.0), toward=st.floats(0.0, 2.0 * np.pi), part=st.floats(0.0, 1.0))
def test_every_place_within_reach_lies_in_an_active_chunk(at, reach, toward, part):
    """Also across borders, also for a reach of several chunks, also beyond the edge of the field."""
    there = np.array([at]) + part * reach * np.array([[np.cos(toward), np.sin(toward)]])
    for mark in ("mark", "mark_box"):
        chunks = grid()
        if mark == "mark":
            chunks.mark(np.array([at]), np.array([reach]))
        else:
            chunks.mark_box(*at, reach)
        chunks.update()
        assert chunks.active[chunks.index(there)[0]], mark


@given(at=st.tuples(st.floats(0.0, 16.5), st.floats(0.0, 8.0)), reach=st.floats(0.0, 3.0))
def test_what_is_farther_than_a_chunk_beyond_the_reach_stays_quiet(at, reach):
    chunks = grid()
    chunks.mark(np.array([at]), np.array([reach]))
    chunks.update()
    x, y = np.meshgrid(np.arange(-0.9, 17.0, 0.1), np.arange(-0.9, 9.0, 0.1))
    places = np.column_stack((x.ravel(), y.ravel()))
    far = np.abs(places - at).max(axis=1) > reach + 2.0
    assert not chunks.active[chunks.index(places[far])].any()


def test_many_pieces_mark_what_each_would_mark_alone():
    rng = np.random.default_rng(3)
    pos, reach = rng.uniform((0, 0), (16.5, 8.0), (50, 2)), rng.uniform(0.1, 3.0, 50)
    together, one_by_one = grid(), grid()
    together.mark(pos, reach)
    for i in range(50):
        one_by_one.mark(pos[i : i + 1], reach[i : i + 1])
    together.update(), one_by_one.update()
    assert (together.active == one_by_one.active).all()


def test_a_chunk_lingers_for_so_many_ticks_and_then_falls_quiet_once():
    chunks = grid(linger=3)
    here = np.array([[5.5, 3.5]])
    index = chunks.index(here)[0]
    chunks.mark(here, np.array([0.1]))
    woken, quiet = chunks.update()
    assert woken[index] and woken.sum() == 1 and not quiet.any()
    for _ in range(3):
        woken, quiet = chunks.update()
        assert chunks.active[index] and not woken.any() and not quiet.any()
    woken, quiet = chunks.update()
    assert quiet[index] and quiet.sum() == 1 and not chunks.active.any()
    assert not chunks.update()[1].any(), "it falls quiet only once"


def test_a_mover_that_comes_back_in_time_keeps_its_chunk():
    chunks = grid(linger=3)
    here, index = np.array([[5.5, 3.5]]), grid().index(np.array([[5.5, 3.5]]))[0]
    for tick in range(20):
        if tick % 4 == 0:
            chunks.mark(here, np.array([0.1]))
        _, quiet = chunks.update()
        assert chunks.active[index] and not quiet.any()


def test_nothing_is_active_before_anything_moves():
    chunks = grid()
    woken, quiet = chunks.update()
    assert not (woken.any() or quiet.any() or chunks.active.any())


def test_a_chunk_without_size_is_refused():
    with pytest.raises(ConfigError, match="size"):
        ChunkGrid(LOW, HIGH, size=0.0)
