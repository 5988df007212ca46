"""Lets the tests here import what makes their inputs."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
