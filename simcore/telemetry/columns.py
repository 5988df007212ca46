"""Numbers of a run as columns: each key has its column for good, and a tick is one row of each type.

Columns only grow: a key that comes late has the next one. A value that is not published in a tick is a gap, a number
that no computation makes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from simcore.errors import ConfigError
from simcore.loop.compiled import compiled
from simcore.typing import BoolArray, IntArray

__all__ = ["FIELDS", "GAP", "Changes", "Columns", "Table"]

Block = npt.NDArray[Any]
"""A row of all columns of one type, shape (n,); of poses (n, 7)."""

_GAP_BITS = 0x7FF8_0000_DEAD_0001
GAP = float(np.array(_GAP_BITS).view(np.float64))
"""A double that stands for no value."""
FIELDS: dict[str, tuple[Any, tuple[int, ...], Any]] = {
    "poses": (np.float64, (7,), GAP),
    "doubles": (np.float64, (), GAP),
    "integers": (np.int64, (), -0x7FF8_DEAD_BEEF_0001),
    "booleans": (np.uint8, (), 255),
}
"""Type, shape and gap of a value, by the field of a `Snapshot`."""


class Table:
    """Keys of one type, each with its column.

    Args:
        field: Field of a snapshot, one of `FIELDS`.
        keys: Those that have columns from the beginning.
    """

    def __init__(self, field: str, keys: Iterable[str] = ()) -> None:
        self.field = field
        self.dtype, self.shape, self.gap = FIELDS[field]
        self.keys = list(keys)
        """Keys in the order of columns."""
        self.places = {key: place for place, key in enumerate(self.keys)}
        """Column of each key."""
        self._other: tuple[Table | None, IntArray, bool] = (None, np.zeros(0, np.int64), False)

    def place(self, key: str) -> int:
        """Return the column of a key, the next one if it is new."""
        if key not in self.places:
            self.places[key] = len(self.keys)
            self.keys.append(key)
        return self.places[key]

    def empty(self, *rows: int) -> Block:
        """Return a row of gaps, or some."""
        return np.full((*rows, len(self.keys), *self.shape), self.gap, self.dtype)

    def gaps(self, block: Block) -> BoolArray:
        """Return where rows have gaps."""
        bits = block[..., 0] if self.shape else block
        found: BoolArray = bits.view(np.int64) == _GAP_BITS if self.dtype == np.float64 else bits == self.gap
        return found

    def values(self, block: Block) -> Any:
        """Return the values of a row as a snapshot has them, gaps too."""
        return block if self.shape else block.astype(bool).tolist() if self.dtype == np.uint8 else block.tolist()

    def row(self, values: Mapping[str, Any]) -> Block:
        """Return values by key as a row of this table; new keys get columns.

        Raises:
            ConfigError: A pose has another shape.
        """
        if isinstance(values, Columns):
            (known, places, is_same), block = self._other, values.block
            if known is not values.table or len(places) < len(block):
                places = np.array([self.place(key) for key in values.table.keys[: len(block)]], np.int64)
                is_same = bool((places == np.arange(len(places))).all())
                self._other = values.table, places, is_same
            if is_same and len(block) == len(self.keys):
                return block
            places = places[: len(block)]
        else:
            places = np.array([self.place(key) for key in values], np.int64)
            for key, value in values.items() if self.shape else ():
                if np.shape(value) != self.shape:
                    raise ConfigError(
                        f"{key}: a pose needs shape (7,) as x, y, z, qw, qx, qy, qz, got {np.shape(value)}"
                    )
            block = np.array(list(values.values()), self.dtype).reshape(-1, *self.shape)
        row = self.empty()
        row[places] = block
        return row


class Columns(Mapping[str, Any]):
    """A row of a table, read by key."""

    __slots__ = ("_made", "block", "table")

    def __init__(self, table: Table, block: Block) -> None:
        self.table, self.block = table, block
        block.setflags(write=False)
        self._made: dict[str, Any] | None = None

    @property
    def _values(self) -> dict[str, Any]:
        if self._made is None:
            values, gaps = self.table.values(self.block), self.table.gaps(self.block).tolist()
            rows = zip(self.table.keys, values, gaps, strict=False)  # the table may have grown
            self._made = {key: value for key, value, is_gap in rows if not is_gap}
        return self._made

    def __getitem__(self, key: str) -> Any:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return repr(self._values)


class Changes:
    """Finds what is new in each row, for who keeps what was before."""

    def __init__(self, field: str) -> None:
        self.table = Table(field)
        self._last = self.table.empty()

    def of(self, values: Mapping[str, Any]) -> tuple[IntArray, Block]:
        """Return the columns whose values differ from those of before, bit by bit, and these; gaps are passed over."""
        table = self.table
        row = table.row(values)
        if len(self._last) < len(row):
            last, self._last = self._last, table.empty()
            self._last[: len(last)] = last
        is_float, found = table.dtype == np.float64, np.empty(len(row), np.int64)
        bits, gap = (np.int64, _GAP_BITS) if is_float else (table.dtype, table.gap)
        width = math.prod(table.shape)
        rows, last = (block.view(bits).reshape(-1, width) for block in (row, self._last))
        columns = found[: _note_changes(rows, last, gap, found)]
        return columns, row.take(columns, axis=0)


@compiled
def _note_changes(rows: Block, last: Block, gap: int, found: IntArray) -> int:
    """Find the rows that differ from the last ones and are no gaps, note them as the last; return how many."""
    count = 0
    for k in range(len(rows)):
        if rows[k, 0] != gap and (rows[k] != last[k]).any():
            last[k] = rows[k]
            found[count] = k
            count += 1
    return count
