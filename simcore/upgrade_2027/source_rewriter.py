"""Rewrites one file of a robot project: edits at the places that the syntax tree names, all else to the byte."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from simcore.upgrade_2027.names_2027 import (
    ELEMENT_TYPES,
    GONE,
    HOOKS,
    LIBRARIES,
    MOTORS,
    OF_KINDS,
    OF_NUMBERS,
    PHOENIX_DEVICES,
    STAMPS,
    VENDORS,
    new_name,
    new_path,
)

__all__ = ["Rewritten", "names_of_project", "rewrite"]

_WIDTH = 120
_PHYSICS_INTERFACE = "pyfrc.physics.core.PhysicsInterface"
_NANO: dict[object, str] = {1e-6: "1e-9", 1e6: "1e9"}


@dataclass(slots=True)
class Rewritten:
    """A file of 2027, and what in it a person has to look at."""

    text: str
    notes: list[tuple[int, str]] = field(default_factory=list)
    """Line in the file of 2026, and a sentence."""


def names_of_project(trees: Iterable[ast.AST]) -> set[str]:
    """Attributes that a project defines itself, which keep their names; not the methods that it overrides."""
    names: set[str] = set()
    for node in (node for tree in trees for node in ast.walk(tree)):
        if isinstance(node, (ast.Module, ast.ClassDef)):
            assigned = (target for part in node.body if isinstance(part, ast.Assign) for target in part.targets)
            names |= {target.id for target in assigned if isinstance(target, ast.Name)}
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            names.add(node.attr)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            names.add(node.target.id)
    return {name for name in names if name not in HOOKS}


def rewrite(text: str, own: set[str]) -> Rewritten:
    """The file of 2027.

    Args:
        text: Of 2026.
        own: What `names_of_project` finds in all files, and the names of the project's modules.

    Raises:
        SyntaxError: It is no Python.
    """
    return _File(text, own).rewritten()


class _File:
    def __init__(self, text: str, own: set[str]) -> None:
        self._lines = [line.encode() for line in text.splitlines(keepends=True)]
        self._starts = [0]
        for line in self._lines:
            self._starts.append(self._starts[-1] + len(line))
        self._bytes, self._tree, self._own = text.encode(), ast.parse(text), own
        self._edits: list[tuple[int, int, str]] = []
        self._notes: list[tuple[int, str]] = []
        self._bound: dict[str, str] = {}
        self._kinds: dict[str, str] = {}
        self._extra: set[str] = set()
        self._used: set[str] = set()
        self._dissolved: set[str] = set()
        self._merged: dict[str, list[str]] = {}
        self._imports: list[tuple[ast.Import | ast.ImportFrom, dict[str, list[str]]]] = []

    def rewritten(self) -> Rewritten:
        imports = [n for n in ast.walk(self._tree) if isinstance(n, (ast.Import, ast.ImportFrom))]
        for statement in imports:
            for alias in statement.names:
                module = f"{statement.module}." if isinstance(statement, ast.ImportFrom) else ""
                name = alias.asname or (alias.name if module else alias.name.split(".")[0])
                self._bound[name] = f"{module}{alias.name if module or alias.asname else name}"
        for _ in range(2):
            self._find_kinds()
        self._visit(self._tree)
        for statement in imports:
            self._rewrite_import(statement)
        self._write_imports()
        out, end = self._bytes, len(self._bytes) + 1
        for first, last, new in sorted(self._edits, reverse=True):
            if last <= end:
                out, end = out[:first] + new.encode() + out[last:], first
        return Rewritten(out.decode(), sorted(set(self._notes)))

    # --- what an expression is ------------------------------------------------------------------------------------

    def _path(self, node: ast.AST) -> str | None:
        """Full name of 2026 of a name or of attributes of one, if it was imported."""
        if isinstance(node, ast.Name):
            return self._bound.get(node.id)
        base = self._path(node.value) if isinstance(node, ast.Attribute) else None
        return f"{base}.{node.attr}" if base and isinstance(node, ast.Attribute) else None

    def _kind(self, node: ast.AST | None) -> str:
        """Full name that a value comes from: of its class, or of the function that made it; empty: unknown."""
        if isinstance(node, ast.Name):
            return self._kinds.get(node.id) or self._bound.get(node.id, "")
        if isinstance(node, ast.Attribute):
            return self._kinds.get(f".{node.attr}") or self._path(node) or self._kind(node.value)
        if isinstance(node, ast.Call):
            return self._kind(node.func)
        return self._kind(node.value) if isinstance(node, (ast.Subscript, ast.Await)) else ""

    def _find_kinds(self) -> None:
        for node in ast.walk(self._tree):
            if isinstance(node, ast.arg) and node.annotation is not None:
                self._note_kind(node.arg, self._path(node.annotation) or "")
            elif isinstance(node, ast.Assign):
                for target in node.targets:
                    pairs = [(target, node.value)]
                    if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                        pairs = list(zip(target.elts, node.value.elts, strict=False))
                    for each, value in pairs:
                        name = f".{each.attr}" if isinstance(each, ast.Attribute) else getattr(each, "id", "")
                        self._note_kind(name, self._kind(value))

    def _note_kind(self, name: str, kind: str) -> None:
        if name and kind and name not in self._bound:
            self._kinds[name] = kind

    # --- edits ----------------------------------------------------------------------------------------------------

    def _at(self, line: int, column: int) -> int:
        return self._starts[line - 1] + column

    def _replace(self, node: ast.expr, new: str) -> None:
        assert node.end_lineno is not None and node.end_col_offset is not None
        self._edits.append((self._at(node.lineno, node.col_offset), self._end(node), new))

    def _end(self, node: ast.expr) -> int:
        return self._at(node.end_lineno or node.lineno, node.end_col_offset or 0)

    def _note(self, node: ast.AST, text: str) -> None:
        self._notes.append((getattr(node, "lineno", 1), text))

    def _visit(self, node: ast.AST) -> None:
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            return
        if isinstance(node, ast.ClassDef):
            self._rewrite_hooks(node)
        elif isinstance(node, ast.Call):
            if self._rewrite_call(node):
                return
        elif isinstance(node, ast.BinOp):
            self._rewrite_clock(node)
        elif isinstance(node, (ast.Attribute, ast.Name)):
            path = self._path(node)
            if path is not None:
                self._rewrite_path(node, path)
                return
            if isinstance(node, ast.Attribute):
                of_kind = OF_KINDS.get(self._kind(node.value) or self._guessed_kind(node.value), {}).get(node.attr)
                if of_kind is not None:
                    self._rename(node, of_kind)
                elif not self._is_own(node) and not self._is_vendors(node.value):
                    self._rename(node, new_name(node.attr))
        elif isinstance(node, ast.Expr):
            self._assign_answer(node.value)
        for child in ast.iter_child_nodes(node):
            self._visit(child)

    def _guessed_kind(self, node: ast.expr) -> str:
        """Class of a value that only its name tells."""
        is_state = re.search(r"state(s\[.*\])?$", ast.unparse(node), re.IGNORECASE)
        return "wpimath.kinematics.SwerveModuleState" if is_state else ""

    def _assign_answer(self, node: ast.expr) -> None:
        """Of a call that changes a SwerveModuleState in 2026, and gives another one in 2027."""
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and len(node.args) == 1:
            if node.func.attr in ("optimize", "cosineScale") and self._path(node.func) is None:
                place = self._at(node.lineno, node.col_offset)
                self._edits.append((place, place, f"{ast.unparse(node.func.value)} = "))

    def _is_own(self, node: ast.Attribute) -> bool:
        """Whether an attribute is one of the project's; not where it is known to be a library's."""
        return node.attr in self._own and self._kind(node.value).split(".")[0] not in LIBRARIES

    def _is_vendors(self, node: ast.AST) -> bool:
        return self._kind(node).split(".")[0] in VENDORS

    def _rename(self, node: ast.Attribute, new: str) -> None:
        if new != node.attr:
            self._edits.append((self._end(node) - len(node.attr.encode()), self._end(node), new))

    def _rewrite_path(self, node: ast.Attribute | ast.Name, path: str) -> None:
        if (
            path.split(".")[0] == "self"
            or path.split(".")[0] not in LIBRARIES | {"pyfrc"}
            or path == _PHYSICS_INTERFACE
        ):
            if isinstance(node, ast.Name):
                self._used.add(node.id)
            elif path.split(".")[0] in self._own:  # a module of the project: what it has may be a library's object
                if not self._is_own(node):
                    self._rename(node, new_name(node.attr))
                self._visit(node.value)
            return
        root: ast.AST = node
        while isinstance(root, ast.Attribute):
            root = root.value
        assert isinstance(root, ast.Name)
        new, bound = new_path(path), self._bound[root.id]
        for gone, why in GONE.items():
            if f"{path}.".startswith(f"{gone}.") and new == ".".join(map(new_name, path.split("."))):
                self._note(node, f"{path} {why}")
        rest = len(path.split(".")) - len(bound.split("."))
        kept = new.split(".")[: len(new.split(".")) - rest]
        if ".".join(kept) == new_path(bound):  # what was imported is what is needed
            self._used.add(root.id)
            local = new_path(bound).split(".")[-1] if root.id == bound.split(".")[-1] else root.id
            spelled = ".".join((local, *new.split(".")[len(kept) :]))
        elif new.startswith(f"{bound}."):  # another place in the module that was imported
            self._used.add(root.id)
            spelled = root.id + new[len(bound) :]
        else:
            self._dissolved.add(root.id)
            spelled = self._import(new, through_module="." not in bound)
        old = ast.unparse(node)
        if spelled != old:
            self._replace(node, spelled)

    def _import(self, path: str, *, through_module: bool = False) -> str:
        """Import what has this full name of 2027; returns how to write it."""
        module = next((m for m in ("telemetry", "tunables", "wpilib.simulation", "commands2.button") if
                       path.startswith(f"{m}.")), path.split(".")[0])  # fmt: skip
        if through_module or module in ("telemetry", "tunables"):
            self._extra.add(f"import {module}")
            return path
        rest = path[len(module) + 1 :]
        self._extra.add(f"from {module} import {rest.split('.')[0]}")
        return rest

    def _rewrite_hooks(self, node: ast.ClassDef) -> None:
        names = {f.name for f in node.body if isinstance(f, ast.FunctionDef)}
        for function in node.body:
            if not (isinstance(function, ast.FunctionDef) and function.name in HOOKS and node.bases):
                continue
            new = HOOKS[function.name] or new_name(function.name)
            if new == "__init__" and "__init__" in names:
                self._note(function, "robotInit is called no more, and this class has an __init__: put it in there")
                continue
            at = self._bytes.index(b"def " + function.name.encode(), self._at(function.lineno, function.col_offset)) + 4
            self._edits.append((at, at + len(function.name), new))
            if new == "__init__":
                first = function.body[0]
                place = self._at(first.lineno, first.col_offset)
                self._edits.append((place, place, f"super().__init__()\n{' ' * first.col_offset}"))

    def _rewrite_call(self, node: ast.Call) -> bool:
        """Edit what changes with the call as a whole; returns whether nothing is left in it."""
        path, function = self._path(node.func), node.func
        if path == "phoenix6.utils.fpga_to_current_time" and len(node.args) == 1:
            self._edits.append((self._at(node.lineno, node.col_offset), self._at(
                node.args[0].lineno, node.args[0].col_offset), "("))  # fmt: skip
            self._visit(node.args[0])
            return True
        if path in ELEMENT_TYPES:
            self._edits.append((self._end(node) - 1, self._end(node) - 1, f", element_type={ELEMENT_TYPES[path]}"))
        elif path == "wpilib.SmartDashboard.putData":
            if len(node.args) == 2 and self._kind(node.args[1]) == "wpilib.SendableChooser":
                self._replace(node.func, self._import("tunables.publish"))
                self._dissolved.add(ast.unparse(node.func).split(".")[0])
                for argument in node.args:
                    self._visit(argument)
                return True
            if len(node.args) == 1:
                self._note(node, "telemetry.log wants a name first")
        elif path in PHOENIX_DEVICES:
            self._give_bus(node, path)
        elif path in OF_NUMBERS and isinstance(function, ast.Attribute) and len(node.args) == 4:
            self._visit(function.value)
            self._edits.append((self._end(function.value), self._end(function), ""))
            last = self._at(node.args[3].lineno, node.args[3].col_offset)
            self._edits.append((self._end(node.args[2]), last, f").{OF_NUMBERS[path]}("))
            for argument in node.args:
                self._visit(argument)
            return True
        elif path == "hal.initialize" and node.args:  # a time-out, and what to do with other programs
            self._edits.append((self._at(node.args[0].lineno, node.args[0].col_offset), self._end(node) - 1, ""))
            self._visit(function)
            return True
        if isinstance(function, ast.Attribute) and not self._is_own(function):
            if function.attr in ("W", "X", "Y", "Z") and not (node.args or node.keywords):
                self._edits.append((self._end(function) - 1, self._end(node), function.attr.lower()))
                self._visit(function.value)
                return True
            if function.attr == "with_can_bus_name" and len(node.args) == 1:
                self._rename(function, "with_network")
                begin = self._at(node.args[0].lineno, node.args[0].col_offset)
                self._edits.append((begin, begin, f"{self._import('phoenix6.CANBus')}("))
                self._edits.append((self._end(node.args[0]), self._end(node.args[0]), ")"))
            elif function.attr in ("set", "get", "stopMotor") and self._kind(function.value).startswith(MOTORS):
                with_stop = self._kind(function.value).startswith(("phoenix6", "rev"))
                name = "stop_motor" if with_stop else "disable"
                self._rename(function, name if function.attr == "stopMotor" else f"{function.attr}_throttle")
            elif function.attr in ("getRawButton", "getPOV"):
                self._note(node, f"{function.attr}: buttons count from 0, a POV is a POVDirection; "
                                 "of an Xbox controller it is in get_hid()")  # fmt: skip
            elif function.attr.startswith("pov") and function.attr != "pov":
                self._note(node, f"{function.attr}: in commands2 2027.0.0a7 it is never true, as it compares a "
                                 "POVDirection with degrees; Trigger(lambda: hid.get_pov() == ...) is")  # fmt: skip
            elif function.attr in ("setAutonomous", "setTest"):
                self._note(node, f"{function.attr}: DriverStationSim.set_robot_mode(hal.RobotMode....)")
        for keyword in node.keywords:
            renamed = new_name(keyword.arg or "")
            if (
                keyword.arg not in self._own
                and renamed != keyword.arg
                and self._kind(node.func).split(".")[0] in (LIBRARIES)
            ):
                at = self._at(keyword.lineno, keyword.col_offset)
                self._edits.append((at, at + len((keyword.arg or "").encode()), renamed))
        return False

    def _give_bus(self, node: ast.Call, path: str) -> None:
        bus = next((k.value for k in node.keywords if k.arg == "canbus"), node.args[1] if len(node.args) > 1 else None)
        if bus is None:
            self._edits.append((self._end(node) - 1, self._end(node) - 1, f', {self._import("phoenix6.CANBus")}("")'))
        elif isinstance(bus, ast.Constant) and isinstance(bus.value, str):
            self._replace(bus, f'{self._import("phoenix6.CANBus")}("{bus.value}")')
        else:
            self._note(node, f"{path}: its bus must be a CANBus")

    def _rewrite_clock(self, node: ast.BinOp) -> None:
        for number, other in ((node.left, node.right), (node.right, node.left)):
            if isinstance(number, ast.Constant) and number.value in _NANO and isinstance(node.op, (ast.Mult, ast.Div)):
                names = {getattr(n, "attr", getattr(n, "id", "")) for n in ast.walk(other)}
                if names & STAMPS:
                    self._replace(number, _NANO[number.value])
                    self._note(node, "stamps count nanoseconds now; the factor was made a thousand times finer")

    # --- imports --------------------------------------------------------------------------------------------------

    def _rewrite_import(self, node: ast.Import | ast.ImportFrom) -> None:
        module = node.module if isinstance(node, ast.ImportFrom) else ""
        roots = {(module or alias.name).split(".")[0] for alias in node.names}
        for vendor in sorted(roots & VENDORS):
            self._note(
                node, f"{vendor} has no release for 2027 that simcore knows of; names from it are left as they are"
            )
        if not roots & (LIBRARIES | {"pyfrc"}) or (isinstance(node, ast.ImportFrom) and node.level):
            return
        lines: dict[str, list[str]] = {}
        for alias in node.names:
            old = f"{module}.{alias.name}" if module else alias.name
            new, name = new_path(old), alias.asname or alias.name
            if old == _PHYSICS_INTERFACE:  # a type of arguments, of which simcore passes one of its own
                lines.setdefault("from typing import ", []).append(f"Any as {name}")
                self._used.add(name)
                self._note(node, "PhysicsInterface: simcore passes one of its own, under `robotpy sim --simcore`")
                continue
            for gone, why in GONE.items():
                if f"{old}.".startswith(f"{gone}.") and new == old and gone.startswith("pyfrc"):
                    self._note(node, f"{old} {why}")
            if alias.name == "*":
                new = f"{new_path(module or '')}.*"
            local = f" as {alias.asname}" if alias.asname else ""
            if not module:
                lines.setdefault(f"import {new}{local}", [])
            elif name in self._used or name not in self._dissolved:
                lines.setdefault(f"from {new.rpartition('.')[0]} import ", []).append(new.rpartition(".")[2] + local)
        if node.col_offset == 0:  # what comes from one module now stands in the first of its statements
            for first in [first for first in lines if first in self._merged]:
                self._merged[first] += lines.pop(first)
            self._merged.update({first: names for first, names in lines.items() if names})
        self._imports.append((node, lines))

    def _write_imports(self) -> None:
        present = {alias.name for n in ast.walk(self._tree) if isinstance(n, ast.Import) for alias in n.names}
        further: dict[str, list[str]] = {}
        for line in sorted(self._extra):
            first, _, name = line.rpartition(" ")
            if first == "import":
                further |= {} if name in present else {line: []}
            else:
                self._merged.get(f"{first} ", further.setdefault(f"{first} ", [])).append(name)
        news = [_import_line(first, names) for first, names in further.items() if names or first.startswith("import")]
        for node, lines in self._imports:
            texts = [_import_line(first, names) for first, names in lines.items()]
            if node.col_offset == 0 and not getattr(node, "module", "") == "__future__":
                texts, news = [*news, *texts], []
            begin, end = (
                self._at(node.lineno, node.col_offset),
                self._at(node.end_lineno or 1, node.end_col_offset or 0),
            )
            if not texts:  # with its line
                begin, end = self._at(node.lineno, 0), self._at((node.end_lineno or node.lineno) + 1, 0)
            self._edits.append((begin, end, f"\n{' ' * node.col_offset}".join(texts)))


def _import_line(first: str, names: list[str]) -> str:
    line = first + ", ".join(sorted(set(names), key=str.lower))
    return line if len(line) <= _WIDTH else f"{first}(\n    " + ",\n    ".join(sorted(set(names))) + ",\n)"
