"""Pieces in a robot: places inside of the room and apart, the order in which they leave, and no more than fit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import CapacityError, ConfigError
from simcore.pieces.storage import Storage, StorageConfig

LOW, HIGH = (-0.33, -0.30, 0.20), (0.20, 0.30, 0.50)


@given(st.floats(0.04, 0.14), st.integers(1, 60))
def test_places_are_apart_and_inside_of_the_walls(radius, count):
    """As many as the room holds in layers are inside on every side; more are stacked over its top."""
    config = StorageConfig(capacity=count, low=LOW, high=HIGH)
    places = np.array([config.position(number, radius) for number in range(count)])
    assert (places[:, :2] - radius >= np.array(LOW[:2]) - 1e-9).all()
    assert (places[:, :2] + radius <= np.array(HIGH[:2]) + 1e-9).all()
    assert (places[:, 2] >= LOW[2] + radius - 1e-9).all()
    layer = math.floor((HIGH[0] - LOW[0]) / (2 * radius)) * math.floor((HIGH[1] - LOW[1]) / (2 * radius))
    if count <= layer:
        assert places[:, 2] == pytest.approx(LOW[2] + radius)
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 9.0 * np.eye(count)
    assert apart.min() >= 2.0 * radius - 1e-9


@pytest.mark.parametrize(("order", "first"), [("fifo", [3, 4, 5]), ("lifo", [5, 4, 3])])
def test_pieces_leave_in_their_order(order, first):
    storage = Storage(StorageConfig(capacity=3, order=order))
    storage.add([3, 4, 5])
    assert [storage.take() for _ in range(3)] == first
    with pytest.raises(CapacityError, match="empty"):
        storage.take()


def test_no_more_than_fit_and_then_nothing_has_changed():
    storage = Storage(StorageConfig(capacity=2))
    storage.add([7])
    with pytest.raises(CapacityError, match="room for 1 more, got 2"):
        storage.add([8, 9])
    assert storage.pieces == [7] and storage.room == 1
    storage.discard(7)
    assert storage.room == 2


def test_rooms_that_cannot_be_are_refused():
    for change, words in (
        ({"capacity": -1}, "capacity"), ({"capacity": 1.5}, "whole number"), ({"order": "x"}, "order must be"),
        ({"low": (0.5, 0.0, 0.0)}, "low must be below high"),
    ):  # fmt: skip
        with pytest.raises(ConfigError, match=words):
            StorageConfig(**change)
