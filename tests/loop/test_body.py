"""Rigid bodies in plain Python: rotation, impulses, soft contacts and boxes against closed forms."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from simcore.loop import body as bodies
from simcore.loop.robot_state import BODY, ROBOT, SPRING, SPRINGS, TOUCHES
from simcore.world.rotation import from_rpy, matrix

H = 1e-3


@pytest.fixture
def plain(monkeypatch):
    """Return the module with its compiled functions replaced by plain Python, for internal calls as well."""
    for name, function in list(vars(bodies).items()):
        if hasattr(function, "py_func"):
            monkeypatch.setattr(bodies, name, function.py_func)
    return bodies


def record(dtype, model=None, **values):
    one = np.zeros(1, dtype).view(np.recarray)[0]
    for name, value in (model or {}).items():
        one["model"][name] = value
    for name, value in values.items():
        one[name] = value
    return one


def tumbling(plain):
    quat = from_rpy(0.4, -0.7, 1.9)
    model = dict(mass=4.0, inertia=(2.0, 3.0, 5.0), principal=np.eye(3), center=(0.1, -0.2, 0.3), is_robot=1)
    body = record(
        BODY, model, quat=quat, pos=(1.0, 2.0, 3.0), vel=(0.5, -1.0, 2.0), rate=matrix(quat) @ (1.0, -2.0, 3.0)
    )
    plain.update_axes(body)
    return body, matrix(quat)


def test_a_body_turns_by_eulers_equations(plain):
    """I dw/dt + w x I w = M, in body axes."""
    body, _ = tumbling(plain)
    inertia, rate, moment = body.model.inertia, np.array((1.0, -2.0, 3.0)), np.array((0.5, -1.0, 2.0))
    after = rate + H * (moment - np.cross(rate, inertia * rate)) / inertia
    assert plain.turned_rate(body, *moment, H) == pytest.approx(after, abs=1e-12)


def test_an_impulse_changes_linear_and_angular_momentum(plain):
    body, turn = tumbling(plain)
    arm, impulse = np.array((0.3, 0.2, -0.1)), np.array((2.0, -3.0, 1.0))
    inertia = turn @ np.diag(body.model.inertia) @ turn.T
    before = body.model.mass * body.vel, inertia @ body.rate
    plain.apply_impulse(body, *impulse, *arm)
    assert body.model.mass * body.vel - before[0] == pytest.approx(impulse)
    assert inertia @ body.rate - before[1] == pytest.approx(np.cross(arm, impulse))
    assert body.impulse == pytest.approx([*impulse, *np.cross(arm, impulse)])
    stands = record(BODY, {"mass": 4.0, "inertia": (1.0, 1.0, 1.0)})
    plain.apply_impulse(stands, *impulse, *arm)
    assert not stands.vel.any() and stands.impulse[:3] == pytest.approx(impulse), "the engine moves it after the call"


def test_a_body_turns_about_its_center_of_mass_and_an_impulse_precedes_the_drift(plain):
    body, _ = tumbling(plain)
    com, away = body.com.copy(), np.linalg.norm(body.pos - body.com)
    plain.drift(body, H)
    assert body.com == pytest.approx(com + H * body.vel) and np.linalg.norm(body.quat) == pytest.approx(1.0)
    assert np.linalg.norm(body.pos - body.com) == pytest.approx(away), "its origin goes around"
    com, vel = body.com.copy(), body.vel.copy()
    kicked = np.array([body]).view(np.recarray)
    plain.kick_and_drift(kicked, 0, 3.0, 0.0, -1.0, 0.0, 0.0, 0.5, H)
    assert kicked[0].com == pytest.approx(com + H * np.array((3.0, 0.0, -1.0)))
    assert kicked[0].vel == pytest.approx(vel + np.array((3.0, 0.0, -1.0))) and kicked[0].rate[2] - body.rate[2] == 0.5


def test_a_soft_contact_sticks_up_to_mu_n_then_slips_and_never_pulls(plain):
    """N = k d - c v; along the surface a spring of k / 2 acts up to mu N. An initial overlap exerts no force."""
    robot, springs = record(ROBOT), np.zeros((1, SPRINGS), SPRING).view(np.recarray)
    step = 0

    def press(depth, velocity, *, key=7):
        nonlocal step
        step += 1
        return plain._press(
            robot, 0, springs, key, step, depth, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *velocity, 1e5, 100.0, 0.5, 0.4, H
        )

    assert press(2e-4, (0.0, 0.0, 0.0)) == pytest.approx((20.0, 0.0, 0.0, 20.0)), "a slack of 0.2 mm"
    assert press(2e-4, (0.0, 0.0, -0.1)) == pytest.approx((30.0, 0.0, 0.0, 30.0))
    load, fx, fy, _ = press(2e-4, (0.002, 0.0, 0.0))
    assert (load, fx, fy) == pytest.approx((20.0, -0.5e5 * 0.002 * H - 50.0 * 0.002, 0.0)), "it sticks"
    load, fx, fy, _ = press(2e-4, (3.0, -4.0, 0.0))
    assert (load, fx, fy) == pytest.approx((20.0, -0.4 * 20.0 * 0.6, 0.4 * 20.0 * 0.8), abs=2e-3), "it slips"
    press(2e-4, (0.0, 0.0, 0.0), key=9)
    assert press(2e-4, (0.12, 0.0, 0.0), key=9)[1] == pytest.approx(-8.0), "where it would need 12 N to stick"
    assert press(2e-4, (0.0, 0.0, 1.0)) == (0.0, 0.0, 0.0, 0.0), "it would pull"
    assert press(0.05, (0.0, 0.0, -1.0), key=8)[0] == pytest.approx(1e5 * (H + 2e-4) + 100.0), "as deep as it came"
    assert press(0.01, (0.0, 0.0, 0.0), key=8)[0] == 0.0, "what is out of it counts anew from there"
    assert press(0.0102, (0.0, 0.0, 0.0), key=8)[0] == pytest.approx(20.0)


def test_a_contact_keeps_its_spring_and_a_new_contact_replaces_the_oldest_contact(plain):
    springs = np.zeros((1, SPRINGS), SPRING).view(np.recarray)
    for key in range(SPRINGS):
        assert plain.find_spring(springs, 0, 100 + key, 10 + key)[1]
    springs[0, 5].stretch[0] = springs[0, 0].put_in = 1.0
    assert plain.find_spring(springs, 0, 105, 16) == (5, False) and springs[0, 5].stretch[0] == 1.0
    assert plain.find_spring(springs, 0, 1, 300) == (0, True), "it was over for the longest"
    assert springs[0, 0].put_in == 0.0 and not springs[0, 0].stretch.any()
    assert plain.find_spring(springs, 0, 105, 18)[1], "not touched in the step before"


def test_each_touched_element_is_recorded_once_until_the_list_is_full(plain):
    robot = record(ROBOT)
    for row in (3, 3, 4, *range(100)):
        plain.add_touch(robot, row)
    assert robot.touched == TOUCHES and robot.touches[:3].tolist() == [3, 4, 0]
    plain.apply_force(robot, 0.0, 0.5, 0.0, 1.0, 2.0, 3.0)
    assert robot.press.tolist() == [1.0, 2.0, 3.0] and robot.twist.tolist() == [1.5, 0.0, -0.5]


def test_the_gap_of_a_point_is_its_signed_distance_from_the_box(plain):
    model = SimpleNamespace(bottom=0.0, top=0.2, half_length=0.4, half_width=0.3, x=0.1, y=0.0)
    part = SimpleNamespace(model=model)
    third = 1.0 / math.sqrt(3.0)
    for place, wanted in (
        ((0.6, 0.4, 0.3), (0.1 * math.sqrt(3.0), third, third, third)),
        ((0.46, 0.0, 0.1), (-0.04, 1.0, 0.0, 0.0)),
        ((0.1, -0.28, 0.1), (-0.02, 0.0, -1.0, 0.0)),
        ((0.1, 0.0, 0.19), (-0.01, 0.0, 0.0, 1.0)),
        ((0.1, 0.0, -0.05), (0.05, 0.0, 0.0, -1.0)),
    ):
        assert plain._box_gap(part, *place) == pytest.approx(wanted)


def test_an_edge_is_clipped_at_the_faces_of_a_box(plain):
    half, ends = (0.4, 0.3, 0.1), np.zeros((24, 7))
    assert plain._clip(-1.0, 0.0, 0.05, 1.0, 0.0, 0.05, half, ends, 0) == 2
    assert ends[:2, :3] == pytest.approx(np.array([(-0.4, 0.0, 0.05), (0.4, 0.0, 0.05)]))
    assert plain._clip(0.0, 0.0, 0.0, 0.0, 0.6, 0.2, half, ends, 2) == 4
    assert ends[2:4, :3] == pytest.approx(np.array([(0.0, 0.0, 0.0), (0.0, 0.3, 0.1)]))
    for outside in ((-1.0, 0.3, 0.0, 1.0, 0.3, 0.0), (0.0, 0.4, 0.0, 0.0, 0.9, 0.0), (0.3, 0.6, 0.0, 0.8, 0.0, 0.0)):
        assert plain._clip(*outside, half, ends, 4) == 4, "it runs along a face, or passes by"
    assert plain._clip(-1.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, ends, 23) == 23, "no room for both ends"


def test_contacts_at_a_point_are_averaged_with_their_loads_as_weights(plain):
    point = SimpleNamespace(load=0.0, normal=np.zeros(3), arm=np.zeros(3))
    plain._add_load(point, 30.0, 0.0, 0.0, 1.0, 0.2, 0.0, -0.1)
    plain._add_load(point, 10.0, 1.0, 0.0, 0.0, 0.4, 0.0, 0.1)
    assert point.load == 40.0 and point.normal.tolist() == [0.25, 0.0, 0.75]
    assert point.arm == pytest.approx((0.25, 0.0, -0.05))
