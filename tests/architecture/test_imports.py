"""Packages import only inner packages, one module imports each engine, and time and random numbers are arguments."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Collection, Iterator
from functools import cache
from pathlib import Path

import pytest
from each_case import each

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted([*(ROOT / "simcore").rglob("*.py"), *(ROOT / "games").rglob("*.py")])

ADAPTERS = {"bridge", "calibrate", "robotcode", "show"}
"""Outermost packages of simcore: only these import vendor libraries, WPILib's robot side or a wall clock."""

BASE = {"channel", "errors", "quantities", "units", "typing", "install_text", "season"}
TOOLS = {
    "simcore/loop/compiled.py",  # reports the time of compilation
    "simcore/match/runner.py",  # measures how long ticks take; hands no time to the simulation
    "simcore/sweep/one_run.py",  # measures the processor time of a run
    "simcore/sweep/sweep_command.py",  # reports the remaining time
}
"""Files outside the simulation, which may read a clock to report durations."""
INNER = BASE | {"loop", "world"}
DOMAIN = {"robot", "pieces", "vision"}
CORE = INNER | DOMAIN | {"telemetry", "match"}

ALLOWED = {
    # package: packages that it may import, in addition to itself
    **dict.fromkeys(BASE, BASE),
    "loop": BASE,
    "world": BASE | {"loop"},
    "pieces": INNER,
    "vision": INNER,
    "robot": INNER | {"pieces", "vision"},  # a robot is composed of a body, mechanisms, manipulators and cameras
    "telemetry": INNER,
    "match": CORE,
    "robot_file": CORE,  # contents of simcore.toml, which the adapters read
    **dict.fromkeys(
        ("cli", "__main__"), BASE | {"cli", "__version__"}
    ),  # a table of names: commands are imported when they run
    "calibrate": CORE | {"robot_file", "robotcode.sim", "show", "sweep"},  # describes robots as check does
    "sweep": CORE | {"robot_file", "show"},  # pages of results are drawn as those of runs
    "testing": CORE,
    "new_game": CORE,  # lists the installed games
    "show": CORE | {"robotcode.networktables"},
    "bridge": CORE | {"robot_file", "robotcode.program", "robotcode.sim", "show", "sweep"},
    "robotcode.networktables": CORE,
    "robotcode.program": CORE | {"robot_file"},  # makers are loaded by name
    "robotcode.makers": CORE | {"robot_file", "robotcode.program", "robotcode.emulator", "robotcode.networktables"},
    "robotcode.emulator": BASE | {"loop", "robot"},  # emulates CTRE's library; imports motors, but no adapters
    "robotcode.sim": CORE
    | {"robot_file", "show", "sweep"}
    | {f"robotcode.{part}" for part in ("program", "makers", "emulator", "networktables")},
}

WPILIB = ("wpilib", "hal", "wpimath", "ntcore", "wpiutil", "robotpy_apriltag")
VENDORS = ("pybullet", "mujoco", "wpilib", "hal", "phoenix6", "rev", "navx")


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imports(path: Path) -> list[tuple[str, int]]:
    """Return every module that a file imports anywhere, with the line."""
    return list(_imports(path))


def _imports(path: Path) -> Iterator[tuple[str, int]]:
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, node.lineno
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: relative import"
            if node.module in ("simcore", "simcore.robotcode", "games"):
                for alias in node.names:
                    yield f"{node.module}.{alias.name}", node.lineno
            else:
                yield str(node.module), node.lineno


def is_adapter(path: Path) -> bool:
    parts = path.relative_to(ROOT).parts
    return parts[0] == "simcore" and parts[1].removesuffix(".py") in ADAPTERS


def package_of(name: str) -> str:
    """Return a module's package as named in `ALLOWED`: `match`, `robotcode.sim`; empty for `simcore` itself."""
    parts = name.split(".")[1:]
    return ".".join(parts[:2] if parts[:1] == ["robotcode"] else parts[:1])


def test_each_package_imports_only_the_packages_that_it_may_import():
    wrong = []
    for path in SOURCES:
        own = package_of(module_name(path))
        if path.is_relative_to(ROOT / "games") or own in ("", "robotcode"):
            continue
        assert own in ALLOWED, f"a new package {own!r}: decide here what it may import"
        for name, line in imports(path):
            is_other = name.startswith("simcore.") and package_of(name) not in ALLOWED[own] | {own, "__version__"}
            if is_other or name.split(".")[0] == "games":
                wrong.append(f"{path.relative_to(ROOT)}:{line} imports {name}")
    assert wrong == []


def loaded_with(path: Path, modules: Collection[str]) -> set[str]:
    """Return those modules that a file imports at load time: outside functions, and not only for type checking."""
    names = set()

    def visit(nodes: list[ast.stmt]) -> None:
        for node in nodes:
            if isinstance(node, ast.Import):
                names.update(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    inside = f"{node.module}.{alias.name}"
                    names.add(inside if inside in modules else str(node.module))
            elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
                visit(node.orelse)
            elif not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                for part in ("body", "orelse", "finalbody"):
                    visit(getattr(node, part, []))
                for handler in getattr(node, "handlers", []):
                    visit(handler.body)

    visit(tree_of(path).body)
    return names & set(modules)


def find_cycle(graph: dict[str, set[str]]) -> list[str]:
    """Return a cycle of a graph with its first node repeated at the end; empty without a cycle."""
    done: set[str] = set()
    way: list[str] = []

    def visit(name: str) -> list[str]:
        if name in way:
            return [*way[way.index(name) :], name]
        if name in done:
            return []
        way.append(name)
        for target in sorted(graph[name]):
            if cycle := visit(target):
                return cycle
        way.pop()
        done.add(name)
        return []

    return next((cycle for name in sorted(graph) if (cycle := visit(name))), [])


def test_there_are_no_import_cycles():
    files = {module_name(path): path for path in SOURCES}
    assert len(files) > 100
    graph = {name: loaded_with(path, files) for name, path in files.items()}
    assert " -> ".join(find_cycle(graph)) == ""


def test_imports_for_types_and_inside_functions_form_no_cycle():
    """A game must not depend on the match that plays it, even for annotations or inside a function."""
    files = {module_name(path): path for path in SOURCES}
    files = {name: path for name, path in files.items() if name.split(".")[1:2] and name.split(".")[1] in CORE}
    assert len(files) > 80
    graph = {}
    for name, path in files.items():
        named = {part for module, _ in imports(path) for part in (module, module.rpartition(".")[0])}
        graph[name] = named & set(files) - {name}
    assert " -> ".join(find_cycle(graph)) == ""


def test_the_cycle_search_finds_a_cycle():
    assert find_cycle({"a": {"b"}, "b": {"c", "d"}, "c": set(), "d": {"b"}}) == ["b", "d", "b"]
    assert find_cycle({"a": {"b"}, "b": {"c"}, "c": set()}) == []


def test_importing_simcore_alone_loads_no_heavy_module():
    """Robot programs import simcore at start, which may load numpy but no adapter and no game."""
    code = "import simcore, sys; print(sorted(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    loaded = ast.literal_eval(run.stdout)
    assert not {"scipy", "trimesh", "rich"} & set(loaded)
    ours = [name for name in loaded if name.startswith(("simcore.", "games"))]
    assert all(name.split(".")[1] in BASE for name in ours), ours


def test_every_top_level_name_comes_from_its_home_module():
    import simcore

    for name in simcore.__all__:
        if name in simcore._HOME:
            try:
                home = getattr(simcore, name).__module__
            except ImportError:  # from an extra that is not installed
                continue
            assert home == simcore._HOME[name] or home.startswith("phoenix6"), name
    for name, words in (("Macth", "Did you mean 'Match'"), ("SwerveDrive", "from simcore.robot.swerve_drive import")):
        with pytest.raises(ImportError, match=words):
            getattr(simcore, name)
    with pytest.raises(AttributeError, match="no attribute 'quite_else'"):
        simcore.quite_else  # noqa: B018


@pytest.mark.parametrize(
    ("package", "module"), [("pybullet", "simcore.world.bullet"), ("mujoco", "simcore.world.mujoco_engine")]
)
def test_only_one_module_imports_each_engine(package, module):
    who = [module_name(path) for path in SOURCES for name, _ in imports(path) if name.split(".")[0] == package]
    assert who == [module]


def test_only_adapters_import_vendor_libraries_and_wpilib():
    assert not [
        f"{module_name(path)}:{line} imports {name}"
        for path in SOURCES
        if not is_adapter(path)
        for name, line in imports(path)
        if name.split(".")[0] in (*WPILIB, "phoenix6", "commands2", "pyfrc")
    ]


MAKERS_WORDS = re.compile(r"ctre|talon|spark|phoenix|pigeon|cancoder|candle|canrange|navx", re.IGNORECASE)
DELIVERED = "simcore/robot/dc_motor.py"
"""Module with the makers' default current limits, which apply to motors without configured limits."""


def test_no_identifier_in_the_inner_packages_names_a_device_maker():
    """Docstrings may name a maker as a source."""
    found = set()
    for path in SOURCES:
        parts, place = path.relative_to(ROOT).parts, path.relative_to(ROOT).as_posix()
        if parts[0] != "simcore" or parts[1] not in CORE or place == DELIVERED:
            continue
        for node in ast.walk(tree_of(path)):
            names = (getattr(node, kind, None) for kind in ("id", "attr", "name", "arg"))
            found |= {f"{place}: {name}" for name in names if isinstance(name, str) and MAKERS_WORDS.search(name)}
    assert found == set()


def test_only_the_view_server_imports_websockets():
    who = {module_name(path) for path in SOURCES for name, _ in imports(path) if name.split(".")[0] == "websockets"}
    assert who == {"simcore.show.view_server"}


def test_the_view_imports_no_vendor_library():
    wrong = [
        f"{module_name(path)}:{line} imports {name}"
        for path in SOURCES
        if path.is_relative_to(ROOT / "simcore" / "show")
        for name, line in imports(path)
        if name.split(".")[0] in VENDORS or (name.startswith("simcore.robotcode.") and "networktables" not in name)
    ]
    assert wrong == []


def clocks_and_chance(tree: ast.AST) -> Iterator[tuple[str, int]]:
    """Yield every use of a clock or of unseeded random numbers, with its line."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] in ("time", "datetime", "random", "secrets", "uuid"):
                    yield f"import {alias.name}", node.lineno
        elif isinstance(node, ast.ImportFrom):
            if str(node.module).split(".")[0] in ("time", "datetime", "random", "secrets", "uuid"):
                yield f"from {node.module}", node.lineno
            if node.module == "numpy.random":
                yield "from numpy.random", node.lineno
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Attribute):
            if node.value.attr == "random" and node.attr not in ("Generator", "default_rng"):
                yield f"numpy.random.{node.attr}", node.lineno
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            seeded = any(not (isinstance(a, ast.Constant) and a.value is None) for a in node.args) or node.keywords
            if node.func.attr == "default_rng" and not seeded:
                yield "default_rng() without a seed", node.lineno


def test_the_simulation_reads_no_clock_and_uses_no_unseeded_random_numbers():
    wrong = [
        f"{module_name(path)}:{line} {what}"
        for path in SOURCES
        if path.is_relative_to(ROOT / "simcore") and not is_adapter(path)
        if path.relative_to(ROOT).as_posix() not in TOOLS
        for what, line in clocks_and_chance(tree_of(path))
    ]
    assert wrong == []


def test_no_game_reads_a_clock_or_uses_unseeded_random_numbers():
    wrong = [
        f"{module_name(path)}:{line} {what}"
        for path in SOURCES
        if path.is_relative_to(ROOT / "games")
        for what, line in clocks_and_chance(tree_of(path))
    ]
    assert wrong == []


@each(
    "code",
    [
        "import time",
        "from time import perf_counter",
        "import datetime as d",
        "from random import random",
        "import numpy as np\nnp.random.seed(1)",
        "import numpy as np\nnp.random.rand(3)",
        "import numpy as np\nnp.random.default_rng()",
        "import numpy as np\nnp.random.default_rng(None)",
        "from numpy.random import rand",
    ],
)
def test_the_scan_finds_clocks_and_unseeded_random_numbers(code):
    assert list(clocks_and_chance(ast.parse(code)))


def test_the_scan_accepts_a_seeded_generator():
    code = "import numpy as np\nrng: np.random.Generator = np.random.default_rng(seed)\nrng.random()"
    assert not list(clocks_and_chance(ast.parse(code)))


def test_importing_simcore_loads_neither_an_engine_nor_wpilib():
    """The test imports every module outside the adapters, then the view, which imports its web server late."""
    sources = [path for path in SOURCES if path.is_relative_to(ROOT / "simcore")]
    modules = sorted({module_name(path) for path in sources if not is_adapter(path)})
    view = [module_name(path) for path in sources if path.parent.name == "show" and path.stem != "__main__"]
    assert len(modules) > 50
    code = (
        "import importlib, sys\n"
        f"for name in {modules!r}:\n"
        "    importlib.import_module(name)\n"
        f"    loaded = [v for v in {VENDORS!r} if v in sys.modules]\n"
        "    assert not loaded, f'{name} loads {loaded}'\n"
        f"for name in {[*view, 'games.rebuilt.__main__']!r}: importlib.import_module(name)\n"
        "assert 'websockets' not in sys.modules\n"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stderr


def test_a_match_needs_no_part_of_wpilib():
    """Motors, tags, poses and logs are simcore's own, with any season installed or none."""
    code = (
        "import sys\n"
        f"for name in {WPILIB!r}: sys.modules[name] = None\n"
        "from games.rebuilt import REBUILT\n"
        "from simcore.match.game import RobotEntry\n"
        "from simcore.match.match import Match\n"
        "auto = REBUILT.auto(None)\n"
        "with Match(REBUILT, robots=[RobotEntry(start=auto.start)], seed=1) as match:\n"
        "    match.set_controller(0, auto.controller(match, 'blue'))\n"
        "    match.play(seconds=2.0)\n"
        "    print(match.robots[0].chassis.pose[0] - auto.start[0])\n"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stderr
    assert abs(float(run.stdout)) > 0.2


def test_every_public_name_exists():
    """An undefined name in `__all__` breaks `from module import *` and the docs."""
    missing = []
    for path in SOURCES:
        tree = tree_of(path)
        defined: set[str] = set()
        for node in [*tree.body, *(n for part in tree.body if isinstance(part, ast.If) for n in part.body)]:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                defined.add(node.name)
            elif isinstance(node, (ast.Import, ast.ImportFrom)):
                defined |= {alias.asname or alias.name for alias in node.names}
            elif isinstance(node, ast.Assign):
                defined |= {t.id for target in node.targets for t in ast.walk(target) if isinstance(t, ast.Name)}
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                defined.add(node.target.id)
        for node in tree.body:
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__":
                missing += [
                    f"{module_name(path)}.{name}" for name in ast.literal_eval(node.value) if name not in defined
                ]
    assert missing == []


def test_each_test_file_has_the_path_of_its_module():
    """`tests/x/test_y.py` tests `simcore/x/y`; a test file of several modules has a docstring."""
    folders = {"adapters", "architecture", "docs", "games", "laws", "shared", "view"}
    wrong = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        place = path.relative_to(ROOT / "tests")
        if place.parts[0] in folders:
            continue
        module = ROOT / "simcore" / place.parent / place.stem.removeprefix("test_")
        if not module.is_dir() and not module.with_suffix(".py").is_file() and ast.get_docstring(tree_of(path)) is None:
            wrong.append(place.as_posix())
    assert wrong == []
