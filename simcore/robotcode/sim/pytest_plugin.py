"""Pytest plugin for robot tests in simulated time under `robotpy test`.

`robotpy test` runs each test in a separate process. Pytest also loads this plugin in projects without a robot. The
plugin therefore imports large modules only when a robot test runs.
"""

from __future__ import annotations

import atexit
import contextlib
import itertools
import os
import shutil
import sys
import threading
import time
from collections.abc import Generator
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

import pytest

if TYPE_CHECKING:
    from simcore.robotcode.sim.robot_test import RobotTest

__all__ = ["INIT_TIMEOUT", "sim"]

INIT_TIMEOUT = 120.0
"""Largest wall time that a robot program may take to finish robotInit [s]."""
_PLAIN = (
    "a robot test needs its own process with the robot in it, which `python -m robotpy test` starts: run that in the "
    "folder of robot.py; options of pytest follow after --, as in `python -m robotpy test -- -k %s`"
)
_LONGEST_FAILURE = 2000  # largest length of an assertion on a page [characters]
_LATE_MS = 5.0  # largest age of rotor readings without overshoot of a steer loop [ms]
_PLUGINS = ("PyFrcPlugin", "RobotTestingPlugin", "IsolatedTestsPlugin")
_MODES = ("simulated", "real")
_complaints: TextIO | None = None


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add simcore's command-line options and ini settings for robot tests to pytest."""
    group = parser.getgroup("simcore", "robot tests")
    group.addoption(
        "--phoenix",
        choices=_MODES,
        default=None,
        help="Phoenix 6 in simulated time (default), or CTRE's own simulation on the wall clock; also SIMCORE_PHOENIX",
    )
    group.addoption(
        "--sim-output",
        default=None,
        help="folder for log and page of failed tests; default: test_output next to robot.py",
    )
    group.addoption(
        "--sim-seed",
        type=int,
        default=None,
        metavar="N",
        help="seed of everything left to chance in robot tests; default: 0",
    )
    group.addoption(
        "--sim-scatter",
        default=None,
        metavar="SPREADS",
        help="scatter in robot tests: a factor of the default spreads and single ones by name, e.g. 1,exit_speed=0.03; "
        "default: as simcore.toml says",
    )
    parser.addini(
        "simcore_hang",
        "how long a robot loop may take: CPU time while it works, wall time while it waits [s]",
        default="9",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Prepare pytest for robot tests, and check the options.

    The hook copies the terminal's stderr for reports about a hanging program, fixes the hash seed of all test
    processes, and adapts RobotPy's plugins.

    Raises:
        UsageError: An option or SIMCORE_PHOENIX is invalid.
    """
    global _complaints
    if _complaints is None:
        _complaints = os.fdopen(os.dup(2), "w")
    # Robot tests run in separate processes, which all need the same iteration order of sets of strings.
    os.environ.setdefault("PYTHONHASHSEED", "0")
    mode = os.environ.get("SIMCORE_PHOENIX", "simulated")
    if mode not in _MODES:
        raise pytest.UsageError(f"SIMCORE_PHOENIX must be {' or '.join(_MODES)}, got {mode!r}")
    _fit_into_pyfrc(config)
    seed = config.getoption("sim_seed")
    if seed is not None and seed < 0:
        raise pytest.UsageError(f"--sim-seed must be a whole number >= 0, got {seed}")
    if config.getoption("sim_scatter") is not None:
        from simcore.errors import SimcoreError
        from simcore.match.scatter import Scatter

        try:
            Scatter.parse(config.getoption("sim_scatter"))
        except SimcoreError as error:
            raise pytest.UsageError(f"--sim-scatter: {error}") from None


def _fit_into_pyfrc(config: pytest.Config) -> None:
    """Make `robotpy test` import the program through simcore and run exactly one test in each process.

    For each test, pyfrc starts a process that imports the robot class. The arguments of the process are the test and
    all arguments of the session. A path in these arguments would make the process run all tests in a file.
    """
    for plugin in config.pluginmanager.get_plugins():
        if type(plugin).__name__ == "IsolatedTestsPlugin":
            plugin._robot_class = _RobotClass(plugin._robot_class, _mode(config) == "simulated")
        elif type(plugin).__name__ == "WorkerPlugin":
            del config.args[1:]


class _RobotClass:
    """Picklable reference to a robot class.

    A process that unpickles the reference imports the program, records the devices and obtains the class.
    """

    def __init__(self, robot_class: Any, simulated: bool) -> None:
        self._names = robot_class.__module__, robot_class.__qualname__
        self._simulated = simulated

    def __reduce__(self) -> tuple[Any, ...]:
        from simcore.robotcode.sim.attach import load_watched_class

        return load_watched_class, (*self._names, self._simulated)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Store the error message of a robot that could not start. `pytest_unconfigure` prints the message."""
    _start_sentences.update({str(value): None for name, value in report.user_properties if name == _START})


_START = "why the robot did not start"
_start_sentences: dict[str, None] = {}


def pytest_unconfigure(config: pytest.Config) -> None:
    """Print the error messages of robots that could not start, and close the copy of stderr.

    If the tests share one process, the hook also makes the process exit before Python waits for robot threads.
    """
    global _complaints
    reporter: Any = config.pluginmanager.get_plugin("terminalreporter")
    for sentence in _start_sentences if reporter is not None else ():
        reporter.write(f"\n{sentence}\n")
    _start_sentences.clear()
    if _complaints is not None:
        _complaints.close()
        _complaints = None
    if not getattr(_pyfrc(config), "isolated", True):
        threading._register_atexit(_end_at_once)  # type: ignore[attr-defined]  # before Python waits for any thread


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Store the exit status of the session, with which `_end_at_once` ends the process."""
    global _status
    _status = int(exitstatus)


_status = 0


def _end_at_once() -> None:
    """Run the exit handlers and end the process, before Python waits for robot threads or hangs in a destructor."""
    atexit._run_exitfuncs()
    _end_process(_status)


def _end_process(code: int) -> NoReturn:
    """End the process immediately with an exit code, because Python's shutdown can hang on HAL threads."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> None:
    """Add the folder of robot.py to `sys.path`, so that tests can import the project's modules as in `robotpy test`."""
    for folder in (file_path.parent, file_path.parent.parent):
        if file_path.suffix == ".py" and (folder / "robot.py").is_file() and str(folder) not in sys.path:
            sys.path.insert(0, str(folder))


# --- the process of a test ----------------------------------------------------------------------------------------


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Fail a test that uses `sim` under plain pytest, with a message that names the command to use."""
    info = getattr(item, "_fixtureinfo", None)
    ours = () if info is None else info.name2fixturedefs.get("sim", ())
    if ours and getattr(ours[-1].func, "__module__", "") == __name__ and _pyfrc(item.config) is None:
        pytest.fail(_PLAIN % item.name, pytrace=False)


def _pyfrc(config: pytest.Config) -> Any:
    """Return RobotPy's plugin in a session of `robotpy test` or a sweep; None in any other session."""
    plugins = config.pluginmanager.get_plugins()
    return next((p for p in plugins if type(p).__name__ in _PLUGINS), None)


def _mode(config: pytest.Config) -> str:
    return str(config.getoption("phoenix") or os.environ.get("SIMCORE_PHOENIX", "simulated"))


# --- devices ------------------------------------------------------------------------------------------------------


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: Any, request: pytest.FixtureRequest) -> Generator[None, Any, Any]:
    """Prepare simulated time, set seed and scatter, and attach physics before RobotPy's plugin builds the robot."""
    if fixturedef.argname == "robot":
        plugin = _pyfrc(request.config)
        if plugin is not None and _mode(request.config) == "simulated":
            from simcore.robotcode.sim.attach import begin_robot

            begin_robot()
            _make_repeatable(Path(request.getfixturevalue("robot_path")))
        if plugin is not None:
            _vary(request.config)
        if plugin is not None and hasattr(plugin, "_robot_class"):
            with _start_errors(plugin._robot_file.parent):
                _attach(plugin, wants_field="sim" in request.fixturenames)
    return (yield)


@contextlib.contextmanager
def _start_errors(folder: Path) -> Generator[None, None, None]:
    """Convert a simcore error in the context to a test failure with a one-sentence message and no traceback."""
    from simcore.errors import SimcoreError, start_sentence

    global _start_failure
    try:
        yield
    except SimcoreError as error:
        _start_failure = pytest.fail.Exception(start_sentence(error, folder), pytrace=False)
        raise _start_failure from None


_start_failure: BaseException | None = None
"""Test failure of the latest robot that could not start in this process; None if all robots have started."""


def _make_repeatable(folder: Path) -> None:
    from simcore.robotcode.sim.repeatable_runs import order_notifiers, seed_generators, use_robot_clock

    seed_generators()
    use_robot_clock(folder)
    order_notifiers()


def _vary(config: pytest.Config) -> None:
    """Set the seed and scatter of the next match from the command line."""
    from simcore.match.scatter import Scatter
    from simcore.robotcode.sim.run_variation import run_variation, set_run_variation

    text = config.getoption("sim_scatter")
    scatter = None if text is None else Scatter.parse(text)
    set_run_variation(replace(run_variation(), seed=config.getoption("sim_seed") or 0, scatter=scatter))


def _attach(plugin: Any, *, wants_field: bool) -> None:
    """Attach physics as `robotpy sim --simcore` does, if a test needs the field or the project describes the robot.

    The function also attaches physics if the project's physics.py uses simcore. Any other physics.py runs without
    simcore if the test does not need the field and no file describes the robot.

    Args:
        plugin: RobotPy's plugin.
        wants_field: Whether the test uses the fixture `sim`.

    Raises:
        ConfigError: The test uses the field, but the robot cannot be placed on a field.
    """
    from simcore.robot_file.template import FILE_NAME
    from simcore.robotcode.sim.attach import PhysicsHook, attach, is_ours, load_physics

    before, folder = getattr(plugin, "_physics", None), plugin._robot_file.parent
    if isinstance(before, PhysicsHook):
        return  # an earlier test of this process
    physics = load_physics(folder) if before is None else before.module
    is_described = (folder / FILE_NAME).exists()
    if wants_field or is_described or (physics is not None and is_ours(physics)):
        for cls in plugin._robot_class.__mro__ if before is not None else ():
            for name in ("_simulationInit", "_simulationPeriodic"):
                if getattr(vars(cls).get(name), "__module__", "") == type(before).__module__:
                    delattr(cls, name)  # pyfrc's own hooks, which call the project's physics.py
        plugin._physics, plugin._robot_class = attach(
            *(plugin._robot_class, folder),
            physics=physics,
            joins=wants_field or is_described,
            needs_field=wants_field,
            guard=partial(_start_errors, folder),
        )
        _wait_longer(plugin)


def _wait_longer(plugin: Any) -> None:
    """Make RobotPy's plugin wait up to `INIT_TIMEOUT` for the program to start, because building a field takes 1 s.

    By default, pyfrc's plugin waits 2 s, and wpilib.testing's plugin polls 1000 times at intervals of 1 ms.
    """
    if hasattr(plugin, "_init_timeout"):
        plugin._init_timeout = max(plugin._init_timeout, INIT_TIMEOUT)
        return
    from simcore import season

    has_started = season.wpilib_simulation.get_program_started

    def has_started_by_then() -> bool:
        if not has_started():
            time.sleep(1e-3 * INIT_TIMEOUT)
        return bool(has_started())

    season.test_controller().get_program_started = has_started_by_then


# --- the fixture --------------------------------------------------------------------------------------------------


@pytest.fixture
def sim(request: pytest.FixtureRequest, robot: Any, control: Any) -> Generator[RobotTest, None, None]:
    """Provide the project's robot on the simulated field, and record the run (docs/testing.md)."""
    from simcore.robotcode.sim.robot_test import RobotTest
    from simcore.telemetry.recording import Recording

    hang = float(request.config.getini("simcore_hang"))
    folder = _output_folder(request.node, request.getfixturevalue("robot_path"))
    _remove(folder)
    request.node.stash[_OUTPUT] = folder
    hook = _pyfrc(request.config)._physics
    with RobotTest(control, robot, hook, hang=hang, complaints=_complaints) as test:
        # the period of NetworkTables snapshots in tests
        request.node.stash[_RECORDING] = recording = Recording(period=0.1, bulk_period=0.1)
        test.add_sink(recording)
        yield test


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, Any, Any]:
    """Fail a test that starts a robot mode and ends without any simulated time in this mode."""
    result = yield
    test = getattr(pyfuncitem, "funcargs", {}).get("sim")
    if test is not None and _RECORDING in pyfuncitem.stash:
        from simcore.robotcode.sim.robot_test import ConditionError

        try:
            test.require_played()
        except ConditionError as error:  # no line of the test caused the error
            pytest.fail(f"ConditionError: {error}", pytrace=False)
    return result


_RECORDING: pytest.StashKey[Any] = pytest.StashKey()
_OUTPUT: pytest.StashKey[Path] = pytest.StashKey()


def _output_folder(item: pytest.Item, robot_path: Path) -> Path:
    """Return the folder for the log and page of a failed test, from `--sim-output` or next to robot.py."""
    named = item.config.getoption("sim_output")
    base = Path(named) if named else robot_path / "test_output"
    return base / "".join(c if c.isalnum() or c in "-_." else "_" for c in item.name)


def _remove(folder: Path) -> None:
    """Remove the output folder of an earlier run of a test, and the parent folder if no other output remains."""
    shutil.rmtree(folder, ignore_errors=True)
    with contextlib.suppress(OSError):  # the folder is missing or contains another test's output
        folder.parent.rmdir()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[Any]) -> Generator[None, Any, Any]:
    """Write the log and page of a failed test, and add warnings and the paths of these files to the report.

    The hook also records start failures, shortens tracebacks, and marks a test as skipped if the computer was too slow
    for CTRE's simulation.
    """
    if call.excinfo is not None and call.excinfo.value is _start_failure:
        item.user_properties.append((_START, str(call.excinfo.value)))
    _end_at_callers_line(item.config, call.excinfo)
    report = yield
    if report.when != "call":
        return report
    if call.excinfo is not None and getattr(call.excinfo.value, "name", "") == "sim" and call.excinfo.type is NameError:
        report.sections.append(("simcore", f"sim is a fixture, which a test asks for: def {item.name}(sim)"))
    if "robot" in getattr(item, "fixturenames", ()):
        _judge_lateness(item, report)
    test = getattr(item, "funcargs", {}).get("sim")
    recording = item.stash.get(_RECORDING, None)
    if report.failed and recording is not None and test is not None and test.has_run:
        from simcore.show.failed_run import save_failed_run
        from simcore.show.scene import scene_of

        assert call.excinfo is not None
        test.record.failure = call.excinfo.exconly()[:_LONGEST_FAILURE]
        if test.was_enabled and isinstance(call.excinfo.value, AssertionError):
            test.record.conclude()
        recording.write(test.match.snapshot())  # always record the last state
        scene, note = scene_of(test.match), f"failed at {test.summary()}"
        left = save_failed_run(recording, item.stash[_OUTPUT], scene=scene, title=item.nodeid, note=note)
        lines = [f"- {warning}" for warning in (*test.warnings, *_missing_parts(test))]
        lines += [str(left), f"at its end: {test.summary()}"]
        report.sections.append(("simcore", "\n".join(lines)))
    return report


def _missing_parts(test: RobotTest) -> list[str]:
    """Return a hint if the robot has neither a shooter nor a claw in a game with pieces; empty in other cases."""
    robot = test.robot_sim
    if robot.config.shooters or robot.config.placers or not test.match.game.pieces:
        return []
    return [
        f"no shooter or claw is described, so the robot throws and places nothing, and holds {len(robot.held)}; "
        "describe them as [[shooter]] and [[claw]] in simcore.toml, which `simcore init` writes"
    ]


def _end_at_callers_line(config: pytest.Config, excinfo: pytest.ExceptionInfo[BaseException] | None) -> None:
    """Remove the frames of simcore and installed packages from a traceback, unless `--full-trace` is given.

    The traceback of a simcore error ends at the line that called simcore. Any other traceback keeps all frames after
    the last frame of the test, game or robot.
    """
    from simcore.errors import SimcoreError

    if excinfo is None or config.getoption("fulltrace"):
        return
    package = Path(__file__).parents[2]
    step: TracebackType | None = excinfo.tb
    own: list[TracebackType] = []
    while step is not None:
        file = Path(step.tb_frame.f_code.co_filename)
        own += [step] if package not in file.parents and "site-packages" not in file.parts else []
        step = step.tb_next
    for before, after in itertools.pairwise(own):
        before.tb_next = after
    if own and isinstance(excinfo.value, SimcoreError):
        own[-1].tb_next = None


def _judge_lateness(item: pytest.Item, report: Any) -> None:
    if _mode(item.config) != "real" or "simcore.robotcode.sim.robot_physics" not in sys.modules:
        return
    from simcore.robotcode.sim.robot_physics import latest_physics

    physics = latest_physics()
    late = 0.0 if physics is None else physics.times.lateness_ms
    if late > _LATE_MS:
        report.outcome = "skipped"
        report.longrepr = (
            str(item.path),
            item.location[1] or 0,
            f"Skipped: the machine was too slow to judge (it {call_outcome(report)}): with --phoenix=real physics came "
            f"{late:.1f} ms late (99 % of parts), {_LATE_MS:g} ms are allowed; close other programs, or test in "
            "simulated time",
        )


def call_outcome(report: Any) -> str:
    """Return the outcome of a test as text, `failed` or `passed`."""
    return "failed" if report.longrepr else "passed"
