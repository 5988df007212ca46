"""Floats are summed from left to right: the builtin `sum` gives other last bits on Python 3.12 and later."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted([*(ROOT / "simcore").rglob("*.py"), *(ROOT / "games").rglob("*.py")])

WHOLE_NUMBERS = {
    "simcore/match/report.py:print_report": "counts of pieces",
    "simcore/pieces/pool.py:__init__": "counts of pieces",
    "simcore/phoenix6_emulator/emulated_talon.py:receive": "asks only whether a field is NaN",
}
"""Where `sum` adds no floats, or only their being finite counts: file:function and the reason."""


def is_whole(node: ast.expr) -> bool:
    """Whether an expression is an int or a bool whatever its parts are."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int)
    if isinstance(node, ast.Compare):
        return True
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, ast.Not) or is_whole(node.operand)
    if isinstance(node, ast.BoolOp):
        return all(map(is_whole, node.values))
    if isinstance(node, ast.BinOp):
        return not isinstance(node.op, ast.Div) and is_whole(node.left) and is_whole(node.right)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        return node.func.id in ("len", "int", "bool", "isinstance")
    return False


def float_sums(tree: ast.AST, function: str = "") -> Iterator[tuple[str, int]]:
    """Calls of the builtin `sum` over what may be floats: innermost function and line."""
    for node in ast.iter_child_nodes(tree):
        inside = node.name if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) else function
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "sum" and node.args:
            added = node.args[0]
            if not (isinstance(added, (ast.GeneratorExp, ast.ListComp)) and is_whole(added.elt)):
                yield function, node.lineno
        yield from float_sums(node, inside)


def test_no_builtin_sum_of_floats():
    wrong = []
    for path in SOURCES:
        name = path.relative_to(ROOT).as_posix()
        for function, line in float_sums(ast.parse(path.read_text(encoding="utf-8"))):
            if f"{name}:{function}" not in WHOLE_NUMBERS:
                wrong.append(f"{name}:{line} in {function}: use simcore.units.plain_sum or math.fsum")
    assert wrong == []


@pytest.mark.parametrize("code", ["sum(x)", "sum(a * b for a in b)", "sum([x.mass for x in xs])", "sum(x, 0.0)"])
def test_the_scan_finds_sums_that_may_be_of_floats(code):
    assert list(float_sums(ast.parse(code)))


@pytest.mark.parametrize("code", ["sum(a > b for a in b)", "sum(len(f) - 2 for f in fs)", "sum(1 for x in xs if x)"])
def test_the_scan_lets_counts_pass(code):
    assert not list(float_sums(ast.parse(code)))
