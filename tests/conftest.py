"""For page_reader.py and each_case.py, which tests of several folders share."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "scripts"))  # for tests of scripts, which import each other
sys.path.append(str(Path(__file__).parent / "pages"))  # in a folder without games/
