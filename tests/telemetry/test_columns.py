"""Columns: each key keeps its column, gaps have no value, and `Changes` yields only new values."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.channel import Channel
from simcore.errors import ConfigError, UnknownNameError
from simcore.match.match import Match
from simcore.telemetry.columns import FIELDS, Changes, Columns, Table


def test_a_row_is_read_by_key_without_gaps_even_after_the_table_has_grown() -> None:
    table = Table("integers")
    assert [table.place(key) for key in ("a", "b", "a", "c")] == [0, 1, 0, 2]
    block = table.empty()
    block[[0, 2]] = 7, -(2**63)
    row = Columns(table, block)
    table.place("late")
    assert dict(row) == {"a": 7, "c": -(2**63)} and "b" not in row and type(row["a"]) is int
    with pytest.raises(ValueError, match="read-only"):
        row.block[0] = 1


@pytest.mark.parametrize("field", FIELDS)
def test_rows_of_other_tables_and_mappings_are_moved_to_the_right_columns(field: str) -> None:
    shape = FIELDS[field][1]
    values = {key: np.full(shape, k) if shape else k for k, key in enumerate("ab")}
    other, mine = Table(field), Table(field)
    mine.place("b")
    block = other.row(values)
    for row in (mine.row(Columns(other, block)), mine.row(values)):
        assert mine.keys == ["b", "a"]
        assert np.array_equal(row, block[::-1])
    assert other.row(Columns(other, block)) is block, "its own row as it is"


def test_a_change_is_yielded_once_and_compared_bit_by_bit() -> None:
    changes = Changes("doubles")
    rows = [{"x": 0.0, "y": 1.0}, {"x": -0.0, "y": 1.0}, {"y": 1.0}, {"x": -0.0, "z": math.nan}, {"z": math.nan}]
    found = [changes.of(row) for row in rows]
    keys = [[changes.table.keys[column] for column in columns] for columns, _ in found]
    assert keys == [["x", "y"], ["x"], [], ["z"], []]
    assert math.copysign(1.0, found[1][1][0]) == -1.0


def test_a_robot_program_can_add_a_channel_at_any_time() -> None:
    with Match.bare() as match:
        match.tick()
        assert "Sim/Turns" not in match.snapshot().doubles
        match.robots[0].channels.append(Channel("Turns", "double", lambda robot: robot.number + 1 / 3, "", decimals=2))
        match.tick()
        assert match.snapshot().doubles["Sim/Turns"] == 0.33
        match.robots[0].channels.append(Channel("Turns", "double", lambda robot: 0.0, ""))
        with pytest.raises(ConfigError, match="'Sim/Turns' is declared twice"):
            match.snapshot()


def test_a_channel_of_an_unknown_kind_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'boolean'"):
        Channel("IsHome", "bool", lambda robot: True, "")
