"""What pyproject.toml lists to be compiled means the same in plain Python."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIST = re.search(
    r"^\[tool\.hatch\.build\.targets\.wheel\.hooks\.custom\]\nmodules = \[\n(.*?)^\]",
    (ROOT / "pyproject.toml").read_text(encoding="utf-8"),
    re.MULTILINE | re.DOTALL,
)
assert LIST is not None
MODULES = re.findall(r'"([\w.]+)"', LIST[1])


def source_of(module: str) -> Path:
    return ROOT / f"{module.replace('.', '/')}.py"


def test_every_module_of_the_list_has_a_source_and_stands_there_once():
    assert len(MODULES) > 70 and sorted(set(MODULES)) == MODULES
    assert [module for module in MODULES if not source_of(module).is_file()] == []


@pytest.mark.parametrize("module", MODULES)
def test_no_sum_of_a_generator(module):
    """Since 3.12 `sum` of floats is compensated; compiled, it is a plain loop over a generator: other last bits."""
    calls = [
        node.lineno
        for node in ast.walk(ast.parse(source_of(module).read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "sum" and node.args
        if isinstance(node.args[0], ast.GeneratorExp)
    ]
    assert calls == [], "write sum([...])"


def test_no_interpreted_class_derives_from_a_compiled_one():
    """mypyc forbids it: the module of the one or of the other has to change sides."""
    wrong = []
    for path in [p for top in ("simcore", "games", "examples") for p in (ROOT / top).rglob("*.py")]:
        if ".".join(path.relative_to(ROOT).with_suffix("").parts) in MODULES:
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        compiled = {
            alias.asname or alias.name
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module in MODULES
            for alias in node.names
        }
        wrong += [
            f"{path.relative_to(ROOT)}: {node.name}({ast.unparse(base)})"
            for node in ast.walk(tree)
            if isinstance(node, ast.ClassDef)
            for base in node.bases
            if ast.unparse(base).partition("[")[0] in compiled
        ]
    assert wrong == []


def test_constants_of_compiled_classes_are_class_variables():
    """Compiled, a plain assignment in a class body is a default of instances: read from the class it is a descriptor,
    which compares unequal to everything without a word. `ClassVar` makes it one of the class; enums are as in Python.
    """
    plain, inherited = set(), set()
    for module in MODULES:
        for node in ast.walk(ast.parse(source_of(module).read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef) and not any("num" in ast.unparse(base) for base in node.bases):
                for line in node.body:
                    if isinstance(line, ast.Assign):
                        plain |= {(node.name, ast.unparse(target)) for target in line.targets}
                    elif isinstance(line, ast.AnnAssign) and "ClassVar" in ast.unparse(line.annotation):
                        inherited.add(ast.unparse(line.target))  # a subclass assigns without saying so again
                    elif isinstance(line, ast.AnnAssign):
                        plain.add((node.name, ast.unparse(line.target)))
    read = {
        f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)}"
        for top in ("simcore", "games", "examples", "tests", "scripts")
        for path in (ROOT / top).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and (ast.unparse(node.value).rpartition(".")[2], node.attr) in plain
        if node.attr not in inherited
    }
    assert sorted(read) == []
