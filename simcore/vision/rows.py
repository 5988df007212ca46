"""3 x 3 matrices as three rows of plain floats: for single ones half the time of arrays, and no objects made."""

from __future__ import annotations

from simcore.geometry.quaternion import Vector
from simcore.typing import FloatArray

__all__ = ["Rows", "apply", "apply_back", "as_rows", "times", "times_back", "transposed"]

Rows = tuple[Vector, Vector, Vector]


def as_rows(a: Rows | FloatArray) -> Rows:
    """An array of shape (3, 3) as rows; rows stay what they are."""
    if isinstance(a, tuple):
        return a
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = a.tolist()
    return (a00, a01, a02), (a10, a11, a12), (a20, a21, a22)


def transposed(a: Rows) -> Rows:
    """The transpose a^T."""
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = a
    return (a00, a10, a20), (a01, a11, a21), (a02, a12, a22)


def apply(a: Rows, v: Vector) -> Vector:
    """Its product a v with a vector."""
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = a
    x, y, z = v
    return a00 * x + a01 * y + a02 * z, a10 * x + a11 * y + a12 * z, a20 * x + a21 * y + a22 * z


def apply_back(a: Rows, v: Vector) -> Vector:
    """The product a^T v: for a rotation, its inverse."""
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = a
    x, y, z = v
    return a00 * x + a10 * y + a20 * z, a01 * x + a11 * y + a21 * z, a02 * x + a12 * y + a22 * z


def times(a: Rows, b: Rows) -> Rows:
    """Their product a b."""
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = a
    (b00, b01, b02), (b10, b11, b12), (b20, b21, b22) = b
    return (
        (a00 * b00 + a01 * b10 + a02 * b20, a00 * b01 + a01 * b11 + a02 * b21, a00 * b02 + a01 * b12 + a02 * b22),
        (a10 * b00 + a11 * b10 + a12 * b20, a10 * b01 + a11 * b11 + a12 * b21, a10 * b02 + a11 * b12 + a12 * b22),
        (a20 * b00 + a21 * b10 + a22 * b20, a20 * b01 + a21 * b11 + a22 * b21, a20 * b02 + a21 * b12 + a22 * b22),
    )


def times_back(a: Rows, b: Rows) -> Rows:
    """Their product a^T b."""
    return times(transposed(a), b)
