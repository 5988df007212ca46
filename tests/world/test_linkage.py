"""Chains of joints: poses computed by hand, and motion by numerical differentiation."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError, UnknownNameError
from simcore.world.linkage import Joint, part_pose, part_state, require_mechanisms
from simcore.world.rotation import matrix

angle = st.floats(-3.0, 3.0)
unit = st.tuples(angle, angle, angle).filter(lambda v: math.hypot(*v) > 0.1)
joint = st.builds(
    lambda name, axis, origin, slides, ratio: Joint(
        mechanism=name, axis=tuple(c / math.hypot(*axis) for c in axis), origin=origin, slides=slides, ratio=ratio
    ),
    st.sampled_from("ab"), unit, st.tuples(angle, angle, angle), st.booleans(), st.sampled_from([1.0, -0.5]),
)  # fmt: skip


def motion(position=0.0, velocity=0.0):
    return SimpleNamespace(position=position, velocity=velocity)


def test_the_pose_of_an_arm_on_an_elevator_follows_both_joints():
    """The lift is 0.3 m up, and the part is 0.5 m out on an arm raised by 60 degrees."""
    lift = Joint(mechanism="lift", axis=(0.0, 0.0, 1.0), slides=True, ratio=0.02, origin=(0.1, 0.0, 0.2))
    arm = Joint(mechanism="arm", axis=(0.0, -1.0, 0.0), origin=(0.0, 0.05, 0.0))
    mechanisms = {"lift": motion(15.0), "arm": motion(math.pi / 3)}
    pos, quat = part_pose((lift, arm), mechanisms, (0.5, 0.0, 0.0))
    assert pos == pytest.approx((0.1 + 0.25, 0.05, 0.5 + 0.5 * math.sqrt(0.75)))
    assert matrix(quat)[:, 0] == pytest.approx((0.5, 0.0, math.sqrt(0.75)))


def test_a_part_without_joints_is_fixed():
    assert part_pose((), {}, (0.1, 0.2, 0.3)) == ((0.1, 0.2, 0.3), (0.0, 0.0, 0.0, 1.0))
    assert part_state((), {}).vel == (0.0, 0.0, 0.0)


@given(st.lists(joint, max_size=4), angle, angle, angle, angle, st.tuples(angle, angle, angle))
def test_the_motion_of_a_part_is_the_derivative_of_its_pose(joints, a, b, da, db, offset):
    """Central differences over 2e-6 s have errors of 1e-10 from rounding and 1e-9 from terms that they leave out."""
    h = 1e-6

    def at(t):
        return part_pose(joints, {"a": motion(a + da * t), "b": motion(b + db * t)}, offset)

    (before, q0), (after, q1) = at(-h), at(h)
    state = part_state(joints, {"a": motion(a, da), "b": motion(b, db)}, offset)
    assert (state.pos, state.quat) == at(0.0)
    assert np.array(state.vel) == pytest.approx((np.array(after) - before) / (2 * h), abs=1e-6)
    spin = (matrix(q1) - matrix(q0)) / (2 * h) @ matrix(state.quat).T  # the skew matrix of omega
    assert np.array(state.rate) == pytest.approx([spin[2, 1], spin[0, 2], spin[1, 0]], abs=1e-6)


def test_invalid_joints_are_refused():
    with pytest.raises(ConfigError, match="unit vector"):
        Joint(mechanism="a", axis=(1.0, 1.0, 0.0))
    with pytest.raises(ConfigError, match="ratio"):
        Joint(mechanism="a", axis=(1.0, 0.0, 0.0), ratio=math.nan)
    with pytest.raises(UnknownNameError, match=r"for an intake.*Did you mean 'roller'"):
        require_mechanisms("an intake", [None, "rollr"], ["roller"])
