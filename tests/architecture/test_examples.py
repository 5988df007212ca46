"""Robot code of the examples does not depend on the simulation: only physics.py imports simcore.

A project with a simcore.toml has no physics.py.
"""

import ast
from pathlib import Path

from each_case import each

ROOT = Path(__file__).resolve().parents[2]
PROJECTS = sorted(path.parent for path in (ROOT / "examples").glob("*/robot.py"))
SUBSYSTEMS = sorted((ROOT / "examples" / "rebuilt_robot" / "subsystems").glob("*.py"))
LINE = "# ==================== SIMULATION SUPPORT - sim-only methods below this line ===================="


def imported(path: Path) -> set[str]:
    """Return the top-level names of all modules that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(str(node.module).split(".")[0])
    return found


@each("project", PROJECTS)
def test_only_physics_py_imports_the_simulation(project):
    if (project / "simcore.toml").exists():
        assert not (project / "physics.py").exists()
    else:
        assert "simcore" in imported(project / "physics.py")
    for path in project.rglob("*.py"):
        if path.name == "physics.py" or "tests" in path.relative_to(project).parts:
            continue
        names = imported(path)
        assert not names & {"simcore", "games", "pybullet", "pyfrc", "physics"}, path


@each("path", SUBSYSTEMS)
def test_simulation_accessors_are_below_the_marker_and_only_return_an_attribute(path):
    text = path.read_text(encoding="utf-8")
    for node in ast.parse(text).body:
        if not isinstance(node, ast.ClassDef):
            continue
        lines = text.splitlines()[node.lineno - 1 : node.end_lineno]
        marks = [node.lineno + k for k, line in enumerate(lines) if line.strip() == LINE]
        for method in (m for m in node.body if isinstance(m, ast.FunctionDef)):
            is_below = bool(marks) and method.lineno > marks[0]
            assert ("Sim" in method.name) == is_below, f"{path.name}: {node.name}.{method.name}"
            if is_below:
                (only,) = method.body
                assert isinstance(only, ast.Return) and isinstance(only.value, ast.Attribute), method.name
