"""Where convex outlines touch in plan, and the impulses of Coulomb's and Newton's laws there."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.physics.bumper_contacts import slice_between
from simcore.physics.planar_contacts import PlanarBody, PlanarContact, Polygon, manifold, solve_contacts

H = 0.005
WALL = Polygon([(1.0, -5.0), (2.0, -5.0), (2.0, 5.0), (1.0, 5.0)])


def square(x, y, yaw=0.0, half=0.4):
    c, s = half * math.cos(yaw), half * math.sin(yaw)
    return Polygon.rectangle(x, y, (c, s), (-s, c))


def robot(x, y, velocity, change=(0.0, 0.0, 0.0)):
    """55 kg, 0.8 x 0.8 m, with a velocity to which its tires add in the step."""
    vx, vy, w = velocity
    ax, ay, b = change
    return PlanarBody(
        center=(x, y, 0.0),
        mass=55.0,
        inertia=(5.0, 5.0, 55.0 * 0.64 / 6.0),
        start=velocity,
        mean=(vx + 0.5 * ax, vy + 0.5 * ay, w + 0.5 * b),
        end=(vx + ax, vy + ay, w + b),
    )


def contacts_of(body, outline, other, other_body=None, *, friction=0.0, restitution=0.0):
    return [
        PlanarContact(body, other_body, x, y, nx, ny, gap, friction, restitution)
        for x, y, nx, ny, gap in manifold(outline, other, 0.05)
    ]


def test_a_flat_side_has_a_contact_at_both_ends_of_the_overlap():
    found = manifold(square(0.59, 0.0), WALL, 0.02)
    assert [(y, gap) for _, y, _, _, gap in found] == [pytest.approx((end, 0.01)) for end in (-0.4, 0.4)]
    assert all((nx, ny) == (1.0, 0.0) for _, _, nx, ny, _ in found)
    assert [y for _, y, *_ in manifold(square(0.0, 0.0), square(0.8, 0.5), 0.02)] == pytest.approx([0.1, 0.4])
    assert manifold(square(0.59, 0.0), WALL, 0.005) == []


def test_the_order_of_two_outlines_only_turns_the_normal():
    a, b = square(0.0, 0.0, 0.1), square(0.82, 0.1, -0.2)
    one, other = manifold(a, b, 0.1), manifold(b, a, 0.1)
    assert sorted((x, y, nx, ny, g) for x, y, nx, ny, g in one) == [
        pytest.approx(row) for row in sorted((x, y, -nx, -ny, g) for x, y, nx, ny, g in other)
    ]


def test_a_seam_between_two_flush_walls_stops_nobody():
    """What lies ahead overlaps the bumper by less than 3 mm from the side."""
    ahead = Polygon([(0.5, -1.0), (2.0, -1.0), (2.0, -0.398), (0.5, -0.398)])
    assert manifold(square(0.0, 0.0), ahead, 0.2) == []
    assert len(manifold(square(0.0, 0.0), Polygon([(0.5, -1.0), (2.0, -1.0), (2.0, -0.3), (0.5, -0.3)]), 0.2)) == 2


@pytest.mark.parametrize("gap", [0.0, 0.004, 0.012])
def test_a_hit_ends_at_the_wall_and_bounces_with_its_restitution(gap):
    body = robot(0.6 - gap, 0.0, (3.0, 0.0, 0.0))
    ((mean, end),) = solve_contacts([body], contacts_of(body, square(0.6 - gap, 0.0), WALL, restitution=0.2), H)
    after = 3.0 + end[0]
    assert after == pytest.approx(-0.6, abs=1e-6)
    share = gap / (3.0 * H)
    assert 3.0 + mean[0] == pytest.approx(3.0 * share - 0.6 * (1.0 - share), abs=1e-6), "up to the wall, and back"


def test_a_robot_that_leans_on_a_wall_stands_and_friction_holds_up_to_mu_n():
    """0.06 m/s in a step into the wall and 0.01 along it: it sticks; 0.03 along: mu N is taken of it."""
    for along, left in ((0.01, 0.0), (0.03, 0.03 - 0.35 * 0.06)):
        body = robot(0.6, 0.0, (0.0, 0.0, 0.0), (0.06, along, 0.0))
        ((mean, end),) = solve_contacts([body], contacts_of(body, square(0.6, 0.0), WALL, friction=0.35), H)
        assert 0.06 + end[0] == pytest.approx(0.0, abs=1e-8)
        assert 0.03 + mean[0] == pytest.approx(0.0, abs=1e-8)
        assert along + end[1] == pytest.approx(left, abs=1e-8)
        assert end[2] == pytest.approx(0.0, abs=1e-7), "the pressure goes to the front and holds the heading"


@given(
    yaw=st.floats(-0.7, 0.7),
    offset=st.floats(-0.7, 0.7),
    velocity=st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(-8.0, 8.0)),
    friction=st.floats(0.0, 1.0),
    restitution=st.floats(0.0, 1.0),
)
def test_two_robots_keep_momentum_gain_no_energy_and_stay_in_the_friction_cone(
    yaw, offset, velocity, friction, restitution
):
    a, b = robot(0.0, 0.0, velocity), robot(0.85, offset, (-0.5, 0.3, 1.0))
    found = contacts_of(a, square(0.0, 0.0), square(0.85, offset, yaw), b, friction=friction, restitution=restitution)
    changes = [end for _, end in solve_contacts([a, b], found, H)]
    total, energy = np.zeros(3), 0.0
    for body, (dx, dy, turn) in zip((a, b), changes, strict=True):
        mass, inertia, (x, y, _) = body.mass, body.inertia[2], body.center
        total += (mass * dx, mass * dy, inertia * turn + mass * (x * dy - y * dx))
        vx, vy, w = body.end
        energy += mass * (vx * dx + 0.5 * dx * dx + vy * dy + 0.5 * dy * dy) + inertia * (w * turn + 0.5 * turn * turn)
    assert total == pytest.approx(np.zeros(3), abs=1e-9)
    assert energy < 1e-6
    for contact in found:
        assert contact.normal >= 0.0
        assert abs(contact.tangent) <= friction * contact.normal + 1e-6


def test_the_slice_of_a_slanted_wall_is_what_it_has_at_that_height():
    """A wedge 1 m high, 1 m deep below and nothing above: between 0.2 and 0.5 m it is 0.8 m deep."""
    points = np.array([(x, y, z) for y in (0.0, 2.0) for x, z in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))])
    corners = slice_between(points, 0.2, 0.5)
    assert corners[:, 0].max() == pytest.approx(0.8) and np.ptp(corners[:, 1]) == pytest.approx(2.0)
    assert len(slice_between(points, 1.2, 1.5)) == 0
