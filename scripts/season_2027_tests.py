"""Writes a copy of the adapters' tests and of the example robots that runs on WPILib and Phoenix 6 of 2027.

    python scripts/season_2027_tests.py FOLDER

Both are rewritten by `simcore upgrade-2027`, also the programs that stand in strings of a test: what it cannot rewrite,
teams will meet as well. `scripts/season_2027.sh` runs the copy.
"""

from __future__ import annotations

import argparse
import ast
import shutil
import tempfile
from pathlib import Path

from simcore.upgrade_2027.source_rewriter import names_of_project, rewrite
from simcore.upgrade_2027.upgrade_command import upgrade

ROOT = Path(__file__).resolve().parents[1]
UPGRADED = (
    "own_maxswerve",
    "own_spark_cancoder",
    "own_talons",
    "own_magic",
    "own_tank_sparks",
    "own_mecanum",
)
"""Robots of the tests that are upgraded as a team does it, and driven, beside the example with CTRE's swerve."""
GYRO = (
    "self.gyro = wpilib.ADXRS450_Gyro()",
    "from phoenix6 import hardware\n\n        self.gyro = hardware.Pigeon2(60)",
)
SPARKS = ROOT / "simcore" / "upgrade_2027" / "spark_units.txt"
LEFT_OUT = shutil.ignore_patterns("__pycache__", "test_output", "ctre_sim")


def main(to: Path) -> None:
    """Write the copy into a folder that is not there yet."""
    for name in ("tests", "docs", "scripts"):
        shutil.copytree(ROOT / name, to / name, ignore=LEFT_OUT)
    for name in ("conftest.py", "pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, to)
    (to / "examples").mkdir()
    for robot in sorted((ROOT / "examples").glob("*/robot.py")):
        upgrade(robot.parent, to / "examples" / robot.parent.name)
    adapters = to / "tests" / "adapters"
    robots = adapters / "robots"
    of_2027 = "rev_2027"  # in names of what is of 2027 already
    _rewrite([p for p in adapters.rglob("*.py") if not p.is_relative_to(robots) and of_2027 not in p.stem])
    (adapters / "test_program_shapes.py").unlink()  # puts its programs together from names of 2026
    for folder in sorted(p for p in robots.iterdir() if p.is_dir() and of_2027 not in p.name):
        _rewrite(sorted(folder.rglob("*.py")))
        shutil.copy(SPARKS, folder / "spark_units.py")
    for source in (ROOT / "examples" / "first_robot", *(ROOT / "tests/adapters/robots" / name for name in UPGRADED)):
        with tempfile.TemporaryDirectory() as old:
            shutil.copytree(source, old, ignore=LEFT_OUT, dirs_exist_ok=True)
            (Path(old) / "physics.py").unlink(missing_ok=True)  # of the example: its drivetrain is found without
            for path in Path(old).rglob("*.py"):  # the robot of 2027 has no such gyro, which a team changes by hand
                text = path.read_text(encoding="utf-8").replace(*GYRO)
                text = text.replace("Rotation2d.fromDegrees(-self.gyro.getAngle())", "self.gyro.getRotation2d()")
                path.write_text(text, encoding="utf-8")
            upgrade(Path(old), robots / "upgraded" / source.name)


def _rewrite(files: list[Path]) -> None:
    """Rewrite what belongs together."""
    texts = {path: path.read_text(encoding="utf-8") for path in files}
    own = names_of_project([ast.parse(text) for text in texts.values()]) | {path.stem for path in files}
    for path, text in texts.items():
        path.write_text(_with_programs(rewrite(text, own).text), encoding="utf-8")


def _with_programs(text: str) -> str:
    """A file with the programs that stand in its strings rewritten, too."""
    raw, edits = text.encode(), []
    starts = [0]
    for line in raw.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and "\n" in node.value:
            begin = starts[node.lineno - 1] + node.col_offset
            end = starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)
            try:
                new = rewrite(node.value, set()).text.replace("\\", "\\\\")
            except (SyntaxError, ValueError):
                continue  # no program
            if raw[begin:end].startswith(b'"""') and '"""' not in new:
                edits.append((begin, end, f'"""{new}"""'.encode()))
    for begin, end, new_text in sorted(edits, reverse=True):
        raw = raw[:begin] + new_text + raw[end:]
    return raw.decode()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="that is not there yet")
    main(parser.parse_args().folder)
