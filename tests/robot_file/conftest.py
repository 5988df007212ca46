import pytest

from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import RobotSettings


@pytest.fixture
def read(tmp_path):
    """Return a function that reads the text of a simcore.toml and returns its settings."""

    def read(text: str) -> RobotSettings:
        path = tmp_path / "simcore.toml"
        path.write_text(text, encoding="utf-8")
        return read_settings(path)

    return read
