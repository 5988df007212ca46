"""Columns: each key keeps its own, gaps are no values, and only what is new comes out of `Changes`."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.channel import Channel
from simcore.errors import ConfigError, UnknownNameError
from simcore.match.match import Match
from simcore.telemetry.columns import FIELDS, Changes, Columns, Table


def test_a_row_is_read_by_key_without_its_gaps_also_after_the_table_has_grown() -> None:
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
def test_rows_of_another_table_and_mappings_find_their_own_columns(field: str) -> None:
    shape = FIELDS[field][1]
    values = {key: np.full(shape, k) if shape else k for k, key in enumerate("ab")}
    other, mine = Table(field), Table(field)
    mine.place("b")
    block = other.row(values)
    for row in (mine.row(Columns(other, block)), mine.row(values)):
        assert mine.keys == ["b", "a"]
        assert np.array_equal(row, block[::-1])
    assert other.row(Columns(other, block)) is block, "its own row as it is"


def test_what_changes_comes_once_bit_by_bit() -> None:
    changes = Changes("doubles")
    rows = [{"x": 0.0, "y": 1.0}, {"x": -0.0, "y": 1.0}, {"y": 1.0}, {"x": -0.0, "z": math.nan}, {"z": math.nan}]
    found = [changes.of(row) for row in rows]
    keys = [[changes.table.keys[column] for column in columns] for columns, _ in found]
    assert keys == [["x", "y"], ["x"], [], ["z"], []]
    assert math.copysign(1.0, found[1][1][0]) == -1.0


def test_a_robot_program_adds_a_channel_with_one_line_at_any_time() -> None:
    with Match.bare() as match:
        match.tick()
        assert "Sim/Turns" not in match.snapshot().doubles
        match.robots[0].channels.append(Channel("Turns", "double", lambda robot: robot.number + 1 / 3, "", decimals=2))
        match.tick()
        assert match.snapshot().doubles["Sim/Turns"] == 0.33
        match.robots[0].channels.append(Channel("Turns", "double", lambda robot: 0.0, ""))
        with pytest.raises(ConfigError, match="'Sim/Turns' is declared twice"):
            match.snapshot()


def test_a_channel_has_one_of_the_kinds() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'boolean'"):
        Channel("IsHome", "bool", lambda robot: True, "")
