"""How much of the robot each wheel carries."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.errors import NonFiniteError
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.wheel_loads import normal_loads
from simcore.units import GRAVITY

SQUARE = SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0))


class TestLoads:
    LEVEL = (0.0, 0.0, -GRAVITY)

    def test_speeding_up_loads_the_rear(self):
        """m a h / wheelbase per axle."""
        loads = normal_loads(SQUARE, [True] * 4, self.LEVEL, (3.0, 0.0, 0.0))
        assert sum(loads[2:]) - sum(loads[:2]) == pytest.approx(2 * 55.0 * 3.0 * 0.2 / 0.527)

    def test_a_left_turn_loads_the_right(self):
        loads = normal_loads(SQUARE, [True] * 4, self.LEVEL, (0.0, 3.0, 0.0))
        assert loads[1] > loads[0]

    def test_nose_up_loads_the_rear(self):
        a = math.radians(15)
        loads = normal_loads(SQUARE, [True] * 4, (-GRAVITY * math.sin(a), 0.0, -GRAVITY * math.cos(a)))
        assert loads[2] > loads[0]

    def test_wheels_in_the_air_carry_nothing(self):
        loads = normal_loads(SQUARE, [True, True, False, True], self.LEVEL)
        assert loads[2] == 0.0
        assert sum(loads) == pytest.approx(55.0 * GRAVITY)
        assert normal_loads(SQUARE, [False] * 4, self.LEVEL) == [0.0] * 4
        assert normal_loads(SQUARE, [True] * 4, (0.0, 0.0, 0.0)) == [0.0] * 4

    def test_beyond_tipping_the_outer_wheels_carry_all(self):
        loads = normal_loads(SQUARE, [True] * 4, self.LEVEL, (20.0, 0.0, 0.0))
        assert loads[:2] == [0.0, 0.0]
        assert sum(loads) == pytest.approx(55.0 * GRAVITY)

    @pytest.mark.parametrize("bad", [math.nan, math.inf])
    def test_bad_accelerations_are_refused(self, bad):
        with pytest.raises(NonFiniteError, match="loads"):
            normal_loads(SQUARE, [True] * 4, self.LEVEL, (bad, 0.0, 0.0))

    def test_shares_follow_the_center_of_mass(self):
        loads = normal_loads(replace(SQUARE, center_of_mass=(0.1, 0.0, 0.2)), [True] * 4, self.LEVEL)
        assert sum(loads) == pytest.approx(55.0 * GRAVITY)
        assert np.average([m.x for m in SQUARE.modules], weights=loads) == pytest.approx(0.1)
