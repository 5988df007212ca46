"""Every test here runs on the physics engines that `--engine` and its marker say."""

import pytest


@pytest.fixture(autouse=True)
def _engine(engine_name):
    """Worlds of this test are of this engine."""
