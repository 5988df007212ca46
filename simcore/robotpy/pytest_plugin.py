"""The pytest plugin: robot tests in simulated time, under `robotpy test` and under plain `pytest`.

Loads with pytest itself, in projects that have no robot too: whatever is heavy is imported when a robot test runs.
"""

from __future__ import annotations

import argparse
import atexit
import contextlib
import os
import shutil
import sys
import threading
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import pytest

if TYPE_CHECKING:
    from simcore.robotpy.robot_test import RobotTest

__all__ = ["sim"]

_ALONE, _ONE_OF_MANY = "alone", "one-of-many"
_SEEDS_MARK = (
    "seeds(n, scatter=None): run a robot test once for each of n seeds, or of a list of seeds, with scatter on; see "
    "sim.success"
)
_ROBOT_FIXTURES = ("sim", "robot", "control")
_LONGEST_FAILURE = 2000  # letters of an assertion on a page
_LATE_MS = 5.0  # a steer loop that sees rotors so old overshoots
_PLUGINS = ("PyFrcPlugin", "RobotTestingPlugin", "IsolatedTestsPlugin")
_MODES = ("simulated", "real")
_complaints: TextIO | None = None


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options and settings."""
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
        help="folder for log and page of failed tests; default: test_output by robot.py",
    )
    group.addoption(
        "--sim-seed",
        type=int,
        default=None,
        metavar="N",
        help="seed of all that is left to chance in robot tests; default: 0, with the mark seeds(...) all of its seeds",
    )
    group.addoption(
        "--sim-scatter",
        default=None,
        metavar="SPREADS",
        help="scatter in robot tests: a factor of the default spreads and single ones by name, e.g. 1,exit_speed=0.03; "
        "default: as simcore.toml says",
    )
    group.addoption(
        "--seeds", type=int, default=None, metavar="N", help="of tests marked with seeds(...) the first N seeds only"
    )
    group.addoption(
        "--seed-workers",
        type=int,
        default=None,
        metavar="N",
        help="runs of such a test at a time; default: one a core, with xdist 1",
    )
    # Set for the processes of single runs by the one that starts them.
    group.addoption("--sim-run", choices=(_ALONE, _ONE_OF_MANY), default=None, help=argparse.SUPPRESS)
    parser.addini("simcore_robot", "robot.py of the tests; default: the nearest above a test", default="")
    parser.addini("simcore_timeout", "wall time that a robot test may take [s]", default="300")
    parser.addini("simcore_hang", "wall time that a robot loop may take [s]", default="30")


def pytest_configure(config: pytest.Config) -> None:
    """Keep the terminal's own stderr, for the stacks of a program that hangs; refuse options that cannot be."""
    global _complaints
    if _complaints is None:
        _complaints = os.fdopen(os.dup(2), "w")
    # Robot tests run in further processes; sets of strings shall have one order in all of them.
    os.environ.setdefault("PYTHONHASHSEED", "0")
    mode = os.environ.get("SIMCORE_PHOENIX", "simulated")
    if mode not in _MODES:
        raise pytest.UsageError(f"SIMCORE_PHOENIX must be {' or '.join(_MODES)}, got {mode!r}")
    config.addinivalue_line("markers", _SEEDS_MARK)
    _fit_into_pyfrc(config)
    for option, least in (("sim_seed", 0), ("seeds", 1), ("seed_workers", 1)):
        number = config.getoption(option)
        if number is not None and number < least:
            raise pytest.UsageError(f"--{option.replace('_', '-')} must be a whole number >= {least}, got {number}")
    if config.getoption("sim_scatter") is not None:
        from simcore.errors import SimcoreError
        from simcore.match.scatter import Scatter

        try:
            Scatter.parse(config.getoption("sim_scatter"))
        except SimcoreError as error:
            raise pytest.UsageError(f"--sim-scatter: {error}") from None


def _fit_into_pyfrc(config: pytest.Config) -> None:
    """Let `robotpy test` import a program in each process as we do, and run one test there.

    pyfrc hands the process of a test the robot class, which is imported on the way, and all arguments of its own
    session after the test: a path among them would make the process run every test of that file.
    """
    for plugin in config.pluginmanager.get_plugins():
        if type(plugin).__name__ == "IsolatedTestsPlugin":
            plugin._robot_class = _RobotClass(plugin._robot_class, _mode(config) == "simulated")
        elif type(plugin).__name__ == "WorkerPlugin":
            del config.args[1:]


class _RobotClass:
    """A robot class that another process imports when it is told what to note."""

    def __init__(self, robot_class: Any, simulated: bool) -> None:
        self._names = robot_class.__module__, robot_class.__qualname__
        self._simulated = simulated

    def __reduce__(self) -> tuple[Any, ...]:
        from simcore.robotpy.program_watch import load_watched_class

        return load_watched_class, (*self._names, self._simulated)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note why a robot could not start."""
    _start_sentences.update({str(value): None for name, value in report.user_properties if name == _START})


_START = "why the robot did not start"
_start_sentences: dict[str, None] = {}


def pytest_unconfigure(config: pytest.Config) -> None:
    """Say last why robots could not start, and let go of what `pytest_configure` opened."""
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
    """Note how the session ends."""
    global _status
    _status = int(exitstatus)


_status = 0


def _end_at_once() -> None:
    """End a process in which robots were: Python would wait for their threads, or hang as it takes devices apart."""
    from simcore.robotpy.isolation import end_process

    atexit._run_exitfuncs()
    end_process(_status)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> None:
    """Let tests import the modules of their project, as `robotpy test` does."""
    for folder in (file_path.parent, file_path.parent.parent):
        if file_path.suffix == ".py" and (folder / "robot.py").is_file() and str(folder) not in sys.path:
            sys.path.insert(0, str(folder))


# --- one process a test -------------------------------------------------------------------------------------------


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> bool | None:
    """Under plain pytest: hand a robot test to a process of its own."""
    config, hook = item.config, item.ihook
    has_seeds = item.get_closest_marker("seeds") is not None and config.getoption("sim_run") is None
    # Under `robotpy test` this is the process of one test already; one with seeds starts further ones all the same.
    if not _is_robot_test(item) or (_pyfrc(config) is not None and not has_seeds):
        return None
    from simcore.errors import SimcoreError
    from simcore.robotpy.isolation import run_isolated
    from simcore.robotpy.seed_runs import judged_seeds, seeds_and_spreads

    hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    try:
        robot_file = _robot_file(item)
        seeds, spreads = seeds_and_spreads(item, robot_file) if has_seeds else ((), [])
    except SimcoreError as error:
        reports = [
            pytest.TestReport(
                nodeid=item.nodeid,
                location=item.location,
                keywords={},
                outcome="failed",
                longrepr=str(error),
                when="setup",
            )
        ]
    else:
        real = _mode(config) == "real"  # configurations persist in ./ctre_sim: a fresh folder

        def play(kind: str = _ALONE, *further: str) -> list[pytest.TestReport]:
            return run_isolated(
                item,
                robot_file,
                [*_child_arguments(config), *spreads, f"--sim-run={kind}", *further],
                timeout=float(config.getini("simcore_timeout")),
                folder=None if real else config.invocation_params.dir,
            )

        if seeds:
            output = _output_folder(item, robot_file.parent)
            _remove(output)
            reports = judged_seeds(item, seeds, lambda seed: play(_ONE_OF_MANY, f"--sim-seed={seed}"), output)
        else:
            reports = play()
    for report in reports:
        hook.pytest_runtest_logreport(report=report)
    hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def _is_robot_test(item: pytest.Item) -> bool:
    """Whether a test asks for this plugin's fixture, or for one of pyfrc's that nobody else provides."""
    names = getattr(item, "fixturenames", ())
    info = getattr(item, "_fixtureinfo", None)
    if info is None or not set(_ROBOT_FIXTURES) & set(names):
        return False
    definitions = info.name2fixturedefs
    ours = definitions.get("sim")
    if ours and getattr(ours[-1].func, "__module__", "") == __name__:
        return True
    return any(name in names and name not in definitions for name in ("robot", "control"))


def _pyfrc(config: pytest.Config) -> Any:
    """The plugin of pyfrc, if it runs this session: `robotpy test`, or our own child process."""
    plugins = config.pluginmanager.get_plugins()
    return next((p for p in plugins if type(p).__name__ in _PLUGINS), None)


def _robot_file(item: pytest.Item) -> Path:
    from simcore.robotpy.robot_program import find_robot_file

    return find_robot_file(item.path, named=item.config.getini("simcore_robot"), base=item.config.rootpath)


def _child_arguments(config: pytest.Config) -> list[str]:
    options = config.option
    arguments = ["-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:cov", "-q", "--no-header"]
    for plugin in options.plugins or ():
        arguments += ["-p", plugin]
    arguments += [f"--rootdir={config.rootpath}", f"--phoenix={_mode(config)}", f"--tb={options.tbstyle}"]
    if config.inipath is not None:
        arguments += ["-c", str(config.inipath)]
    for setting in options.override_ini or ():
        arguments += ["-o", setting]
    if options.sim_seed is not None:
        arguments.append(f"--sim-seed={options.sim_seed}")
    if options.sim_scatter is not None:
        arguments.append(f"--sim-scatter={options.sim_scatter}")
    if options.showlocals:
        arguments.append("--showlocals")
    if options.sim_output:
        arguments.append(f"--sim-output={Path(options.sim_output).absolute()}")
    arguments.append(f"--import-mode={options.importmode}")
    return arguments


def _mode(config: pytest.Config) -> str:
    return str(config.getoption("phoenix") or os.environ.get("SIMCORE_PHOENIX", "simulated"))


# --- devices ------------------------------------------------------------------------------------------------------


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: Any, request: pytest.FixtureRequest) -> Generator[None, Any, Any]:
    """Before pyfrc builds the robot: Phoenix 6 into simulated time, and the robot onto the field."""
    if fixturedef.argname == "robot":
        plugin = _pyfrc(request.config)
        if plugin is not None and _mode(request.config) == "simulated":
            from simcore.robotpy.program_watch import begin_robot

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
    """Make one sentence of what simcore has to say of a project, without the way there through simcore's own code."""
    from simcore.errors import SimcoreError, start_sentence

    global _start_failure
    try:
        yield
    except SimcoreError as error:
        _start_failure = pytest.fail.Exception(start_sentence(error, folder), pytrace=False)
        raise _start_failure from None


_start_failure: BaseException | None = None
"""As it was raised in this process."""


def _make_repeatable(folder: Path) -> None:
    from simcore.robotpy.repeatable_runs import order_notifiers, seed_generators, use_robot_clock

    seed_generators()
    use_robot_clock(folder)
    order_notifiers()


def _vary(config: pytest.Config) -> None:
    """Say to whoever builds the match which of many runs this is."""
    from simcore.match.scatter import Scatter
    from simcore.robotpy.run_variation import run_variation, set_run_variation

    text = config.getoption("sim_scatter")
    scatter = None if text is None else Scatter.parse(text)
    set_run_variation(replace(run_variation(), seed=config.getoption("sim_seed") or 0, scatter=scatter))


def _attach(plugin: Any, *, wants_field: bool) -> None:
    """As `robotpy sim --simcore` does, for a test that wants the field or a project that describes its robot.

    Args:
        plugin: pyfrc's.
        wants_field: Whether the test uses `sim`.

    Raises:
        ConfigError: It wants the field, and nothing could put the robot there.
    """
    from simcore.robot_file.template import FILE_NAME
    from simcore.robotpy.physics_hook import hook_of

    physics, folder = hook_of(plugin), plugin._robot_file.parent
    if wants_field or physics is not None or (folder / FILE_NAME).exists():
        from simcore.robotpy.isolation import wait_longer
        from simcore.robotpy.robot_attachment import attach_physics

        # A physics.py of the team's alone is left alone where nobody asked for the field.
        hook, plugin._robot_class = attach_physics(
            *(physics, plugin._robot_class, folder),
            joins=wants_field or (folder / FILE_NAME).exists(),
            needs_field=wants_field,
        )
        plugin._physics = hook
        hook.log_init_errors = False  # as pyfrc has it in tests
        hook._simulationInit = _start_errors(folder)(hook._simulationInit)
        wait_longer(plugin)


# --- the fixture --------------------------------------------------------------------------------------------------


@pytest.fixture
def sim(request: pytest.FixtureRequest, robot: Any, control: Any) -> Generator[RobotTest, None, None]:
    """The robot of this project on its simulated field; see docs/testing.md."""
    from simcore.robotpy.robot_test import RobotTest
    from simcore.telemetry.recording import Recording

    hang = float(request.config.getini("simcore_hang"))
    is_one_of_many = request.config.getoption("sim_run") == _ONE_OF_MANY
    folder = _output_folder(request.node, request.getfixturevalue("robot_path"))
    if is_one_of_many:
        folder /= f"seed_{request.config.getoption('sim_seed')}"
    else:
        _remove(folder)
    request.node.stash[_OUTPUT] = folder
    with RobotTest(control, robot, hang=hang, complaints=_complaints, is_one_of_many=is_one_of_many) as test:
        # as often as NetworkTables wants a snapshot here
        request.node.stash[_RECORDING] = recording = Recording(period=0.1, bulk_period=0.1)
        test.add_sink(recording)
        yield test


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, Any, Any]:
    """Let no test pass that ends in a mode of which it has played nothing."""
    result = yield
    test = getattr(pyfuncitem, "funcargs", {}).get("sim")
    if test is not None and _RECORDING in pyfuncitem.stash:
        test.require_played()
    return result


_RECORDING: pytest.StashKey[Any] = pytest.StashKey()
_OUTPUT: pytest.StashKey[Path] = pytest.StashKey()


def _output_folder(item: pytest.Item, robot_path: Path) -> Path:
    """Where log and page of this test go if it fails."""
    named = item.config.getoption("sim_output")
    base = Path(named) if named else robot_path / "test_output"
    return base / "".join(c if c.isalnum() or c in "-_." else "_" for c in item.name)


def _remove(folder: Path) -> None:
    """Take away what an earlier run of the test left."""
    shutil.rmtree(folder, ignore_errors=True)
    with contextlib.suppress(OSError):  # not there, or another test's output is in it
        folder.parent.rmdir()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[Any]) -> Generator[None, Any, Any]:
    """Leave log and page of a failed test; tell when the machine was too slow for the real Phoenix 6."""
    if call.excinfo is not None and call.excinfo.value is _start_failure:
        item.user_properties.append((_START, str(call.excinfo.value)))
    report = yield
    if report.when != "call":
        return report
    if "robot" in getattr(item, "fixturenames", ()):
        _judge_lateness(item, report)
    test = getattr(item, "funcargs", {}).get("sim")
    recording = item.stash.get(_RECORDING, None)
    if item.config.getoption("sim_run") == _ONE_OF_MANY:
        from simcore.robotpy.robot_test import run_report

        refuted = call.excinfo is not None and call.excinfo.errisinstance((AssertionError, pytest.fail.Exception))
        started = call.excinfo is None or call.excinfo.value is not _start_failure
        report.user_properties.append(run_report(test, is_refuted=refuted and started))
    is_lost = report.failed or (test is not None and not all(claim.held for claim in test.claims))
    if is_lost and recording is not None and test is not None and test.has_run:
        from simcore.show.failed_run import save_failed_run
        from simcore.show.scene import scene_of

        test.record.failure = "no success" if call.excinfo is None else call.excinfo.exconly()[:_LONGEST_FAILURE]
        test.record.conclude()
        recording.write(test.match.snapshot())  # the end itself, whenever a snapshot would have been due
        scene, note = scene_of(test.match), f"failed at {test.summary()}"
        left = save_failed_run(recording, item.stash[_OUTPUT], scene=scene, title=item.nodeid, note=note)
        lines = [*(f"- {warning}" for warning in test.warnings), str(left), f"at its end: {test.summary()}"]
        report.sections.append(("simcore", "\n".join(lines)))
    return report


def _judge_lateness(item: pytest.Item, report: Any) -> None:
    if _mode(item.config) != "real" or "simcore.robotpy.robot_physics" not in sys.modules:
        return
    from simcore.robotpy.robot_physics import latest_physics

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
    """What a report says of its test, as a verb."""
    return "failed" if report.longrepr else "passed"
