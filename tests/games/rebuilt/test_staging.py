"""Staging by the manual: 504 fuel, a block of 206 x 72 in, places drawn by the seed."""

import math

import numpy as np
import pytest
from each_case import each
from scipy.spatial.distance import pdist

from games.rebuilt.dimensions import (
    DEPOT_BARRIER_HEIGHT,
    DEPOT_BARRIER_WIDTH,
    DEPOT_DEPTH,
    DEPOT_WIDTH,
    DEPOT_Y,
    FIELD_CENTER,
    FIELD_WIDTH,
)
from games.rebuilt.field import FIELD
from games.rebuilt.fuel import FUEL
from games.rebuilt.staging import Staging, depot_places, neutral_places
from simcore.errors import ConfigError
from simcore.units import inches

RADIUS = FUEL.bounding_radius


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_the_default_staging_has_the_504_fuel_of_the_manual():
    """360 in the neutral zone, 24 in each depot, 24 in each chute, 8 in each of six robots."""
    assert Staging().total == 360 + 2 * 24 + 2 * 24 + 6 * 8 == 504


@each(("robots", "fuel"), [(6, 360), (5, 368), (1, 400), (0, 408)])
def test_preloads_of_absent_robots_are_staged_in_the_neutral_zone(robots, fuel):
    assert Staging().in_neutral_zone(robots) == fuel


def test_the_full_block_measures_206_by_72_inches_around_the_field_center():
    """The block is measured between the outer sides of the outermost fuel; jitter is 1 mm and play 0.09 in."""
    places = neutral_places(408, rng())
    low, high = places.min(axis=0) - RADIUS, places.max(axis=0) + RADIUS
    assert high[1] - low[1] == pytest.approx(inches(206.0), abs=0.005)
    assert high[0] - low[0] == pytest.approx(inches(72.0), abs=0.005)
    assert (low + high)[:2] / 2 == pytest.approx(FIELD_CENTER, abs=0.002)


def test_no_fuel_is_staged_on_the_two_inch_divider():
    y = neutral_places(408, rng())[:, 1] - FIELD_WIDTH / 2
    assert (np.abs(y) - RADIUS).min() >= inches(1.0) - 0.001


@each("seed", range(5))
def test_no_two_fuel_overlap_and_all_fuel_lies_on_the_carpet(seed):
    random = rng(seed)
    places = np.vstack((neutral_places(408, random), depot_places("blue", 24, random), depot_places("red", 24, random)))
    assert pdist(places).min() > 2.0 * RADIUS
    assert places[:, 2] == pytest.approx(RADIUS)


@pytest.mark.parametrize("alliance", ["blue", "red"])
def test_the_fuel_of_a_depot_lies_between_its_barriers_and_the_wall(alliance):
    places = depot_places(alliance, 24, rng())
    if alliance == "red":
        places = FIELD.symmetry.flip_points(places)
    x, y = places[:, 0], places[:, 1]
    assert len(places) == 24
    assert x.min() > RADIUS
    reach = math.sqrt(RADIUS**2 - (RADIUS - DEPOT_BARRIER_HEIGHT) ** 2)  # reach of a ball at barrier height
    assert x.max() + reach < DEPOT_DEPTH - DEPOT_BARRIER_WIDTH
    assert np.abs(y - DEPOT_Y).max() + reach < DEPOT_WIDTH / 2 - DEPOT_BARRIER_WIDTH


def test_staged_positions_depend_on_the_seed():
    assert (neutral_places(400, rng(4)) == neutral_places(400, rng(4))).all()
    assert not np.array_equal(neutral_places(400, rng(4)), neutral_places(400, rng(5)))
    assert not np.array_equal(depot_places("blue", 24, rng(4)), depot_places("blue", 24, rng(5)))


@each("field", ["neutral", "depot", "chute", "preload_per_robot", "robots"])
@each("value", [-1, 2.5])
def test_staging_counts_must_be_whole_numbers(field, value):
    with pytest.raises(ConfigError, match=f"{field} must be a whole number from 0 to .*, got {value}"):
        Staging(**{field: value})


def test_staging_more_fuel_than_fits_is_refused():
    with pytest.raises(ConfigError, match="depot must be a whole number from 0 to 24 fuel, got 25"):
        Staging(depot=25)
    with pytest.raises(ConfigError, match="the neutral zone holds 408 fuel, got 409"):
        Staging(neutral=361).in_neutral_zone(0)
