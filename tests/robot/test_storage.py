"""Pieces in a storage: their places, the order in which they leave, and the capacity."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from games.rebuilt.fuel import FUEL
from games.rebuilt.robot import rebuilt_robot
from simcore.errors import CapacityError, ConfigError
from simcore.robot.storage import Storage, StorageConfig
from simcore.units import inches

LOW, HIGH = (-0.33, -0.30, 0.20), (0.20, 0.30, 0.50)


@given(st.floats(0.04, 0.14), st.integers(1, 60))
def test_positions_are_inside_the_storage_and_do_not_overlap_while_there_is_room(radius, count):
    """Balls touch at most until the storage is full; more balls overlap, and no ball is above the storage."""
    config = StorageConfig(capacity=count, low=LOW, high=HIGH)
    places = np.array([config.position(number, radius) for number in range(count)])
    assert (places - radius >= np.array(LOW) - 1e-9).all()
    assert (places + radius <= np.array(HIGH) + 1e-9).all()
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 9.0 * np.eye(count)
    assert (apart.min() >= 2.0 * radius - 1e-9) == (count <= config.balls_that_fit(radius))


def test_balls_lie_in_the_hollows_of_the_layer_below():
    """Layers of 4 x 4 and 3 x 3 balls of diameter d alternate: one every d / sqrt(2), so five fit in a cube of 4 d."""
    room = StorageConfig(capacity=66, low=(-0.2, -0.2, 0.0), high=(0.2, 0.2, 0.4))
    assert room.balls_that_fit(0.05) == 3 * 16 + 2 * 9
    heights = sorted({room.position(number, 0.05)[2] for number in range(66)})
    assert np.diff(heights) == pytest.approx(0.1 / math.sqrt(2.0))


def test_a_full_rebuilt_robot_is_within_the_height_limit():
    """50 fuel fit in its hopper, below 30 in; nor do they form a tower in the default storage."""
    hopper, radius = rebuilt_robot().storage, FUEL.bounding_radius
    assert hopper.balls_that_fit(radius) >= hopper.capacity == 50
    assert max(hopper.position(number, radius)[2] for number in range(50)) + radius < inches(30.0)
    room = StorageConfig(capacity=50)
    assert max(room.position(number, radius)[2] for number in range(50)) + radius <= room.high[2] + 1e-9


@pytest.mark.parametrize(("order", "first"), [("fifo", [3, 4, 5]), ("lifo", [5, 4, 3])])
def test_pieces_leave_a_storage_in_the_configured_order(order, first):
    storage = Storage(StorageConfig(capacity=3, order=order))
    storage.add([3, 4, 5])
    assert list(storage.in_turn) == first
    assert [storage.take() for _ in range(3)] == first
    with pytest.raises(CapacityError, match="empty"):
        storage.take()


def test_more_pieces_than_fit_are_refused_without_a_change():
    storage = Storage(StorageConfig(capacity=2))
    storage.add([7])
    with pytest.raises(CapacityError, match="room for 1 more, got 2"):
        storage.add([8, 9])
    assert storage.pieces == [7] and storage.room == 1
    storage.discard(7)
    assert storage.room == 2


def test_invalid_storages_are_refused():
    for change, words in (
        ({"capacity": -1}, "capacity"), ({"capacity": 1.5}, "whole number"), ({"order": "x"}, "order must be"),
        ({"low": (0.5, 0.0, 0.0)}, "low must be below high"),
    ):  # fmt: skip
        with pytest.raises(ConfigError, match=words):
            StorageConfig(**change)
