"""The command `simcore`: help, version, error messages and loaded modules; help of the scripts."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import simcore
from simcore.cli import COMMANDS, main
from simcore.errors import ConfigError
from simcore.robot_file.key_tables import read_toml

ROOT = Path(__file__).resolve().parents[1]
SCRIPTS = sorted(path for path in (ROOT / "scripts").glob("*.py") if "__main__" in path.read_text(encoding="utf-8"))


def test_simcore_without_arguments_prints_its_help(capsys):
    assert main([]) == 0
    said = capsys.readouterr().out
    assert said.startswith("usage: simcore") and all(f"\n    {name}" in said for name in COMMANDS)


def test_the_command_the_project_file_and_the_changelog_state_the_same_version(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0 and capsys.readouterr().out == f"simcore {simcore.__version__}\n"
    declared = re.search(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
    newest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert declared[1] == newest[1] == simcore.__version__


def test_listing_the_commands_loads_no_heavy_module():
    code = (
        "import sys; from simcore.cli import main; main([]);"
        "assert not {'numpy', 'scipy', 'trimesh', 'rich', 'wpimath', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, timeout=60)


@pytest.mark.parametrize("name", ["generate_rebuilt_field", "make_layout"])
def test_printing_the_help_of_a_script_changes_no_model(name):
    models = {path: path.stat().st_mtime_ns for path in (ROOT / "models").rglob("*")}
    words = [sys.executable, str(ROOT / "scripts" / f"{name}.py"), "--help"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0 and done.stdout.startswith("usage: "), done.stderr
    assert {path: path.stat().st_mtime_ns for path in (ROOT / "models").rglob("*")} == models


def test_every_script_has_a_help_text():
    assert [path.name for path in SCRIPTS if "parse_args(" not in path.read_text(encoding="utf-8")] == []


@pytest.mark.parametrize(
    "words, said",
    [
        (["play", "--jsn"], "unrecognized arguments: --jsn. Did you mean --json?"),
        (["play", "--zzzz"], "unrecognized arguments: --zzzz (`simcore play --help` lists what there is)\n"),
        (["play", "depot"], "no game named 'depot': it is an auto of rebuilt, as in `--auto depot`"),
        (["play", "2026"], "no game named '2026': the game of 2026 is rebuilt"),
        (["play", "reefscape", "--hub-exits"], "unrecognized arguments: --hub-exits"),
        (["play", "reefscap", "--hub-exits"], "no game named 'reefscap'. Did you mean 'reefscape'"),
        (
            ["shots", "--distances", "5:1:0.5"],
            "'5:1:0.5' cannot be read: write from:to:step, the nearest first, e.g. 2:6",
        ),
        (["play", "--sead", "3"], "unrecognized arguments: --sead. Did you mean --seed?"),
        (["compare", "depot"], "'depot' with what? Give two folders with a robot.py, or two autos of the game"),
    ],
)
def test_the_error_for_a_mistyped_command_says_how_to_correct_it(words, said, capsys):
    try:
        assert main(words) == 1
    except SystemExit as end:
        assert end.code == 2
    error = capsys.readouterr().err
    assert said in error and len(error.strip().splitlines()) == 1


def test_the_help_lists_the_options_of_the_named_game(capsys):
    for words, has_cages in (["play"], False), (["play", "rebuilt"], False), (["play", "reefscape"], True):
        with pytest.raises(SystemExit) as end:
            main([*words, "--help"])
        assert end.value.code == 0 and ("--red-cage-3-shallow" in capsys.readouterr().out) == has_cages


def test_only_the_named_game_is_loaded():
    code = (
        "import sys; from simcore.cli import main\n"
        "for words in (['play', '--help'], ['play', 'reefscape', '--help'], ['play', 'reefscape', '--list']):\n"
        "    try: main(words)\n"
        "    except SystemExit: pass\n"
        "assert 'games.reefscape' in sys.modules and 'games.rebuilt' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, timeout=60)


def test_the_error_for_a_decimal_comma_suggests_a_decimal_point(tmp_path):
    (tmp_path / "simcore.toml").write_text("[robot]\nbumper_width = 52,5  # cm\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"decimals take a point: 52\.5"):
        read_toml(tmp_path / "simcore.toml")


def test_a_missing_library_is_reported_in_one_sentence():
    code = "import sys; sys.modules['numba'] = None; from simcore.cli import main; sys.exit(main(['play']))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False
    )
    (line,) = done.stderr.strip().splitlines()
    assert done.returncode == 1 and line.startswith("simcore play: import of numba halted") and "pip install" in line


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["compare", "depot", "neutral", "--seeds", "1"], "must be a whole number from 2 to"),
        (["sweep", "--seeds", "1000000000"], "give a number of seeds (1 to 1000000), or"),
        (["play", "--live", "--nt-port", "0"], "must be a whole number from 1 to 65535, got '0'"),
        (
            ["play", "rebuilt", "--match", "--blue", "me:3"],
            "player 'me:3': 'me' plays --auto and has no level, so give 'me'",
        ),
        (["play", "rebuilt", "--log", "run.csv"], "cannot write the log 'run.csv': its name must end in .wpilog"),
        (["play", "rebuilt", "--page", "run.txt"], "cannot write the page 'run.txt': its name must end in .html"),
        (["new-game", "numpy"], "'numpy' is a game or module that is installed"),
        (["calibrate", "--shot", "distance=2,rps=fast"], "rps must be a number above 0"),
    ],
)
def test_invalid_arguments_are_refused_before_anything_runs(words, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    try:
        assert main(words) == 1
    except SystemExit as end:
        assert end.code == 2
    error = capsys.readouterr().err
    assert said in error and len(error.strip().splitlines()) == 1 and not any(tmp_path.iterdir())
