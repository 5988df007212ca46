"""How much of the robot each wheel carries."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.errors import NonFiniteError
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.wheel_loads import LoadTransfer, normal_loads
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

    @pytest.mark.parametrize(("accel", "rear"), [(0.0, 0.0), (3.0, 1.0), (-3.0, 0.0)])
    def test_a_dropped_center_carries_all_with_the_end_that_it_leans_on(self, accel, rear):
        """m a h over half the wheelbase on the end behind, or before; nothing on the other."""
        tank = TankConfig()
        loads = normal_loads(tank, [True] * 6, self.LEVEL, (accel, 0.0, 0.0))
        front, middle, back = (loads[k] + loads[k + 3] for k in range(3))
        end = tank.mass * abs(accel) * tank.center_of_mass[2] / 0.28
        assert (front, back) == pytest.approx(((1.0 - rear) * end, rear * end), abs=1e-9)
        assert middle == pytest.approx(tank.mass * GRAVITY - end)

    def test_without_a_dropped_center_all_six_wheels_carry_alike(self):
        loads = normal_loads(TankConfig(dropped_center=False), [True] * 6, self.LEVEL)
        assert loads == pytest.approx([50.0 * GRAVITY / 6.0] * 6)

    def test_a_dropped_center_in_the_air_leaves_the_load_to_the_ends(self):
        loads = normal_loads(TankConfig(), [True, False, True] * 2, self.LEVEL)
        assert loads == pytest.approx([50.0 * GRAVITY / 4.0, 0.0, 50.0 * GRAVITY / 4.0] * 2)


class TestLoadTransfer:
    LEVEL = (0.0, 0.0, -GRAVITY)
    LAG = 0.010

    @staticmethod
    def to_the_rear(loads):
        return sum(loads[2:]) - sum(loads[:2])

    @pytest.mark.parametrize("h", [0.005, 0.00125])
    def test_loads_follow_the_tires_with_the_lag_at_any_step(self, h):
        """In the middle of a step at t: 2 m h_c / wheelbase times a (1 - exp(-t / lag)); exactly, for a constant a."""
        transfer = LoadTransfer(SQUARE)
        transfer.stand([True] * 4, self.LEVEL, (0.0, 0.0, 0.0))
        for k in range(round(0.02 / h)):
            transfer.follow(h, 3.0, 0.0, 0.0)
            followed = 1.0 - math.exp(-(k + 1.5) * h / self.LAG)
            expected = 2 * 55.0 * 3.0 * 0.2 / 0.527 * followed
            assert self.to_the_rear(transfer.loads(h)) == pytest.approx(expected, rel=1e-9)

    def test_what_was_transferred_stays_in_the_field_while_the_robot_turns(self):
        transfer = LoadTransfer(SQUARE)
        transfer.stand([True] * 4, self.LEVEL, (0.0, 0.0, 0.0))
        transfer.follow(1.0, 3.0, 0.0, math.pi / 2)
        loads = transfer.loads(1e-12)
        assert self.to_the_rear(loads) == pytest.approx(0.0, abs=1e-6)
        assert loads[0] + loads[2] - loads[1] - loads[3] == pytest.approx(2 * 55.0 * 3.0 * 0.2 / 0.527)

    @pytest.mark.parametrize("world", [(2.0, -4.0, 0.5), (0.0, 14.0, 0.0), (-20.0, 9.0, 3.0), (0.0, 0.0, -20.0)])
    @pytest.mark.parametrize("touching", [[True] * 4, [True, False, True, True], [False] * 4])
    def test_at_last_they_are_those_of_the_acceleration(self, world, touching):
        """Also where a wheel lifts, and in free fall."""
        transfer = LoadTransfer(SQUARE)
        transfer.stand(touching, self.LEVEL, world)
        transfer.follow(1.0, 1.0, 0.5, 0.0)
        whole = (world[0] + 1.0, world[1] + 0.5, world[2])
        assert transfer.loads(1.0) == pytest.approx(normal_loads(SQUARE, touching, self.LEVEL, whole), abs=1e-6)
        transfer.reset()
        assert transfer.loads(1e-12) == pytest.approx(normal_loads(SQUARE, touching, self.LEVEL), abs=1e-6)
