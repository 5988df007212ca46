from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.physics.contact_law import REST_SPEED, RIGID, NormalLaw, excess, normal_law

H = 0.01


def law(gap: float, speed: float, free: float = 0.0, *, e: float = 0.5, k: float = RIGID, give=math.inf) -> NormalLaw:
    one = lambda value: np.array([value])  # noqa: E731
    return normal_law(
        one(gap), one(speed), one(free), one(1.0), restitution=one(e), stiffness=one(k), give=one(give), h=H
    )


def speed_after(found: NormalLaw, speed: float, free: float) -> float:
    """Of one contact alone: (A + r) f = a_ref - a_0, f >= 0, A = 1."""
    force = max(0.0, (found.reference[0] - free) / (1.0 + found.regularization[0]))
    return speed + (free + force) * H


@pytest.mark.parametrize(("k", "above"), [(1e4, 0.15), (RIGID, 0.25)])
@given(st.floats(0.0, 20.0), st.floats(0.01, 0.99), st.floats(0.0, 1.0), st.floats(-20.0, 0.0))
def test_an_impact_leaves_with_restitution_times_the_speed_of_meeting(k, above, v, phase, e, free):
    """Ballistic to the surface, bounce, and on for the rest of the step."""
    t, v = phase * H, v + above
    gap = v * t - free * t * t / 2.0
    found = law(gap, -v, free, e=e, k=k)
    meeting = v - free * t
    assert found.hits[0] and found.hit_time[0] == pytest.approx(t, rel=1e-9)
    expected = max(0.0, e * meeting + free * (H - t))
    assert speed_after(found, -v, free) == pytest.approx(expected, abs=1e-9)


def test_rigid_bodies_do_not_bounce_with_what_a_push_gives_them_in_a_step():
    """0.15 m/s is less than 20 m/s^2 times a step of 10 ms: a robot that leans on a wall. A soft ball bounces."""
    assert not law(0.0002, -0.15).hits[0]
    assert law(0.0002, -0.15, k=1e4, give=0.03).hits[0]


def test_what_is_not_reached_is_let_be():
    found = law(0.1, -1.0)
    assert not found.hits[0] and speed_after(found, -1.0, 0.0) == -1.0


def test_what_is_slow_ends_at_the_surface_without_a_bounce():
    gap, speed = 0.0002, -0.5 * REST_SPEED
    found = law(gap, speed)
    assert not found.hits[0] and speed_after(found, speed, 0.0) == pytest.approx(-gap / H, rel=2e-3)


@given(st.floats(1e-5, 0.03), st.floats(1e3, 1e5))
def test_under_load_the_force_at_rest_is_stiffness_times_squeeze(depth, k):
    """At rest v = 0 and f = -a_0 (mass 1), so the squeeze f / k is where the law asks for no acceleration."""
    found = law(-depth, 0.0, -k * depth, k=k)
    assert found.loaded[0] and speed_after(found, 0.0, -k * depth) == pytest.approx(0.0, abs=1e-6 * k)


@pytest.mark.parametrize("k", [5e3, 2e4, RIGID])
@pytest.mark.parametrize("h", [0.001, 0.005, 0.01])
def test_a_spring_never_gives_back_more_than_it_took(k, h):
    depth, speed, energy = 0.004, 0.0, 0.5 * k * 0.004**2
    for _ in range(500):
        one = lambda value: np.array([value])  # noqa: E731
        found = normal_law(
            one(-depth), one(speed), one(0.0), one(1.0), restitution=one(0.9), stiffness=one(k), give=one(1.0), h=h
        )
        if depth <= 0.0:
            break
        speed += max(0.0, found.reference[0] / (1.0 + found.regularization[0])) * h
        depth -= speed * h
    assert 0.5 * speed**2 <= energy * (1.0 + 1e-9)


def test_a_soft_contact_is_rigid_when_it_is_squeezed_through():
    assert law(-0.05, 0.0, k=1e4, give=0.03).force[0] == pytest.approx(1e4 * 0.03 + RIGID * 0.02, rel=0.1)


def test_excess_is_what_friction_cannot_give():
    wish, free = np.array([[3.0, 4.0], [0.3, 0.4]]), np.zeros((2, 2))
    assert excess(wish, free, np.array([2.0, 2.0])) == pytest.approx([3.0, 0.0])
