"""Destination of each piece in a robot with several places for pieces."""

from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
from each_case import each

from simcore.match.piece_flow import PieceFlow
from simcore.robot.storage import Storage, StorageConfig
from simcore.world.rotation import IDENTITY


def flow_and_robot(held=(), *, placers=()):
    """Return a piece flow with coral in even slots and algae in odd slots, and a robot with some of them in storage."""
    state = SimpleNamespace(
        kind=np.array([0, 1] * 3), pos=np.zeros((6, 3)), vel=np.zeros((6, 3)), before=np.zeros((6, 3))
    )
    types = [SimpleNamespace(name="Coral"), SimpleNamespace(name="Algae")]
    pieces = Mock(state=state, types=types, mass=np.ones(6))
    storage = Storage(StorageConfig(capacity=5))
    storage.add(list(held))
    robot = SimpleNamespace(
        number=0, storage_of=lambda config: storage, placers=placers, intakes=(), balance=Mock(),
        pose_before=((0.0, 0.0, 0.0), IDENTITY), chassis=SimpleNamespace(pos=(0.0, 0.0, 0.0), quat=IDENTITY),
    )  # fmt: skip
    return PieceFlow(Mock(), pieces, [robot], Mock()), robot


@each(
    ("held", "kinds", "ready"),
    [((0, 2, 1, 4), ("Coral",), 2), ((1, 0, 2), ("Coral",), 0), ((0, 1, 2), (), 3), ((), ("Coral",), 0)],
)
def test_a_shooter_shoots_its_kinds_until_another_kind_is_next(held, kinds, ready):
    flow, robot = flow_and_robot(held)
    assert flow._ready(robot, SimpleNamespace(kinds=kinds)) == ready


def test_two_intakes_that_reach_one_piece_take_it_only_once():
    flow, robot = flow_and_robot()
    robot.intakes = [Mock(config=SimpleNamespace(kinds=(), roller="rollers")) for _ in range(2)]
    for intake in robot.intakes:
        intake.captured.return_value = np.array([True, True])
    flow._take_some_of(robot, np.array([2, 5]))
    assert robot.storage_of(None).pieces == [2, 5]


def test_an_intake_takes_nothing_while_its_roller_holds_a_placers_piece():
    jaw = SimpleNamespace(config=SimpleNamespace(roller="jaw"), piece=None)
    flow, robot = flow_and_robot((0,), placers=(jaw,))
    for piece, roller, room in ((None, "jaw", 4), (3, "jaw", 0), (3, "rollers", 4)):
        jaw.piece = piece
        assert flow._room_behind(robot, SimpleNamespace(config=SimpleNamespace(roller=roller, kinds=()))) == room


@each(("held", "at_handover", "takes"), [((0,), True, False), ((), True, True), ((0,), False, True)])
def test_a_placer_at_its_handover_takes_no_field_piece_while_the_storage_has_one(held, at_handover, takes):
    placer = Mock(takes=True, is_at_handover=at_handover, config=SimpleNamespace(kinds=()))
    placer.captured.return_value = np.array([True])
    flow, robot = flow_and_robot(held, placers=(placer,))
    flow._take_some_of(robot, np.array([2]))
    assert placer.take.call_args_list == ([((2,),)] if takes else [])
