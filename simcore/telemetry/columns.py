"""Tables of the numbers of a run: each type of value has a table, with a column for each key and a row for each tick.

A new key gets the next column. A gap marks a value that is not published in a tick. A gap is a number that no
computation yields.
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
"""Row of a table with n columns: values of one type, shape (n,), or (n, 7) for poses."""

_GAP_BITS = 0x7FF8_0000_DEAD_0001
GAP = float(np.array(_GAP_BITS).view(np.float64))
"""NaN with the bits `_GAP_BITS`, which marks a missing float value."""
FIELDS: dict[str, tuple[Any, tuple[int, ...], Any]] = {
    "poses": (np.float64, (7,), GAP),
    "doubles": (np.float64, (), GAP),
    "integers": (np.int64, (), -0x7FF8_DEAD_BEEF_0001),
    "booleans": (np.uint8, (), 255),
}
"""Numpy type of the values, shape of a value, and number that marks a gap, by field of `Snapshot`."""


class Table:
    """Assignment of keys to columns, for values of one type.

    Args:
        field: Field of `Snapshot` with the values, a key of `FIELDS`.
        keys: Keys of the first columns, in order.
    """

    def __init__(self, field: str, keys: Iterable[str] = ()) -> None:
        self.field = field
        self.dtype, self.shape, self.gap = FIELDS[field]
        self.keys = list(keys)
        """Keys in the order of the columns."""
        self.places = {key: place for place, key in enumerate(self.keys)}
        """Column index of each key."""
        self._other: tuple[Table | None, IntArray, bool] = (None, np.zeros(0, np.int64), False)

    def place(self, key: str) -> int:
        """Return the column of a key; a new key gets the next column."""
        if key not in self.places:
            self.places[key] = len(self.keys)
            self.keys.append(key)
        return self.places[key]

    def empty(self, *rows: int) -> Block:
        """Return a row in which all values are gaps, or an array of such rows, with `rows` as the first dimensions."""
        return np.full((*rows, len(self.keys), *self.shape), self.gap, self.dtype)

    def gaps(self, block: Block) -> BoolArray:
        """Return a mask of the gaps in one or several rows; the mask has no dimension for the pose components."""
        bits = block[..., 0] if self.shape else block
        found: BoolArray = bits.view(np.int64) == _GAP_BITS if self.dtype == np.float64 else bits == self.gap
        return found

    def values(self, block: Block) -> Any:
        """Return the values of a row, including gaps: a list of Python values, or an array of poses."""
        return block if self.shape else block.astype(bool).tolist() if self.dtype == np.uint8 else block.tolist()

    def row(self, values: Mapping[str, Any]) -> Block:
        """Return a row of this table with the given values and gaps for all other keys; new keys get columns.

        Raises:
            ConfigError: If a pose does not have shape (7,).
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
    """Read-only mapping from keys to the values of a table row, without the gaps."""

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
    """Detector of values that differ from the previous value of the same key."""

    def __init__(self, field: str) -> None:
        self.table = Table(field)
        self._last = self.table.empty()

    def of(self, values: Mapping[str, Any]) -> tuple[IntArray, Block]:
        """Return the columns whose values have changed bitwise since the last call, and the new values; ignore gaps."""
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
    """Write the indices of changed rows to `found`, copy the changed rows to `last`, and return the number of changes.

    Args:
        rows: Bits of the new values, shape (n, width).
        last: Bits of the last values, shape (n, width), updated in place.
        gap: Bits that mark a gap; rows with a gap are ignored.
        found: Output for the indices of changed rows, shape (n,).
    """
    count = 0
    for k in range(len(rows)):
        if rows[k, 0] != gap and (rows[k] != last[k]).any():
            last[k] = rows[k]
            found[count] = k
            count += 1
    return count
