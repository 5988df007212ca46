"""Leaves out what needs a vendor's library that is not installed: the adapters are optional extras."""

import gc
import os
from importlib.util import find_spec

import pytest
from hypothesis import settings

settings.register_profile("simcore", deadline=None)  # a busy computer is no failure
settings.load_profile("simcore")

collect_ignore_glob = ["examples/*", "tests/adapters/robots/*", "tests/adapters/scenarios/*"]
if find_spec("phoenix6") is None or find_spec("wpilib") is None:
    collect_ignore_glob += ["simcore/robotcode/makers/phoenix6/*", "simcore/robotcode/emulator/*"]
if find_spec("rev") is None or find_spec("wpilib") is None:
    collect_ignore_glob.append("simcore/robotcode/makers/revlib/*")
if find_spec("navx") is None:
    collect_ignore_glob.append("simcore/robotcode/makers/navx/*")
if find_spec("photonlibpy") is None:
    collect_ignore_glob.append("simcore/robotcode/makers/photonvision/*")
if find_spec("pyfrc") is None or find_spec("phoenix6") is None:
    collect_ignore_glob.append("simcore/robotcode/sim/*")
if find_spec("wpimath") is None or find_spec("wpimath.geometry") is None:  # they compare with WPILib of 2026
    collect_ignore_glob += [
        "tests/games/test_game_telemetry.py",
        "tests/games/test_pose_estimation.py",
        "tests/games/test_rebuilt_models.py",
        "tests/laws/test_against_wpilib.py",
        "tests/world/test_rotation.py",
        "tests/show/test_failed_run.py",
        "tests/telemetry/test_log_reader.py",
    ]


def pytest_configure(config):
    """Compile the physics before the tests part into workers, each of which would do it."""
    if not hasattr(config, "workerinput"):
        from simcore.loop.step import prepare

        prepare()


def pytest_addoption(parser):
    """Add the option `--whole`, which runs in full the tests that are sampled otherwise."""
    parser.addoption("--whole", action="store_true", help="run long tests in full, which are sampled otherwise")
    parser.addoption(
        "--engine",
        choices=("bullet", "mujoco", "both"),
        help="physics engine of tests/laws and tests/games (default: both in tests/laws, and "
        "in the others PyBullet, with a sample on MuJoCo)",
    )


EXTRAS = {
    **{name: name for name in ("navx", "phoenix6", "rev")},
    **{"photonlibpy": "photonvision", "pyfrc": "robotpy", "websockets": "view", "mkdocs": "docs"},
}
"""Extras with tests of their own, which `[test]` does not bring, by a module of each."""
ENGINES = {"bullet": "pybullet", "mujoco": "mujoco"}
_ENGINE = os.environ.get("SIMCORE_ENGINE")  # that the caller has set


def pytest_generate_tests(metafunc):
    """Run the tests of a folder with the fixture `engine_name` once for each engine."""
    if "engine_name" not in metafunc.fixturenames:
        return
    marker = metafunc.definition.get_closest_marker("engines")
    asked = metafunc.config.getoption("--engine")
    usual = marker.args if marker else tuple(ENGINES) if "laws" in metafunc.definition.path.parts else ("bullet",)
    if asked is not None:
        wanted = tuple(ENGINES) if asked == "both" else (asked,)
        names = [name for name in wanted if name in usual] if marker and not marker.kwargs.get("sample") else wanted
    else:
        names = usual
        if find_spec(ENGINES[names[0]]) is None and not (marker and len(marker.args) == 1):
            names = [name for name in ENGINES if find_spec(ENGINES[name]) is not None]
    params = [
        pytest.param(
            name,
            marks=[] if find_spec(ENGINES[name]) is not None else pytest.mark.skip(reason=f"{name} is not installed"),
        )
        for name in names
    ]
    metafunc.parametrize("engine_name", params, indirect=True, scope="session")


@pytest.fixture(scope="session")
def engine_name(request):
    """Name of the physics engine that worlds of this test get."""
    return request.param


@pytest.fixture
def whole(request):
    """Whether long tests run in full."""
    return bool(request.config.getoption("--whole"))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Worlds get the engine of the test; those of a test without the fixture get the one that the caller has set.

    Left out is what other tests beside it would keep from coming in time.
    """
    name = item.callspec.params.get("engine_name", _ENGINE) if hasattr(item, "callspec") else _ENGINE
    if name is None:
        os.environ.pop("SIMCORE_ENGINE", None)
    else:
        os.environ["SIMCORE_ENGINE"] = name
    if item.get_closest_marker("realtime") and "PYTEST_XDIST_WORKER" in os.environ:
        pytest.skip("on the wall clock: without -n")


def pytest_collection_finish(session):
    """Exclude all that was imported and collected from later garbage collections."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item, nextitem):
    """Collect matches and recordings, which refer to each other in cycles, after each file and each game."""
    result = yield
    if nextitem is None or nextitem.path != item.path or "game" in getattr(item, "fixturenames", ()):
        gc.collect()
    return result


def pytest_terminal_summary(terminalreporter):
    """One line says what was left out, and how to run it."""
    skipped = len(terminalreporter.stats.get("skipped", ()))
    missing = sorted(extra for module, extra in EXTRAS.items() if find_spec(module) is None)
    said = [f"{skipped} tests skipped"] if skipped else []
    if not terminalreporter.config.getoption("--whole"):
        said.append("long ones run in full with --whole")
    if missing:
        said.append(f'those of {", ".join(missing)} after: python -m pip install -e ".[{",".join(missing)}]"')
    terminalreporter.write_line("; ".join(said))
