"""Where compiled parts are kept, and that only what fits the sources is ever found."""

from __future__ import annotations

import ast
import os
import shutil
import sys
from pathlib import Path

import pytest

from simcore.compiled import store
from simcore.compiled.modules import GROUP, MODULES, source_of

ROOT = Path(store.PACKAGE).parent
SOURCES = [pytest.param(ROOT / source_of(module), id=module) for module in MODULES]


def made_up(package: Path) -> Path:
    """A package with two modules that may be compiled."""
    (package / "robot").mkdir(parents=True)
    (package / "__init__.py").write_text('__version__ = "1"\n')
    (package / "robot" / "swerve_drive.py").write_text("x = 1\n")
    (package / "robot" / "tire_solver.py").write_text("y = 2\n")
    return package


TWO = ("simcore.robot.swerve_drive", "simcore.robot.tire_solver")


def built(place: Path, name: str) -> Path:
    """A build, as far as the store looks at it."""
    library = Path(store.library(str(place / name), f"{GROUP}__mypyc"))
    library.parent.mkdir(parents=True)
    library.write_bytes(b"")
    return place / name


def test_a_tag_names_python_the_machine_and_the_sources(tmp_path):
    package = made_up(tmp_path / "simcore")
    first = store.tag(str(package), TWO)
    assert first.startswith(store.abi()) and first == store.tag(str(package), TWO)
    (package / "robot" / "other.py").write_text("not compiled\n")
    assert store.tag(str(package), TWO) == first


@pytest.mark.parametrize("changed", ["robot/swerve_drive.py", "robot/tire_solver.py", "__init__.py"])
def test_any_change_of_a_compiled_source_or_the_version_gives_another_tag(tmp_path, changed):
    package = made_up(tmp_path / "simcore")
    first = store.tag(str(package), TWO)
    (package / changed).write_text("x = 2\n")
    assert store.tag(str(package), TWO) != first


def test_a_moved_line_between_two_files_gives_another_tag(tmp_path):
    package = made_up(tmp_path / "simcore")
    first = store.tag(str(package), TWO)
    (package / "robot" / "swerve_drive.py").write_text("")
    (package / "robot" / "tire_solver.py").write_text("x = 1\ny = 2\n")
    assert store.tag(str(package), TWO) != first


def test_only_a_build_of_this_tag_with_its_library_is_found(tmp_path):
    (tmp_path / "empty" / "a").mkdir(parents=True)  # e.g. half deleted
    there = built(tmp_path / "second", "a")
    stores = [str(tmp_path / "none"), str(tmp_path / "empty"), str(tmp_path / "second")]
    assert store.find(stores, "a") == str(there)
    assert store.find(stores, "b") is None
    assert store.find(stores[:2], "a") is None


def test_others_are_of_this_python_and_not_of_this_tag(tmp_path):
    mine = f"{store.abi()}-0"
    for name in (mine, f"{store.abi()}-1", "cpython-39-other-2"):
        built(tmp_path, name)
    assert [os.path.basename(path) for path in store.others([str(tmp_path)], mine)] == [f"{store.abi()}-1"]


@pytest.mark.parametrize(("value", "off"), [(None, False), ("", False), ("1", False), ("0", True)])
def test_zero_is_off(value, off):
    environment = {} if value is None else {store.VARIABLE: value}
    assert store.is_off(environment) is off
    assert store.places(environment, "/lib/simcore")[0] == os.path.join("/lib/simcore", "compiled", "store")
    assert len(store.places(environment)) == 2


def test_a_folder_in_the_environment_is_the_only_store(tmp_path):
    assert store.places({store.VARIABLE: str(tmp_path)}) == [str(tmp_path)]


@pytest.mark.parametrize(
    ("platform", "environment", "end"),
    [
        ("linux", {"XDG_CACHE_HOME": "/c"}, "/c/simcore/compiled"),
        ("linux", {}, ".cache/simcore/compiled"),
        ("darwin", {}, "Library/Caches/simcore/compiled"),
        ("win32", {"LOCALAPPDATA": "/Local"}, "/Local/simcore/compiled"),
        ("win32", {}, "AppData/Local/simcore/compiled"),
    ],
)
def test_the_folder_of_the_user(monkeypatch, platform, environment, end):
    monkeypatch.setattr(sys, "platform", platform)
    assert store.places(environment)[1].replace(os.sep, "/").endswith(end)


# --- what may be compiled -------------------------------------------------------------------------------------------


def test_every_module_of_the_list_has_a_source_and_stands_there_once():
    assert len(set(MODULES)) == len(MODULES) and sorted(MODULES) == list(MODULES)
    assert [module for module in MODULES if not (ROOT / source_of(module)).is_file()] == []


@pytest.mark.parametrize("path", SOURCES)
def test_no_sum_of_a_generator(path):
    """Since 3.12 `sum` of floats is compensated; compiled, it is a plain loop over a generator: other last bits."""
    calls = [
        node.lineno
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "sum" and node.args
        if isinstance(node.args[0], ast.GeneratorExp)
    ]
    assert calls == [], "write sum([...])"


def test_no_constant_of_another_module_is_compiled_in():
    """mypyc writes the value of a `Final` into who uses it, and a tag knows compiled sources only."""
    finals = [
        path
        for path in (ROOT / "simcore").rglob("*.py")
        if not path.is_relative_to(ROOT / "simcore" / "compiled")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and any(alias.name == "Final" for alias in node.names)
    ]
    assert finals == []


def test_a_copied_package_has_the_tag_of_the_original(tmp_path):
    copy = tmp_path / "simcore"
    shutil.copytree(store.PACKAGE, copy, ignore=shutil.ignore_patterns("store", "__pycache__"))
    assert store.tag(str(copy)) == store.tag()


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
        for node in ast.walk(ast.parse((ROOT / source_of(module)).read_text(encoding="utf-8"))):
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
