"""Run every test here on the physics engines that `--engine` and the test's marker select."""

import pytest


@pytest.fixture(autouse=True)
def _engine(engine_name):
    """Build the worlds of each test on the selected engine."""
