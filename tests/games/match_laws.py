"""Matches of scripted players, and laws that hold at every tick."""

from __future__ import annotations

import math

import numpy as np

from simcore.match.match import Match
from simcore.match.players.lineup import entries, lineup, take_seats
from simcore.pieces.pool import PieceStatus


def require_one_owner(match):
    """Check that pieces are conserved, robots and pieces agree on holders, and the record belongs to this run."""
    state = match.pieces.state
    assert match.count.is_conserved
    for robot in match.robots:
        held = np.nonzero((state.status == PieceStatus.HELD) & (state.holder == robot.number))[0]
        assert sorted(robot.held) == held.tolist()
    assert np.isfinite(state.pos).all()
    record = match.record
    assert record.hits <= len(record.shots) and set(record.flying) <= {shot.slot for shot in record.shots}
    for robot, own in zip(match.robots, record.robots, strict=True):
        assert math.isfinite(own.distance) and own.battery is robot.battery
        assert own.battery.min_voltage <= robot.battery.voltage


def show_time(match: Match, time: float) -> None:
    """Set the match clock to a time [s]."""
    match.timer._start, match.timer._ticks = time, 0
    match.timer.time = time


def match_of(game, sides, *, at=0.0, seed=1, options=()):
    """Return a match with its players and the match clock at a time [s]."""
    seats = lineup(game, **sides)
    match = Match(game, robots=entries(game, seats), seed=seed, options=options)
    show_time(match, at)
    take_seats(match, seats)
    return match
