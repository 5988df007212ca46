"""Import paths of the modules in `scripts/` and `tests/shared/`, which tests of several folders import."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "scripts"))  # for tests of scripts, which import each other
sys.path.append(str(Path(__file__).parent / "shared"))  # for a folder without games/
