"""What is asked of runs, as text: `score >= 30`, `hits == shots and brownouts == 0`, `hits / shots`."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, UnknownNameError

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["evaluate", "names_in", "no_condition"]

_ARITHMETIC: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_EXAMPLE = "want columns, numbers, + - * /, comparisons, and, or, not, e.g. 'score >= 30 and brownouts == 0'"


def evaluate(table: pd.DataFrame, text: str) -> pd.Series:
    """The value of an expression in each row; True and False where it is a condition.

    >>> import pandas as pd
    >>> runs = pd.DataFrame({"score": [28, 32, 35], "battery.charge": [0.3, 1.0, 1.0]})
    >>> evaluate(runs, "score >= 30 and battery.charge > 0.5").tolist()
    [False, True, True]

    Args:
        table: A row a run.
        text: Of names of columns, numbers, words in quotes, `+ - * /`, comparisons, `and`, `or`, `not`.

    Raises:
        ConfigError: It is none of these.
        UnknownNameError: There is no such column; the text lists those that there are.
    """
    if text in table.columns:
        return table[text]
    value = _value(table, _parsed(text), text)
    import pandas as pd

    return value if isinstance(value, pd.Series) else pd.Series([value] * len(table), index=table.index)


def names_in(text: str) -> list[str]:
    """The columns that an expression reads, in order.

    >>> names_in("hits / shots >= 0.9 and battery.charge < 1")
    ['hits', 'shots', 'battery.charge']
    """
    found: list[str] = []

    def visit(node: ast.AST) -> None:
        name = _dotted(node)
        if name is None:
            for child in ast.iter_child_nodes(node):
                visit(child)
        elif name not in found:
            found.append(name)

    visit(_parsed(text))
    return found


def no_condition(text: str) -> ConfigError:
    """What to raise where a condition is wanted, and an expression is neither true nor false."""
    return ConfigError(f"{text!r} is no condition: compare it with something, e.g. 'score >= 30'")


def _parsed(text: str) -> ast.expr:
    try:
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError) as error:
        raise ConfigError(f"{text!r} cannot be read: {_EXAMPLE}") from error


def _dotted(node: ast.AST) -> str | None:
    """A name, or names joined by dots; None for anything else."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute) and (owner := _dotted(node.value)) is not None:
        return f"{owner}.{node.attr}"
    return None


def _value(table: pd.DataFrame, node: ast.expr, text: str) -> Any:
    name = _dotted(node)
    if name is not None:
        if name not in table.columns:
            raise UnknownNameError("column", name, map(str, table.columns))
        return table[name]
    if isinstance(node, ast.Constant) and isinstance(node.value, (bool, int, float, str)):
        return node.value
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -_value(table, node.operand, text)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return np.logical_not(_value(table, node.operand, text))
    if isinstance(node, ast.BinOp) and type(node.op) in _ARITHMETIC:
        left, right = (_value(table, side, text) for side in (node.left, node.right))
        if isinstance(left, str) or isinstance(right, str):
            raise ConfigError(f"{text!r} calculates with words: {_EXAMPLE}")
        return _ARITHMETIC[type(node.op)](left, right)
    if isinstance(node, ast.BoolOp):
        join = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
        result = _value(table, node.values[0], text)
        for other in node.values[1:]:
            result = join(result, _value(table, other, text))
        return result
    if isinstance(node, ast.Compare) and all(type(op) in _COMPARISONS for op in node.ops):
        sides = [_value(table, side, text) for side in (node.left, *node.comparators)]
        result = True
        for op, left, right in zip(node.ops, sides[:-1], sides[1:], strict=True):
            result = np.logical_and(result, _COMPARISONS[type(op)](left, right))
        return result
    raise ConfigError(f"{text!r} has {ast.unparse(node)!r} in it: {_EXAMPLE}")
