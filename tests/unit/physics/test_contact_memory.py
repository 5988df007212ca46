"""Contacts of a step are found again by the pair of shapes, and only those that push are kept."""

from __future__ import annotations

import numpy as np
from simcore.physics.contact_memory import ContactMemory


def test_nothing_is_known_at_first():
    known, sliding, friction = ContactMemory(9).recall(np.array([1, 2]), np.array([3, 4]))
    assert not known.any()
    assert sliding.shape == (2,)
    assert friction.shape == (2, 3)


def test_a_contact_is_found_again_in_any_order_and_those_of_one_pair_in_theirs():
    memory = ContactMemory(9)
    pushes = np.array([True, True, True, False])
    friction = np.arange(12.0).reshape(4, 3)
    memory.keep(np.array([5, 1, 5, 2]), np.array([6, 3, 6, 4]), pushes, np.array([0.1, 0.2, 0.3, 0.4]), friction)
    known, sliding, found = memory.recall(np.array([2, 5, 1, 5, 6, 5]), np.array([4, 6, 3, 6, 5, 6]))
    assert known.tolist() == [False, True, True, True, False, False]
    assert sliding[known].tolist() == [0.1, 0.2, 0.3]
    assert found[known].tolist() == friction[[0, 1, 2]].tolist()


def test_what_no_longer_touches_is_forgotten():
    memory = ContactMemory(9)
    one = np.array([True])
    memory.keep(np.array([1]), np.array([3]), one, np.array([0.1]), np.ones((1, 3)))
    memory.keep(np.array([2]), np.array([4]), one, np.array([0.2]), np.ones((1, 3)))
    assert memory.recall(np.array([1, 2]), np.array([3, 4]))[0].tolist() == [False, True]
