"""Leaves out what needs a vendor's library that is not installed: the adapters are optional extras."""

import os
from importlib.util import find_spec

import pytest

collect_ignore_glob = ["examples/*", "tests/adapters/robots/*", "tests/adapters/scenarios/*"]
if find_spec("phoenix6") is None or find_spec("wpilib") is None:
    collect_ignore_glob += ["simcore/phoenix6/*", "simcore/phoenix6_emulator/*"]
if find_spec("photonlibpy") is None:
    collect_ignore_glob.append("simcore/photonvision.py")
if find_spec("pyfrc") is None or find_spec("phoenix6") is None:
    collect_ignore_glob.append("simcore/robotpy/*")


def pytest_addoption(parser):
    """The flag of tests that are sampled otherwise."""
    parser.addoption("--whole", action="store_true", help="run long tests in full, which are sampled otherwise")


@pytest.fixture
def whole(request):
    """Whether long tests run in full."""
    return bool(request.config.getoption("--whole"))


@pytest.fixture(scope="session")
def compiled_store(tmp_path_factory):
    """A store with a fresh build of the present sources; the one that SIMCORE_COMPILED names, if it does."""
    from simcore.compiled import build, store
    from simcore.errors import CompileError

    place = os.environ.get(store.VARIABLE, "")
    if place in ("", "0", "1"):
        place = str(tmp_path_factory.mktemp("compiled"))
    try:
        build.check_tools()
        build.build({**os.environ, store.VARIABLE: place})
    except CompileError as error:
        if "not installed" in str(error) or "no C compiler" in str(error) or "headers" in str(error):
            pytest.skip(f"nothing to compile with: {error}")
        raise
    return place
