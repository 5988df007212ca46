"""What a contact is stands in one module: no other one has a number of a contact, or multiplies factors of a pair."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LAW = ROOT / "simcore" / "physics" / "contact_law.py"
FOLDERS = ("physics", "pieces", "shooting", "match")
SOURCES = [
    *(path for folder in FOLDERS for path in sorted((ROOT / "simcore" / folder).rglob("*.py")) if path != LAW),
    ROOT / "simcore" / "robot" / "chassis.py",
    ROOT / "simcore" / "robot" / "chassis_config.py",
]
"""All that makes, finds or solves contacts. Materials and pieces of a game are its data; tires are no contacts of
an engine and have their law in `tire_solver`."""

RULE = re.compile(
    r"friction|restitution|bounc|stiff|damping|compliance|rolling(?!_r)|relaxation|slip|hardness|rigid|erp$|push_out|"
    r"hit_speed",
    re.IGNORECASE,
)
FACTOR = re.compile(r"(?:^|_)(friction|restitution)(?:_|$)", re.IGNORECASE)
NEUTRAL = {0.0, 1.0}
"""Numbers that switch a term off or leave it as it is."""

NO_CONTACTS = {
    ("simcore/physics/hanging.py", "damping"): "of a pendulum: the chain and the air take it, no surface",
    ("simcore/match/scatter.py", "restitution"): "by how much pieces differ, in parts of what the law says",
    ("simcore/match/scatter.py", "tread_friction"): "of tires",
}


def named(node: ast.AST | None) -> str:
    """The last name of what an expression or target refers to, empty if it is none."""
    if isinstance(node, ast.Subscript):
        return named(node.value)
    if isinstance(node, ast.Tuple):
        return " ".join(map(named, node.elts))
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    return getattr(node, "id", None) or getattr(node, "attr", None) or getattr(node, "arg", None) or ""


def numbers(node: ast.AST | None) -> list[float]:
    """Literals that make up an expression, not those of calls and comparisons in it: these are looked at themselves."""
    if isinstance(node, ast.Constant):
        is_number = isinstance(node.value, int | float) and not isinstance(node.value, bool)
        return [float(node.value)] if is_number and float(node.value) not in NEUTRAL else []
    if isinstance(node, ast.UnaryOp):
        return numbers(node.operand)
    if isinstance(node, ast.BinOp):
        return numbers(node.left) + ([] if isinstance(node.op, ast.Pow) else numbers(node.right))
    if isinstance(node, ast.Tuple | ast.List):
        return [number for one in node.elts for number in numbers(one)]
    if isinstance(node, ast.Dict):
        return [number for one in node.values for number in numbers(one)]
    return []


def pairs(tree: ast.AST) -> Iterator[tuple[int, ast.AST | None, ast.AST | None]]:
    """Line, what has a name, and what is set to it or stands beside it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                yield node.lineno, target, node.value
        elif isinstance(node, ast.AnnAssign | ast.AugAssign):
            yield node.lineno, node.target, node.value
        elif isinstance(node, ast.keyword):
            yield node.value.lineno, node, node.value
        elif isinstance(node, ast.Dict):
            for key, value in zip(node.keys, node.values, strict=True):
                yield value.lineno, key, value
        elif isinstance(node, ast.Compare):
            for other in node.comparators:
                yield node.lineno, node.left, other
                yield node.lineno, other, node.left
        elif isinstance(node, ast.arguments):
            for arg, default in zip(node.args[len(node.args) - len(node.defaults) :], node.defaults, strict=True):
                yield default.lineno, arg, default
            for arg, value in zip(node.kwonlyargs, node.kw_defaults, strict=True):
                if value is not None:
                    yield value.lineno, arg, value


def rules_in(text: str) -> list[tuple[int, str]]:
    """Line and name of each rule of a contact in a source: a number of one, or a product of two factors."""
    tree = ast.parse(text)
    found = [
        (line, named(target)) for line, target, value in pairs(tree) if RULE.search(named(target)) and numbers(value)
    ]
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and not isinstance(node.op, ast.Pow):
            left, right = named(node.left), named(node.right)
            if isinstance(node.op, ast.Mult):
                one, other = FACTOR.search(left), FACTOR.search(right)
                if one and other and one[1].lower() == other[1].lower():
                    found.append((node.lineno, f"{left} * {right}"))
            if (RULE.search(left) and numbers(node.right)) or (RULE.search(right) and numbers(node.left)):
                found.append((node.lineno, left or right))
    return found


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_other_module_has_a_rule_of_a_contact(path):
    name = path.relative_to(ROOT).as_posix()
    found = [
        (line, what) for line, what in rules_in(path.read_text(encoding="utf-8")) if (name, what) not in NO_CONTACTS
    ]
    assert found == [], f"{name}: move them to {LAW.relative_to(ROOT)}"


@pytest.mark.parametrize(
    "line",
    [
        "_FRICTION = 0.4",
        "friction: float = 0.8",
        "_DAMPING_RATIOS = {'bullet': 8.0}",
        "surface = TerrainSurface(name='NET', friction=f, restitution=0.2)",
        "p.changeDynamics(body, -1, contactStiffness=2e4)",
        "p.setPhysicsEngineParameter(contactERP=h / 0.5)",
        "_HIT_SPEED = 0.3",
        "p.changeDynamics(body, -1, lateralFriction=2.0 * s.friction)",
        "is_rigid = stiffness > 5e6",
        "def spring(stiffness=1e5): ...",
        "def spring(*, damping=3.0): ...",
        "limit = 0.9 * contact.friction",
        "both = a.friction * b.friction",
        "both = self._restitution[a] * self._restitution[b]",
        "_SLIP, _LEAST = 2e-4, 1e-3",
    ],
)
def test_a_new_rule_elsewhere_is_found(line):
    assert rules_in(line)


@pytest.mark.parametrize(
    "line", ["friction = 0.0", "limit = friction * normal", "rolling = one.rolling * other.friction"]
)
def test_what_only_uses_a_rule_is_none(line):
    assert rules_in(line) == []


def test_the_law_itself_has_them_and_nothing_else_is_let_off_in_vain():
    assert len(rules_in(LAW.read_text(encoding="utf-8"))) > 15
    for name, what in NO_CONTACTS:
        assert what in [rule for _, rule in rules_in((ROOT / name).read_text(encoding="utf-8"))]


def test_nothing_asks_which_engine_it_is_but_who_makes_one():
    """What differs between engines stands in them."""
    engines = {f"simcore/physics/{name}.py" for name in ("bullet", "mujoco_engine", "engine_choice")}
    folders = (*FOLDERS, "robot", "geometry", "vision")
    found = {
        path.relative_to(ROOT).as_posix()
        for folder in folders
        for path in (ROOT / "simcore" / folder).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value in ("bullet", "mujoco")
    }
    assert found == engines
