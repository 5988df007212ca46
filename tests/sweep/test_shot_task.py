"""Sampled launches and flights of a shooter agree with those of a match."""

import numpy as np
import pytest
from real_shots import RealShots, low_shooter

from games.rebuilt import REBUILT
from simcore.match.match import Match
from simcore.match.scatter import Scatter
from simcore.pieces.flight import FLIGHT_STEP
from simcore.pieces.launch import Aim, Launch
from simcore.sweep.shot_task import ShotDraws, ShotTask, Stand
from simcore.units import degrees
from simcore.world.ball_dynamics import make_memory
from simcore.world.rotation import from_yaw


def test_sampled_shots_leave_with_the_velocity_and_spin_of_the_robots_shooter() -> None:
    """Place, velocity and spin equal those from `Shooter.released`, for both barrels."""
    task = ShotTask(REBUILT)
    stand = Stand(3.0, 0.4)
    elevation, speed = np.array([1.1, 0.9]), np.array([7.0, 8.0])
    rows = task.rows(stand, elevation, speed, np.array([0, 1]))
    with Match(REBUILT) as match:
        robot = match.robots[0]
        shooter = robot.shooters[0]
        x, y = stand.place(task.opening.middle)
        for row in range(2):
            motion = robot.motion_at(0.0)
            quat = from_yaw(task.aim(stand))
            motion = type(motion)(pos=(x, y, 0.0), quat=quat, vel=(0.0,) * 3, rate=(0.0,) * 3)
            launch = Launch(barrel=row, delay=0.0, aim=Aim(float(elevation[row]), float(speed[row])))
            piece = shooter.released(launch, radius=float(rows.radius[row]), robot=motion)
            assert rows.pos[row] == pytest.approx(piece.pos, abs=1e-12)
            assert rows.vel[row] == pytest.approx(piece.vel, abs=1e-12)
            assert rows.spin[row] == pytest.approx(piece.rate, abs=1e-9)
    x, y, _ = task.opening.middle - task.muzzle(stand, task.aim(stand))
    assert x * rows.vel[:, 1] - y * rows.vel[:, 0] == pytest.approx(0.0, abs=1e-3), "from the middle of the muzzles"


def test_draws_have_the_standard_deviations_in_the_scatter() -> None:
    """Standard deviations of 20,000 draws are within 3 % of the configured values; their standard error is 0.5 %."""
    scatter = Scatter()
    draws = ShotDraws.of(scatter, np.random.default_rng(1), 20_000)
    for found, wanted in (
        (np.log(draws.exit_speed), scatter.exit_speed), (draws.elevation, scatter.elevation),
        (draws.azimuth, scatter.azimuth), (np.log(draws.spin), scatter.spin), (np.log(draws.drag), scatter.drag),
        (np.sqrt(3.0) * draws.mass, scatter.piece_mass), (np.sqrt(3.0) * draws.diameter, scatter.piece_diameter),
    ):  # fmt: skip
        assert np.std(found) == pytest.approx(wanted, rel=0.03)
    none = ShotDraws.none(3)
    assert (none.exit_speed == 1.0).all() and (none.azimuth == 0.0).all() and (none.drag == 1.0).all()


def test_a_clean_shot_goes_in_from_all_sides_and_a_shot_off_the_board_from_one_side() -> None:
    """The second shot touches the board behind the hub, so no table recommends it."""
    draws, task = ShotDraws.of(Scatter(), np.random.default_rng(1), 500), ShotTask(REBUILT)
    for elevation, speed, least, most, is_clean in ((69.0, 7.37, 0.9, 1.0, True), (57.0, 7.6, 0.0, 0.5, False)):
        shares = [task.share(Stand(3.0, degrees(b)), degrees(elevation), speed, draws) for b in (0, 30, 60)]
        assert shares[0] > 0.9 and least <= min(shares[1:]) <= most, shares
        assert task.hits(Stand(3.0, 0.0), np.array([degrees(elevation)]), np.array([speed])).all() == is_clean


def test_shots_of_a_fixed_shooter_fly_in_a_match_as_predicted() -> None:
    """Speed and elevation differ as in a scatter; the result is the same, and paths agree within 1 mm to the end."""
    task, stand = ShotTask(REBUILT, low_shooter(REBUILT.robot())), Stand(3.0, 0.0)
    verdicts = []
    with RealShots(task, seed=1) as real:
        for elevation_deg, speed in ((62.0, 7.07), (60.0, 7.3), (64.5, 6.95), (58.0, 6.6), (66.0, 6.2)):
            aim = np.array([degrees(elevation_deg)]), np.array([speed])
            foreseen = bool(task.fly(task.rows(stand, *aim)).goes_in[0])
            ball, memory = task.rows(stand, *aim), make_memory(1)
            way = [ball.pos[0].copy()]
            while not ball.is_touched[0]:
                task.field.fly(ball, memory, FLIGHT_STEP)
                way.append(ball.pos[0].copy())
            scored = real.shoot(stand, degrees(elevation_deg), speed)
            x, *across = np.array(way).T
            flown = np.array(real.match.record.shots[-1].points)
            flown = flown[np.maximum.accumulate(flown[:, 0]) < x[-2]]
            foreseen_there = np.column_stack([np.interp(flown[:, 0], x, one) for one in across])
            assert len(flown) > 20 and np.abs(flown[:, 1:] - foreseen_there).max() < 1e-3
            assert scored == foreseen, f"{elevation_deg} deg, {speed} m/s"
            verdicts.append(scored)
    assert verdicts == [True, True, True, False, False]
