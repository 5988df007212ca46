"""Checks of numbers from users: error messages and accepted values."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.match.game import StagedPieces
from simcore.quantities import (
    COUNT,
    CURRENT_LIMIT,
    FIELD_PLACE,
    MASS,
    POSE,
    ROBOT_LENGTH,
    START,
    Quantity,
    Row,
    require,
    require_fields,
    require_points,
    require_row,
)
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.robot_config import RobotConfig
from simcore.world.linkage import Joint


@each(
    ("quantity", "value", "said"),
    [
        (MASS, math.nan, "must be a number above 0 and up to 1000 kg, got nan"),
        (MASS, 0.0, "must be a number above 0 and up to 1000 kg, got 0.0"),
        (MASS, "5", "must be a number above 0 and up to 1000 kg, got '5'"),
        (MASS, True, "must be a number above 0 and up to 1000 kg, got True"),
        (MASS, 1001.0, "must be a number above 0 and up to 1000 kg, got 1001.0. As pounds that is 454 kg"),
        (Quantity("kg", 20.0, 75.0), 125, "must be a number from 20 to 75 kg, got 125. As pounds that is 56.7 kg"),
        (ROBOT_LENGTH, 34, "must be a number above 0 and up to 3 m, got 34. As inches that is 0.864 m"),
        (ROBOT_LENGTH, 860, "must be a number above 0 and up to 3 m, got 860. As mm that is 0.86 m"),
        (ROBOT_LENGTH, -1.0, "must be a number above 0 and up to 3 m, got -1.0"),
        (COUNT, 1.5, "must be a whole number from 0 to 10000, got 1.5"),
        (COUNT, 10**400, f"must be a whole number from 0 to 10000, got 1{'0' * 59}... (401 characters)"),
        (CURRENT_LIMIT, -1.0, "must be a number from 0 to 10000 A, or math.inf for no limit, got -1.0"),
    ],
)
def test_the_error_for_an_invalid_value_gives_the_bounds_and_the_unit(quantity, value, said):
    with pytest.raises(ConfigError) as caught:
        require("Robot", "it", value, quantity)
    assert str(caught.value) == f"Robot: it {said}"


@each(("quantity", "value"), [(MASS, 5), (MASS, np.float32(5.0)), (COUNT, np.int64(3)), (CURRENT_LIMIT, math.inf)])
def test_a_valid_value_is_accepted(quantity, value):
    require("Robot", "it", value, quantity)


@each(
    ("row", "values", "said"),
    [
        (POSE, (1.0, 2.0), r"start must be 3 numbers \(m, m, rad\), got \(1.0, 2.0\)"),
        (POSE, 7.0, r"start must be 3 numbers \(m, m, rad\), got 7.0"),
        (POSE, "abc", "start must be 3 numbers"),
        (POSE, np.array(1.0), "start must be 3 numbers"),
        (POSE, (1.0, math.nan, 0.0), r"start\[1\] must be a number from -100 to 100 m, got nan"),
        (START, (2.0, 2.0, 180.0), r"start\[2\] must be .* rad, got 180.0. As degrees that is 3.14 rad"),
        ([POSE], ((1.0, 2.0, 0.0), (1.0, 2.0, None)), r"start\[1\]\[2\] must be a number from .* rad, got None"),
    ],
)
def test_the_error_names_the_index_of_a_bad_number_in_a_row(row: Row, values, said):
    with pytest.raises(ConfigError, match=f"^Robot: {said}"):
        require_row("Robot", "start", values, row)


def test_the_error_names_the_index_of_a_bad_point_or_the_required_shape():
    require_points("Hull", "points", np.eye(3), FIELD_PLACE, least=3)
    with pytest.raises(ConfigError, match=r"Hull: points\[1, 2\] must be a number from -100 to 100 m, got inf"):
        require_points("Hull", "points", np.array([[0.0, 0.0, 0.0], [0.0, 0.0, math.inf]]), FIELD_PLACE)
    with pytest.raises(ConfigError, match=r"shape \(n >= 3, 3\)"):
        require_points("Hull", "points", np.eye(3)[:2], FIELD_PLACE, least=3)


def test_none_is_accepted_only_where_it_is_the_default():
    @dataclass(frozen=True)
    class Claw:
        mass: float
        length: float | None = None

    require_fields(Claw(1.0), mass=MASS, length=ROBOT_LENGTH)
    with pytest.raises(ConfigError, match=r"^Claw: mass must be a number above 0 and up to 1000 kg, got None"):
        require_fields(Claw(None), mass=MASS, length=ROBOT_LENGTH)
    with pytest.raises(ConfigError, match=r"^my claw: length must be a number above 0 and up to 3 m, got 9"):
        require_fields(Claw(1.0, 9), "my claw", mass=MASS, length=ROBOT_LENGTH)


class Unprintable:
    def __repr__(self) -> str:
        raise RuntimeError("no")


def test_huge_and_unprintable_values_raise_a_config_error():
    for value in (10**5000, Unprintable(), [Unprintable()]):
        said = f"must be a whole number from 0 to 10000, got {type(value).__name__} that cannot be shown"
        with pytest.raises(ConfigError, match=said):
            require("Robot", "it", value, COUNT)
    with pytest.raises(ConfigError, match=r"must be .*, got range\(0, 1000000000000\)"):
        require_row("Robot", "it", range(10**12), [COUNT])
    with pytest.raises(ConfigError, match=r"cameras must be .*, got range\(0, 1000000000000\)"):
        RobotConfig(drivetrain=TankConfig(), cameras=range(10**12))


@dataclass(frozen=True, slots=True)
class Plate:
    """Config with a number and a tuple of numbers."""

    mass: float
    place: tuple[float, float, float]

    def __post_init__(self) -> None:
        require_fields(self, mass=MASS, place=POSE)


@each("kind", [np.float16, np.float32, np.longdouble, np.int8, int])
def test_numpy_numbers_in_a_config_become_python_numbers(kind):
    plate = Plate(kind(5), (kind(1), 2.0, kind(0)))
    assert {type(plate.mass), *map(type, plate.place)} <= {int, float}
    assert Plate(1.0, np.zeros(3, dtype=np.float16)).place == (0.0, 0.0, 0.0)


def test_a_tiny_number_is_refused_if_zero_is_refused():
    with pytest.raises(ConfigError, match="mass must be a number above 0 and up to 1000 kg, got 5e-324"):
        Plate(5e-324, (0.0, 0.0, 0.0))


def test_lists_and_arrays_in_tuple_fields_become_tuples():
    """Tuples are hashable; -0.0 becomes 0.0."""
    for origin in ([0.1, -0.0, 0.3], np.array([0.1, 0.0, 0.3]), (np.float32(0.5), 0.0, -0.0)):
        joint = Joint(mechanism="arm", axis=(0.0, 1.0, 0.0), origin=origin)
        assert type(joint.origin) is tuple and hash(joint) and "-0.0" not in repr(joint.origin)
    assert TankConfig(wheel_xs=np.array([0.3, -0.3])).wheel_xs == (0.3, -0.3)
    assert RobotConfig(drivetrain=TankConfig(), placers=[]).placers == ()
    with pytest.raises(ConfigError, match="attitudes must have shape"):
        StagedPieces(kind="Ball", positions=np.zeros((2, 3)), attitudes=((1.0, 2.0), (3.0,)))
